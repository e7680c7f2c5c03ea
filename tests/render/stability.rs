//! Crawl and pop energy on masks and pictures made by hand.

use bevy::{
    math::{DVec3, UVec2},
    prelude::{Transform, Vec3},
};
use umbrage::render::reference::{
    pixels::{PixelRays, PixelTruth},
    stability::{Crawl, MaskFrame, Pop, crawl, luma},
};

const SIZE: UVec2 = UVec2::new(16, 8);
const PIXELS: usize = 16 * 8;
/// Distance of the wall that all frames look at, in metres.
const DISTANCE: f32 = 4.0;
/// Side of a pixel on the wall in metres: the wall is as high as twice its distance.
const PIXEL: f64 = 1.0;

/// A camera before the wall, moved by whole pixels; 90 degrees high.
fn rays(right: f64, up: f64) -> PixelRays {
    PixelRays {
        size: SIZE,
        eye: DVec3::new(right * PIXEL, up * PIXEL, 0.0),
        right: DVec3::X,
        up: DVec3::Y,
        forward: DVec3::NEG_Z,
        tan_half_fov_y: 1.0,
    }
}

/// What a frame owns.
struct Picture {
    rays: PixelRays,
    mask: Vec<u8>,
    depths: Vec<f32>,
    truth: Vec<PixelTruth>,
}

impl Picture {
    /// A lit wall with a mask: a function of the pixel.
    fn new(rays: PixelRays, mask: impl Fn(i32, i32) -> u8) -> Self {
        Self {
            rays,
            mask: (0..PIXELS as i32).map(|i| mask(i % 16, i / 16)).collect(),
            depths: vec![DISTANCE; PIXELS],
            truth: vec![PixelTruth::Lit; PIXELS],
        }
    }

    fn frame(&self) -> MaskFrame<'_> {
        MaskFrame {
            rays: self.rays,
            mask: &self.mask,
            depths: &self.depths,
            truth: &self.truth,
        }
    }
}

fn step(before: &Picture, after: &Picture) -> Crawl {
    Crawl::of(&crawl(&before.frame(), &after.frame()))
}

/// Squares of three pixels, fixed to the wall.
fn checker(x: i32, y: i32) -> u8 {
    if (x.div_euclid(3) + y.div_euclid(3)) % 2 == 0 {
        255
    } else {
        0
    }
}

#[test]
fn what_stands_still_has_no_energy() {
    let picture = Picture::new(rays(0.0, 0.0), checker);
    let still = step(&picture, &picture);
    assert_eq!((still.pixels, still.compared), (128, 128));
    assert_eq!((still.energy(), still.certain_energy()), (0.0, 0.0));
}

#[test]
fn an_edge_that_moves_by_a_pixel_has_its_length_as_energy() {
    let before = Picture::new(rays(0.0, 0.0), |x, _| if x < 7 { 0 } else { 255 });
    let after = Picture::new(rays(0.0, 0.0), |x, _| if x < 8 { 0 } else { 255 });
    // Eight pixels change by one; the camera stands still, so every pixel has one pixel before it.
    let moved = step(&before, &after);
    assert_eq!((moved.squared, moved.certain), (8.0, 8.0));
    assert!((moved.energy() - 8.0 / 128.0).abs() < 1e-12);
    // Filtered edges: a step by 51/255 is a fifth, its square a twenty-fifth.
    let soft = Picture::new(rays(0.0, 0.0), |x, _| if x < 7 { 51 } else { 255 });
    assert!((step(&before, &soft).squared - 7.0 * 8.0 / 25.0).abs() < 1e-12);
}

#[test]
fn a_mask_on_the_ground_moves_with_the_camera() {
    let before = Picture::new(rays(0.0, 0.0), checker);
    // Two pixels to the right and one up: the wall moves to the left and down in the picture.
    let after = Picture::new(rays(2.0, 1.0), |x, y| checker(x + 2, y - 1));
    let moved = step(&before, &after);
    assert_eq!((moved.squared, moved.certain), (0.0, 0.0));
    assert_eq!(moved.compared, 14 * 7, "two columns and a row come into the picture");
    // Glued to the screen instead, it crawls over the wall.
    let glued_to_screen = Picture::new(rays(2.0, 1.0), checker);
    let energy = step(&before, &glued_to_screen).energy();
    assert!(energy > 0.4, "{energy}");
}

