//! Mips of real leaves: coverage stays, where plain averaging changes it.

use umbrage::forge::texture::{
    leaf::LeafShape,
    mips::{coverage, coverage_preserving_mips},
    sprigs::{Sprig, paint},
};

const BIRCH: Sprig = Sprig::Leaves {
    shape: LeafShape::BIRCH,
    length: 0.115,
    count: 60,
};

#[test]
fn every_mip_covers_what_the_first_covers() {
    for sprig in [BIRCH, Sprig::Spray, Sprig::Tufts] {
        let [picture, _] = paint(sprig, "leaves", 3);
        let mips = coverage_preserving_mips(&picture, 0.5);
        assert_eq!(mips.len(), 10, "512 texels down to one");
        let wanted = coverage(&mips[0].texels, 0.5);
        // Down to 8 × 8 texels; below, one texel is more than 1 %.
        for mip in &mips[1..7] {
            let own = coverage(&mip.texels, 0.5);
            assert!(
                (own - wanted).abs() < 0.01,
                "{sprig:?}, {} wide: {own} for {wanted}",
                mip.width
            );
        }
    }
}

#[test]
fn plain_averages_miss_the_coverage() {
    let [picture, _] = paint(BIRCH, "leaves", 3);
    let wanted = coverage(&picture.texels, 0.5);
    // The mean alpha of 32 × 32 texels against the same cutoff: what a loader without care would show.
    let side = picture.width / 32;
    let mean = |i: usize| -> f32 {
        let (x, y) = (i % side * 32, i / side * 32);
        let block = (0..1024).map(|j| f32::from(picture.texels[(y + j / 32) * picture.width + x + j % 32][3]));
        block.sum::<f32>() / 1024.0
    };
    let plain = (0..side * side).filter(|i| mean(*i) >= 127.5).count() as f32 / (side * side) as f32;
    assert!((plain - wanted).abs() > 0.01, "plain {plain}, wanted {wanted}");
}
