// The shadow of a fading level of detail: as many texels of the map as its share says.

#import bevy_pbr::{mesh_functions::get_tag, pbr_prepass_functions::prepass_alpha_discard, prepass_io}
#import umbrage::coat::{coat_shadow, threshold}

#ifdef PREPASS_FRAGMENT
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
