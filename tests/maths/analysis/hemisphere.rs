//! S̄ over all light directions.

use std::f64::consts::TAU;

use bevy_math::DVec3;
use umbrage::maths::{
    analysis::{
        direction::{Scheme, TiltedWarp},
        hemisphere::{LightDirection, StorageHemisphere, worst_direction},
    },
    storage::{LightPlace, PartitionScheme, closed_storage_factor},
};

use crate::support::{OPENING, close, papers_camera};

fn hemisphere(far: f64, scheme: &Scheme) -> StorageHemisphere {
    StorageHemisphere::new(&papers_camera(1.0, far), scheme, 18, 36).expect("sound")
}

/// Lloyd, table 3.8, its second half (figure 7): largest value and geometric mean on 19 × 36 directions.
#[test]
fn peaks_and_means() {
    for (far, uniform, guarded, faces) in [
        (100.0, (1.94e4, 1.23e4), (1.94e4, 296.0), (308.0, 164.5)),
        (1000.0, (1.94e6, 1.24e6), (1.94e6, 4174.0), (3024.0, 1645.0)),
        (10000.0, (1.94e8, 1.24e8), (1.94e8, 6.1e4), (3.00e4, 1.64e4)),
    ] {
        for (scheme, (largest, mean)) in [
            (Scheme::depth(1, TiltedWarp::Uniform), uniform),
            (Scheme::depth(1, TiltedWarp::Guarded), guarded),
            (Scheme::faces(1), faces),
        ] {
            let map = hemisphere(far, &scheme);
            close(map.largest().0, largest, 3.0e-3);
            close(map.geometric_mean(), mean, 1.0e-2);
        }
    }
}

/// Lloyd, table 3.9: slices, α = 1000; "within a factor of 2 to 3 of light from behind".
#[test]
fn peaks_and_means_of_slices() {
    for (slices, uniform, guarded, faces) in [
        (2, (3879.0, 2439.0), (3517.0, 161.2), (197.1, 102.9)),
        (4, (245.3, 142.4), (245.3, 44.68), (73.9, 32.7)),
        (8, (87.3, 43.2), (87.3, 28.28), (62.3, 21.1)),
    ] {
        for (scheme, closed, (largest, mean)) in [
            (
                Scheme::depth(slices, TiltedWarp::Uniform),
                PartitionScheme::Sliced,
                uniform,
            ),
            (
                Scheme::depth(slices, TiltedWarp::Guarded),
                PartitionScheme::SlicedWarped,
                guarded,
            ),
            (Scheme::faces(slices), PartitionScheme::FacesSlicedWarped, faces),
        ] {
            let map = hemisphere(1000.0, &scheme);
            close(map.largest().0, largest, 5.0e-3);
            close(map.geometric_mean(), mean, 5.0e-3);
            let behind = closed_storage_factor(closed, LightPlace::AlongView, 1000.0, slices as f64, OPENING);
            let share = map.largest().0 / behind.expect("sound");
            assert!((1.0..3.0).contains(&share), "{scheme:?}: {share}");
        }
    }
}

/// Lloyd, oracle 17: the largest of all directions.
#[test]
fn the_worst_direction() {
    for far in [10.0, 100.0, 1000.0] {
        let view = papers_camera(1.0, far);
        let (uniform, _) = worst_direction(&view, &Scheme::depth(1, TiltedWarp::Uniform)).expect("sound");
        assert!(
            (1.93..=2.0001).contains(&(uniform / (far * far))),
            "{}",
            uniform / (far * far)
        );
        let guarded_faces = Scheme {
            warp: TiltedWarp::Guarded,
            ..Scheme::faces(1)
        };
        let (faces, place) = worst_direction(&view, &guarded_faces).expect("sound");
        let share = faces / (2.0 * (far - 1.0) + 1.0);
        assert!((1.5..1.95).contains(&share), "{share} at {place:?}");
        assert!(faces >= hemisphere(far, &guarded_faces).largest().0);
    }
    // Guarded warps are never above no warp.
    let (uniform, guarded) = (
        hemisphere(1000.0, &Scheme::depth(1, TiltedWarp::Uniform)),
        hemisphere(1000.0, &Scheme::depth(1, TiltedWarp::Guarded)),
    );
    for ring in 0..=18 {
        for sector in 0..36 {
            assert!(guarded.value(ring, sector) <= uniform.value(ring, sector) * (1.0 + 1.0e-12));
        }
    }
    assert!(uniform.value(19, 0).is_nan());
}

