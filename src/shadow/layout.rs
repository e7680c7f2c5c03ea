//! [`AtlasLayout`]: how many texels each map of a camera gets, and where they lie in the atlas (Lloyd, section 6.1; Stingl,
//! section 3.3.5).

use bevy::math::{UVec2, UVec4, Vec4Swizzles};

use crate::maths::{
    error::LargestErrors,
    storage::{SizeLimits, error_of_size, fill_atlas},
};

/// The maps of one camera in their square atlas.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtlasLayout {
    /// Side of the atlas in texels.
    pub side: u32,
    /// x, y, width and height of every map in texels, from the top left. They neither overlap nor stick out.
    pub rects: Vec<UVec4>,
    /// Of balanced maps: the rectangles of all slots, also of those without a map in this frame; empty for equal maps.
    places: Vec<UVec4>,
    /// The largest errors that they were made for, by slot; empty for equal maps.
    needs: Vec<LargestErrors>,
}

/// Balanced maps keep their places until the share or the shape of one of them should be so many times larger or smaller:
/// whenever they change, all edges of shadows move.
const TOLERATED_CHANGE: f64 = 1.25;

/// Sides of balanced maps are multiples of this many texels.
const MULTIPLE: u32 = 8;

/// Smallest side of a balanced map in texels, unless the atlas is smaller than 16 of them.
const SMALLEST: u32 = 64;

/// Side of the square grid of cells that holds so many maps: 1, 2 (up to 4), 3 (up to 9), 4 (up to 16).
#[must_use]
pub fn cells_per_side(maps: u32) -> u32 {
    (1..).find(|side| side * side >= maps).unwrap_or(1)
}

impl AtlasLayout {
    /// Squares of `cell` texels in the places of a grid that has room for `most` maps, row by row; `slots` are the places in
    /// use.
    #[must_use]
    pub fn equal(cell: u32, most: u32, slots: impl Iterator<Item = u32>) -> Self {
        let grid = cells_per_side(most);
        Self {
            side: grid * cell,
            rects: slots
                .map(|slot| UVec4::new(slot % grid * cell, slot / grid * cell, cell, cell))
                .collect(),
            places: Vec::new(),
            needs: Vec::new(),
        }
    }

    /// Rectangles that give all maps the same largest error; those of the frame before as long as they are good. `None`
    /// where the atlas has no room for maps of the smallest side.
    ///
    /// `needs`: the largest errors by slot, zero for slots without a map, which keep a place of the smallest side: a map
    /// that comes or goes thin moves no other (Lloyd, section 5.2). `slots`: those with a map, in the order of the
    /// rectangles.
    #[must_use]
    pub fn balanced(needs: Vec<LargestErrors>, slots: &[u32], side: u32, previous: Option<&Self>) -> Option<Self> {
        let with_rects = |layout: Self| {
            let rects = slots.iter().map(|slot| layout.places.get(*slot as usize).copied());
            let rects: Option<Vec<UVec4>> = rects.collect();
            Some(Self {
                rects: rects?,
                ..layout
            })
        };
        let kept = previous.filter(|previous| previous.side == side && previous.suits(&needs));
        if let Some(kept) = kept {
            return with_rects(kept.clone());
        }
        let limits = SizeLimits {
            smallest: SMALLEST.min(side / 16),
            largest: side,
            multiple: MULTIPLE,
        };
        let places = fill_atlas(&needs, side, &limits).cells;
        if places.len() != needs.len() {
            return None;
        }
        with_rects(Self {
            side,
            rects: Vec::new(),
            places,
            needs,
        })
    }

