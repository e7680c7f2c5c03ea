//! [`PictureCamera`]: the camera whose picture is looked at, and what the shaders read of it.

use bevy::math::{DMat4, DVec4, Mat4, UVec2, Vec2};

use crate::{
    maths::virtual_map::{
        feedback::PictureMotion,
        mapping::{MappingOptions, NeedMeasure, NeighbourPick},
    },
    render::gpu_types::NeedParameters,
};

/// A camera and its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureCamera {
    /// Rigid: place and direction of the camera.
    pub world_from_view: DMat4,
    /// The projection, with the jitter of this frame.
    pub clip_from_view: DMat4,
    /// Pixels of the viewport.
    pub size: UVec2,
    /// The viewport's first pixel in the target.
    pub origin: UVec2,
}

impl PictureCamera {
    /// Clip space of the picture to the world, in double precision.
    pub fn world_from_clip(&self) -> DMat4 {
        self.world_from_view * self.clip_from_view.inverse()
    }

    /// The motion of the picture for a bound of the camera's motion between two frames: metres and radians. `None` for
    /// orthographic cameras, whose needs stay under motion.
    pub fn motion(&self, step: f64, turn: f64) -> Option<PictureMotion> {
        let scale = self.clip_from_view;
        let is_parallel = scale.w_axis.w == 1.0;
        let focal = [
            scale.x_axis.x * f64::from(self.size.x),
            scale.y_axis.y * f64::from(self.size.y),
        ];
        // Off-centre frusta: the corner that is farthest from the axis.
        let corner = [(scale.x_axis.x, scale.z_axis.x), (scale.y_axis.y, scale.z_axis.y)]
            .map(|(scale, offset)| (1.0 + offset.abs()) / scale);
        (!is_parallel).then(|| PictureMotion {
            step,
            turn,
            focal: focal[0].max(focal[1]) * 0.5,
            corner: corner[0].hypot(corner[1]),
        })
    }

    /// How far the camera has moved since another frame, in metres and radians.
    pub fn moved_since(&self, earlier: &Self) -> [f64; 2] {
        let step = (self.world_from_view.w_axis - earlier.world_from_view.w_axis).length();
        let turn = self.world_from_view * earlier.world_from_view.inverse();
        let trace = turn.x_axis.x + turn.y_axis.y + turn.z_axis.z;
        [step, ((trace - 1.0) * 0.5).clamp(-1.0, 1.0).acos()]
    }
}

/// What the shaders read. `clip_from_world`: the light view of the whole map, as the lookup has it; `depths`: the view
/// depths in metres of the pixels that count, half open; `map_size`: texels of a mapping map, or the picture's; `cells`: per
/// axis of the grid. `options.bytes` and `skip_facing_away` are not for the
/// shaders' parameters.
pub fn need_parameters(
    camera: &PictureCamera,
    clip_from_world: Mat4,
    depths: [f32; 2],
    options: &MappingOptions,
    map_size: UVec2,
    cells: u32,
) -> NeedParameters {
    let world_from_clip = camera.world_from_clip();
    let row: DVec4 = world_from_clip.row(3);
    let is_parallel = row.truncate().abs().max_element() <= 1.0e-12 * row.w.abs();
    let motion = options.motion.as_ref();
    NeedParameters {
        map_from_picture: (clip_from_world.as_dmat4() * world_from_clip).as_mat4(),
        clip_from_world,
        // Zeros tell the shader that depth is linear already.
        inverse_depth: if is_parallel {
            DVec4::new(0.0, 0.0, 0.0, 1.0)
        } else {
            row
        }
        .as_vec4(),
        picture_size: camera.size,
        picture_origin: camera.origin,
        map_size,
        cells_per_axis: cells,
        measure: match options.measure {
            NeedMeasure::Sides => 0,
            NeedMeasure::Extent => 1,
            NeedMeasure::Box => 2,
        },
        pick: match options.pick {
            NeighbourPick::Smaller => 0,
            NeighbourPick::Larger => 1,
        },
        need_scale: (-options.need_bias).exp2() as f32,
        depth_range: Vec2::from(depths),
        wide_steps: u32::from(options.wide_steps),
        motion_step: motion.map_or(-1.0, |motion| motion.step as f32),
        motion_turn_factor: motion.map_or(1.0, |motion| motion.turn_factor() as f32),
        motion_focal: motion.map_or(0.0, |motion| motion.focal as f32),
        motion_corner: motion.map_or(0.0, |motion| motion.corner as f32),
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::DVec3;

    use super::*;
    use crate::maths::{near_plane::Motion, view::ViewVolume};

    fn camera(eye: DVec3, yaw: f64) -> PictureCamera {
        PictureCamera {
            world_from_view: DMat4::from_translation(eye) * DMat4::from_rotation_y(yaw),
            clip_from_view: DMat4::perspective_infinite_reverse_rh(1.0, 16.0 / 9.0, 0.1),
            size: UVec2::new(160, 90),
            origin: UVec2::ZERO,
        }
    }

    #[test]
    fn motion_is_that_of_the_view_volume() {
        let view = ViewVolume::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 16.0 / 9.0, 0.1, 100.0).unwrap();
        let motion = Motion {
            speed: 0.2,
            turning: 0.01,
            time: 1.0,
        };
        let expected = PictureMotion::new(&view, &motion, 90.0).unwrap();
        let found = camera(DVec3::ZERO, 0.0).motion(0.2, 0.01).unwrap();
        for (name, expected, found) in [
            ("step", expected.step, found.step),
            ("turn", expected.turn, found.turn),
            ("focal", expected.focal, found.focal),
            ("corner", expected.corner, found.corner),
        ] {
            assert!(
                (expected - found).abs() < 1.0e-9 * expected,
                "{name}: {expected}, {found}"
            );
        }
        let parallel = PictureCamera {
            clip_from_view: DMat4::orthographic_rh(-1.0, 1.0, -1.0, 1.0, 100.0, 0.0),
            ..camera(DVec3::ZERO, 0.0)
        };
        assert_eq!(parallel.motion(0.2, 0.01), None, "needs of parallel pictures stay");
    }

    #[test]
    fn moves_are_measured() {
        let [step, turn] = camera(DVec3::new(3.0, 4.0, 0.0), 0.3).moved_since(&camera(DVec3::ZERO, 0.1));
        assert!(
            (step - 5.0).abs() < 1.0e-12 && (turn - 0.2).abs() < 1.0e-9,
            "{step} m, {turn} rad"
        );
    }
}