/// Averaged over the sky the error falls from no warp over the warp and face partitions to four warped slices, all with
/// the same number of texels.
#[test]
fn the_mean_error_falls_from_scheme_to_scheme() {
    for far in [10.0, 100.0, 1000.0, 10000.0] {
        let means = [
            Scheme::depth(1, TiltedWarp::Uniform),
            Scheme::depth(1, TiltedWarp::Guarded),
            Scheme::faces(1),
            Scheme::depth(4, TiltedWarp::Guarded),
        ]
        .map(|scheme| hemisphere(far, &scheme).mean_error());
        assert!(means.is_sorted_by(|a, b| a > b), "{far}: {means:?}");
    }
    // The mean depends on the sky, not on the grid: every direction counts with its share.
    let view = papers_camera(1.0, 100.0);
    let unwarped = Scheme::depth(1, TiltedWarp::Uniform);
    let coarse = StorageHemisphere::new(&view, &unwarped, 18, 36)
        .expect("sound")
        .mean_error();
    let fine = StorageHemisphere::new(&view, &unwarped, 36, 72)
        .expect("sound")
        .mean_error();
    close(coarse, fine, 1.0e-2);
}

/// The hemisphere is left-right symmetric, and ahead equals behind.
#[test]
fn symmetries() {
    for scheme in [
        Scheme::depth(1, TiltedWarp::Uniform),
        Scheme::depth(2, TiltedWarp::Guarded),
        Scheme::faces(2),
    ] {
        let map = hemisphere(100.0, &scheme);
        for ring in 1..=18 {
            for sector in 0..36 {
                let value = map.value(ring, sector);
                close(map.value(ring, 36 - sector), value, 1.0e-6);
                close(map.value(ring, (18 + 36 - sector) % 36), value, 1.0e-6);
            }
        }
    }
}

#[test]
fn directions_are_named_from_the_viewer() {
    let view = papers_camera(1.0, 10.0);
    let travel = |polar: f64, azimuth: f64| {
        LightDirection {
            polar: polar.to_radians(),
            azimuth: azimuth.to_radians(),
        }
        .light_travel(&view)
    };
    // Light from ahead travels against the view direction −z.
    for (polar, azimuth, expected) in [
        (0.0, 77.0, [0.0, -1.0, 0.0]),
        (90.0, 0.0, [0.0, 0.0, 1.0]),
        (90.0, 180.0, [0.0, 0.0, -1.0]),
        (90.0, 90.0, [-1.0, 0.0, 0.0]),
    ] {
        assert!(
            travel(polar, azimuth).distance(expected.into()) < 1.0e-9,
            "{polar}° {azimuth}°"
        );
    }
}

/// Next to a light direction along a frustum edge the published warp of a face bends without bound; the guard mends it.
#[test]
fn the_spike_along_a_frustum_edge() {
    let view = papers_camera(1.0, 10.0);
    let behind = 19.0;
    let edge = DVec3::new(OPENING * 0.5, OPENING * 0.5, -1.0).normalize();
    let [mut published, mut guarded] = [0.0_f64; 2];
    for step in 0..400 {
        let turn = f64::from(step) * TAU / 400.0;
        let (right, up) = edge.any_orthonormal_pair();
        let light = -(edge + (right * turn.cos() + up * turn.sin()) * 1.0e-4);
        for (worst, warp) in [
            (&mut published, TiltedWarp::Lispsm),
            (&mut guarded, TiltedWarp::Guarded),
        ] {
            let scheme = Scheme {
                warp,
                ..Scheme::faces(1)
            };
            *worst = worst.max(scheme.storage_factor(&view, light).expect("sound"));
        }
    }
    assert!(published > 8.0 * behind, "{published}");
    assert!(guarded < 1.1 * behind, "{guarded}");
}
