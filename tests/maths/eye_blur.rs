//! Blur of the shadow result on the screen.

use bevy_math::Vec3;
use umbrage::maths::filter::eye_blur::{EyeBlur, EyePicture, EyePixel, MAX_ITERATIONS, iterations_at, strength};

const WIDTH: usize = 48;

fn all(iterations: u32) -> EyeBlur {
    EyeBlur {
        iterations,
        full_depth: f32::INFINITY,
    }
}

/// A wall at view depth `depth` that faces the viewer, one centimetre per pixel at 10 m.
fn wall(depth: impl Fn(usize, usize) -> f32, visibility: impl Fn(usize, usize) -> f32) -> EyePicture {
    let places = || (0..WIDTH * WIDTH).map(|index| (index % WIDTH, index / WIDTH));
    let pixels = places().map(|(x, y)| {
        let view_depth = depth(x, y);
        EyePixel {
            position: Vec3::new(x as f32, y as f32, -1000.0) * view_depth * 0.001,
            normal: Vec3::Z,
            view_depth,
        }
    });
    EyePicture {
        width: WIDTH,
        pixels: pixels.collect(),
        visibility: places().map(|(x, y)| visibility(x, y)).collect(),
    }
}

fn impulse(x: usize, y: usize) -> f32 {
    f32::from(u8::from(x == WIDTH / 2 && y == WIDTH / 2))
}

fn stripes(x: usize, y: usize) -> f32 {
    f32::from(u8::from((x / 2 + y / 7) % 2 == 0))
}

fn sum(picture: &EyePicture) -> f64 {
    picture.visibility.iter().map(|value| f64::from(*value)).sum()
}

/// Scherzer, oracle 19: the variance of i iterations is i ÷ 2 pixels² per axis; sums, constants and the range stay.
#[test]
fn iterations_have_their_variance() {
    for iterations in [0, 1, 2, 4, 8, 16] {
        let picture = wall(|_, _| 10.0, impulse).blurred(&all(iterations));
        assert!((sum(&picture) - 1.0).abs() < 1e-6, "{iterations} iterations");
        for axis in 0..2 {
            let variance: f32 = picture
                .visibility
                .iter()
                .enumerate()
                .map(|(index, value)| {
                    let place = [index % WIDTH, index / WIDTH][axis] as f32 - (WIDTH / 2) as f32;
                    value * place * place
                })
                .sum();
            let expected = iterations as f32 / 2.0;
            assert!((variance - expected).abs() < 1e-3, "{variance}, not {expected}");
        }
    }
    let one = wall(|_, _| 10.0, impulse).blurred(&all(1));
    let at = |x: usize, y: usize| one.visibility[(WIDTH / 2 + y) * WIDTH + WIDTH / 2 + x];
    assert_eq!(
        [at(0, 0), at(1, 0), at(0, 1), at(1, 1), at(2, 0)],
        [0.25, 0.125, 0.125, 0.0625, 0.0]
    );
}

#[test]
fn no_iteration_changes_nothing_and_twice_is_double() {
    let picture = wall(|_, _| 10.0, stripes);
    assert_eq!(picture.clone().blurred(&all(0)), picture);
    let twice = picture.clone().blurred(&all(4)).blurred(&all(4));
    assert_eq!(twice, picture.clone().blurred(&all(8)));
    assert_eq!(
        picture.clone().blurred(&all(1000)),
        picture.blurred(&all(MAX_ITERATIONS)),
        "limited"
    );
}

/// Scherzer, oracle 19, and the sum also with borders, edges and strengths that differ from pixel to pixel.
#[test]
fn the_blur_is_a_diffusion() {
    let slanted = |x: usize, y: usize| if y < 5 { 0.0 } else { 4.0 + x as f32 * 0.005 };
    let blur = EyeBlur {
        iterations: 7,
        full_depth: 2.0,
    };
    let strengths = [0, WIDTH - 1].map(|x| strength(&blur, slanted(x, 9), 1));
    assert!(strengths[0] > strengths[1] + 0.1, "neighbours differ: {strengths:?}");
    for depth in [
        &(|_: usize, _: usize| 10.0_f32) as &dyn Fn(usize, usize) -> f32,
        &slanted,
    ] {
        for visibility in [stripes, |x: usize, _: usize| f32::from(u8::from(x < WIDTH / 2))] {
            let picture = wall(depth, visibility);
            let before = sum(&picture);
            let blurred = picture.clone().blurred(&blur);
            assert!(
                (sum(&blurred) - before).abs() < 1e-3,
                "{} against {before}",
                sum(&blurred)
            );
            assert!(
                blurred.visibility.iter().all(|value| (0.0..=1.0).contains(value)),
                "in 0..=1"
            );
            assert_ne!(blurred, picture);
        }
        let constant = wall(depth, |_, _| 0.3);
        assert_eq!(constant.clone().blurred(&blur), constant);
    }
}

