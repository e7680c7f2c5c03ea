//! Depths that the picture itself has shown, instead of those of bounding boxes (Stingl 2011, section 4.3; Scherzer 2005,
//! section 4.4): [`MeasuredDepths`] asks for them, [`VisibleDepthRange`] brings them, [`known_depths`] says what of them
//! still holds.
//!
//! The render room reduces the depth prepass of every frame and sends its two ends back, one frame late or more. What a
//! late range can be used for, without losing a shadow:
//!
//! - **Near.** [`late_near`] says how near something seen then may have come since. It cannot say what has entered from
//!   beside the picture, so nothing is cut: the plane enters as a pseudo-near plane, from which on the warp is at its
//!   best, and what is nearer stays covered.
//! - **Far.** What was hidden may lie beyond any earlier far plane. The farthest depth enters the warp only, as Δz, never
//!   the bodies.
//! - **Splits.** Their scheme is evaluated between both, while the first partition still begins at the near plane of the
//!   bounds and the last one ends at their far plane.
//!
//! A range of this very picture can cut the view volume itself, as the thesis does by waiting for the GPU.
//! [`MeasureUse::Same`] is this reference without the wait: it uses only ranges that were measured from where the camera
//! stands now. Tools draw each frame twice for it.

use bevy::prelude::*;

use crate::maths::{
    near_plane::{Motion, late_near},
    split::{PseudoPlanes, VisibleDepths},
    view::ViewVolume,
};

/// Which planes come from what the picture shows. Needs the full path; costs one pass over the depth prepass, and nothing
/// when all are off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
pub struct MeasuredDepths {
    /// The near plane of warps. Where [`SunShadows::near`](super::settings::SunShadows::near) is set too, the farther
    /// one counts.
    pub near: NearMeasurement,
    /// The far plane of warps: Δz of n_opt.
    pub far: bool,
    /// Splits between the nearest and the farthest visible depth. Means nothing for splits by hand.
    pub splits: bool,
    /// Which measurements count.
    pub measure: MeasureUse,
}

/// Whether the near plane of warps is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
pub enum NearMeasurement {
    /// Where it helps: for warps of two z-partitions or more. The first of them begins at the camera's near plane, where
    /// hardly ever anything is seen, and a warp that is at its best there is too strong for what is seen behind it. One map
    /// for the whole range loses: what is near is most of the picture. Not with a near plane by hand, and not for maps that
    /// are kept from frame to frame.
    #[default]
    Slices,
    /// Always.
    On,
    /// Never: the near plane of the bounds.
    Off,
}

/// Which measurements count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
pub enum MeasureUse {
    /// Those of an earlier frame, with what may have happened since; nothing is cut. For games.
    #[default]
    Late,
    /// Only those from where the camera stands now, and they cut: the reference. Sharpest, and right as long as the scene
    /// stands still. A camera that moves has none, unless each frame is drawn twice.
    Same,
}

impl MeasuredDepths {
    /// Nothing is measured: all planes come from bounding boxes.
    pub const OFF: Self = Self {
        near: NearMeasurement::Off,
        ..Self::BEST
    };

    /// The near plane where it helps.
    pub const BEST: Self = Self {
        near: NearMeasurement::Slices,
        far: false,
        splits: false,
        measure: MeasureUse::Late,
    };

    /// Whether the depths of the picture are asked for. The default of the near plane asks for them where it helps only:
    /// see [`SunShadows::measures`](super::settings::SunShadows::measures).
    #[must_use]
    pub fn is_on(self) -> bool {
        self.near == NearMeasurement::On || self.far || self.splits
    }
}

/// From where a depth range was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredView {
    /// The camera in the world.
    pub world_from_view: GlobalTransform,
    /// Its projection, reverse z.
    pub clip_from_view: Mat4,
    /// Time since the start of the app, in seconds.
    pub seconds: f64,
}

/// On a camera whose sun asks for [`MeasuredDepths`]: the depths that one of its last frames showed. The render room
/// inserts it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct VisibleDepthRange {
    /// Nearest and farthest view depth of a pixel with geometry, in metres. `None`: the picture showed only sky.
    pub depths: Option<VisibleDepths>,
    /// Pixels with geometry.
    pub pixel_count: u32,
    /// From where it was measured.
    pub view: MeasuredView,
}

/// What is known of the depths that a camera sees now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnownDepths {
    /// Nothing: no measurement, an empty picture, or one that has nothing to do with this one (a cut).
    Unknown,
    /// Measured from where the camera stands now.
    Same(VisibleDepths),
    /// Measured before: the nearest depth already allows for what may have happened since.
    Late(VisibleDepths),
}

/// Speed that things in the scene may have, in metres per second: a car in a town. It widens late measurements; nothing is
/// lost if something is faster.
pub const MOVER_SPEED: f64 = 15.0;
/// Age from which a measurement says nothing, in seconds.
pub const LARGEST_AGE: f64 = 0.25;
/// Part of the opening of the picture by which a camera may turn between both frames; more is a cut.
const LARGEST_TURN: f64 = 0.25;
/// Part of the farthest visible depth by which it may have moved; more is a cut.
const LARGEST_STEP: f64 = 0.25;

