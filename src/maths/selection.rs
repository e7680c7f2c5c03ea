//! Which light view a point is looked up in; the CPU twin of `shaders/selection.wgsl`, and the seams between light views.
//!
//! Partitions overlap as maps: that of one slice contains much of its neighbours, all of it when light and view are
//! parallel. So there are four rules ([`Selection`]), one formula without branches for the first ([`selection_mask`]),
//! weights that hide the seams ([`depth_seam`], [`border_weights`]; [`view_weights`] for every rule, as the shader has them)
//! and one that hides the end ([`range_fade`]).
//!
//! Face partitions could be told apart by their columns ([`partition_of_point`](super::face::partition_of_point)). The
//! shader takes the map with the most texels around the point instead: the maps are rectangles around their columns, so
//! that parts of a column lie in finer maps of others; no plane has to go to the GPU; and where two columns meet, both maps
//! are about equally fine.
//! Split distances are those of [`split_depths`](super::split::split_depths); intervals are half open, so that every
//! depth has exactly one partition. Lloyd's mask has both comparisons strict: a depth on a split would have none.

use bevy_math::{DMat4, DVec2, DVec3, UVec2, Vec4Swizzles};

use super::{footprint::texel_footprint, split::MAX_PARTITIONS};

/// How a light view is chosen for a point; in the order of the constants `SELECTION_*` of `shaders/types.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Selection {
    /// By view depth (Stingl, section 3.3.3): the first map that does not end in front of the point and contains it.
    Depth,
    /// The first, finest map that contains the point, whatever its depth.
    BestResolution,
    /// The first map that does not end in front of the point, whether it contains it or not: Bevy's cascades.
    Cascades,
    /// The map with the most texels around the point, of those that contain it: for face partitions, which have no order.
    Finest,
}

/// What selection needs to know of a light view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectableView {
    /// World to light clip space, reverse z.
    pub clip_from_world: DMat4,
    /// View depth at which the partition ends, in metres.
    pub end_depth: f64,
    /// Share of the map that the filter reads on each side of a point: its radius in texels ÷ texels per side.
    pub margin: DVec2,
    /// Texels of the map.
    pub size: UVec2,
    /// Length of view depth before the end over which the next map takes over, in metres; for [`Selection::Depth`].
    pub seam_depth: f64,
    /// It serves only points that lie in no other map: no seam leads into it. For [`Selection::Finest`].
    pub stands_in: bool,
}

impl SelectableView {
    /// Texels per square metre across the light, at a point; 0 behind the projection centre.
    pub fn density(&self, point: DVec3) -> f64 {
        texel_footprint(&self.clip_from_world, self.size, point).map_or(0.0, |footprint| 1.0 / footprint.area())
    }

    /// Texture coordinates 0..=1, y down, and reverse depth; `None` behind the projection centre.
    fn project(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let clip = self.clip_from_world * point.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        (clip.w > 0.0).then(|| (DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y), ndc.z))
    }

    /// Whether the map holds the point with all texels that the filter reads. The depth matters as much as the rest: a
    /// point behind the far end of a map may have occluders that the map never drew.
    pub fn contains(&self, point: DVec3) -> bool {
        self.room(point).is_some_and(|room| room >= 0.0)
    }

    /// Distance in texture coordinates from the point to the border that the filter must not cross, negative outside.
    /// `None` where the map has no depth for the point.
    fn room(&self, point: DVec3) -> Option<f64> {
        self.rooms(point).map(DVec2::min_element)
    }

    /// The same across both pairs of borders.
    fn rooms(&self, point: DVec3) -> Option<DVec2> {
        let (uv, depth) = self.project(point)?;
        (0.0..=1.0).contains(&depth).then(|| uv.min(1.0 - uv) - self.margin)
    }

    /// Texture coordinates per metre across the light: half the box around the image of a disc with a radius of one metre.
    fn uv_per_metre(&self, point: DVec3) -> DVec2 {
        let clip = self.clip_from_world * point.extend(1.0);
        let gradient = |row: usize, coordinate: f64| {
            let gradient =
                self.clip_from_world.row(row).xyz() - self.clip_from_world.row(3).xyz() * (coordinate / clip.w);
            (gradient * (0.5 / clip.w)).length()
        };
        DVec2::new(gradient(0, clip.x), gradient(1, clip.y))
    }

    /// How much of a point the map takes near its border: all of it up to the band, nothing at the border itself.
    fn border_share(&self, point: DVec3, band: BorderBand) -> f64 {
        let width = band.width(self, point);
        let rooms = self.rooms(point).unwrap_or_default();
        fade_out(-rooms.x, 0.0, width.x).min(fade_out(-rooms.y, 0.0, width.y))
    }
}

