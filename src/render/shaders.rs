//! Shader files of the full path, embedded into the crate; [`mask`](super::mask) embeds its own.

use std::path::{Path, PathBuf};

use bevy::{
    asset::{AssetServer, io::embedded::EmbeddedAssetRegistry},
    prelude::*,
    shader::Shader,
};

/// Embeds one file of `shaders/` so that users of the crate have it and that the feature `dev` reloads it when saved.
macro_rules! embed_shader {
    ($registry:expr, $name:literal) => {
        $registry.insert_asset(
            PathBuf::from(concat!("shaders/", $name)),
            Path::new(concat!("umbrage/", $name)),
            include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $name)).as_slice(),
        )
    };
}

/// Modules that others import, and shaders of levels of detail, which fade for less time than loading takes: loaded once and
/// kept for the life of the app.
const LIBRARIES: [&str; 13] = [
    "types.wgsl",
    "spaces.wgsl",
    "bias.wgsl",
    "surface.wgsl",
    "selection.wgsl",
    "fading.wgsl",
    "filter.wgsl",
    "depth_offset.wgsl",
    "visibility.wgsl",
    "virtual_map/needs.wgsl",
    "unpop/coat.wgsl",
    "unpop/fade.wgsl",
    "unpop/cast.wgsl",
];

/// The lookup that [`bridge`](super::bridge) appends to Bevy's shadow module.
pub(crate) const FETCH_SHADOW: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/bridge/fetch_shadow.wgsl"));

/// Keeps handles of shader libraries: a module that nobody holds is unloaded.
#[derive(Resource)]
struct ShaderLibraries(#[expect(dead_code, reason = "held, never read")] Vec<Handle<Shader>>);

/// Makes all shader files loadable under `embedded://umbrage/…`.
pub(crate) fn embed(app: &mut App) {
    let registry = app.world_mut().resource_mut::<EmbeddedAssetRegistry>();
    embed_shader!(registry, "types.wgsl");
    embed_shader!(registry, "spaces.wgsl");
    embed_shader!(registry, "bias.wgsl");
    embed_shader!(registry, "surface.wgsl");
    embed_shader!(registry, "selection.wgsl");
    embed_shader!(registry, "fading.wgsl");
    embed_shader!(registry, "filter.wgsl");
    embed_shader!(registry, "depth_offset.wgsl");
    embed_shader!(registry, "visibility.wgsl");
    embed_shader!(registry, "apply/apply_views.wgsl");
    embed_shader!(registry, "blur/eye_blur.wgsl");
    embed_shader!(registry, "bridge/write_layer.wgsl");
    embed_shader!(registry, "bridge/write_second_layer.wgsl");
    embed_shader!(registry, "caster/cull_casters.wgsl");
    embed_shader!(registry, "caster/peel.wgsl");
    embed_shader!(registry, "depth_range/reduce_depths.wgsl");
    embed_shader!(registry, "history/blend_history.wgsl");
    embed_shader!(registry, "heat_map/map_colors.wgsl");
    embed_shader!(registry, "heat_map/sampling_rate.wgsl");
    embed_shader!(registry, "heat_map/texel_ratio.wgsl");
    embed_shader!(registry, "light_plane/see_blocks.wgsl");
    embed_shader!(registry, "transparent/peel.wgsl");
    embed_shader!(registry, "transparent/select_layer.wgsl");
    embed_shader!(registry, "virtual_map/apply_tile.wgsl");
    embed_shader!(registry, "virtual_map/show_tiles.wgsl");
    embed_shader!(registry, "virtual_map/needs.wgsl");
    embed_shader!(registry, "virtual_map/collect_needs.wgsl");
    embed_shader!(registry, "virtual_map/map_needs.wgsl");
    embed_shader!(registry, "virtual_map/show_needs.wgsl");
    embed_shader!(registry, "unpop/coat.wgsl");
    embed_shader!(registry, "unpop/fade.wgsl");
    embed_shader!(registry, "unpop/cast.wgsl");
    let server = app.world().resource::<AssetServer>();
    let handles = LIBRARIES.iter().map(|name| load(server, name)).collect();
    app.insert_resource(ShaderLibraries(handles));
}

/// Handle of an embedded shader file.
pub(crate) fn load(server: &AssetServer, name: &str) -> Handle<Shader> {
    server.load(format!("embedded://umbrage/{name}"))
}