    /// Whether the shares and the shapes that the maps have are about those that they need, or a map has come that is good
    /// enough in its place, or has gone.
    fn suits(&self, needs: &[LargestErrors]) -> bool {
        let shares = |needs: &[LargestErrors]| -> Vec<f64> {
            let total: f64 = needs.iter().map(LargestErrors::storage_factor).sum();
            let sides = needs.iter().flat_map(|errors| [errors.across, errors.along]);
            sides.map(|error| error / total.sqrt()).collect()
        };
        let (old, new) = (shares(&self.needs), shares(needs));
        let tolerated = 1.0 / TOLERATED_CHANGE..=TOLERATED_CHANGE;
        // Maps of parts that see nothing need nothing.
        let is_kept = |(old, new): (&f64, &f64)| old == new || tolerated.contains(&(new / old));
        let errors = |needs: &[LargestErrors]| -> Vec<f64> {
            let maps = needs.iter().zip(&self.places);
            let errors = maps.map(|(need, place)| error_of_size(need, place.zw(), 1.0));
            errors
                .map(|error| if error.is_finite() { error } else { 0.0 })
                .collect()
        };
        let worst = errors(&self.needs).into_iter().fold(0.0, f64::max);
        let is_good_in_place = |slot: usize, error: f64| {
            let is_without = |needs: &[LargestErrors]| needs[slot].storage_factor() == 0.0;
            (is_without(&self.needs) || is_without(needs)) && error <= worst * TOLERATED_CHANGE
        };
        self.needs.len() == needs.len()
            && (old.chunks(2).zip(new.chunks(2)).zip(errors(needs)).enumerate())
                .all(|(slot, ((old, new), error))| old.iter().zip(new).all(is_kept) || is_good_in_place(slot, error))
    }