/// Scherzer, oracle 20: the radius never grows with depth, and far pixels stay as they are, bit by bit.
#[test]
fn far_pixels_are_left_alone() {
    let blur = EyeBlur {
        iterations: 16,
        full_depth: 5.0,
    };
    assert_eq!(iterations_at(&blur, 3.0), 16.0);
    assert!(
        (iterations_at(&blur, 10.0) - 4.0).abs() < 1e-5,
        "half the size on the screen: a quarter of the variance"
    );
    let mut last = f32::INFINITY;
    for step in 1..2000 {
        let depth = step as f32 * 0.05;
        let here = iterations_at(&blur, depth);
        assert!(here <= last, "{here} at {depth} m after {last}");
        last = here;
    }
    assert_eq!(last, 0.0);
    assert_eq!([0.0, -1.0].map(|depth| iterations_at(&blur, depth)), [0.0, 0.0], "sky");
    assert_eq!(
        [0, 3, 4, 15].map(|iteration| strength(&blur, 10.0, iteration)),
        [1.0, 1.0, 0.0, 0.0]
    );
    assert!(
        (strength(&blur, 20.0, 0) - 1.0).abs() < 1e-6 && strength(&blur, 30.0, 0) < 0.5,
        "a part of an iteration"
    );
    let far = wall(|_, _| 95.0, stripes);
    assert_eq!(far.clone().blurred(&blur), far);
    let variance_at = |depth: f32| {
        let picture = wall(|_, _| depth, impulse).blurred(&blur);
        let square = |index: usize| (index % WIDTH) as f32 - (WIDTH / 2) as f32;
        let values = picture.visibility.iter().enumerate();
        values.map(|(index, value)| value * square(index).powi(2)).sum::<f32>()
    };
    for depth in [4.0, 7.0, 10.0, 13.0, 19.0] {
        let expected = iterations_at(&blur, depth) / 2.0;
        assert!((variance_at(depth) - expected).abs() < 1e-3, "at {depth} m");
    }
}

/// Nothing crosses a step in depth, a fold or the border of the sky.
#[test]
fn edges_are_not_crossed() {
    let left_lit = |x: usize, _: usize| f32::from(u8::from(x < WIDTH / 2));
    let step = wall(|x, _| if x < WIDTH / 2 { 10.0 } else { 11.0 }, left_lit);
    assert_eq!(step.clone().blurred(&all(16)), step, "a step of a metre");
    let sky = wall(|x, _| if x < WIDTH / 2 { 0.0 } else { 11.0 }, left_lit);
    assert_eq!(sky.clone().blurred(&all(16)), sky, "sky");
    let mut fold = wall(|_, _| 10.0, left_lit);
    for (index, pixel) in fold.pixels.iter_mut().enumerate() {
        if index % WIDTH < WIDTH / 2 {
            pixel.normal = Vec3::new(0.5, 0.0, 0.866_025_4);
        }
    }
    assert_eq!(fold.clone().blurred(&all(16)), fold, "a fold of 30 degrees");
    let flat = wall(|_, _| 10.0, left_lit);
    assert_ne!(flat.clone().blurred(&all(16)), flat);
}

/// The ground seen at a low angle: neighbouring depths differ by percents, but it is one plane.
#[test]
fn slanted_ground_is_one_surface() {
    let mut ground = wall(|_, _| 10.0, |_, y| f32::from(u8::from(y / 2 % 2 == 0)));
    for (index, pixel) in ground.pixels.iter_mut().enumerate() {
        let (x, y) = (index % WIDTH, index / WIDTH);
        // Rays below the horizon meet the ground 1.7 m below the eye.
        let depth = 1.7 / (0.03 + 0.001 * y as f32);
        *pixel = EyePixel {
            position: Vec3::new((x as f32 - 24.0) * 0.001 * depth, -1.7, -depth),
            normal: Vec3::Y,
            view_depth: depth,
        };
    }
    assert!(
        ground.pixels[0].view_depth > 1.03 * ground.pixels[WIDTH].view_depth,
        "steps of 3 %"
    );
    let spread = |picture: &EyePicture| {
        let mean = sum(picture) as f32 / picture.visibility.len() as f32;
        picture
            .visibility
            .iter()
            .map(|value| (value - mean).powi(2))
            .sum::<f32>()
    };
    let before = spread(&ground);
    assert!(spread(&ground.blurred(&all(8))) < 0.3 * before, "blurred all over");
}
