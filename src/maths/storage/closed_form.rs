//! Storage factors in closed form, for the two light directions that have one (Lloyd, section 5.3).

/// How a view frustum is divided into maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PartitionScheme {
    /// ZP: self-similar z-partitions, unwarped.
    Sliced,
    /// ZP+W: the same, each with its warp.
    SlicedWarped,
    /// FP+ZP+W: each side of the frustum sliced, each slice with its warp, and the near face.
    FacesSlicedWarped,
    /// The logarithmic parametrisation that no matrix can express: what infinitely many warped slices reach.
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
/// | ZP | k a (a − 1) ÷ 2 tan Θ | k a² |
/// | ZP+W | k (a − 1) ÷ 2 tan Θ | k a² |
/// | FP+ZP+W | k (a − 1) ÷ 2 tan Θ | 2 k (a − 1) + 1 |
/// | logarithmic | ln α ÷ 2 tan Θ | 2 ln α + 1, on faces |
///
/// The directions between lie within a factor of two to three of the values along the view.
pub fn closed_storage_factor(scheme: PartitionScheme, light: LightPlace, ratio: f64, slices: f64, opening: f64) -> f64 {
    let slice_ratio = ratio.powf(1.0 / slices);
    let warped = slices * (slice_ratio - 1.0);
    match (light, scheme) {
        (LightPlace::Overhead, PartitionScheme::Sliced) => slice_ratio * warped / opening,
        (LightPlace::Overhead, PartitionScheme::SlicedWarped | PartitionScheme::FacesSlicedWarped) => warped / opening,
        (LightPlace::Overhead, PartitionScheme::Logarithmic) => ratio.ln() / opening,
        (LightPlace::AlongView, PartitionScheme::Sliced | PartitionScheme::SlicedWarped) => {
            slices * slice_ratio * slice_ratio
        }
        // Four sides, each like a camera of 45° half opening (2 tan 45° = 2), and 1 for the near face.
        (LightPlace::AlongView, PartitionScheme::FacesSlicedWarped) => 4.0 * warped / 2.0 + 1.0,
        (LightPlace::AlongView, PartitionScheme::Logarithmic) => 4.0 * ratio.ln() / 2.0 + 1.0,
    }
}

/// The number of maps from which faces need less storage than slices for light along the view (Lloyd, figure 13): j maps
/// are j slices, or j ÷ 4 slices of four sides. About 0.35 + 2.27 ln α for α from 5 to 10⁵. Not whole; with fewer maps
/// use z-partitions. `None` unless α is finite and more than 1.
pub fn crossover_maps(ratio: f64) -> Option<f64> {
    if !(ratio.is_finite() && ratio > 1.0) {
        return None;
    }
    let faces_win = |maps: f64| {
        let storage = |scheme, slices| closed_storage_factor(scheme, LightPlace::AlongView, ratio, slices, 1.0);
        storage(PartitionScheme::FacesSlicedWarped, maps / 4.0) < storage(PartitionScheme::Sliced, maps)
    };
    let (mut slices_win, mut win) = (1.0, 8.0 + 4.0 * ratio.ln());
    for _ in 0..60 {
        let middle = (slices_win + win) * 0.5;
        *(if faces_win(middle) { &mut win } else { &mut slices_win }) = middle;
    }
    Some(win)
}
