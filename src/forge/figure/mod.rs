//! Inhabitants: skinned figures that walk.
//!
//! ```text
//! capsules along bones ──► surface ──► fewer triangles, three levels ──► normals, weights, shade ─┐
//! field                    march       decimate                          grow                     ├─► .glb
//! joints ──► key poses of legs that reach for the ground ──────────────────────────────► clips ───┘
//! rig        limb, deer/motion, walker/motion
//! ```
//!
//! Figures look along +z and stand at the origin; they walk on the spot, as far as [`Clip::metres`](super::rig::Clip)
//! says per loop.

pub mod decimate;
pub mod deer;
pub mod field;
pub mod grow;
pub mod limb;
pub mod march;
pub mod walker;

use bevy_math::Vec3;

use super::{Recipe, rig::Joint};

/// The figures.
pub const RECIPES: [Recipe; 2] = [
    Recipe {
        name: "deer",
        about: "red deer: a stag, a hind; they walk and graze",
        make: deer::forge,
    },
    Recipe {
        name: "walker",
        about: "people in jacket, coat and hat; they walk and stand",
        make: walker::forge,
    },
];

/// Joints from names, parents' names and places; those whose names end in `_l` get a right twin.
fn skeleton(table: &[(&str, &str, Vec3)]) -> Vec<Joint> {
    let mut joints: Vec<Joint> = Vec::new();
    let mut add = |name: String, parent: &str, position: Vec3| {
        let parent = joints.iter().position(|joint| joint.name == parent);
        joints.push(Joint { name, parent, position });
    };
    for (name, parent, position) in table {
        add((*name).to_owned(), parent, *position);
        if let Some(stem) = name.strip_suffix("_l") {
            let twin = parent
                .strip_suffix("_l")
                .map_or((*parent).to_owned(), |stem| format!("{stem}_r"));
            add(format!("{stem}_r"), &twin, grow::mirror(*position));
        }
    }
    joints
}

/// Index of a joint that the figure's own table names.
///
/// # Panics
/// With a name that is not in the table.
fn joint(joints: &[Joint], name: &str) -> usize {
    let found = joints.iter().position(|joint| joint.name == name);
    found.unwrap_or_else(|| panic!("the skeleton has no joint `{name}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_joints_get_right_twins_with_right_parents() {
        let joints = skeleton(&[
            ("hips", "", Vec3::Y),
            ("thigh_l", "hips", Vec3::new(0.1, 0.9, 0.0)),
            ("shin_l", "thigh_l", Vec3::new(0.1, 0.5, 0.0)),
        ]);
        let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(names, ["hips", "thigh_l", "thigh_r", "shin_l", "shin_r"]);
        let parents: Vec<Option<usize>> = joints.iter().map(|joint| joint.parent).collect();
        assert_eq!(parents, [None, Some(0), Some(0), Some(1), Some(2)]);
        assert_eq!(joints[4].position, Vec3::new(-0.1, 0.5, 0.0));
        assert_eq!(grow::opposite(&joints, 3), 4);
        assert_eq!(grow::opposite(&joints, 0), 0);
    }
}