    /// The same layout in an atlas of at most `largest` texels per side.
    #[must_use]
    pub fn shrunk(&self, largest: u32) -> Self {
        if self.side <= largest {
            return self.clone();
        }
        let scaled = |texels: u32| (u64::from(texels) * u64::from(largest) / u64::from(self.side.max(1))) as u32;
        let shrink = |rect: &UVec4| {
            let start = UVec2::new(scaled(rect.x), scaled(rect.y));
            let end = UVec2::new(scaled(rect.x + rect.z), scaled(rect.y + rect.w));
            let size = (end - start).max(UVec2::ONE);
            UVec4::new(start.x, start.y, size.x, size.y)
        };
        Self {
            side: largest,
            rects: self.rects.iter().map(shrink).collect(),
            places: self.places.iter().map(shrink).collect(),
            needs: self.needs.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn assert_apart(layout: &AtlasLayout) {
        for (index, a) in layout.rects.iter().enumerate() {
            assert!(a.z > 0 && a.w > 0, "{a} is empty");
            assert!(a.x + a.z <= layout.side && a.y + a.w <= layout.side, "{a} sticks out");
            for b in &layout.rects[..index] {
                let is_apart = a.x + a.z <= b.x || b.x + b.z <= a.x || a.y + a.w <= b.y || b.y + b.w <= a.y;
                assert!(is_apart, "{a} overlaps {b}");
            }
        }
    }

    fn need(across: f64, along: f64) -> LargestErrors {
        LargestErrors { across, along }
    }

    #[test]
    fn equal_maps_fill_the_grid_without_overlap() {
        for most in 1..=16_u32 {
            let layout = AtlasLayout::equal(8, most, 0..most);
            let grid = cells_per_side(most);
            assert!(
                grid * grid >= most && (grid - 1) * (grid - 1) < most,
                "{grid}² cells for {most} maps"
            );
            assert_eq!((layout.side, layout.rects.len()), (8 * grid, most as usize));
            assert_apart(&layout);
        }
    }

    #[test]
    fn maps_keep_their_place_when_others_are_missing() {
        let all = AtlasLayout::equal(8, 5, 0..5);
        let some = AtlasLayout::equal(8, 5, [1, 4].into_iter());
        assert_eq!(some.rects, [all.rects[1], all.rects[4]]);
    }

    fn balanced(needs: Vec<LargestErrors>, previous: Option<&AtlasLayout>) -> AtlasLayout {
        let slots: Vec<u32> = (0..needs.len() as u32).collect();
        AtlasLayout::balanced(needs, &slots, 1024, previous).expect("room")
    }

    /// Lloyd, section 5.2: a face that comes into the light comes thin.
    #[test]
    fn maps_that_come_and_go_thin_move_no_other() {
        let of = |last: LargestErrors| vec![need(10.0, 10.0), need(3.0, 5.0), need(3.0, 5.0), last];
        let slots = [0, 1, 2, 3];
        let without = AtlasLayout::balanced(of(need(0.0, 0.0)), &slots[..3], 1024, None).expect("room");
        assert_eq!(without.rects.len(), 3);
        let thin = AtlasLayout::balanced(of(need(0.1, 0.4)), &slots, 1024, Some(&without)).expect("room");
        assert_eq!(thin.rects[..3], without.rects, "a thin map has come");
        assert_apart(&thin);
        let gone = AtlasLayout::balanced(of(need(0.0, 0.0)), &slots[..3], 1024, Some(&thin)).expect("room");
        assert_eq!(gone, without, "and gone");
        let thick = AtlasLayout::balanced(of(need(6.0, 6.0)), &slots, 1024, Some(&thin)).expect("room");
        assert_ne!(thick.rects[..3], without.rects, "a map that needs its share gets it");
        let fewer = AtlasLayout::balanced(of(need(0.1, 0.4)), &[1, 3], 1024, Some(&thin)).expect("room");
        assert_eq!(
            fewer.rects,
            [thin.rects[1], thin.rects[3]],
            "rectangles follow their slots"
        );
    }

    #[test]
    fn balanced_maps_stay_until_the_need_has_changed() {
        let of = |stretch: f64| vec![need(10.0 * stretch, 10.0), need(3.0, 5.0), need(3.0, 5.0)];
        let first = balanced(of(1.0), None);
        assert_apart(&first);
        let near = balanced(of(1.2), Some(&first));
        assert_eq!(first, near, "a fifth is tolerated");
        let unseen = |along: f64| [of(1.0), vec![need(0.0, 0.0)], vec![need(1.0, along)]].concat();
        let with_unseen = balanced(unseen(1.0), None);
        let later = balanced(unseen(1.01), Some(&with_unseen));
        assert_eq!(with_unseen, later, "a map that nothing needs changes nothing");
        let far = balanced(of(1.8), Some(&first));
        assert_ne!(first.rects, far.rects, "four fifths are not");
        let fewer = balanced(of(1.0)[..2].to_vec(), Some(&first));
        assert_eq!(fewer.rects.len(), 2, "a map less");
    }

    #[test]
    fn layouts_shrink_to_the_device() {
        let layout = AtlasLayout::equal(4096, 16, 0..16);
        let shrunk = layout.shrunk(8192);
        assert_eq!((shrunk.side, shrunk.rects[5]), (8192, UVec4::splat(2048)));
        assert_apart(&shrunk);
        assert_eq!(layout.shrunk(16_384), layout, "what fits is kept");
    }

    proptest! {
        #[test]
        fn balanced_maps_never_overlap(
            needs in prop::collection::vec((0.01f64..100.0, 0.01f64..100.0), 1..=16),
            side in prop_oneof![Just(256u32), Just(1000), Just(4095)],
            largest in 100u32..5000,
        ) {
            let needs: Vec<_> = needs.into_iter().map(|(across, along)| need(across, along)).collect();
            let slots: Vec<u32> = (0..needs.len() as u32).collect();
            let layout = AtlasLayout::balanced(needs, &slots, side, None).expect("room");
            assert_apart(&layout);
            let shrunk = layout.shrunk(largest);
            prop_assert!(shrunk.rects.iter().all(|rect| rect.x + rect.z <= shrunk.side && rect.y + rect.w <= shrunk.side));
        }
    }
}
