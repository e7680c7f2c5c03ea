//! Scenes of a few flat pieces, seen by a camera pixel by pixel.

use bevy_math::{DMat4, DVec2, DVec3, UVec2};
use umbrage::maths::{
    fit::LightAxes,
    light_plane::space::{
        BaseFilm, FilmBin, FilmHull, FilmMoments, FilmSample, SampleGrid, SeenBlock, SeenPicture, reduce_block,
    },
    view::ViewVolume,
};

/// A part of a plane; the normal looks to the camera.
pub(crate) struct Piece {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) contains: fn(DVec3) -> bool,
}

pub(crate) struct Camera {
    pub(crate) view: ViewVolume,
    pub(crate) grid: SampleGrid,
}

impl Camera {
    /// `samples` in the picture, each standing for a pixel.
    pub(crate) fn new(eye: DVec3, forward: DVec3, half_fov: f64, aspect: f64, samples: UVec2) -> Self {
        Self::sparse(eye, forward, half_fov, aspect, samples, samples)
    }

    /// `samples` in a picture of more pixels.
    pub(crate) fn sparse(
        eye: DVec3,
        forward: DVec3,
        half_fov: f64,
        aspect: f64,
        samples: UVec2,
        picture_size: UVec2,
    ) -> Self {
        let view =
            ViewVolume::perspective(eye, forward, DVec3::Y, 2.0 * half_fov, aspect, 0.1, 1000.0).expect("a camera");
        let forward = view.forward();
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        let tangent = half_fov.tan();
        let row = |axis: DVec3, scale: f64| axis.extend(-axis.dot(eye)) / scale;
        let near = bevy_math::DVec4::W * 0.1;
        let rows = [row(right, tangent * aspect), row(up, tangent), near, row(forward, 1.0)];
        let clip_from_world = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        let grid = SampleGrid {
            clip_from_world,
            picture_size,
            samples,
        };
        Self { view, grid }
    }

    /// World-space points and the index of the piece, of all pixels that see one.
    pub(crate) fn hits(&self, pieces: &[Piece]) -> Vec<(DVec3, usize)> {
        let mut hits = Vec::new();
        for row in 0..self.grid.samples.y {
            for column in 0..self.grid.samples.x {
                let place = (DVec2::new(f64::from(column), f64::from(row)) + 0.5) / self.grid.samples.as_dvec2();
                hits.extend(self.hit(pieces, place * 2.0 - 1.0));
            }
        }
        hits
    }

    /// World-space point and index of the piece that a place of the picture shows.
    fn hit(&self, pieces: &[Piece], ndc: DVec2) -> Option<(DVec3, usize)> {
        let eye = self.view.eye();
        let ray = self.ray(ndc);
        let along = pieces.iter().enumerate().filter_map(|(index, piece)| {
            let distance = (piece.point - eye).dot(piece.normal) / ray.dot(piece.normal);
            let point = eye + ray * distance;
            (distance > 1.0e-6 && distance.is_finite() && (piece.contains)(point)).then_some((distance, index))
        });
        let (distance, index) = along.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((eye + ray * distance, index))
    }

    /// All pixels of the picture, and what its blocks come to.
    pub(crate) fn picture(&self, pieces: &[Piece]) -> (SeenPicture, Vec<DVec3>) {
        let (size, grid) = (self.grid.picture_size, self.grid.samples);
        let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y)));
        let hits: Vec<Option<(DVec3, usize)>> = pixels
            .map(|pixel| {
                let place = (pixel.as_dvec2() + 0.5) / size.as_dvec2();
                self.hit(pieces, DVec2::new(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y))
            })
            .collect();
        let clip_from_world = self.grid.clip_from_world;
        let depth =
            |hit: &Option<(DVec3, usize)>| hit.map_or(0.0, |(point, _)| clip_from_world.project_point3(point).z);
        let depths: Vec<f32> = hits.iter().map(|hit| depth(hit) as f32).collect();
        let block = |index: u32| {
            let block = UVec2::new(index % grid.x, index / grid.x);
            let reduced = reduce_block(&depths, size, grid, block)?;
            let (position, piece) = hits[(reduced.pixel.y * size.x + reduced.pixel.x) as usize]?;
            Some(SeenBlock {
                position,
                normal: pieces[piece].normal,
                depths_ndc: reduced.depths_ndc,
                pixel: reduced.pixel,
                pixels: reduced.pixels,
                plane: reduced.plane,
            })
        };
        let picture = SeenPicture {
            clip_from_world,
            size,
            grid,
            blocks: (0..grid.element_product()).map(block).collect(),
        };
        let points = hits.into_iter().flatten().map(|(point, _)| point);
        (picture, points.collect())
    }

    fn ray(&self, ndc: DVec2) -> DVec3 {
        let corners = self.view.corners(0.0, 1.0);
        let [bottom_left, bottom_right, _, top_left] = [4, 5, 6, 7].map(|index| corners[index] - self.view.eye());
        let place = ndc * 0.5 + 0.5;
        bottom_left + (bottom_right - bottom_left) * place.x + (top_left - bottom_left) * place.y
    }
}