/// The outcome of [`select_view`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Selected {
    /// The light view that was tried last; 0 when none was.
    pub index: usize,
    /// False: beyond the shadow distance, or in no map. Such points are lit.
    pub is_found: bool,
}

/// Chooses a light view for a point at a view depth: step by step what the shader does. `views` go from near to far;
/// the last has no end. `shadow_distance` is the view depth from which everything is lit.
pub fn select_view(
    views: &[SelectableView],
    selection: Selection,
    point: DVec3,
    view_depth: f64,
    shadow_distance: f64,
) -> Selected {
    let mut selected = Selected::default();
    if view_depth >= shadow_distance {
        return selected;
    }
    if selection == Selection::Finest {
        return finest_view(views, point, None);
    }
    for (index, view) in views.iter().enumerate() {
        let is_last = index + 1 == views.len();
        let is_behind = view_depth >= view.end_depth && !is_last;
        if selection != Selection::BestResolution && is_behind {
            continue;
        }
        selected = Selected {
            index,
            is_found: view.contains(point),
        };
        if selected.is_found || selection == Selection::Cascades {
            return selected;
        }
    }
    selected
}

/// The finest map that contains a point, of all or of those that are coarser than another (of equally fine ones: behind it)
/// and do not only stand in.
fn finest_view(views: &[SelectableView], point: DVec3, coarser_than: Option<usize>) -> Selected {
    let key = |index: usize| (views[index].density(point), std::cmp::Reverse(index));
    let finest = (0..views.len())
        .filter(|index| views[*index].contains(point))
        .filter(|index| coarser_than.is_none_or(|other| key(*index) < key(other) && !views[*index].stands_in))
        .max_by(|a, b| key(*a).partial_cmp(&key(*b)).unwrap_or(std::cmp::Ordering::Equal));
    finest.map_or_else(Selected::default, |index| Selected { index, is_found: true })
}

/// How wide maps are blended at their borders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BorderBand {
    /// Not at all.
    None,
    /// A share of the map's sides.
    Share(f64),
    /// Metres across the light.
    Metres(f64),
}

impl BorderBand {
    /// The width in texture coordinates at a point.
    fn width(self, view: &SelectableView, point: DVec3) -> DVec2 {
        match self {
            Self::None => DVec2::ZERO,
            Self::Share(share) => DVec2::splat(share),
            Self::Metres(metres) => view.uv_per_metre(point) * metres,
        }
    }
}

/// Weights of all light views for a point, step by step as the shader has them: the view that [`select_view`] finds, and
/// the next ones by the same rule as far as its seam leaves something to them. [`Selection::Depth`] blends over
/// [`SelectableView::seam_depth`] before the end of an interval ([`depth_seam`]), the other rules over `band` before the
/// border of a map ([`border_weights`]). The weights sum to 1, or are all 0 where the point is in no map.
pub fn view_weights(
    views: &[SelectableView],
    selection: Selection,
    band: BorderBand,
    point: DVec3,
    view_depth: f64,
    shadow_distance: f64,
) -> Vec<f64> {
    let mut weights = vec![0.0; views.len()];
    let mut selected = select_view(views, selection, point, view_depth, shadow_distance);
    let mut left = 1.0;
    while selected.is_found {
        let view = &views[selected.index];
        let share = match selection {
            _ if selected.index + 1 == views.len() && selection != Selection::Finest => 1.0,
            Selection::Depth => fade_out(view_depth, view.end_depth, view.seam_depth),
            _ => view.border_share(point, band),
        };
        let weight = left * share;
        weights[selected.index] += weight;
        left -= weight;
        if left <= 0.0 {
            break;
        }
        let next = match selection {
            Selection::Finest => finest_view(views, point, Some(selected.index)),
            _ => {
                let start = selected.index + 1;
                let next = select_view(&views[start..], selection, point, view_depth, shadow_distance);
                Selected {
                    index: next.index + start,
                    ..next
                }
            }
        };
        if !next.is_found {
            weights[selected.index] += left;
        }
        selected = next;
    }
    weights
}

/// The partition of a view depth: C_i <= depth < C_(i+1), the last including its end. `None` outside the range.
pub fn partition_of_depth(depths: &[f64], view_depth: f64) -> Option<usize> {
    let last = depths.len().checked_sub(2)?;
    if !(view_depth >= depths[0] && view_depth <= depths[last + 1]) {
        return None;
    }
    Some(depths[1..=last].partition_point(|end| *end <= view_depth))
}

