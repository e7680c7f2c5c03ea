//! Sizes of maps and their places in the atlas (Lloyd, sections 4.2, 5.3, 6.1).

use bevy_math::{UVec2, UVec4};
use proptest::prelude::*;
use umbrage::maths::{
    body::light_visible,
    error::LargestErrors,
    face::{FaceOptions, face_partitions},
    storage::{
        Allocation, AllocationState, Packing, PackingState, SizeLimits, allocate, budgeted_size, critical_size,
        error_of_size, fill_atlas, pack,
    },
};

use crate::support::{OPENING, close, huge_scene, light_at, papers_camera};

fn errors(across: f64, along: f64) -> LargestErrors {
    LargestErrors { across, along }
}

/// Lloyd, section 3.11: 2428 × 1729 texels per warped slice for a picture of 1024².
#[test]
fn the_critical_size_of_a_slice() {
    let slice_ratio = 1000.0_f64.powf(0.25);
    let slice = errors(slice_ratio.sqrt(), (slice_ratio - 1.0) / (OPENING * slice_ratio.sqrt()));
    let size = critical_size(&slice, 1024.0).round();
    assert_eq!((size.x, size.y), (2428.0, 1729.0));
    close(slice.storage_factor() * 4.0, 16.02, 1.0e-3);
}

/// Lloyd, equations 13 and 14 and oracles 9 and 10.
#[test]
fn a_budget_gives_both_axes_the_same_error() {
    let ratio = 1000.0_f64;
    let lispsm = errors(ratio.sqrt(), (ratio - 1.0) / (OPENING * ratio.sqrt()));
    let psm = errors(1.0, (ratio - 1.0) / OPENING);
    for (errors, aspect) in [
        (lispsm, ratio / (ratio - 1.0) * OPENING),
        (psm, OPENING / (ratio - 1.0)),
    ] {
        let size = budgeted_size(&errors, 1024.0 * 1024.0);
        close(size.element_product(), 1024.0 * 1024.0, 1.0e-12);
        close(size.x / size.y, aspect, 1.0e-9);
        let found = critical_size(&errors, 800.0) / size;
        close(found.x, found.y, 1.0e-12);
        close(
            found.x,
            800.0 * (errors.storage_factor() / (1024.0 * 1024.0)).sqrt(),
            1.0e-9,
        );
    }
}

#[test]
fn alike_maps_get_alike_sizes() {
    let slices = [errors(2.0, 2.0); 4];
    let allocation = allocate(&slices, 4 * 2048 * 2048, &SizeLimits::default());
    assert_eq!(allocation.sizes, [UVec2::splat(2048); 4]);
    assert_eq!(allocation.state, AllocationState::Equal);
}

#[test]
fn texels_follow_the_storage_factor() {
    let maps = [errors(8.0, 2.0), errors(4.0, 4.0), errors(2.0, 1.0)];
    let Allocation { sizes, state } = allocate(&maps, 1 << 22, &SizeLimits::default());
    assert_eq!(state, AllocationState::Equal);
    let worst = maps
        .iter()
        .zip(&sizes)
        .map(|(errors, size)| error_of_size(errors, *size, 1.0));
    let ideal = ((16.0 + 16.0 + 2.0) / f64::from(1 << 22)).sqrt();
    for error in worst {
        close(error, ideal, 0.03);
    }
}

/// A clamped side leaves its texels to the other one; a map that needs next to nothing gets the smallest size.
#[test]
fn limits_are_kept() {
    let limits = SizeLimits {
        smallest: 60,
        largest: 1000,
        multiple: 8,
    };
    let maps = [
        errors(1000.0, 1.0),
        errors(1.0e-6, 1.0e-6),
        errors(f64::NAN, 1.0),
        errors(0.0, 1.0),
    ];
    let allocation = allocate(&maps, 1 << 19, &limits);
    assert_eq!(allocation.state, AllocationState::Limited);
    assert_eq!(allocation.sizes[1..], [UVec2::splat(64); 3]);
    assert_eq!(allocation.sizes[0].x, 1000);
    assert!(allocation.sizes[0].y > 450, "{allocation:?}");
    assert!(allocation.texels() <= 1 << 19);
    // Two maps with one S̄ keep one number of texels.
    let limits = SizeLimits {
        largest: 1024,
        ..SizeLimits::default()
    };
    let alike = allocate(&[errors(64.0, 1.0), errors(8.0, 8.0)], 1 << 20, &limits);
    assert_eq!(alike.sizes, [UVec2::new(1024, 512), UVec2::splat(720)]);
    // A side that is raised to the smallest does not shorten the other one: that has the largest error.
    let small = allocate(&[errors(1.0, 64.0), errors(8.0, 8.0)], 1 << 14, &limits);
    assert_eq!(small.sizes, [UVec2::new(64, 192), UVec2::splat(64)]);
}

