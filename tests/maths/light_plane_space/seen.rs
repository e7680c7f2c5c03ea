//! Blocks of a picture, and what they cover.

use bevy_math::{DVec2, DVec3, UVec2, Vec2};
use umbrage::maths::{
    fit::LightAxes,
    light_plane::space::{BaseFilm, BlockCorner, FilmHull, SeenPicture, block_pixels, reduce_block},
};

use super::scene::{Camera, scene_two};
use crate::support::close;

const TRAVEL: DVec3 = DVec3::new(0.4, -1.0, -0.3);

fn camera(picture_size: UVec2, samples: UVec2) -> Camera {
    let (eye, ahead) = (DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.2, -0.3, -1.0));
    Camera::sparse(eye, ahead, 0.5, 1.5, samples, picture_size)
}

fn base(picture: &SeenPicture, camera: &Camera) -> BaseFilm {
    let axes = LightAxes::new(camera.view.forward(), DVec3::Y, TRAVEL).expect("a light");
    let positions: Vec<DVec3> = picture.blocks.iter().flatten().map(|block| block.position).collect();
    BaseFilm::of_sun(axes, &positions).expect("surfaces")
}

#[test]
fn every_pixel_is_in_one_block() {
    for (size, grid) in [
        (UVec2::new(64, 36), UVec2::new(8, 4)),
        (UVec2::new(161, 91), UVec2::new(16, 9)),
        (UVec2::new(7, 5), UVec2::new(16, 3)),
    ] {
        let mut counts = vec![0; size.element_product() as usize];
        for y in 0..grid.y {
            for x in 0..grid.x {
                let pixels = block_pixels(size, grid, UVec2::new(x, y));
                for row in pixels.y..pixels.w {
                    for column in pixels.x..pixels.z {
                        counts[(row * size.x + column) as usize] += 1;
                    }
                }
            }
        }
        assert!(counts.iter().all(|count| *count == 1), "{size} in {grid}");
    }
}

/// A block of 4 × 3 pixels at the right of a picture of 8 × 3.
#[test]
fn a_block_by_hand() {
    #[rustfmt::skip]
    let depths = [
        9.0, 9.0, 9.0, 9.0, 0.2, 0.3, 0.0, 0.0,
        9.0, 9.0, 9.0, 9.0, 0.4, 0.0, 0.0, 0.1,
        9.0, 9.0, 9.0, 9.0, 0.0, 0.6, 0.5, 0.0,
    ];
    let block = reduce_block(&depths, UVec2::new(8, 3), UVec2::new(2, 1), UVec2::X).expect("surfaces");
    assert_eq!((block.depths_ndc, block.pixels), ([0.6, 0.1], 6));
    // From (5, 0) 0.1 less to the left, and its neighbours to the right and below see the sky.
    assert_eq!(
        (block.plane.depth_ndc, block.plane.slope),
        (0.3, Vec2::new(0.3 - 0.2, 0.0))
    );
    let [lowest, highest] = block.plane.offsets;
    close(lowest.into(), 0.1 - 0.5, 1.0e-6);
    close(highest.into(), 0.6 - 0.3, 1.0e-6);
    // The middle is at (6, 1.5): (5, 0), (5, 2) and (6, 2) are equally near, and the first of them counts.
    assert_eq!(block.pixel, UVec2::new(5, 0));
    assert_eq!(
        reduce_block(&[0.0; 24], UVec2::new(8, 3), UVec2::new(2, 1), UVec2::X),
        None
    );
}

