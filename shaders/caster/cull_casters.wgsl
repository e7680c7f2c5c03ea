// Appends one indirect draw for every (light view, caster) whose bounds may touch the light view.
//
// Conservative: a caster that is left out cannot change a texel, so maps with and without culling are bit-identical.

#import bevy_pbr::mesh_types::Mesh
#import umbrage::types::{CasterBin, CullParameters, DrawIndexedArguments}

@group(0) @binding(0) var<storage, read> meshes: array<Mesh>;
@group(0) @binding(1) var<storage, read> bins: array<CasterBin>;
@group(0) @binding(2) var<storage, read> clip_from_world: array<mat4x4<f32>>;
@group(0) @binding(3) var<storage, read_write> arguments: array<DrawIndexedArguments>;
// One counter per (light view, first instance of a bin).
@group(0) @binding(4) var<storage, read_write> counts: array<atomic<u32>>;
// Storage, not uniform: a software driver compiles a shader anew for every value of a uniform that bounds a loop, and
// keeps them all: 6 MB a second in the city, where the numbers change with every step.
@group(0) @binding(5) var<storage, read> parameters: CullParameters;

// Casters drawn, per light view of the frame: for statistics.
@group(0) @binding(6) var<storage, read_write> drawn: array<atomic<u32>>;

@compute @workgroup_size(64)
fn cull_casters(@builtin(global_invocation_id) id: vec3<u32>) {
    let instance = id.x;
    let light_view = id.y;
    if instance >= parameters.instance_total {
        return;
    }
    let bin = bins[find_bin(instance)];
    if instance < bin.first_instance || instance >= bin.first_instance + bin.instance_count {
        return;
    }
    if bin.unbounded == 0u && !may_touch(bin, instance, light_view) {
        return;
    }
    let base = light_view * parameters.instance_total + bin.first_instance;
    let slot = atomicAdd(&counts[base], 1u);
    // Those without a counter of their own share the last.
    atomicAdd(&drawn[min(parameters.first_counter + light_view, arrayLength(&drawn) - 1u)], 1u);
    arguments[base + slot] = DrawIndexedArguments(bin.index_count, 1u, bin.first_index, bin.base_vertex, instance);
}

// Bins are sorted by their first instance: the last one that starts at or before it.
fn find_bin(instance: u32) -> u32 {
    var low = 0u;
    var high = parameters.bin_count;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if bins[middle].first_instance <= instance {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// The oriented box against the four sides and the far plane (z = 0) of the light view; the near plane is open, casters
// towards the light are clamped into the map.
fn may_touch(bin: CasterBin, instance: u32, light_view: u32) -> bool {
    let world_from_local = meshes[instance].world_from_local;
    let center = transform(world_from_local, vec4<f32>(bin.center_local.xyz, 1.0));
    let extent_x = transform(world_from_local, vec4<f32>(bin.half_extents_local.x, 0.0, 0.0, 0.0));
    let extent_y = transform(world_from_local, vec4<f32>(0.0, bin.half_extents_local.y, 0.0, 0.0));
    let extent_z = transform(world_from_local, vec4<f32>(0.0, 0.0, bin.half_extents_local.z, 0.0));
    let rows = transpose(clip_from_world[light_view]);
    let planes = array<vec4<f32>, 5>(rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1], rows[3] - rows[1], rows[2]);
    for (var i = 0u; i < 5u; i += 1u) {
        let plane = planes[i];
        let reach = abs(dot(plane.xyz, extent_x)) + abs(dot(plane.xyz, extent_y)) + abs(dot(plane.xyz, extent_z));
        // One millimetre and a part in 10⁴ keep rounding on the safe side.
        let slack = 0.001 * length(plane.xyz) + 1e-4 * reach;
        if dot(plane.xyz, center) + plane.w < -(reach + slack) {
            return false;
        }
    }
    return true;
}

// `Mesh` stores the affine matrix as three rows.
fn transform(world_from_local: mat3x4<f32>, point_local: vec4<f32>) -> vec3<f32> {
    return point_local * world_from_local;
}
