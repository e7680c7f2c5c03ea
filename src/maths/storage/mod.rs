//! How many texels each map of a scheme deserves, and where it lies in the atlas (Lloyd, sections 4.2, 5.3 and 6.1).
//!
//! The storage factor S̄ = M_x · M_z of a map is the number of texels per picture pixel at which no error exceeds 1
//! ([`LargestErrors::storage_factor`]). With a budget all maps get texels in proportion to their S̄, and each the shape
//! that makes its errors equal in both directions: then all maps have the same largest error,
//! M = res_i √(ΣS̄ ÷ budget), and no other division of the budget has a smaller one.
//!
//! A map whose size changes from picture to picture shows it as crawling shadow edges. Call [`fill_atlas`] when the scheme
//! or the light changes, or every few seconds, rather than for every picture.

mod closed_form;
mod pack;

pub use closed_form::{
    LightPlace, PartitionScheme, best_slices_along_view, closed_storage_factor, crossover_maps, storage_factor_of_maps,
};
pub use pack::{Packing, PackingState, pack};

use bevy_math::{DVec2, UVec2};

use super::error::LargestErrors;

/// Critical resolution res_s* × res_t* in texels: the smallest size of a map without errors above 1 (Lloyd, section
/// 4.2). `picture_height` is res_i: picture pixels along the direction whose opening the errors were computed with.
pub fn critical_size(errors: &LargestErrors, picture_height: f64) -> DVec2 {
    errors.critical_resolution(picture_height)
}

/// The size of a map with a number of texels and the same error in both directions (Lloyd, equations 13 and 14), in
/// texels, not rounded. Not finite for errors of zero.
pub fn budgeted_size(errors: &LargestErrors, texels: f64) -> DVec2 {
    errors.balanced_resolution(texels)
}

/// The largest error of a map of this size, in texels per pixel: M = res_i · max(M_x ÷ res_s, M_z ÷ res_t).
pub fn error_of_size(errors: &LargestErrors, size: UVec2, picture_height: f64) -> f64 {
    (critical_size(errors, picture_height) / size.as_dvec2()).max_element()
}

/// What sizes of maps are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SizeLimits {
    /// Smallest side in texels: below it guard texels and filters eat the map.
    pub smallest: u32,
    /// Largest side in texels: that of the device's textures, or of the atlas.
    pub largest: u32,
    /// Sides are multiples of this.
    pub multiple: u32,
}

impl Default for SizeLimits {
    fn default() -> Self {
        Self {
            smallest: 64,
            largest: 8192,
            multiple: 8,
        }
    }
}

impl SizeLimits {
    /// Smallest and largest side as multiples, in texels; at least one multiple.
    fn sides(&self) -> (u32, u32) {
        let multiple = self.multiple.max(1);
        let smallest = self.smallest.max(1).div_ceil(multiple) * multiple;
        (smallest, (self.largest / multiple * multiple).max(smallest))
    }
}

/// How well [`allocate`] could equalise the errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AllocationState {
    /// Errors are equal up to rounding.
    Equal,
    /// At least one map has the smallest or largest side; the other maps share what that leaves or takes.
    Limited,
    /// The budget does not hold as many maps of the smallest size: all are squares of one size below it, down to nothing.
    OverBudget,
}

/// Sizes of maps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Allocation {
    /// Texels across and along the warp axis, one entry per map.
    pub sizes: Vec<UVec2>,
    /// How well the errors are equalised.
    pub state: AllocationState,
}

impl Allocation {
    /// Texels of all maps; never more than the budget.
    pub fn texels(&self) -> u64 {
        self.sizes
            .iter()
            .map(|size| u64::from(size.x) * u64::from(size.y))
            .sum()
    }
}