/// What a light sees of what the camera sees.
pub(crate) struct Lit {
    pub(crate) base: BaseFilm,
    pub(crate) samples: Vec<FilmSample>,
    pub(crate) points: Vec<(DVec3, usize)>,
}

impl Lit {
    pub(crate) fn moments(&self) -> FilmMoments {
        self.samples.iter().map(FilmMoments::of).sum()
    }

    pub(crate) fn bin(&self) -> FilmBin {
        FilmBin::of_samples(&self.samples)
    }

    /// The hull of the middles of the pixels, as the reference numbers have it.
    pub(crate) fn hull_of_middles(&self) -> FilmHull {
        FilmHull::new(self.samples.iter().map(|sample| sample.film)).expect("an area")
    }
}

pub(crate) fn axes_along(forward: DVec3, up: DVec3) -> LightAxes {
    let z = -forward.normalize();
    let x = up.cross(z).normalize();
    LightAxes { x, y: z.cross(x), z }
}

/// A light at a point that looks along the mean direction to what is seen.
pub(crate) fn lit_from(camera: &Camera, pieces: &[Piece], position: DVec3) -> Lit {
    let points = camera.hits(pieces);
    let mean: DVec3 = points.iter().map(|(point, _)| (point - position).normalize()).sum();
    lit_along(camera, pieces, position, axes_along(mean, DVec3::new(0.3, 1.0, 0.2)))
}

pub(crate) fn lit_along(camera: &Camera, pieces: &[Piece], position: DVec3, axes: LightAxes) -> Lit {
    sampled(camera, pieces, unit_base(position, axes), camera.hits(pieces))
}

/// The base film of the specification: at distance 1, with its middle on the axis and no scale.
pub(crate) fn unit_base(position: DVec3, axes: LightAxes) -> BaseFilm {
    let square = [axes.x + axes.y, axes.x - axes.y, axes.y - axes.x, -axes.x - axes.y];
    let square = square.map(|corner| position - axes.z + corner);
    BaseFilm::of_point(position, axes, &square).expect("in front of the light")
}

/// The same with the base film of the receivers.
pub(crate) fn lit_over_receivers(camera: &Camera, pieces: &[Piece], position: DVec3, axes: LightAxes) -> Lit {
    let points = camera.hits(pieces);
    let receivers: Vec<DVec3> = points.iter().map(|(point, _)| *point).collect();
    let base = BaseFilm::of_point(position, axes, &receivers).expect("in front of the light");
    sampled(camera, pieces, base, points)
}

/// The sun.
pub(crate) fn sunlit(camera: &Camera, pieces: &[Piece], light_travel: DVec3) -> Lit {
    let axes = LightAxes::new(camera.view.forward(), DVec3::Y, light_travel).expect("a light");
    let points = camera.hits(pieces);
    let receivers: Vec<DVec3> = points.iter().map(|(point, _)| *point).collect();
    let base = BaseFilm::of_sun(axes, &receivers).expect("receivers");
    sampled(camera, pieces, base, points)
}

fn sampled(camera: &Camera, pieces: &[Piece], base: BaseFilm, points: Vec<(DVec3, usize)>) -> Lit {
    let sample = |(point, index): &(DVec3, usize)| {
        FilmSample::new(&base, &camera.grid, *point, pieces[*index].normal).expect("a lit point")
    };
    let samples = points.iter().map(sample).collect();
    Lit { base, samples, points }
}

/// Section 3.5: a floor and a wall.
pub(crate) fn scene_two() -> [Piece; 2] {
    [
        Piece {
            point: DVec3::ZERO,
            normal: DVec3::Y,
            contains: |point| point.x.abs() < 30.0 && point.z > -30.0,
        },
        Piece {
            point: DVec3::new(0.0, 0.0, -14.0),
            normal: DVec3::new(0.1, 0.0, 1.0) / 1.01_f64.sqrt(),
            contains: |point| point.y > 0.0 && point.y < 4.0 && (point.x - 4.0).abs() < 5.0,
        },
    ]
}

pub(crate) fn camera_two(samples: UVec2) -> Camera {
    Camera::new(
        DVec3::new(0.0, 2.0, 0.0),
        DVec3::new(0.2, -0.3, -1.0),
        30.0_f64.to_radians(),
        1.5,
        samples,
    )
}

pub(crate) const LIGHT_TWO: DVec3 = DVec3::new(-4.0, 8.0, -2.0);

/// A floor without end that fills the picture.
pub(crate) fn whole_floor() -> [Piece; 1] {
    [Piece {
        point: DVec3::ZERO,
        normal: DVec3::Y,
        contains: |_| true,
    }]
}

pub(crate) fn camera_on_floor(samples: UVec2) -> Camera {
    Camera::new(
        DVec3::new(0.0, 3.0, 0.0),
        DVec3::new(0.15, -0.9, -1.0),
        20.0_f64.to_radians(),
        1.5,
        samples,
    )
}
