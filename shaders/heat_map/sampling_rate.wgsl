// Texels per pixel in color over the picture, from the Jacobian of map over picture on the receiver (Stingl, section 5.7 and
// listing A.3): its determinant, or the length of one of its rows with UMBRAGE_RATE_ACROSS or UMBRAGE_RATE_ALONG.
//
// The CPU twin is `src/maths/sampling_rate.rs`.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::bias::{limited_normal, ndc_step}
#import umbrage::selection::{parameters, select_view}
#import umbrage::surface::{load_depth, surface_at, view}

// Colors, sRGB, and the texels per pixel that have them.
const RATE_KNOTS: array<vec4<f32>, 7> = array<vec4<f32>, 7>(
    vec4<f32>(0.2, 0.0, 0.0, 0.0), vec4<f32>(1.0, 0.2, 0.0, 1.0 / 7.75), vec4<f32>(1.0, 1.0, 0.0, 1.0 / 3.25),
    vec4<f32>(0.0, 1.0, 0.0, 1.0), vec4<f32>(0.3, 0.8, 1.0, 3.25), vec4<f32>(0.0, 0.0, 1.0, 7.75),
    vec4<f32>(0.0, 0.0, 0.4, 10.0),
);

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
    let depth_ndc = load_depth(vec2<i32>(in.position.xy));
    if depth_ndc <= 0.0 {
        return vec4<f32>(0.0);
    }
    let surface = surface_at(in.position.xy, depth_ndc, parameters.direction_to_light);
    let selected = select_view(surface);
    if !selected.is_found {
        return vec4<f32>(0.0);
    }
    // Edge-on to the viewer a pixel would have no end.
    let normal = limited_normal(surface.normal, normalize(view.world_position - surface.position));
    let map_size = parameters.light_views[selected.index].atlas_rect.zw;
    let texels = steps_per_metre(
        parameters.light_views[selected.index].clip_from_world, surface.position, normal, map_size);
    let pixels = steps_per_metre(view.clip_from_world, surface.position, normal, view.viewport.zw);
    let color = rate_color(rate(texels * inverted(pixels)));
    return vec4<f32>(linear_from_srgb(color), parameters.opacity);
}

// Texels (or pixels) per metre along two tangents of a plane, one tangent a column. The sign of y does not matter here.
fn steps_per_metre(
    clip_from_world: mat4x4<f32>,
    position: vec3<f32>,
    normal: vec3<f32>,
    size: vec2<f32>,
) -> mat2x2<f32> {
    let clip = clip_from_world * vec4<f32>(position, 1.0);
    let ndc = clip.xyz / clip.w;
    let helper = select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), abs(normal.x) > 0.7);
    let tangent = normalize(cross(normal, helper));
    let bitangent = cross(normal, tangent);
    return mat2x2<f32>(
        0.5 * size * ndc_step(clip_from_world, ndc, clip.w, tangent).xy,
        0.5 * size * ndc_step(clip_from_world, ndc, clip.w, bitangent).xy,
    );
}

fn inverted(m: mat2x2<f32>) -> mat2x2<f32> {
    return mat2x2<f32>(m[1].y, -m[0].y, -m[1].x, m[0].x) * (1.0 / determinant(m));
}

// Columns: texels for a step of one pixel to the right, and up.
fn rate(texels_per_pixel: mat2x2<f32>) -> f32 {
#ifdef UMBRAGE_RATE_ACROSS
    return length(vec2<f32>(texels_per_pixel[0].x, texels_per_pixel[1].x));
#else
#ifdef UMBRAGE_RATE_ALONG
    return length(vec2<f32>(texels_per_pixel[0].y, texels_per_pixel[1].y));
#else
    return abs(determinant(texels_per_pixel));
#endif
#endif
}

// Straight lines between the knots: an interval leaves its end beyond it and changes nothing before it.
fn rate_color(texels_per_pixel: f32) -> vec3<f32> {
    var knots = RATE_KNOTS;
    var color = knots[0].rgb;
    for (var i = 1u; i < 7u; i += 1u) {
        let start = knots[i - 1u].a;
        let share = saturate((texels_per_pixel - start) / (knots[i].a - start));
        color = mix(color, knots[i].rgb, share);
    }
    return color;
}

fn linear_from_srgb(color: vec3<f32>) -> vec3<f32> {
    return select(pow((color + 0.055) / 1.055, vec3<f32>(2.4)), color / 12.92, color <= vec3<f32>(0.04045));
}
