//! Cameras with matrices, planes to look at, and depth pictures of them.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2};
use umbrage::maths::{bounds::Bounds, polytope::HalfSpace, view::ViewVolume, virtual_map::picture::DepthPicture};

/// A camera's matrix with reverse z: infinite for perspective, linear for orthographic cameras.
pub(crate) fn camera_clip_from_world(view: &ViewVolume) -> DMat4 {
    let back = -view.forward();
    let up = view.up();
    let right = up.cross(back);
    let world_from_view = DMat4::from_cols(
        right.extend(0.0),
        up.extend(0.0),
        back.extend(0.0),
        view.eye().extend(1.0),
    );
    let clip_from_view = if view.is_orthographic() {
        let corners = view.corners(view.near(), view.near());
        let size = DVec2::new(corners[0].distance(corners[1]), corners[1].distance(corners[2]));
        let range = view.far() - view.near();
        DMat4::from_cols(
            DVec4::new(2.0 / size.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 2.0 / size.y, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0 / range, 0.0),
            DVec4::new(0.0, 0.0, view.far() / range, 1.0),
        )
    } else {
        let scale = 2.0 / view.opening();
        DMat4::from_cols(
            DVec4::new(scale.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, scale.y, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, view.near(), 0.0),
        )
    };
    clip_from_view * world_from_view.inverse()
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) plane: usize,
}

/// A picture of planes, of which only what lies in a box exists.
pub(crate) struct Picture {
    pub(crate) size: UVec2,
    pub(crate) clip_from_world: DMat4,
    pub(crate) depths: Vec<f32>,
    pub(crate) seen: Vec<Option<Seen>>,
}

impl Picture {
    pub(crate) fn of_planes(view: &ViewVolume, size: UVec2, planes: &[HalfSpace], scene: &Bounds) -> Self {
        let clip_from_world = camera_clip_from_world(view);
        let world_from_clip = clip_from_world.inverse();
        let mut seen = Vec::new();
        let mut depths = Vec::new();
        for y in 0..size.y {
            for x in 0..size.x {
                let uv = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / size.as_dvec2();
                let place = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
                let [start, end] = [1.0, 0.5].map(|depth| world_from_clip.project_point3(place.extend(depth)));
                let direction = (end - start).normalize();
                let hits = planes.iter().enumerate().filter_map(|(plane, half_space)| {
                    let distance = -half_space.excess(start) / half_space.normal.dot(direction);
                    let point = start + direction * distance;
                    let depth = view.depth(point);
                    let is_seen = distance > 0.0 && depth < view.far() && scene.contains(point, 0.0);
                    is_seen.then_some((distance, point, half_space.normal, plane))
                });
                let nearest = hits.min_by(|a, b| a.0.total_cmp(&b.0));
                depths.push(nearest.map_or(0.0, |(_, point, ..)| clip_from_world.project_point3(point).z as f32));
                seen.push(nearest.map(|(_, point, normal, plane)| Seen { point, normal, plane }));
            }
        }
        Self {
            size,
            clip_from_world,
            depths,
            seen,
        }
    }

    pub(crate) fn depths(&self) -> DepthPicture<'_> {
        DepthPicture::new(self.size, &self.depths, self.clip_from_world.inverse()).expect("a picture")
    }

    pub(crate) fn at(&self, x: u32, y: u32) -> Option<Seen> {
        self.seen[(y * self.size.x + x) as usize]
    }

    /// Pixels whose four neighbours show the same plane.
    pub(crate) fn inner(&self) -> impl Iterator<Item = (UVec2, Seen)> + '_ {
        let places = (1..self.size.y - 1).flat_map(move |y| (1..self.size.x - 1).map(move |x| UVec2::new(x, y)));
        places.filter_map(|UVec2 { x, y }| {
            let seen = self.at(x, y)?;
            let neighbours = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            let is_inner = neighbours
                .iter()
                .all(|(x, y)| self.at(*x, *y).is_some_and(|other| other.plane == seen.plane));
            is_inner.then_some((UVec2::new(x, y), seen))
        })
    }
}

/// The same numbers on every machine, without a crate.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    /// In 0..1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In low..=high.
    pub(crate) fn whole(&mut self, low: u32, high: u32) -> u32 {
        low + ((self.unit() * f64::from(high - low + 1)) as u32).min(high - low)
    }
}