#[test]
fn budgets_that_hold_no_map() {
    let limits = SizeLimits::default();
    for (budget, side) in [(64 * 64 * 3, 48), (400, 8), (100, 0), (0, 0)] {
        let allocation = allocate(&[errors(1.0, 1.0); 4], budget, &limits);
        assert_eq!(allocation.state, AllocationState::OverBudget);
        assert_eq!(allocation.sizes, [UVec2::splat(side); 4]);
    }
    assert_eq!(allocate(&[], 100, &limits).sizes, []);
    let odd = SizeLimits {
        smallest: 0,
        largest: 0,
        multiple: 0,
    };
    assert_eq!(allocate(&[errors(1.0, 2.0)], 1000, &odd).sizes, [UVec2::ONE]);
}

#[test]
fn needs_of_any_magnitude_are_met() {
    for scale in [1.0e-200, 1.0e-12, 1.0, 1.0e15, 1.0e200] {
        let maps = [errors(scale, scale), errors(2.0 * scale, 2.0 * scale)];
        let allocation = allocate(&maps, 1 << 20, &SizeLimits::default());
        assert_eq!(allocation.sizes, [UVec2::splat(456), UVec2::splat(912)], "{scale}");
    }
    let nothing = allocate(&[errors(0.0, 0.0); 2], 1 << 20, &SizeLimits::default());
    assert_eq!(
        (nothing.sizes, nothing.state),
        (vec![UVec2::splat(64); 2], AllocationState::Limited)
    );
}

#[test]
fn equal_squares_fill_a_grid() {
    let grid = pack(&[UVec2::splat(2048); 4], 4096, 8);
    assert_eq!(grid.state, PackingState::Whole);
    let corners: Vec<UVec2> = grid.cells.iter().map(|cell| UVec2::new(cell.x, cell.y)).collect();
    let expected = [(0, 0), (2048, 0), (0, 2048), (2048, 2048)].map(|(x, y)| UVec2::new(x, y));
    assert_eq!(corners, expected);
    assert_eq!(pack(&[UVec2::splat(1024); 16], 4096, 8).state, PackingState::Whole);
}

#[test]
fn what_does_not_fit_shrinks_evenly() {
    let shrunk = pack(&[UVec2::new(3000, 1000), UVec2::new(2000, 4000)], 4096, 8);
    assert_eq!(shrunk.state, PackingState::Shrunk);
    let [wide, high] = shrunk.cells[..] else {
        panic!("two cells")
    };
    close(f64::from(wide.z) / f64::from(high.z), 1.5, 0.02);
    close(f64::from(wide.w) / f64::from(high.w), 0.25, 0.02);
    assert!(wide.z > 2300, "{wide}");
    let crowd = pack(&[UVec2::splat(64); 100], 64, 8);
    assert_eq!((crowd.state, crowd.cells.len()), (PackingState::TooMany, 0));
    assert_eq!(pack(&[UVec2::splat(64); 60], 64, 8).state, PackingState::Shrunk);
    assert_eq!(
        pack(&[], 64, 8),
        Packing {
            cells: Vec::new(),
            state: PackingState::Whole
        }
    );
    assert_eq!(pack(&[UVec2::ONE], 0, 8).state, PackingState::TooMany);
}

/// z-partitions fill the atlas: none of it is lost, whatever the shape of the errors.
#[test]
fn alike_maps_fill_the_atlas() {
    let packing = fill_atlas(&[errors(2.3714, 1.6885); 4], 4096, &SizeLimits::default());
    assert_eq!(packing.state, PackingState::Whole);
    let sizes: Vec<[u32; 2]> = packing.cells.iter().map(|cell| [cell.z, cell.w]).collect();
    assert_eq!(sizes, [[2048, 2048]; 4]);
}

/// The maps of a face partition together are better off than in the cells of a square grid, and lose less than half to
/// their shapes: four maps twice as wide as high can but be square.
#[test]
fn face_partitions_fill_the_atlas() {
    let view = papers_camera(1.0, 1000.0);
    let visible = light_visible(&view, &huge_scene());
    for degrees in [0.0, 30.0, 70.0, 90.0, 120.0] {
        for slices in [1, 2, 4] {
            let options = FaceOptions {
                slices,
                ..FaceOptions::default()
            };
            let partitions = face_partitions(&view, &visible, light_at(degrees), &options);
            let errors: Vec<LargestErrors> = partitions.iter().map(|part| part.largest_errors(&view, 0.0)).collect();
            let packing = fill_atlas(&errors, 4096, &SizeLimits::default());
            assert_eq!(packing.state, PackingState::Whole, "{degrees} {slices}");
            let of_maps = packing.cells.iter().zip(&errors);
            let worst = of_maps.map(|(cell, errors)| error_of_size(errors, UVec2::new(cell.z, cell.w), 1024.0));
            let sum: f64 = errors.iter().map(LargestErrors::storage_factor).sum();
            let ideal = 1024.0 * sum.sqrt() / 4096.0;
            let loss = worst.fold(0.0, f64::max) / ideal;
            let cell = UVec2::splat(4096 / (errors.len() as f64).sqrt().ceil() as u32);
            let of_grid = errors.iter().map(|errors| error_of_size(errors, cell, 1024.0));
            let grid_loss = of_grid.fold(0.0, f64::max) / ideal;
            assert!(
                loss < 1.5 && loss <= grid_loss + 1.0e-9,
                "{degrees} {slices}: {loss} against {grid_loss}"
            );
        }
    }
}