/// The rays of a block's corners hold all that its pixels show, whether it is one surface or several.
#[test]
fn all_pixels_lie_between_the_rays() {
    let camera = camera(UVec2::new(96, 64), UVec2::new(12, 8));
    let (picture, points) = camera.picture(&scene_two());
    let base = base(&picture, &camera);
    let blocks: Vec<_> = picture.on_film(&base).collect();
    assert_eq!(blocks.len(), picture.blocks.iter().flatten().count());
    let pixels: f64 = blocks
        .iter()
        .filter_map(|block| block.sample)
        .map(|sample| sample.pixels)
        .sum();
    close(pixels, points.len() as f64, 0.0);
    let clip_from_world = camera.grid.clip_from_world;
    let mut checked = 0;
    for point in &points {
        let ndc = clip_from_world.project_point3(*point);
        let place = DVec2::new(ndc.x + 1.0, 1.0 - ndc.y) * 0.5 * picture.size.as_dvec2();
        let pixel = place.as_uvec2();
        let cell = pixel * picture.grid / picture.size;
        let index = (cell.y * picture.grid.x + cell.x) as usize;
        let number = picture.blocks[..index].iter().flatten().count();
        let block = &blocks[number];
        let depth = (clip_from_world * point.extend(1.0)).w;
        let slack = 1.0e-6 * depth;
        assert!(
            (block.depths[0] - slack..=block.depths[1] + slack).contains(&depth),
            "{depth}"
        );
        let hull = FilmHull::new(block.points()).expect("an area").dilated(1.0e-7);
        let inside = base.film(*point).expect("sunlit");
        let sides = hull.points().iter().zip(hull.points().iter().cycle().skip(1));
        for (a, b) in sides {
            assert!((b - a).perp_dot(inside - a) >= 0.0, "{point} is outside of its block");
        }
        checked += 1;
    }
    assert!(checked > 4_000, "{checked} pixels");
}

/// One surface that fills the picture lies in a layer without thickness, far thinner than the depths of its blocks.
#[test]
fn one_surface_lies_in_a_thin_layer() {
    let (eye, ahead) = (DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.2, -1.0, -1.0));
    let camera = Camera::sparse(eye, ahead, 0.5, 1.5, UVec2::new(12, 8), UVec2::new(96, 64));
    let (picture, points) = camera.picture(&scene_two()[..1]);
    assert_eq!(points.len(), 96 * 64, "a plane fills the picture");
    let base = base(&picture, &camera);
    for block in picture.on_film(&base) {
        let thickness = |ends: [BlockCorner; 2]| (ends[1].depth - ends[0].depth).abs();
        let [near, far] = block.depths;
        let thickest = block.corners.map(thickness).into_iter().fold(0.0, f64::max);
        assert!(thickest < 1.0e-4 * (far - near), "{thickest} of {near}..{far}");
    }
}

/// A block that is cut in two holds the same together, and its sample is in one of the parts.
#[test]
fn parts_of_a_block() {
    let camera = camera(UVec2::new(96, 64), UVec2::new(12, 8));
    let (picture, _) = camera.picture(&scene_two());
    let base = base(&picture, &camera);
    let deepest = |spread: f64, depths: [f64; 2]| spread.max(depths[1] / depths[0]);
    assert!(
        picture.on_film(&base).map(|block| block.depths).fold(1.0, deepest) > 1.5,
        "a block spans two surfaces"
    );
    for block in picture.on_film(&base) {
        let [near, far] = block.depths;
        let middle = 0.5 * (near + far);
        let parts = [block.between(0.0, middle), block.between(middle, 1.0e9)].map(|part| part.expect("both parts"));
        assert_eq!(
            parts.iter().filter(|part| part.sample.is_some()).count(),
            usize::from(block.sample.is_some())
        );
        assert_eq!((parts[0].depths, parts[1].depths), ([near, middle], [middle, far]));
        // A cut has no thickness: together the parts hold what the block holds, and no more.
        let area = |points: &[DVec2]| FilmHull::new(points.iter().copied()).expect("an area").area();
        let whole = block.points();
        let both: Vec<DVec2> = parts.iter().flat_map(|part| part.points()).collect();
        close(area(&both), area(&whole), 1.0e-9);
        assert!(parts.iter().all(|part| part.points().len() >= 3), "{parts:?}");
        assert_eq!(block.between(far * 1.01, 1.0e9), None);
        assert_eq!(block.between(0.0, near), None);
    }
}