/// What a measurement says about a camera now. `view` is its view volume, `now` where it stands.
pub fn known_depths(measured: &VisibleDepthRange, view: &ViewVolume, now: &MeasuredView) -> KnownDepths {
    let Some(depths) = measured.depths else {
        return KnownDepths::Unknown;
    };
    let then = &measured.view;
    if (then.world_from_view, then.clip_from_view) == (now.world_from_view, now.clip_from_view) {
        return KnownDepths::Same(depths);
    }
    let time = now.seconds - then.seconds;
    let turn = f64::from(
        then.world_from_view
            .rotation()
            .angle_between(now.world_from_view.rotation()),
    );
    let step = f64::from(
        then.world_from_view
            .translation()
            .distance(now.world_from_view.translation()),
    );
    let is_same_picture = (0.0..=LARGEST_AGE).contains(&time)
        && turn <= LARGEST_TURN * view.opening().min_element().atan()
        && step <= LARGEST_STEP * depths.farthest
        && is_similar(&then.clip_from_view, &now.clip_from_view);
    if !is_same_picture {
        return KnownDepths::Unknown;
    }
    // The whole way and the whole turn, as one step of a second.
    let motion = Motion {
        speed: step + MOVER_SPEED * time,
        turning: turn,
        time: 1.0,
    };
    KnownDepths::Late(VisibleDepths {
        nearest: late_near(depths.nearest, view, &motion).min(depths.farthest),
        farthest: depths.farthest + motion.speed,
    })
}

/// Whether two projections open about as wide: a zoom, not a cut.
fn is_similar(then: &Mat4, now: &Mat4) -> bool {
    let ratio = |axis: usize| f64::from(now.col(axis)[axis] / then.col(axis)[axis]);
    let range = 1.0 - LARGEST_TURN..=1.0 / (1.0 - LARGEST_TURN);
    [0, 1].into_iter().all(|axis| range.contains(&ratio(axis))) && then.w_axis.w == now.w_axis.w
}

/// What a camera's light views take from measured depths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthPlan {
    /// Cuts the view volume for receivers: nearest and farthest view depth. Infinite where nothing is cut.
    pub cut: Option<(f64, f64)>,
    /// Where splits are evaluated.
    pub splits: Option<PseudoPlanes>,
    /// The pseudo-near plane of warps.
    pub near: Option<f64>,
    /// The pseudo-far plane of warps: the farthest visible depth.
    pub far: Option<f64>,
}

impl DepthPlan {
    /// The plan of known depths under these settings, as [`SunShadows::measures`](super::settings::SunShadows::measures)
    /// has them.
    pub fn new(settings: MeasuredDepths, known: KnownDepths) -> Self {
        let is_near = settings.near == NearMeasurement::On;
        let planes = |depths: VisibleDepths| PseudoPlanes {
            near: depths.nearest,
            far: depths.farthest,
        };
        match (known, settings.measure) {
            (KnownDepths::Same(depths), MeasureUse::Same) => {
                // Depths come back in single precision.
                let near = is_near.then_some(depths.nearest * (1.0 - ROUNDING));
                let far = settings.far.then_some(depths.farthest * (1.0 + ROUNDING));
                Self {
                    cut: Some((near.unwrap_or(f64::NEG_INFINITY), far.unwrap_or(f64::INFINITY))),
                    splits: settings.splits.then_some(planes(depths)),
                    ..default()
                }
            }
            (KnownDepths::Unknown, _) | (KnownDepths::Late(_), MeasureUse::Same) => Self::default(),
            (KnownDepths::Same(depths) | KnownDepths::Late(depths), MeasureUse::Late) => Self {
                cut: None,
                splits: settings.splits.then_some(planes(depths)),
                near: is_near.then_some(depths.nearest),
                far: settings.far.then_some(depths.farthest),
            },
        }
    }

    /// The part of a view volume in which there are receivers; the whole one where the cut leaves nothing.
    pub fn cut_view(&self, view: &ViewVolume) -> ViewVolume {
        let (near, far) = self.cut.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let (near, far) = (near.max(view.near()), far.min(view.far()));
        if near < far {
            view.split(near, far)
        } else {
            view.clone()
        }
    }
}

/// Relative error of a depth in single precision that went through a projection and back.
const ROUNDING: f64 = 1.0e-5;

#[cfg(test)]
mod tests {
    use bevy::math::DVec3;

    use super::*;
    use crate::{
        maths::warp::Warp,
        shadow::{
            settings::{ShadowPath, SunShadows},
            stable::Stability,
        },
    };

    const DEPTHS: VisibleDepths = VisibleDepths {
        nearest: 10.0,
        farthest: 80.0,
    };