/// A camera that comes nearer: the wall grows by a third, and every pixel finds its place between pixels.
#[test]
fn a_constant_mask_does_not_care_for_motion() {
    let before = Picture::new(rays(0.0, 0.0), |_, _| 0);
    let mut after = Picture::new(rays(0.3, 0.2), |_, _| 0);
    after.rays.eye.z = -1.0;
    after.depths = vec![DISTANCE - 1.0; PIXELS];
    let moved = step(&before, &after);
    assert_eq!((moved.compared, moved.squared, moved.certain), (128, 0.0, 0.0));
}

/// Half a pixel of motion: a hard edge that is fixed to the wall leaves a residue, but nothing certain.
#[test]
fn resampling_is_not_certain_crawl() {
    let before = Picture::new(rays(0.0, 0.0), |x, _| if x < 7 { 0 } else { 255 });
    let after = Picture::new(rays(0.5, 0.0), |x, _| if x < 7 { 0 } else { 255 });
    let moved = step(&before, &after);
    // One pixel per row lies halfway between both sides: (1/2)² in eight rows.
    assert!((moved.squared - 8.0 / 4.0).abs() < 1e-9, "{moved:?}");
    assert_eq!(moved.certain, 0.0);
    // Two pixels farther, it has moved for certain: one pixel per row more by 1, one by 1/2.
    let farther = Picture::new(rays(0.5, 0.0), |x, _| if x < 9 { 0 } else { 255 });
    let moved = step(&before, &farther);
    assert!((moved.squared - 8.0 * (0.25 + 1.0 + 1.0)).abs() < 1e-9, "{moved:?}");
    assert_eq!(moved.certain, 8.0 * 2.0);
}

#[test]
fn what_truth_changes_does_not_count() {
    let before = Picture::new(rays(0.0, 0.0), |x, _| if x < 7 { 0 } else { 255 });
    let mut after = Picture::new(rays(0.0, 0.0), |x, _| if x < 9 { 0 } else { 255 });
    // Truth goes along in the upper half only.
    for (index, truth) in after.truth.iter_mut().enumerate() {
        if index < PIXELS / 2 && (7..9).contains(&(index % 16)) {
            *truth = PixelTruth::Shadow;
        }
    }
    let moved = step(&before, &after);
    assert_eq!((moved.compared, moved.squared), (128 - 8, 8.0));
    // Pixels that are not valid in one of the frames do not count either.
    after.truth = vec![PixelTruth::Edge; PIXELS];
    assert_eq!(step(&before, &after).compared, 0);
    assert_eq!(step(&after, &before).compared, 0);
    assert_eq!(step(&before, &after).energy(), 0.0);
}

#[test]
fn what_was_hidden_does_not_count() {
    let mut before = Picture::new(rays(0.0, 0.0), |x, _| if x < 4 { 0 } else { 255 });
    let after = Picture::new(rays(0.0, 0.0), |_, _| 255);
    // Something stood before the wall on the left, a metre nearer.
    for (index, depth) in before.depths.iter_mut().enumerate() {
        if index % 16 < 4 {
            *depth = DISTANCE - 1.0;
        }
    }
    let moved = step(&before, &after);
    assert_eq!((moved.compared, moved.squared), (12 * 8, 0.0));
    // On the same surface, the same change counts.
    before.depths = vec![DISTANCE * 1.003; PIXELS];
    assert_eq!(step(&before, &after).squared, 4.0 * 8.0);
}

/// A plane seen at a slant: depths differ much from pixel to pixel, yet all of it is one surface.
#[test]
fn slanted_ground_is_one_surface() {
    let ground = |height: f64, ahead: f64| {
        let rays = PixelRays {
            eye: DVec3::new(0.0, height, -ahead),
            ..rays(0.0, 0.0)
        };
        let mut picture = Picture::new(rays, |_, _| 255);
        for y in 0..8 {
            for x in 0..16 {
                let direction = picture.rays.direction(x as f64 + 0.5, f64::from(y) + 0.5);
                let depth = -height / direction.y;
                let index = y as usize * 16 + x;
                picture.depths[index] = if depth > 0.0 { depth as f32 } else { 0.0 };
                if depth <= 0.0 {
                    picture.truth[index] = PixelTruth::Sky;
                }
            }
        }
        picture
    };
    let moved = step(&ground(2.0, 0.0), &ground(2.0, 0.1));
    // Four rows see ground; of these, the highest has sky among its four pixels.
    assert_eq!((moved.compared, moved.squared), (3 * 16, 0.0));
}

