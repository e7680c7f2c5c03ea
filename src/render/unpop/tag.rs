//! What a fading part carries in its [`MeshTag`]: per instance, so that all of a mesh and material stay one batch. The
//! shader twin is `shaders/unpop/coat.wgsl`.

use bevy::mesh::MeshTag;

use crate::lod::chain::LodCoat;

/// Steps of alpha and shadow.
const MOST: u32 = 1023;
/// Levels of a layer that are told apart: their number modulo this.
const NUMBERS: u32 = 1 << 9;
/// Most layers of nearest surfaces.
pub const MOST_LAYERS: u32 = 8;

/// The tag of a coat, with the layer of nearest surfaces that its level is found in.
pub fn tag(coat: &LodCoat, layer: u32) -> MeshTag {
    let share = |value: f32| (value.clamp(0.0, 1.0) * MOST as f32).round() as u32;
    // Of plain blending both levels fade, and the farther one is seen through the nearer.
    let number = coat.object.wrapping_add(u32::from(coat.wins_ties) * (NUMBERS / 2));
    MeshTag(share(coat.alpha) | share(coat.shadow) << 10 | (number % NUMBERS) << 20 | (layer % MOST_LAYERS) << 29)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_values_have_their_bits() {
        let coat = LodCoat {
            alpha: 1.0,
            shadow: 0.0,
            wins_ties: false,
            dithers_shadow: false,
            object: 513,
        };
        assert_eq!(tag(&coat, 0).0, 1023 | 1 << 20);
        assert_eq!(tag(&coat, 7).0, 1023 | 1 << 20 | 7 << 29);
        let coat = LodCoat {
            alpha: f32::NAN,
            shadow: 2.0,
            object: 0,
            ..coat
        };
        assert_eq!(tag(&coat, 0).0, 1023 << 10);
        let coat = LodCoat {
            alpha: 0.5,
            shadow: 0.25,
            ..coat
        };
        assert_eq!(tag(&coat, 0).0, 512 | 256 << 10);
        let finer = LodCoat {
            wins_ties: true,
            ..coat
        };
        assert_eq!(tag(&finer, 0).0, 512 | 256 << 10 | 256 << 20);
    }
}
