//! Red deer (Cervus elaphus): a stag with antlers and a mane, and a hind.
//!
//! A stag stands 1.2 m high at the shoulder and measures 2 m from nose to tail.

mod body;
mod coat;
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
        triangles: 4200,
        screen_coverage: 0.22,
    },
    Level {
        triangles: 1100,
        screen_coverage: 0.07,
    },
    Level {
        triangles: 360,
        screen_coverage: 0.0,
    },
];

/// Stag and hind, with their clips `walk` and `graze`.
pub fn forge() -> Model {
    let joints = joints();
    let mut model = Model::default();
    let picture = model.add_picture(coat::picture());
    let material = model.add_material(Material {
        base_picture: Some(picture),
        ..Material::plain("deer", [1.0; 3])
    });
    for (name, stag) in [("stag", true), ("hind", false)] {
        let pieces = body::pieces(&joints, material, stag);
        model.variants.push(Variant {
            name: name.into(),
            lods: levels(&joints, &pieces, &LEVELS),
        });
    }
    let clips = vec![motion::walk(&joints), motion::graze(&joints)];
    model.rig = Some(Rig { joints, clips });
    model
}

/// Each leg is in a plane x = constant in the bind pose.
fn joints() -> Vec<Joint> {
    let at = Vec3::new;
    skeleton(&[
        ("hips", "", at(0.0, 1.06, -0.48)),
        ("spine", "hips", at(0.0, 1.08, -0.18)),
        ("chest", "spine", at(0.0, 1.06, 0.14)),
        ("neck_low", "chest", at(0.0, 1.02, 0.42)),
        ("neck_high", "neck_low", at(0.0, 1.24, 0.60)),
        ("head", "neck_high", at(0.0, 1.48, 0.72)),
        ("ear_l", "head", at(0.06, 1.57, 0.70)),
        ("tail", "hips", at(0.0, 1.08, -0.72)),
        ("scapula_l", "chest", at(0.10, 1.10, 0.22)),
        ("humerus_l", "scapula_l", at(0.10, 0.86, 0.38)),
        ("radius_l", "humerus_l", at(0.10, 0.72, 0.26)),
        ("cannon_l", "radius_l", at(0.10, 0.41, 0.285)),
        ("hoof_l", "cannon_l", at(0.10, 0.125, 0.275)),
        ("femur_l", "hips", at(0.11, 1.00, -0.50)),
        ("tibia_l", "femur_l", at(0.11, 0.76, -0.36)),
        ("metatarsus_l", "tibia_l", at(0.11, 0.52, -0.65)),
        ("hind_hoof_l", "metatarsus_l", at(0.11, 0.13, -0.575)),
    ])
}