#[test]
fn nonsense_is_not_compared() {
    let picture = Picture::new(rays(0.0, 0.0), checker);
    let mut broken = Picture::new(rays(0.0, 0.0), checker);
    broken.depths = vec![f32::NAN; PIXELS];
    assert_eq!(step(&picture, &broken).compared, 0);
    assert_eq!(step(&broken, &picture).compared, 0);
    broken.depths.clear();
    assert_eq!(step(&picture, &broken).compared, 0);
    let mut turned = Picture::new(rays(0.0, 0.0), checker);
    turned.rays.forward = DVec3::Z;
    assert_eq!(step(&turned, &picture).compared, 0, "behind the camera");
    let mut empty = Picture::new(rays(0.0, 0.0), checker);
    empty.rays.size = UVec2::ZERO;
    assert_eq!(step(&picture, &empty), Crawl::default());
    assert_eq!(step(&empty, &picture).compared, 0);
}

/// A camera somewhere, turned anyhow: rounding does not make pixels their neighbors' mixtures.
#[test]
fn what_a_pixel_sees_projects_back_onto_it() {
    let eye = Transform::from_xyz(251.3, -12.7, 88.1).looking_at(Vec3::new(-3.0, 1.7, 2.9), Vec3::new(0.1, 1.0, 0.3));
    let picture = Picture::new(PixelRays::of_camera(SIZE, &eye, 1.1), |x, y| (x * 16 + y) as u8);
    let still = step(&picture, &picture);
    assert_eq!((still.compared, still.squared, still.certain), (128, 0.0, 0.0));
}

#[test]
fn steps_add_up() {
    let a = Picture::new(rays(0.0, 0.0), |_, _| 0);
    let b = Picture::new(rays(0.0, 0.0), |_, _| 255);
    let mut sum = step(&a, &b);
    sum += step(&b, &b);
    assert_eq!((sum.pixels, sum.compared, sum.energy()), (256, 256, 0.5));
    assert_eq!(sum.compared_share(), 1.0);
}

/// A quarter of the picture becomes brighter by 0.4, at once and over four frames.
#[test]
fn blending_divides_pop_energy_by_its_frames() {
    let frame = |share: f32| -> Vec<f32> { (0..16).map(|i| if i < 4 { 0.2 + 0.4 * share } else { 0.5 }).collect() };
    let close = |a: f64, b: f64| (a - b).abs() < 1e-7;
    let hard = Pop::of(&[frame(0.0), frame(0.0), frame(1.0), frame(1.0)]);
    assert!(close(hard.total(), 0.04) && close(hard.mean(), 0.04 / 3.0), "{hard:?}");
    assert_eq!(hard.peak().map(|(frame, _)| frame), Some(2));
    let soft = Pop::of(&[frame(0.0), frame(0.25), frame(0.5), frame(0.75), frame(1.0)]);
    assert!(close(soft.total(), 0.01), "{soft:?}");
    assert!(soft.peak().is_some_and(|(_, energy)| close(energy, 0.0025)), "{soft:?}");
}

#[test]
fn pop_energy_of_nothing_is_nothing() {
    let none = Pop::of::<Vec<f32>>(&[]);
    assert_eq!((none.total(), none.mean(), none.peak()), (0.0, 0.0, None));
    assert_eq!(Pop::of(&[vec![0.3]]).peak(), None);
    assert_eq!(Pop::of(&[vec![], vec![1.0]]).total(), 0.0);
}

#[test]
fn luma_weighs_colors() {
    let luma = luma(&[255, 255, 255, 0, 0, 255, 0, 255, 0, 0, 0, 255]);
    assert!(
        (luma[0] - 1.0).abs() < 1e-6 && (luma[1] - 0.7152).abs() < 1e-6,
        "{luma:?}"
    );
    assert_eq!(luma[2], 0.0);
}
