// The shadow of a fading level of detail: its share beside its depth in maps of fading casters; in maps of all casters as
// many texels as the share says.

#import bevy_pbr::{mesh_functions::get_tag, pbr_prepass_functions::prepass_alpha_discard, prepass_io}
#import umbrage::coat::{coat_shadow, threshold}
#import umbrage::fading::fading_depth

#ifdef UMBRAGE_FADING_MAP
@fragment
fn fragment(in: prepass_io::VertexOutput) -> @builtin(frag_depth) f32 {
    let share = coat_shadow(get_tag(in.instance_index));
    if share <= 0.0 {
        discard;
    }
    prepass_alpha_discard(in);
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    return fading_depth(saturate(in.unclipped_depth), share);
#else
    return fading_depth(saturate(in.position.z), share);
#endif
}
#else ifdef PREPASS_FRAGMENT
@fragment
fn fragment(in: prepass_io::VertexOutput) -> prepass_io::FragmentOutput {
    leave_out(in);
    var out: prepass_io::FragmentOutput;
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    out.frag_depth = in.unclipped_depth;
#endif
    return out;
}
#else
@fragment
fn fragment(in: prepass_io::VertexOutput) {
    leave_out(in);
}
#endif

fn leave_out(in: prepass_io::VertexOutput) {
    if coat_shadow(get_tag(in.instance_index)) < threshold(vec2<u32>(in.position.xy)) {
        discard;
    }
    prepass_alpha_discard(in);
}