/// Divides a budget of texels among maps so that their largest errors are equal (Lloyd, section 4.2, for several maps).
///
/// Map i gets the size √λ (M_x, M_z), with the largest λ whose sizes, clamped to the limits and rounded down to
/// multiples, stay within the budget. A side clamped to the largest hands its texels over to the other one, as far as that
/// may grow; a side raised to the smallest takes its texels from all maps, since the other side still needs its own. Maps
/// with errors that are zero, negative or not finite get the smallest size. For one camera, leave out the factor picture
/// height: it changes nothing.
pub fn allocate(errors: &[LargestErrors], texel_budget: u64, limits: &SizeLimits) -> Allocation {
    let (smallest, largest) = limits.sides();
    let count = errors.len() as u64;
    if u64::from(smallest).pow(2) * count > texel_budget {
        let side = ((texel_budget / count.max(1)) as f64).sqrt() as u32;
        let multiple = limits.multiple.max(1);
        return Allocation {
            sizes: vec![UVec2::splat(side / multiple * multiple); errors.len()],
            state: AllocationState::OverBudget,
        };
    }
    let sizes_for = |scale: f64| -> Vec<UVec2> {
        let sizes = errors.iter().map(|errors| sized(errors, scale, limits));
        sizes.collect()
    };
    let fits = |scale: f64| {
        let texels = sizes_for(scale)
            .into_iter()
            .map(|size| u64::from(size.x) * u64::from(size.y));
        texels.sum::<u64>() <= texel_budget
    };
    // Where the search begins every map has the smallest size.
    let widest = errors
        .iter()
        .filter_map(wanted)
        .map(DVec2::max_element)
        .fold(0.0, f64::max);
    let mut good = f64::from(smallest) / widest.max(f64::MIN_POSITIVE);
    let mut bad = good * 2.0;
    for _ in 0..DOUBLINGS {
        if !fits(bad) {
            break;
        }
        (good, bad) = (bad, bad * 2.0);
    }
    for _ in 0..HALVINGS {
        let middle = (good + bad) * 0.5;
        *(if fits(middle) { &mut good } else { &mut bad }) = middle;
    }
    let sizes = sizes_for(good);
    let is_limited = sizes
        .iter()
        .any(|size| size.min_element() == smallest || size.max_element() == largest);
    Allocation {
        sizes,
        state: if is_limited {
            AllocationState::Limited
        } else {
            AllocationState::Equal
        },
    }
}

/// Steps of the search for √λ: maps may differ in need by 2⁶⁴, and the result is exact to a part in 2⁴⁰.
const DOUBLINGS: usize = 64;
const HALVINGS: usize = 40;

/// The errors in both directions, if they are any.
fn wanted(errors: &LargestErrors) -> Option<DVec2> {
    let wanted = DVec2::new(errors.across, errors.along);
    (wanted.is_finite() && wanted.min_element() > 0.0).then_some(wanted)
}

/// The size of a map for √λ.
fn sized(errors: &LargestErrors, scale: f64, limits: &SizeLimits) -> UVec2 {
    let (smallest, largest) = limits.sides();
    let (low, high) = (f64::from(smallest), f64::from(largest));
    let Some(wanted) = wanted(errors) else {
        return UVec2::splat(smallest);
    };
    let (low, high) = (DVec2::splat(low), DVec2::splat(high));
    let size = wanted * scale;
    let left = size / size.min(high);
    let size = (size.min(high) * DVec2::new(left.y, left.x)).clamp(low, high);
    let multiple = limits.multiple.max(1);
    UVec2::new(size.x as u32, size.y as u32) / multiple * multiple
}

/// Sizes and places of all maps in a square atlas: equal errors, as small as they can be.
///
/// Rectangles rarely fill a square. Two shapes are tried, that of [`allocate`] and one whose maps are square on average
/// (best for z-partitions, whose maps are alike); of each the largest share of the atlas that packs, in steps of a 64th;
/// the smaller error wins. If not even the smallest maps fit, [`Packing::state`] says so.
pub fn fill_atlas(errors: &[LargestErrors], side: u32, limits: &SizeLimits) -> Packing {
    let limits = SizeLimits {
        largest: limits.largest.min(side),
        ..*limits
    };
    let aspects = errors.iter().map(|errors| (errors.across / errors.along).ln());
    let mean_aspect = (aspects.filter(|aspect| aspect.is_finite()).sum::<f64>() / errors.len().max(1) as f64).exp();
    let texels = u64::from(side).pow(2);
    let candidates = [1.0, mean_aspect.sqrt()].into_iter().filter_map(|stretch| {
        let shaped: Vec<LargestErrors> = errors
            .iter()
            .map(|errors| LargestErrors {
                across: errors.across / stretch,
                along: errors.along * stretch,
            })
            .collect();
        let mut shares = (1..=SHARES).rev();
        shares.find_map(|share| {
            let allocation = allocate(&shaped, texels * share / SHARES, &limits);
            let packing = pack(&allocation.sizes, side, limits.multiple);
            let is_good = packing.state == PackingState::Whole && allocation.state != AllocationState::OverBudget;
            is_good.then_some(packing)
        })
    });
    let worst = |packing: &Packing| {
        let cells = packing.cells.iter().zip(errors);
        let of_maps = cells.map(|(cell, errors)| error_of_size(errors, UVec2::new(cell.z, cell.w), 1.0));
        of_maps.filter(|error| error.is_finite()).fold(0.0, f64::max)
    };
    let best = candidates.min_by(|a, b| worst(a).total_cmp(&worst(b)));
    best.unwrap_or_else(|| {
        let (smallest, _) = limits.sides();
        pack(&vec![UVec2::splat(smallest); errors.len()], side, limits.multiple)
    })
}

/// Steps of the search for the share of an atlas that packs.
const SHARES: u64 = 64;
