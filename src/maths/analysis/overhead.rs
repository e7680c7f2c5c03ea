//! The sun straight overhead: closed forms of Lloyd et al. 2006, section 4, and Stingl, section 2.3.3.

use crate::maths::{
    error::{AxisErrors, LargestErrors, error_across, error_along},
    split::{SplitScheme, split_depths},
    view::{ViewError, ViewVolume},
    warp::{WarpSpan, trapezoidal_warp_near},
};

/// A view frustum seen from the side by light that comes from above: n, f and 2 tan Θ.
///
/// For pictures that are not square Θ is half the opening in the plane of light and view (for the sun overhead: the
/// vertical one), and S̄ counts texels per pixel all the same. Derivation: with square pixels of side p z at
/// view depth z and an opening of x by y, the map of the whole range needs (f x ÷ (p n)) · ((f − n) ÷ (p n)) texels without a
/// warp; divided by the (x ÷ p) (y ÷ p) pixels that is (f ÷ n) (f ÷ n − 1) ÷ y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverheadRange {
    near: f64,
    far: f64,
    opening: f64,
}

/// How the map of a range is warped, the sun being overhead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OverheadWarp {
    /// n' infinite: no warp.
    Uniform,
    /// n' = n + √(f n): the error along the warp axis is equal at both ends. Re-parametrised `LiSPSM` is the same here.
    Lispsm,
    /// n' = n: the error across is 1 everywhere.
    Psm,
    /// Trapezoidal maps: the view depth `focus` comes to lie at 80 % of the map.
    Trapezoidal {
        /// View depth in metres.
        focus: f64,
    },
    /// The normalised strength: −1 uniform, 0 `LiSPSM`, 1 `PSM` (Lloyd, equation 11).
    Strength {
        /// −1..=1.
        eta: f64,
    },
    /// Levels the error at two view depths inside the range (Stingl, section 4.2).
    PseudoPlanes {
        /// Pseudo-near plane, in metres; clamped into the range.
        near: f64,
        /// Pseudo-far plane.
        far: f64,
    },
    /// n' itself, in metres.
    Near(f64),
}

impl OverheadRange {
    /// A range of view depths and 2 tan Θ.
    pub fn new(near: f64, far: f64, opening: f64) -> Result<Self, ViewError> {
        if !(near.is_finite() && far.is_finite() && opening.is_finite()) {
            Err(ViewError::NotFinite)
        } else if near <= 0.0 || far <= near {
            Err(ViewError::NoRange)
        } else if opening <= 0.0 {
            Err(ViewError::NoArea)
        } else {
            Ok(Self { near, far, opening })
        }
    }

    /// The range of a perspective camera, upright under the sun.
    pub fn of_view(view: &ViewVolume) -> Result<Self, ViewError> {
        Self::new(view.near(), view.far(), view.opening().y)
    }

    /// A side face of any frustum as light from straight behind (or ahead) sees it: a trapezoid whose sides open by 45°,
    /// whatever the picture's opening is; as the papers' 2 tan 45° = 2. Light-plane lengths of the face and widths of pixels
    /// both grow with tan Θ, which cancels (Lloyd, section 5.3).
    pub fn side_face_from_behind(near: f64, far: f64) -> Result<Self, ViewError> {
        Self::new(near, far, 2.0)
    }

    /// n: view depth of the near end, in metres.
    pub fn near(&self) -> f64 {
        self.near
    }

    /// f: view depth of the far end, in metres.
    pub fn far(&self) -> f64 {
        self.far
    }

    /// 2 tan Θ.
    pub fn opening(&self) -> f64 {
        self.opening
    }

    /// α = f ÷ n.
    pub fn depth_ratio(&self) -> f64 {
        self.far / self.near
    }

    /// What a warp has to level here.
    pub fn span(&self) -> WarpSpan {
        WarpSpan::directional(self.far - self.near, self.near, 1.0)
    }

    /// n' of a warp in metres, infinite for no warp.
    ///
    /// Trapezoidal maps follow [`trapezoidal_warp_near`]; their parameter may lie outside of that between `PSM` and
    /// `LiSPSM`, where S̄ is smallest (Lloyd, section 4.3). NaN is uniform.
    pub fn warp_near(&self, warp: OverheadWarp) -> f64 {
        let length = self.far - self.near;
        let near = match warp {
            OverheadWarp::Uniform => f64::INFINITY,
            OverheadWarp::Lispsm => self.near + (self.far * self.near).sqrt(),
            OverheadWarp::Psm => self.near,
            OverheadWarp::Trapezoidal { focus } => trapezoidal_warp_near(length, (focus - self.near) / length),
            OverheadWarp::Strength { eta } => self.span().warp_near(eta.clamp(-1.0, 1.0)),
            OverheadWarp::PseudoPlanes { near, far } => {
                let clamped = |depth: f64| depth.clamp(self.near, self.far);
                self.near + (clamped(near) * clamped(far)).sqrt()
            }
            OverheadWarp::Near(near) => near,
        };
        if near > 0.0 { near } else { f64::INFINITY }
    }

    /// m_x and m_z at a view depth (Lloyd, equations 7 and 8). `None` outside the range.
    ///
    /// The equations let the frustum's far end fill the map, which is so for n' ≥ n. For smaller n' the near end is the
    /// wider one in the map and everything across grows by u ÷ α, u as in [`Self::largest_errors`].
    pub fn errors(&self, warp_near: f64, depth: f64) -> Option<AxisErrors> {
        let near_excess = (self.far_width(warp_near) / self.depth_ratio()).max(1.0);
        (self.near..=self.far).contains(&depth).then(|| AxisErrors {
            across: near_excess * error_across(depth, warp_near, self.near, self.far),
            along: error_along(depth, warp_near, self.near, self.far, self.opening),
        })
    }

