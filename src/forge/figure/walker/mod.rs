//! People on foot: one skeleton of 1.75 m, three outfits.

mod body;
mod motion;

use bevy_math::Vec3;

use super::{
    grow::{Level, levels},
    skeleton,
};
use crate::forge::{
    mesh::{Material, Model, Variant},
    rig::{Joint, Rig},
};

const LEVELS: [Level; 3] = [
    Level {
        triangles: 4000,
        screen_coverage: 0.25,
    },
    Level {
        triangles: 1000,
        screen_coverage: 0.08,
    },
    Level {
        triangles: 280,
        screen_coverage: 0.0,
    },
];

/// A man in a jacket, a woman in a coat with a bag, a man with a hat; clips `walk` and `stand`. The upper garment's
/// material is called `paint`: white, to be tinted.
pub fn forge() -> Model {
    let joints = joints();
    let mut model = Model::default();
    let cloth = model.add_material(Material::plain("paint_cloth", [0.9; 3]));
    let picture = model.add_picture(body::palette());
    let rest = model.add_material(Material {
        base_picture: Some(picture),
        roughness: 0.8,
        ..Material::plain("walker", [1.0; 3])
    });
    for outfit in &body::OUTFITS {
        let pieces = body::pieces(&joints, outfit, [cloth, rest]);
        model.variants.push(Variant {
            name: outfit.name.into(),
            lods: levels(&joints, &pieces, &LEVELS),
        });
    }
    let clips = vec![motion::walk(&joints), motion::stand(&joints)];
    model.rig = Some(Rig { joints, clips });
    model
}

/// Each leg is in a plane x = constant in the bind pose; the arms hang a little off the body.
fn joints() -> Vec<Joint> {
    let at = Vec3::new;
    skeleton(&[
        ("hips", "", at(0.0, 0.94, 0.0)),
        ("spine", "hips", at(0.0, 1.06, 0.0)),
        ("chest", "spine", at(0.0, 1.22, -0.015)),
        ("neck", "chest", at(0.0, 1.46, -0.02)),
        ("head", "neck", at(0.0, 1.55, -0.005)),
        ("upper_arm_l", "chest", at(0.180, 1.405, -0.02)),
        ("lower_arm_l", "upper_arm_l", at(0.300, 1.150, -0.03)),
        ("hand_l", "lower_arm_l", at(0.380, 0.905, 0.0)),
        ("thigh_l", "hips", at(0.095, 0.91, 0.0)),
        ("shin_l", "thigh_l", at(0.095, 0.49, 0.012)),
        ("foot_l", "shin_l", at(0.095, 0.085, -0.02)),
        ("toe_l", "foot_l", at(0.095, 0.025, 0.10)),
    ])
}
