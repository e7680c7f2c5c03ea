//! What several figures use: cameras, axes, curves along the view.

use bevy_math::DVec3;

use crate::{
    maths::{
        analysis::{
            direction::{TiltedWarp, frustum_map},
            overhead::{OverheadRange, OverheadSlice, OverheadWarp},
        },
        error::AxisErrors,
        split::SplitScheme,
        view::ViewVolume,
    },
    plot::{Axis, Curve, Curves, Scale},
};

/// 2 tan Θ for Θ = 30°, the papers' camera.
pub(super) const OPENING: f64 = 1.154_700_538_379_251_7;

/// Said wherever light comes from inside the view cone.
pub(super) const CONE_NOTE: &str = "Where theory ends: with light from inside the view cone (angle between light and view \
    below 30° or above 150°) the frustum has no trapezoidal outline, and the published n' is no optimum but makes the map \
    worse than no warp.";

/// Said wherever equal storage of warps is shown.
pub(super) const ERRATUM_NOTE: &str = "Where theory ends: that all n' from n to n'_LSPSM need equal storage holds for light \
    from overhead only, as the authors' erratum says; for other directions it does not.";

/// The papers' camera: square, 60° opening, near 1.
///
/// # Panics
/// Never: the numbers are sound.
pub(super) fn camera(far: f64) -> ViewVolume {
    let fov_y = 60.0_f64.to_radians();
    ViewVolume::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov_y, 1.0, 1.0, far).expect("sound numbers")
}

/// Light that travels at an angle to that camera's view direction, in degrees: 0 from behind, 90 from overhead.
pub(super) fn light_at(degrees: f64) -> DVec3 {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    DVec3::new(0.0, -sine, -cosine)
}

/// A range under light from overhead, Θ = 30°.
///
/// # Panics
/// Never: the numbers are sound.
pub(super) fn overhead(near: f64, far: f64) -> OverheadRange {
    OverheadRange::new(near, far, OPENING).expect("sound numbers")
}

pub(super) fn axis(label: &str, scale: Scale) -> Axis {
    Axis {
        label: label.to_owned(),
        scale,
        range: None,
    }
}

pub(super) fn curve(label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
    Curve {
        label: label.into(),
        points: points.into_iter().collect(),
    }
}

/// Numbers from `low` to `high` in equal ratios, both included.
pub(super) fn ratios(low: f64, high: f64, steps: usize) -> impl Iterator<Item = f64> + Clone {
    (0..=steps).map(move |step| match step {
        0 => low,
        _ if step == steps => high,
        _ => low * (high / low).powf(step as f64 / steps as f64),
    })
}

/// A configuration with its name: the maps of a depth range.
pub(super) struct Configuration {
    pub(super) name: &'static str,
    pub(super) slices: Vec<OverheadSlice>,
}

/// One map.
pub(super) fn single(name: &'static str, near: f64, far: f64, warp: OverheadWarp) -> Configuration {
    sliced(name, near, far, &SplitScheme::Logarithmic, 1, warp)
}

/// Maps in slices.
pub(super) fn sliced(
    name: &'static str,
    near: f64,
    far: f64,
    scheme: &SplitScheme,
    count: usize,
    warp: OverheadWarp,
) -> Configuration {
    Configuration {
        name,
        slices: overhead(near, far).slices(scheme, count, warp),
    }
}

/// Error along the view: a panel for m_x and one for m_z, on one scale.
pub(super) fn along_view(configurations: &[Configuration]) -> Vec<Curves> {
    let errors = |configuration: &Configuration, of: fn(AxisErrors) -> f64| -> Vec<(f64, f64)> {
        let slices = configuration.slices.iter();
        let points = slices.flat_map(|slice| {
            let depths = ratios(slice.range.near(), slice.range.far(), 120);
            depths.filter_map(|depth| Some((depth, of(slice.range.errors(slice.warp_near, depth)?))))
        });
        points.collect()
    };
    let both = configurations.iter().map(|configuration| {
        let pair = [
            errors(configuration, |errors| errors.across),
            errors(configuration, |errors| errors.along),
        ];
        (configuration.name, pair)
    });
    two_panels(both.collect())
}

/// Error along the view for light at an angle to the view.
pub(super) fn tilted_along_view(far: f64, degrees: f64, warps: &[(&'static str, TiltedWarp)]) -> Vec<Curves> {
    let view = camera(far);
    let curves = warps.iter().filter_map(|(name, warp)| {
        let map = frustum_map(&view, light_at(degrees), *warp).ok()?;
        let errors = |of: fn(AxisErrors) -> f64| {
            let depths = ratios(1.0, far, 120);
            depths
                .map(|depth| (depth, of(map.errors(&view, DVec3::NEG_Z * depth))))
                .collect()
        };
        Some((*name, [errors(|errors| errors.across), errors(|errors| errors.along)]))
    });
    two_panels(curves.collect())
}

/// The names of curves with their points across and along.
type NamedCurves = Vec<(&'static str, [Vec<(f64, f64)>; 2])>;

fn two_panels(curves: NamedCurves) -> Vec<Curves> {
    let all = curves
        .iter()
        .flat_map(|(_, pair)| pair.iter().flatten())
        .map(|(_, error)| *error);
    let (low, high) = all.fold((f64::INFINITY, 0.0_f64), |(low, high), error| {
        (low.min(error), high.max(error))
    });
    let panel = |index: usize, title: &str| Curves {
        title: title.to_owned(),
        x: axis("view depth", Scale::Logarithmic),
        y: Axis {
            range: Some(low * 0.8..high * 1.25),
            ..axis("texel ÷ pixel, resolutions equal", Scale::Logarithmic)
        },
        curves: curves
            .iter()
            .map(|(name, pair)| curve(*name, pair[index].iter().copied()))
            .collect(),
    };
    vec![
        panel(0, "Across the warp axis: m_x"),
        panel(1, "Along the warp axis: m_z"),
    ]
}
