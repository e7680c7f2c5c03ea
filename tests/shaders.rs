//! Structures of `shaders/types.wgsl` have the layout of their Rust twins.

use bevy::render::render_resource::ShaderType;
use umbrage::render::gpu_types::{
    ApplyParameters, BlockGrid, CasterBin, CullParameters, DrawIndexedArguments, GpuDepthRange, GpuEyeBlur,
    GpuHistoryFrame, GpuLightView, GpuMappingTexel, GpuNeedCell, GpuNeedOverlay, GpuSeenBlock, GpuShadowTile,
    GpuTileMark, GpuTileReport, MAX_LIGHT_VIEWS, NeedParameters, NeedTotals,
};

/// Name, size and member offsets of every structure that the shader compiler sees.
fn wgsl_structs() -> Vec<(String, u64, Vec<(String, u64)>)> {
    let source: String = include_str!("../shaders/types.wgsl")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| format!("{line}\n"))
        .collect();
    let module = naga::front::wgsl::parse_str(&source).expect("shaders/types.wgsl is valid WGSL");
    module
        .types
        .iter()
        .filter_map(|(_, kind)| {
            let naga::TypeInner::Struct { members, span } = &kind.inner else {
                return None;
            };
            let members = members
                .iter()
                .map(|member| (member.name.clone().unwrap_or_default(), u64::from(member.offset)))
                .collect();
            Some((kind.name.clone().unwrap_or_default(), u64::from(*span), members))
        })
        .collect()
}

/// Compares one Rust structure, given by its members in order, with the WGSL one.
fn assert_same(name: &str, rust_size: u64, rust_offset: impl Fn(usize) -> u64, members: &[&str]) {
    let structs = wgsl_structs();
    let (_, size, wgsl_members) = structs
        .iter()
        .find(|(other, ..)| other == name)
        .unwrap_or_else(|| panic!("no structure {name} in types.wgsl"));
    assert_eq!(rust_size, *size, "size of {name}");
    assert_eq!(wgsl_members.len(), members.len(), "number of members of {name}");
    for (index, (expected, (member, offset))) in members.iter().zip(wgsl_members).enumerate() {
        assert_eq!(expected, member, "member {index} of {name}");
        assert_eq!(rust_offset(index), *offset, "offset of {name}.{member}");
    }
}

/// `assert_same` with the field names checked by the Rust compiler.
macro_rules! assert_layout {
    ($rust:ty, $wgsl:literal, { $($field:ident),+ $(,)? }) => {
        let _ = |value: $rust| { $( let _ = value.$field; )+ };
        assert_same(
            $wgsl,
            <$rust>::min_size().get(),
            |index| <$rust as ShaderType>::METADATA.offset(index),
            &[$(stringify!($field)),+],
        );
    };
}

#[test]
fn layouts_agree() {
    assert_layout!(GpuLightView, "LightView", {
        clip_from_world, atlas_rect, depth_range, seam_depth, stands_in,
    });
    assert_layout!(ApplyParameters, "ApplyParameters", {
        light_views, direction_to_light, light_view_count, shadow_distance, selection, filter_kind, bias_kind,
        bias_value, opacity, bias_units, filter_taps, filter_radius, search_taps, sun_tangent,
        seam_share, seam_metres, has_seams, fade_end, fade_length, has_fading,
    });
    assert_layout!(GpuEyeBlur, "EyeBlur", { iterations, full_depth, iteration, axis });
    assert_layout!(GpuDepthRange, "DepthRange", { nearest, farthest, pixel_count, padding });
    assert_layout!(GpuHistoryFrame, "HistoryFrame", {
        clip_from_world, view_depth_from_world, new_share, is_valid, padding,
    });
    assert_layout!(GpuShadowTile, "ShadowTile", {
        rect, bounds, place, counts, report, tolerance, light_view, padding,
    });
    assert_layout!(GpuTileMark, "TileMark", {
        place, counts, color, light_view, padding_a, padding_b, padding_c,
    });
    assert_layout!(GpuTileReport, "TileReport", { changed, inside, min_x, min_y, max_x, max_y });
    assert_layout!(CasterBin, "CasterBin", {
        first_instance, instance_count, first_index, index_count, base_vertex, unbounded, padding_a, padding_b,
        center_local, half_extents_local,
    });
    assert_layout!(DrawIndexedArguments, "DrawIndexedArguments", {
        index_count, instance_count, first_index, base_vertex, first_instance,
    });
    assert_layout!(CullParameters, "CullParameters", {
        instance_total, bin_count, light_view_count, first_counter,
    });
    assert_layout!(NeedParameters, "NeedParameters", {
        map_from_picture, clip_from_world, inverse_depth, picture_size, picture_origin, map_size, cells_per_axis,
        measure, pick, need_scale, depth_range, wide_steps, motion_step, motion_turn_factor, motion_focal,
        motion_corner,
    });
    assert_layout!(GpuNeedCell, "NeedCell", {
        level_u, level_v, pixels, first_column_complement, first_row_complement, end_column, end_row,
    });
    assert_layout!(NeedTotals, "NeedTotals", { pixels_by_level, outside });
    assert_layout!(GpuMappingTexel, "MappingTexel", { uv, reach, levels, padding });
    assert_layout!(GpuNeedOverlay, "NeedOverlay", { rectangle_count, cap, opacity, padding });
    assert_layout!(GpuSeenBlock, "SeenBlock", {
        position, nearest_ndc, normal, farthest_ndc, pixel, pixel_count, plane_ndc, slope, offsets,
    });
    assert_layout!(BlockGrid, "BlockGrid", { origin, picture_size, block_count, padding });
    assert_eq!(wgsl_structs().len(), 18, "a structure of types.wgsl has no twin here");
    let array = include_str!("../shaders/types.wgsl").contains(&format!("array<LightView, {MAX_LIGHT_VIEWS}>"));
    assert!(array, "the array of light views has another length");
}
