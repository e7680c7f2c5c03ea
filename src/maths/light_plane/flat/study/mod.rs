//! The source's experiments (Chong 4.1) as data: its tables, scenes like its own, and ours beside them.
//!
//! The source gives the numbers of its tables but neither scenes nor film sizes, so [`scenes`] are rebuilt: the single
//! plane from the table's angles, the others by the pictures' descriptions. Patterns compare, digits do not.

mod published;
mod scenes;

pub use published::{PUBLISHED, PublishedMethod, PublishedRow};
pub use scenes::{Scene, scenes};

use super::{
    Degenerate, Exposure, Footprints, Metric, Tilt, optimal_tilt,
    post_perspective::PostPerspective,
    smallest_largest_tilt,
    split::{SliceExtent, Split, exact_partition, greedy_merge, slices},
};

/// Slices before merging (the source's `MAX_LIGHT_FRUSTA`, whose value it does not give).
pub const SLICES: usize = 16;

/// Pictures of the source's study of coarse first passes, beside its reference of 1000 pixels.
pub const COARSE_PIXELS: [u32; 5] = [100, 50, 25, 10, 5];

/// Ways to choose the film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Method {
    /// Smallest mean.
    L1,
    /// Smallest mean square.
    L2,
    /// Smallest maximum.
    Largest,
    /// The ordinary map.
    HalfAngle,
    /// A perspective shadow map as it is.
    PostPerspective,
    /// A perspective shadow map by the source's rule, near plane pushed to the scene.
    PostPerspectivePrinted,
}

impl Method {
    /// All, in the order of the tables.
    pub const ALL: [Self; 6] = [
        Self::L1,
        Self::L2,
        Self::Largest,
        Self::HalfAngle,
        Self::PostPerspective,
        Self::PostPerspectivePrinted,
    ];

    /// For tables and keys.
    pub fn name(self) -> &'static str {
        match self {
            Self::L1 => "L1",
            Self::L2 => "L2",
            Self::Largest => "L∞",
            Self::HalfAngle => "half-angle",
            Self::PostPerspective => "PSM (actual)",
            Self::PostPerspectivePrinted => "PSM (thesis's rule)",
        }
    }

    /// The film it chooses for a scene.
    ///
    /// # Errors
    /// Those of the method; [`Degenerate::TooWide`] if its film cannot see the whole hull.
    pub fn tilt(self, scene: &Scene, exposure: &Exposure) -> Result<Tilt, Degenerate> {
        let map = || PostPerspective::new(&scene.camera, scene.light, &scene.camera.see(&scene.surfaces));
        match self {
            Self::L1 => optimal_tilt(&exposure.samples, Metric::L1),
            Self::L2 => optimal_tilt(&exposure.samples, Metric::L2),
            Self::Largest => smallest_largest_tilt(&exposure.samples),
            Self::HalfAngle => Ok(Tilt::default()),
            Self::PostPerspective => map()?.tilt(exposure),
            Self::PostPerspectivePrinted => map()?.printed_rule_tilt(1.0, exposure).ok_or(Degenerate::TooWide),
        }
    }
}

/// A row of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The tilt from the half-angle film.
    pub tilt: Tilt,
    /// The film as the source prints it, in degrees; `None` under parallel light.
    pub angle: Option<f64>,
    /// In pixels per texel.
    pub footprints: Footprints,
}

/// A method's row for a scene, with as many texels as the picture has pixels.
///
/// # Errors
/// Those of [`Exposure::half_angle`] and [`Method::tilt`].
pub fn row(scene: &Scene, method: Method) -> Result<Row, Degenerate> {
    let exposure = scene.exposure()?;
    let tilt = method.tilt(scene, &exposure)?;
    let texels = f64::from(scene.camera.pixels());
    let footprints = Footprints::of(&exposure.samples, tilt, texels).ok_or(Degenerate::NothingVisible)?;
    Ok(Row {
        tilt,
        angle: exposure.angle_of_tilt(tilt).map(super::printed_angle),
        footprints,
    })
}

/// How frusta are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Merging {
    /// The source's.
    Greedy,
    /// The best.
    Exact,
}

/// A scene with at most `frusta` frusta, from [`SLICES`] slices of equal angle.
///
/// # Errors
/// Those of [`Exposure::half_angle`] and [`slices`].
pub fn split_scene(
    scene: &Scene,
    frusta: usize,
    metric: Metric,
    merging: Merging,
    extent: SliceExtent,
) -> Result<Split, Degenerate> {
    let exposure = scene.exposure()?;
    let parts = slices(&exposure.samples, &exposure.even_borders(SLICES), metric, extent)?;
    match merging {
        Merging::Greedy => greedy_merge(&parts, frusta, 0.0, metric),
        Merging::Exact => exact_partition(&parts, frusta, metric),
    }
}

/// The mean of pixels per texel of a scene that is split for L1, with as many texels in all as the picture has pixels.
///
/// # Errors
/// As [`split_scene`].
pub fn split_average(scene: &Scene, frusta: usize, merging: Merging, extent: SliceExtent) -> Result<f64, Degenerate> {
    let split = split_scene(scene, frusta, Metric::L1, merging, extent)?;
    let pixels = scene.exposure()?.samples.len() as f64;
    Ok(split.total_error(f64::from(scene.camera.pixels())) / pixels)
}

/// Which hull a coarse first pass has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CoarseHull {
    /// That of the reference, as if known from the scene.
    Known,
    /// That of its own few pixels. The film it chooses is then a turn, measured on the reference's hull.
    Own,
}

/// The error that a first pass of few pixels adds (Chong 4.1.1, figure 4.1), as a share: 0.05 is 5 %. The error is the
/// mean footprint for L1, mean plus deviation for L2, of the reference with the coarse pass's film, over that with its own.
///
/// # Errors
/// Those of [`Exposure::half_angle`], [`optimal_tilt`]; [`Degenerate::TooWide`] if the coarse film cuts the true hull.
pub fn coarse_pass_error(scene: &Scene, pixels: u32, metric: Metric, hull: CoarseHull) -> Result<f64, Degenerate> {
    let reference = scene.exposure()?;
    let hits = scene.camera.with_pixels(pixels)?.see(&scene.surfaces);
    let tilt = match hull {
        CoarseHull::Known => {
            let coarse = Exposure::within(reference.film, reference.hull, &hits)?;
            optimal_tilt(&coarse.samples, metric)?
        }
        CoarseHull::Own => {
            let coarse = Exposure::tight(reference.film, &hits)?;
            let turn = coarse.hull.turn_of_tilt(optimal_tilt(&coarse.samples, metric)?);
            reference.hull.tilt_of_turn(turn).ok_or(Degenerate::TooWide)?
        }
    };
    let error = |tilt| {
        let footprints = Footprints::of(&reference.samples, tilt, 1.0).ok_or(Degenerate::NothingVisible)?;
        Ok(match metric {
            Metric::L1 => footprints.average,
            Metric::L2 => footprints.average_and_deviation(),
        })
    };
    Ok(error(tilt)? / error(optimal_tilt(&reference.samples, metric)?)? - 1.0)
}