    /// M_x and M_z: the largest errors over the range (Lloyd, equations 9 and 10, where a factor n is misprinted).
    ///
    /// m_x is monotone. m_z has one inner extremum, a minimum: its maximum is at n or at f, at both for n'_LSPSM = n + √(f n).
    /// With u = (n' + f − n) ÷ n': M_x = max(α ÷ u, u ÷ α), the second of them for n' < n; M_z = (f − n) ÷ 2 tan Θ ·
    /// max(1 ÷ (n u), u ÷ f).
    pub fn largest_errors(&self, warp_near: f64) -> LargestErrors {
        let far_width = self.far_width(warp_near);
        let relative = self.depth_ratio() / far_width;
        LargestErrors {
            across: relative.max(1.0 / relative),
            along: (self.far - self.near) / self.opening * (1.0 / (self.near * far_width)).max(far_width / self.far),
        }
    }

    /// Share of the map's texels that the frustum's outline covers: (1 + n f' ÷ (n' f)) ÷ 2. A projective map takes the
    /// trapezoid to a trapezoid of full height, as wide as the map at its far end and n f' ÷ (n' f) of that at its near end.
    /// `PSM` fills the map, `LiSPSM` does not, and yet both need the same storage: a filled map is no goal in itself.
    /// `warp_near` from n to infinity.
    pub fn used_share(&self, warp_near: f64) -> f64 {
        0.5 * (1.0 + self.far_width(warp_near) / self.depth_ratio())
    }

    /// u = f' ÷ n': width of the warp frustum at its far end, relative to its near end.
    fn far_width(&self, warp_near: f64) -> f64 {
        1.0 + (self.far - self.near) / warp_near
    }

    /// t of the optimal, logarithmic map at a view depth, 0 at n and 1 at f: t = ln(z ÷ n) ÷ ln(f ÷ n) (Lloyd, appendix C).
    ///
    /// A pixel is 2 tan Θ · z long, so a map whose error is to be the same everywhere must have dz ÷ dt in proportion to z;
    /// this is the only such t. Across, s = x ÷ (2 z tan Θ) + ½ as for `PSM`. A matrix can only give dz ÷ dt in proportion to
    /// (z + c)² (appendix A): none draws such a map, in which lines are curves.
    pub fn logarithmic_place(&self, depth: f64) -> f64 {
        (depth / self.near).ln() / self.depth_ratio().ln()
    }

    /// m_z of that map, the same at all depths: z⁻¹ dz ÷ dt ÷ 2 tan Θ = ln α ÷ 2 tan Θ; its m_x is 1. So this is its S̄ too.
    pub fn logarithmic_error_along(&self) -> f64 {
        self.depth_ratio().ln() / self.opening
    }

    /// The range in slices with a map each.
    ///
    /// Pseudo planes act on the first slice (near) and on the last one (far) only, and the split scheme is evaluated
    /// between them (Stingl, equation 4.1), with the real n and f at its ends; pseudo planes that enclose nothing are left
    /// out of it.
    pub fn slices(&self, scheme: &SplitScheme, count: usize, warp: OverheadWarp) -> Vec<OverheadSlice> {
        let (from, to) = match warp {
            OverheadWarp::PseudoPlanes { near, far } => (near.max(self.near), far.min(self.far)),
            _ => (self.near, self.far),
        };
        let (from, to) = if to > from { (from, to) } else { (self.near, self.far) };
        let mut depths = split_depths(scheme, from, to, count);
        if let [first, .., last] = &mut depths[..] {
            (*first, *last) = (self.near, self.far);
        }
        depths
            .windows(2)
            .map(|ends| {
                let range = Self {
                    near: ends[0],
                    far: ends[1],
                    opening: self.opening,
                };
                OverheadSlice {
                    range,
                    warp_near: range.warp_near(warp),
                }
            })
            .collect()
    }
}

/// A slice of the range with its own map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverheadSlice {
    /// Its view depths.
    pub range: OverheadRange,
    /// n' of its map, in metres.
    pub warp_near: f64,
}

/// m_x and m_z at a view depth for a range in slices: each serves the depths from its near end up to its far end, without
/// that unless it is the last. `None` outside of all. With [`AxisErrors::at_resolution`] this predicts what
/// [`texels_on_pixels`](crate::maths::footprint::texels_on_pixels) measures on a surface across both beams.
///
/// Face partitions add nothing here: one face alone looks to light from overhead, and its outline is the frustum's
/// (Lloyd, equation 19).
pub fn errors_along_view(slices: &[OverheadSlice], depth: f64) -> Option<AxisErrors> {
    let last = slices.last()?;
    let found = slices.iter().find(|slice| depth < slice.range.far).unwrap_or(last);
    found.range.errors(found.warp_near, depth)
}

/// S̄ of a range in slices, each map as large as its own errors demand: the sum of M_x · M_z (Lloyd, section 5.3).
pub fn storage_factor(slices: &[OverheadSlice]) -> f64 {
    let largest = slices.iter().map(|slice| slice.range.largest_errors(slice.warp_near));
    largest.map(|errors| errors.storage_factor()).sum()
}

/// S̄ of a range in slices with maps of one size: their number · max M_x · max M_z (Stingl, section 3.4.1). For
/// self-similar (logarithmic) slices the same as [`storage_factor`], for all others more.
pub fn equal_maps_storage_factor(slices: &[OverheadSlice]) -> f64 {
    let largest = slices.iter().map(|slice| slice.range.largest_errors(slice.warp_near));
    let (across, along) = largest.fold((0.0_f64, 0.0_f64), |(across, along), errors| {
        (across.max(errors.across), along.max(errors.along))
    });
    slices.len() as f64 * across * along
}