#[test]
fn atlases_that_hold_no_maps() {
    let limits = SizeLimits::default();
    assert_eq!(
        fill_atlas(&[errors(1.0, 1.0); 4], 64, &limits).state,
        PackingState::Shrunk
    );
    assert_eq!(
        fill_atlas(&[errors(1.0, 1.0); 100], 64, &limits).state,
        PackingState::TooMany
    );
    assert_eq!(fill_atlas(&[], 64, &limits).cells, []);
    let nothing = fill_atlas(&[errors(f64::NAN, 0.0), errors(0.0, 0.0)], 4096, &limits);
    assert_eq!(nothing.state, PackingState::Whole);
}

fn assert_apart(cells: &[UVec4], side: u32) -> Result<(), TestCaseError> {
    for (index, a) in cells.iter().enumerate() {
        prop_assert!(a.x + a.z <= side && a.y + a.w <= side, "{a} sticks out");
        for b in &cells[..index] {
            let apart = a.x + a.z <= b.x || b.x + b.z <= a.x || a.y + a.w <= b.y || b.y + b.w <= a.y;
            prop_assert!(apart, "{a} overlaps {b}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn packings_never_overlap(sizes in prop::collection::vec((0_u32..900, 1_u32..900), 0..24), side in 1_u32..2000) {
        let sizes: Vec<UVec2> = sizes.into_iter().map(|(x, y)| UVec2::new(x, y)).collect();
        let packing = pack(&sizes, side, 8);
        assert_apart(&packing.cells, side)?;
        prop_assert_eq!(&packing, &pack(&sizes, side, 8));
        match packing.state {
            PackingState::Whole => {
                for (cell, size) in packing.cells.iter().zip(&sizes) {
                    prop_assert_eq!(UVec2::new(cell.z, cell.w), *size);
                }
                prop_assert_eq!(packing.cells.len(), sizes.len());
            }
            PackingState::Shrunk => {
                for (cell, size) in packing.cells.iter().zip(&sizes) {
                    prop_assert!(cell.z <= size.x && cell.w <= size.y);
                }
                prop_assert_eq!(packing.cells.len(), sizes.len());
            }
            PackingState::TooMany => prop_assert!(packing.cells.is_empty()),
        }
    }

    #[test]
    fn allocations_keep_to_the_budget(
        maps in prop::collection::vec((-4.0..4.0_f64, -4.0..4.0_f64), 1..17), budget in 0_u64..1 << 26,
    ) {
        let maps: Vec<LargestErrors> = maps.into_iter().map(|(x, y)| errors(10.0_f64.powf(x), 10.0_f64.powf(y))).collect();
        let limits = SizeLimits { smallest: 64, largest: 4096, multiple: 8 };
        let allocation = allocate(&maps, budget, &limits);
        prop_assert!(allocation.texels() <= budget);
        prop_assert_eq!(&allocation, &allocate(&maps, budget, &limits));
        if allocation.state == AllocationState::OverBudget {
            prop_assert!(budget < 64 * 64 * maps.len() as u64);
            return Ok(());
        }
        for size in &allocation.sizes {
            prop_assert!(size.min_element() >= 64 && size.max_element() <= 4096 && *size % 8 == UVec2::ZERO, "{size}");
        }
        if allocation.state == AllocationState::Equal {
            let worst: Vec<f64> = maps.iter().zip(&allocation.sizes).map(|(errors, size)| error_of_size(errors, *size, 1.0)).collect();
            let least = worst.iter().copied().fold(f64::INFINITY, f64::min);
            // Rounding down takes at most a multiple of 8 from at least 72.
            prop_assert!(worst.iter().all(|error| *error <= least * 80.0 / 72.0 * (1.0 + 1.0e-9)), "{worst:?}");
        }
    }

    #[test]
    fn atlases_are_filled(maps in prop::collection::vec((-2.0..2.0_f64, -2.0..2.0_f64), 1..17), side in 512_u32..4096) {
        let maps: Vec<LargestErrors> = maps.into_iter().map(|(x, y)| errors(10.0_f64.powf(x), 10.0_f64.powf(y))).collect();
        let packing = fill_atlas(&maps, side, &SizeLimits::default());
        assert_apart(&packing.cells, side)?;
        prop_assert_eq!(packing.state, PackingState::Whole);
        prop_assert_eq!(packing.cells.len(), maps.len());
    }
}
