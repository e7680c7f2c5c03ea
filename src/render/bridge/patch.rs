//! The patches of Bevy's modules: the lookup of shadows, and positions that are the same in several pipelines.

use bevy::{log::error_once, prelude::*, shader::Shader};
use thiserror::Error;

use crate::render::shaders::FETCH_SHADOW;

/// Path of the module of shadows.
const MODULE: &str = "embedded://bevy_pbr/render/shadows.wgsl";
/// The function whose place the appended one takes.
const NEEDLE: &str = "fn fetch_directional_shadow(";
/// The name that Bevy's function keeps.
const RENAMED: &str = "fn fetch_directional_shadow_bevy(";
/// The module's own name, after which an import is added.
const IMPORT_PATH: &str = "#define_import_path bevy_pbr::shadows";

/// Path of the module of what vertex shaders hand on.
const VERTEX_MODULE: &str = "embedded://bevy_pbr/render/forward_io.wgsl";
/// The position there.
const POSITION: &str = "    @builtin(position) position: vec4<f32>,";
/// The same, where the pipeline asks for it, with a promise: the same vertices are at the same depths in every pipeline.
const INVARIANT_POSITION: &str = "#ifdef UMBRAGE_INVARIANT_POSITION
    @invariant @builtin(position) position: vec4<f32>,
#else
    @builtin(position) position: vec4<f32>,
#endif";
/// The shader definition that asks for it.
pub const UMBRAGE_INVARIANT_POSITION: &str = "UMBRAGE_INVARIANT_POSITION";

/// Bevy's shader is not the one this version was written for.
#[derive(Debug, Error, PartialEq, Eq)]
#[error("Bevy's shader has no `{missing}`: this version of Umbrage needs Bevy 0.19.1")]
pub struct PatchError {
    /// The text that was looked for.
    pub missing: &'static str,
}

/// The patched source, or `None` when it is patched already.
///
/// # Errors
///
/// When the source does not contain exactly one lookup function and its import path.
pub fn patched(source: &str) -> Result<Option<String>, PatchError> {
    if source.contains(RENAMED) {
        return Ok(None);
    }
    if source.matches(NEEDLE).count() != 1 {
        return Err(PatchError { missing: NEEDLE });
    }
    if !source.contains(IMPORT_PATH) {
        return Err(PatchError { missing: IMPORT_PATH });
    }
    let renamed = source.replace(NEEDLE, RENAMED);
    let imported = renamed.replace(
        IMPORT_PATH,
        &format!("{IMPORT_PATH}\n#import bevy_pbr::view_transformations"),
    );
    Ok(Some(imported + FETCH_SHADOW))
}

/// The source of what vertex shaders hand on with [`INVARIANT_POSITION`], or `None` when it is patched already.
///
/// # Errors
///
/// When the source does not contain exactly one position.
pub fn with_invariant_position(source: &str) -> Result<Option<String>, PatchError> {
    if source.contains(INVARIANT_POSITION) {
        return Ok(None);
    }
    if source.matches(POSITION).count() != 1 {
        return Err(PatchError { missing: POSITION });
    }
    Ok(Some(source.replace(POSITION, INVARIANT_POSITION)))
}

/// Patches the loaded modules in place: the same asset id takes Bevy's hot-reload path, so no pipeline is ever built
/// with the old text, and a hot reload of Bevy's file is patched again.
pub(super) fn patch_modules(server: Res<AssetServer>, mut shaders: ResMut<Assets<Shader>>) {
    if let Err(error) = patch_module(&server, &mut shaders, MODULE, patched) {
        error_once!("{error}; the full path is off");
    }
    if let Err(error) = patch_module(&server, &mut shaders, VERTEX_MODULE, with_invariant_position) {
        error_once!("{error}; fragments of transparent layers may be missing");
    }
}

fn patch_module(
    server: &AssetServer,
    shaders: &mut Assets<Shader>,
    module: &'static str,
    patched: impl Fn(&str) -> Result<Option<String>, PatchError>,
) -> Result<(), PatchError> {
    let Some(handle) = server.get_handle::<Shader>(module) else {
        return Ok(());
    };
    let Some(shader) = shaders.get(&handle) else {
        return Ok(());
    };
    let path = shader.path.clone();
    if let Some(source) = patched(shader.source.as_str())?
        && let Err(error) = shaders.insert(handle.id(), Shader::from_wgsl(source, path))
    {
        error_once!("a shader of Bevy's could not be replaced: {error}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_once_and_names_what_is_missing() {
        let source =
            "#define_import_path bevy_pbr::shadows\nfn fetch_directional_shadow(a: u32) -> f32 { return 1.0; }\n";
        let patch = patched(source).expect("the needle is there").expect("not patched yet");
        assert!(
            patch.contains(RENAMED) && patch.contains(NEEDLE),
            "both functions are in the patched module"
        );
        assert_eq!(patched(&patch), Ok(None), "a patched module is left alone");
        assert_eq!(
            patched("fn other() {}"),
            Err(PatchError { missing: NEEDLE }),
            "a changed module is refused"
        );
    }

    #[test]
    fn positions_become_invariant_once() {
        let source = format!("struct VertexOutput {{\n{POSITION}\n}}\n");
        let patch = with_invariant_position(&source)
            .expect("the position is there")
            .expect("not patched yet");
        assert!(
            patch.contains(INVARIANT_POSITION),
            "the promise is there where it is asked for"
        );
        assert_eq!(
            with_invariant_position(&patch),
            Ok(None),
            "a patched module is left alone"
        );
        assert_eq!(
            with_invariant_position("struct VertexOutput {}"),
            Err(PatchError { missing: POSITION }),
            "a changed module is refused"
        );
    }
}