/// Lloyd's selection without branches (section 6.3): 1 for the partition that a view depth lies in and 0 for the others,
/// so that a sum over all partitions weighted with it picks one. Depths in front of the range belong to the first
/// partition, those behind it to the last: the mask always sums to 1 for two split distances or more.
///
/// Each entry is the difference of two steps, step(C_i) − step(C_(i+1)) with step(C) = 1 for depth >= C; the steps of
/// both ends are constants. NaN belongs to the first partition.
pub fn selection_mask(depths: &[f64], view_depth: f64) -> [f64; MAX_PARTITIONS] {
    let count = depths.len().saturating_sub(1).min(MAX_PARTITIONS);
    let step = |index: usize| match index {
        0 => 1.0,
        _ if index == count => 0.0,
        _ => f64::from(view_depth >= depths[index]),
    };
    std::array::from_fn(|index| {
        if index < count {
            step(index) - step(index + 1)
        } else {
            0.0
        }
    })
}

/// Two light views and how much the second counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// The partition of the point.
    pub first: usize,
    /// The next one; the same as `first` where there is none.
    pub second: usize,
    /// 0: only the first, 1: only the second. The first counts 1 − weight.
    pub weight: f64,
}

/// Blends every partition into the next over the last `share` of its depth range, so that no seam is visible where the
/// size of texels jumps: with `LiSPSM` by α^(1/2k) across the warp axis and not at all along it, with `PSM` the other way
/// round, by α^(1/k) (Lloyd, section 5.2). `None` outside the range.
///
/// The weight rises smoothly from 0 to 1 at the split, where the next partition takes over alone: the blend of any
/// quantity is continuous in depth. The map of the next partition must contain the band: focus it from
/// `C_i − share · (C_i − C_(i−1))` on. `share` is clamped to 0..=1; 0 and NaN do not blend.
pub fn depth_seam(depths: &[f64], view_depth: f64, share: f64) -> Option<Seam> {
    let first = partition_of_depth(depths, view_depth)?;
    let second = (first + 1).min(depths.len() - 2);
    let (start, end) = (depths[first], depths[first + 1]);
    let weight = if second == first {
        0.0
    } else {
        1.0 - fade_out(view_depth, end, (end - start) * share.clamp(0.0, 1.0))
    };
    Some(Seam { first, second, weight })
}

/// Weights of all light views for [`Selection::BestResolution`]: each map counts fully up to `band` (in texture
/// coordinates) before its border and fades to nothing at it; what it leaves goes to the next map that contains the
/// point.
///
/// The last map that contains the point takes all that is left, so the weights sum to 1, or are all 0 where no map
/// contains it. They are continuous wherever a coarser map contains the point; at the outermost border they end in a
/// step, which [`range_fade`] hides.
pub fn border_weights(views: &[SelectableView], point: DVec3, band: f64) -> Vec<f64> {
    let mut weights = vec![0.0; views.len()];
    let (mut left, mut last) = (1.0, None);
    for (index, view) in views.iter().enumerate() {
        let Some(room) = view.room(point).filter(|room| *room >= 0.0) else {
            continue;
        };
        let weight = left * fade_out(-room, 0.0, band);
        weights[index] = weight;
        left -= weight;
        last = Some(index);
    }
    if let Some(last) = last {
        weights[last] += left;
    }
    weights
}

/// How much of a shadow is left near the end of the shadow distance: 1 up to the last `share` of it, then falling
/// smoothly to 0 at `shadow_distance`, and 0 behind. A pixel's light is `mix(1, light, fade)`.
///
/// `share` is clamped to 0..=1; 0 and NaN cut the shadows off at once.
pub fn range_fade(view_depth: f64, shadow_distance: f64, share: f64) -> f64 {
    fade_out(view_depth, shadow_distance, shadow_distance * share.clamp(0.0, 1.0))
}

/// 1 up to `end − length`, 0 from `end` on, the cubic 3 t² − 2 t³ between: continuous with its slope. NaN gives 0.
fn fade_out(value: f64, end: f64, length: f64) -> f64 {
    let left = end - value;
    if left > 0.0 {
        let t = if length > 0.0 { (left / length).min(1.0) } else { 1.0 };
        t * t * (3.0 - 2.0 * t)
    } else {
        0.0
    }
}
