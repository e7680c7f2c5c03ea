// The receiver's plane in a light view; the CPU twin is `src/maths/bias.rs`.
#define_import_path umbrage::bias

#import umbrage::spaces::uv_from_ndc

// Surfaces are treated as if they met the light at this cosine at least (89.4 degrees): beyond it the depth span of a
// texel grows without limit, while direct light is below a hundredth.
const MIN_COS_LIGHT: f32 = 0.01;

struct ReceiverPlane {
    // Texture coordinates in the map, 0..1; y down.
    uv: vec2<f32>,
    // Depth of the receiver, NDC.
    depth_ndc: f32,
    // Change of depth over the map on the receiver's plane.
    depth_per_uv: vec2<f32>,
    // Change of depth for one metre towards the light.
    depth_per_metre: f32,
    // Area of texture coordinates per square metre of the receiver's plane.
    uv_area_per_square_metre: f32,
    // Perspective divisor; at most 0: the point is behind the projection centre.
    w: f32,
}

// The normal of the plane's side that looks to the light, turned so far towards it that their cosine is at least
// MIN_COS_LIGHT. A plane has no side: light falls through a leaf whose lit side the viewer does not see.
fn limited_normal(normal: vec3<f32>, to_light: vec3<f32>) -> vec3<f32> {
    let cosine = dot(normal, to_light);
    if abs(cosine) >= MIN_COS_LIGHT {
        return normal * sign(cosine);
    }
    let across = normal - cosine * to_light;
    let across_length = length(across);
    if across_length < 1e-6 {
        return to_light;
    }
    return across / across_length * sqrt(1.0 - MIN_COS_LIGHT * MIN_COS_LIGHT) + to_light * MIN_COS_LIGHT;
}

// With clip = M p and ndc = clip.xyz / w, a step t in the world changes ndc by (M t - ndc (row_w . t)) / w. Two steps
// that span the plane give a 2x2 system for the gradient of depth over (u, v).
fn receiver_plane(
    clip_from_world: mat4x4<f32>,
    position: vec3<f32>,
    normal: vec3<f32>,
    to_light: vec3<f32>,
) -> ReceiverPlane {
    var plane: ReceiverPlane;
    let clip = clip_from_world * vec4<f32>(position, 1.0);
    plane.w = clip.w;
    if clip.w <= 0.0 {
        return plane;
    }
    let ndc = clip.xyz / clip.w;
    plane.uv = uv_from_ndc(ndc.xy);
    plane.depth_ndc = ndc.z;

    let n = limited_normal(normal, to_light);
    let helper = select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), abs(n.x) > 0.7);
    let tangent = normalize(cross(n, helper));
    let bitangent = cross(n, tangent);
    let step_t = ndc_step(clip_from_world, ndc, clip.w, tangent);
    let step_b = ndc_step(clip_from_world, ndc, clip.w, bitangent);
    let uv_t = step_t.xy * vec2<f32>(0.5, -0.5);
    let uv_b = step_b.xy * vec2<f32>(0.5, -0.5);
    let determinant = uv_t.x * uv_b.y - uv_b.x * uv_t.y;
    plane.depth_per_uv = vec2<f32>(
        (step_t.z * uv_b.y - step_b.z * uv_t.y) / determinant,
        (step_b.z * uv_t.x - step_t.z * uv_b.x) / determinant,
    );
    plane.uv_area_per_square_metre = abs(determinant);
    plane.depth_per_metre = ndc_step(clip_from_world, ndc, clip.w, to_light).z;
    return plane;
}

fn ndc_step(clip_from_world: mat4x4<f32>, ndc: vec3<f32>, w: f32, step: vec3<f32>) -> vec3<f32> {
    let clip_step = clip_from_world * vec4<f32>(step, 0.0);
    return (clip_step.xyz - ndc * clip_step.w) / w;
}
