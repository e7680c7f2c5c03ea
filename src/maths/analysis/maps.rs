//! S̄ against the number of maps, in closed form: light overhead and behind (Lloyd et al. 2006, section 5.3).
//!
//! With self-similar slices every one has the depth ratio a = α^(1 ÷ k). Numbers of maps and slices are real numbers here,
//! so that curves can be drawn and schemes compared; the pictures of the paper do the same.

/// How a view frustum is divided into maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partitioning {
    /// ZP: slices of view depth, no warp.
    Depth,
    /// ZP+W: slices of view depth, each warped.
    WarpedDepth,
    /// FP+ZP+W: slices of the side faces, each warped. Four maps per slice, because the scheme has to stay the same for
    /// all light directions, and one for the near face, which is so small that it does not count as a map.
    WarpedFaces,
}

/// Where the light stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightPlace {
    /// Perpendicular to the view.
    Overhead,
    /// Along the view: from behind the viewer or from ahead.
    Behind,
}

/// S̄ for `slices` self-similar slices (per face where there are faces).
///
/// ```text
/// overhead ZP            k a (a − 1) ÷ 2 tan Θ        equation 17
/// overhead ZP+W          k (a − 1) ÷ 2 tan Θ          equation 18
/// overhead FP+ZP+W       the same                     equation 19: one face alone looks to the light
/// behind   ZP, ZP+W      k a²                         equation 20: the frustum looks square, no warp helps
/// behind   FP+ZP+W       4 k (a − 1) ÷ 2 + 1          equation 21: four faces as under 45°, and the near face
/// ```
///
/// `depth_ratio` is α, `opening` 2 tan Θ. `None` unless α > 1, both others are above zero and all are finite.
pub fn storage_factor_of_slices(
    partitioning: Partitioning,
    place: LightPlace,
    slices: f64,
    depth_ratio: f64,
    opening: f64,
) -> Option<f64> {
    let is_sound = slices > 0.0 && depth_ratio > 1.0 && opening > 0.0;
    if !is_sound || !(slices + depth_ratio + opening).is_finite() {
        return None;
    }
    let ratio = depth_ratio.powf(1.0 / slices);
    Some(match (place, partitioning) {
        (LightPlace::Overhead, Partitioning::Depth) => slices * ratio * (ratio - 1.0) / opening,
        (LightPlace::Overhead, Partitioning::WarpedDepth | Partitioning::WarpedFaces) => {
            slices * (ratio - 1.0) / opening
        }
        (LightPlace::Behind, Partitioning::Depth | Partitioning::WarpedDepth) => slices * ratio * ratio,
        (LightPlace::Behind, Partitioning::WarpedFaces) => 2.0 * slices * (ratio - 1.0) + 1.0,
    })
}

/// Maps that face partitions spend on a slice.
const SIDE_FACES: f64 = 4.0;

/// S̄ for `maps` maps: [`storage_factor_of_slices`] with k = j, or k = j ÷ 4 with faces, and then at least four maps.
pub fn storage_factor_of_maps(
    partitioning: Partitioning,
    place: LightPlace,
    maps: f64,
    depth_ratio: f64,
    opening: f64,
) -> Option<f64> {
    let slices = match partitioning {
        Partitioning::Depth | Partitioning::WarpedDepth => maps,
        Partitioning::WarpedFaces if maps >= SIDE_FACES => maps / SIDE_FACES,
        Partitioning::WarpedFaces => return None,
    };
    storage_factor_of_slices(partitioning, place, slices, depth_ratio, opening)
}

/// S̄ of logarithmic maps, which no matrix can draw: ln α ÷ 2 tan Θ overhead (Lloyd, appendix C), the limit of ZP+W for
/// many slices; 2 ln α + 1 behind, with four side faces as under 45° and the near face: the limit of FP+ZP+W. `None` as
/// for [`storage_factor_of_slices`].
pub fn logarithmic_storage_factor(place: LightPlace, depth_ratio: f64, opening: f64) -> Option<f64> {
    let is_sound = depth_ratio > 1.0 && depth_ratio.is_finite() && opening > 0.0;
    is_sound.then(|| match place {
        LightPlace::Overhead => depth_ratio.ln() / opening,
        LightPlace::Behind => 2.0 * depth_ratio.ln() + 1.0,
    })
}

/// With light from behind, more slices than this make ZP worse, because its maps overlap: k = 2 ln α, where k α^(2 ÷ k) has
/// its minimum 2 e ln α (its derivative is α^(2 ÷ k) (1 − 2 ln α ÷ k)). `None` unless α > 1 and finite.
pub fn best_slices_from_behind(depth_ratio: f64) -> Option<f64> {
    (depth_ratio > 1.0 && depth_ratio.is_finite()).then(|| 2.0 * depth_ratio.ln())
}

/// The number of maps j from which on face partitions need less storage than depth slices with the light behind (Lloyd,
/// figure 13): the root of j α^(2 ÷ j) = ½ j (α^(4 ÷ j) − 1) + 1, at least 4. About 0.35 + 2.27 ln α. `None` unless α > 1 and
/// finite.
pub fn crossover_maps(depth_ratio: f64) -> Option<f64> {
    let behind = |partitioning, maps| storage_factor_of_maps(partitioning, LightPlace::Behind, maps, depth_ratio, 1.0);
    let depth_wins = |maps: f64| Some(behind(Partitioning::Depth, maps)? <= behind(Partitioning::WarpedFaces, maps)?);
    if !depth_wins(SIDE_FACES)? {
        return Some(SIDE_FACES);
    }
    let (mut low, mut high) = (SIDE_FACES, SIDE_FACES + 3.0 * depth_ratio.ln());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if depth_wins(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(high)
}
