//! The patch of Bevy's shadow module.

use bevy::{log::error_once, prelude::*, shader::Shader};
use thiserror::Error;

use crate::render::shaders::FETCH_SHADOW;

/// Path of the module that is patched.
const MODULE: &str = "embedded://bevy_pbr/render/shadows.wgsl";
/// The function whose place the appended one takes.
const NEEDLE: &str = "fn fetch_directional_shadow(";
/// The name that Bevy's function keeps.
const RENAMED: &str = "fn fetch_directional_shadow_bevy(";
/// The module's own name, after which an import is added.
const IMPORT_PATH: &str = "#define_import_path bevy_pbr::shadows";

/// Bevy's shader is not the one this version was written for.
#[derive(Debug, Error, PartialEq, Eq)]
#[error("Bevy's shadow shader has no `{missing}`: this version of Umbrage needs Bevy 0.19.1; the full path is off")]
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

/// Patches the loaded module in place: the same asset id takes Bevy's hot-reload path, so no pipeline is ever built
/// with the old text, and a hot reload of Bevy's file is patched again.
pub(super) fn patch_shadow_module(server: Res<AssetServer>, mut shaders: ResMut<Assets<Shader>>) {
    let Some(handle) = server.get_handle::<Shader>(MODULE) else {
        return;
    };
    let Some(shader) = shaders.get(&handle) else {
        return;
    };
    let path = shader.path.clone();
    match patched(shader.source.as_str()) {
        Ok(None) => {}
        Ok(Some(source)) => {
            if let Err(error) = shaders.insert(handle.id(), Shader::from_wgsl(source, path)) {
                error_once!("Bevy's shadow shader could not be replaced: {error}");
            }
        }
        Err(error) => error_once!("{error}"),
    }
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
}
