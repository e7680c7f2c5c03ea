//! Storage factors in closed form, for the two light directions that have one (Lloyd et al. 2006, section 5.3).
//!
//! With self-similar slices every one has the depth ratio a = α^(1 ÷ k). Numbers of maps and slices are real numbers here,
//! so that curves can be drawn and schemes compared; the pictures of the paper do the same.

/// How a view frustum is divided into maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PartitionScheme {
    /// ZP: self-similar z-partitions, unwarped.
    Sliced,
    /// ZP+W: the same, each with its warp.
    SlicedWarped,
    /// FP+ZP+W: each side of the frustum sliced, each slice with its warp. Four maps per slice, because the scheme has to
    /// stay the same for all light directions, and one for the near face, which is so small that it does not count as a
    /// map.
    FacesSlicedWarped,
    /// The logarithmic parametrisation that no matrix can express: what infinitely many warped slices reach (Lloyd,
    /// appendix C).
    Logarithmic,
}

/// Where the light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightPlace {
    /// From above, perpendicular to the view direction.
    Overhead,
    /// From behind the viewer or from ahead.
    AlongView,
}

/// S̄ of all maps of a scheme together: texels per picture pixel for no error above 1 (Lloyd, equations 17 to 21,
/// appendix C).
///
/// `ratio` is α = f ÷ n; `slices` is k, the number of z-partitions (per side, for faces), which need not be whole;
/// `opening` is 2 tan Θ. With a = α^(1/k):
///
/// | | overhead | along the view |
/// |---|---|---|
/// | ZP | k a (a − 1) ÷ 2 tan Θ | k a²: the frustum looks square |
/// | ZP+W | k (a − 1) ÷ 2 tan Θ | k a²: no warp helps |
/// | FP+ZP+W | k (a − 1) ÷ 2 tan Θ: one face alone looks to the light | 4 k (a − 1) ÷ 2 + 1: four faces as under 45°, and the near face |
/// | logarithmic | ln α ÷ 2 tan Θ | 2 ln α + 1, on faces |
///
/// The directions between lie within a factor of two to three of the values along the view. `None` unless α > 1, the two
/// others are above zero and all are finite.
pub fn closed_storage_factor(
    scheme: PartitionScheme,
    light: LightPlace,
    ratio: f64,
    slices: f64,
    opening: f64,
) -> Option<f64> {
    let is_sound = slices > 0.0 && ratio > 1.0 && opening > 0.0;
    if !is_sound || !(slices + ratio + opening).is_finite() {
        return None;
    }
    let slice_ratio = ratio.powf(1.0 / slices);
    let warped = slices * (slice_ratio - 1.0);
    Some(match (light, scheme) {
        (LightPlace::Overhead, PartitionScheme::Sliced) => slice_ratio * warped / opening,
        (LightPlace::Overhead, PartitionScheme::SlicedWarped | PartitionScheme::FacesSlicedWarped) => warped / opening,
        (LightPlace::Overhead, PartitionScheme::Logarithmic) => ratio.ln() / opening,
        (LightPlace::AlongView, PartitionScheme::Sliced | PartitionScheme::SlicedWarped) => {
            slices * slice_ratio * slice_ratio
        }
        // Four sides, each like a camera of 45° half opening (2 tan 45° = 2), and 1 for the near face.
        (LightPlace::AlongView, PartitionScheme::FacesSlicedWarped) => SIDE_FACES * warped / 2.0 + 1.0,
        (LightPlace::AlongView, PartitionScheme::Logarithmic) => SIDE_FACES * ratio.ln() / 2.0 + 1.0,
    })
}

/// Maps that face partitions spend on a slice.
const SIDE_FACES: f64 = 4.0;

/// S̄ for `maps` maps: [`closed_storage_factor`] with k = j, or k = j ÷ 4 with faces, and then at least four maps.
pub fn storage_factor_of_maps(
    scheme: PartitionScheme,
    light: LightPlace,
    ratio: f64,
    maps: f64,
    opening: f64,
) -> Option<f64> {
    let slices = match scheme {
        PartitionScheme::FacesSlicedWarped if maps >= SIDE_FACES => maps / SIDE_FACES,
        PartitionScheme::FacesSlicedWarped => return None,
        _ => maps,
    };
    closed_storage_factor(scheme, light, ratio, slices, opening)
}

/// With light along the view, more slices than this make ZP worse, because its maps overlap: k = 2 ln α, where
/// k α^(2 ÷ k) has its minimum 2 e ln α (its derivative is α^(2 ÷ k) (1 − 2 ln α ÷ k)). `None` unless α > 1 and finite.
pub fn best_slices_along_view(ratio: f64) -> Option<f64> {
    (ratio > 1.0 && ratio.is_finite()).then(|| 2.0 * ratio.ln())
}

/// The number of maps j from which on faces need less storage than slices with light along the view (Lloyd, figure 13):
/// the root of j α^(2 ÷ j) = ½ j (α^(4 ÷ j) − 1) + 1, at least 4. About 0.35 + 2.27 ln α for α from 5 to 10⁵. Not whole;
/// with fewer maps use z-partitions. `None` unless α > 1 and finite.
pub fn crossover_maps(ratio: f64) -> Option<f64> {
    let along_view = |scheme, maps| storage_factor_of_maps(scheme, LightPlace::AlongView, ratio, maps, 1.0);
    let slices_win = |maps: f64| {
        Some(along_view(PartitionScheme::Sliced, maps)? <= along_view(PartitionScheme::FacesSlicedWarped, maps)?)
    };
    if !slices_win(SIDE_FACES)? {
        return Some(SIDE_FACES);
    }
    let (mut low, mut high) = (SIDE_FACES, SIDE_FACES + 3.0 * ratio.ln());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if slices_win(middle)? { &mut low } else { &mut high }) = middle;
    }
    Some(high)
}