    fn place(x: f32, yaw: f32, seconds: f64) -> MeasuredView {
        let transform = Transform::from_xyz(x, 2.0, 0.0).with_rotation(Quat::from_rotation_y(yaw));
        MeasuredView {
            world_from_view: transform.into(),
            clip_from_view: Mat4::perspective_infinite_reverse_rh(1.0, 1.5, 0.1),
            seconds,
        }
    }

    fn known(now: MeasuredView) -> KnownDepths {
        let measured = VisibleDepthRange {
            depths: Some(DEPTHS),
            pixel_count: 1,
            view: place(0.0, 0.0, 1.0),
        };
        let forward = now.world_from_view.forward().as_vec3().as_dvec3();
        let eye = now.world_from_view.translation().as_dvec3();
        let view = ViewVolume::perspective(eye, forward, DVec3::Y, 1.0, 1.5, 0.1, 500.0).expect("a view");
        known_depths(&measured, &view, &now)
    }

    #[test]
    fn the_near_plane_is_measured_where_it_helps() {
        let measures = |change: fn(&mut SunShadows)| {
            let mut settings = SunShadows::HIGH;
            change(&mut settings);
            settings.measures().near == NearMeasurement::On
        };
        assert!(measures(|_| {}) && measures(|settings| settings.stable = Stability::SHARP));
        assert!(!measures(|settings| settings.partitions.count = 1), "one map");
        assert!(!measures(|settings| settings.warp = Warp::Uniform), "no warp");
        assert!(!measures(|settings| settings.path = ShadowPath::DropIn), "no prepass");
        assert!(!measures(|settings| settings.near = Some(2.0)), "by hand");
        assert!(!measures(|settings| settings.stable = Stability::Held), "kept maps");
        assert!(!measures(|settings| settings.measured = MeasuredDepths::OFF), "never");
        assert!(measures(|settings| {
            settings.partitions.count = 1;
            settings.measured.near = NearMeasurement::On;
        }));
    }

    #[test]
    fn a_camera_that_stands_still_knows() {
        assert_eq!(known(place(0.0, 0.0, 1.0)), KnownDepths::Same(DEPTHS));
    }

    /// Walking straight into what is nearest: the plane stays in front of it, and in front of what drives towards us.
    #[test]
    fn late_depths_allow_for_motion() {
        let KnownDepths::Late(late) = known(place(0.1, 0.01, 1.0 + 1.0 / 60.0)) else {
            panic!("a step is no cut");
        };
        // 0.1 m and a sixtieth of 15 m; the turn by 0.01 shrinks by tan θ · 0.01 more, with tan θ = 0.985.
        let expected = 10.0 * (0.01f64.cos() - (0.5f64.tan() * 1.5f64.hypot(1.0)) * 0.01f64.sin()) - 0.1 - 0.25;
        assert!((late.nearest - expected).abs() < 1.0e-3, "{late:?}, not {expected}");
        assert!(late.farthest >= 80.35 - 1.0e-6, "{late:?}");
    }

    #[test]
    fn cuts_are_known() {
        let frame = 1.0 + 1.0 / 60.0;
        for (name, now) in [
            ("teleport", place(50.0, 0.0, frame)),
            ("turn", place(0.0, 0.5, frame)),
            ("pause", place(0.01, 0.0, 2.0)),
            ("clock set back", place(0.01, 0.0, 0.5)),
            (
                "another lens",
                MeasuredView {
                    clip_from_view: Mat4::perspective_infinite_reverse_rh(0.3, 1.5, 0.1),
                    ..place(0.01, 0.0, frame)
                },
            ),
            (
                "another kind of lens",
                MeasuredView {
                    clip_from_view: Mat4::IDENTITY,
                    ..place(0.01, 0.0, frame)
                },
            ),
        ] {
            assert_eq!(known(now), KnownDepths::Unknown, "{name}");
        }
    }

    #[test]
    fn only_the_same_picture_cuts() {
        let all = MeasuredDepths {
            near: NearMeasurement::On,
            far: true,
            splits: true,
            measure: MeasureUse::Late,
        };
        let late = DepthPlan::new(all, KnownDepths::Late(DEPTHS));
        assert_eq!(late.cut, None);
        assert_eq!((late.near, late.far), (Some(10.0), Some(80.0)));
        let same = DepthPlan::new(
            MeasuredDepths {
                measure: MeasureUse::Same,
                ..all
            },
            KnownDepths::Same(DEPTHS),
        );
        assert!(
            same.cut
                .is_some_and(|(near, far)| near < 10.0 && near > 9.999 && far > 80.0 && far < 80.01)
        );
        assert_eq!((same.near, same.far), (None, None), "what is cut needs no pseudo plane");
        for known in [KnownDepths::Unknown, KnownDepths::Late(DEPTHS)] {
            let plan = DepthPlan::new(
                MeasuredDepths {
                    measure: MeasureUse::Same,
                    ..all
                },
                known,
            );
            assert_eq!(plan, DepthPlan::default(), "{known:?}");
        }
        assert_eq!(
            DepthPlan::new(MeasuredDepths::OFF, KnownDepths::Late(DEPTHS)),
            DepthPlan::default()
        );
    }
}
