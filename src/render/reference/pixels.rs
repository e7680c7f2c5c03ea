//! Truth for every pixel of a picture: [`trace`].

use std::{
    num::NonZero,
    sync::atomic::{AtomicUsize, Ordering},
    thread,
};

use bevy::{
    math::{DMat4, DVec3, UVec2},
    transform::components::Transform,
};

use super::scene::TruthScene;

/// The rays of a perspective camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRays {
    /// Pixels across and down.
    pub size: UVec2,
    /// The camera in the world.
    pub eye: DVec3,
    /// Unit vectors: to the right, up and ahead.
    pub right: DVec3,
    /// Up in the picture.
    pub up: DVec3,
    /// The view direction.
    pub forward: DVec3,
    /// Tangent of half the vertical field of view.
    pub tan_half_fov_y: f64,
}

impl PixelRays {
    /// The rays of a camera; `fov_y` is its full vertical field of view in radians.
    pub fn of_camera(size: UVec2, camera: &Transform, fov_y: f64) -> Self {
        // At right angles in double precision: what is seen through a pixel projects back onto it.
        let world_from_camera = camera.rotation.as_dquat().normalize();
        Self {
            size,
            eye: camera.translation.as_dvec3(),
            right: world_from_camera * DVec3::X,
            up: world_from_camera * DVec3::Y,
            forward: world_from_camera * DVec3::NEG_Z,
            tan_half_fov_y: (fov_y / 2.0).tan(),
        }
    }

    /// The direction through a place in the picture in pixels, y down; pixel centres are at halves. One unit of it is a
    /// metre of view depth.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        let size = self.size.as_dvec2();
        let ndc_x = x / size.x * 2.0 - 1.0;
        let ndc_y = 1.0 - y / size.y * 2.0;
        let aspect = size.x / size.y;
        self.forward + self.right * (ndc_x * self.tan_half_fov_y * aspect) + self.up * (ndc_y * self.tan_half_fov_y)
    }

    /// The same camera as a matrix, with its far plane at infinity and its near plane at 1 m: neither changes where a point
    /// is in the picture.
    pub fn clip_from_world(&self) -> DMat4 {
        let size = self.size.as_dvec2();
        let opening = 2.0 * self.tan_half_fov_y.atan();
        let clip_from_view = DMat4::perspective_infinite_reverse_rh(opening, size.x / size.y, 1.0);
        clip_from_view * DMat4::look_to_rh(self.eye, self.forward, self.up)
    }
}

/// What is true of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PixelTruth {
    /// No surface nearer than far.
    Sky,
    /// The scene of the rays has no surface where the GPU drew one.
    Unmatched,
    /// The surface faces away from the light, or nearly: N·L at most 0.15.
    FacesAway,
    /// A discontinuity in the 8-neighbourhood.
    Edge,
    /// The rays from 0.5 and 2 mm above the surface disagree.
    Unsure,
    /// Valid, and the sun is seen.
    Lit,
    /// Valid, and it is not.
    Shadow,
}

impl PixelTruth {
    /// Whether the pixel counts: lit or in shadow.
    pub fn is_valid(self) -> bool {
        matches!(self, Self::Lit | Self::Shadow)
    }
}

/// N·L above which a pixel is valid.
pub const SMALLEST_COSINE: f64 = 0.15;
/// Cosine between the normals of neighbours below which there is an edge.
pub const EDGE_COSINE: f64 = 0.9;
/// Distance of a neighbour from a pixel's plane, over the smaller depth, above which there is an edge.
pub const EDGE_STEP: f64 = 0.004;
/// Starts of the two rays in metres along the ray.
pub const OFFSETS: [f64; 2] = [0.0005, 0.002];

/// The GPU's depth and the scene's differ at most by this share of the depth.
const DEPTH_TOLERANCE: f64 = 2.0e-3;

/// The surface that a pixel sees, at the pixel's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// In the world.
    pub position_world: DVec3,
    /// Geometric unit normal in the world, turned to the viewer.
    pub normal_world: DVec3,
    /// View depth in metres.
    pub view_depth: f64,
}

/// A picture's surfaces and what is true of them, row 0 on top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Traced {
    /// One per pixel.
    pub truth: Vec<PixelTruth>,
    /// One per pixel; `None`: sky or unmatched.
    pub points: Vec<Option<SurfacePoint>>,
}

impl Traced {
    /// The surface of a pixel that counts.
    pub fn valid_point(&self, index: usize) -> Option<&SurfacePoint> {
        let is_valid = self.truth.get(index).is_some_and(|truth| truth.is_valid());
        is_valid.then(|| self.points.get(index)?.as_ref()).flatten()
    }
}

#[derive(Clone, Copy)]
enum Seen {
    Sky,
    Unmatched,
    Point(SurfacePoint),
}

/// Truth for every pixel, row 0 on top, on all cores. Empty where the picture is.
///
/// `depths` are the view depths in metres that the GPU wrote, 0 where it drew nothing: rays to the sun start there.
/// Normals are those of the triangle that the scene has at that depth. `progress` is called with the number of rows
/// done so far, in any order, by several threads.
pub fn trace(
    scene: &TruthScene,
    rays: &PixelRays,
    depths: &[f32],
    far: f64,
    direction_to_light: DVec3,
    progress: impl Fn(usize) + Sync,
) -> Traced {
    let (width, height) = (rays.size.x as usize, rays.size.y as usize);
    if width == 0 || height == 0 || depths.len() < width * height {
        return Traced::default();
    }
    let to_light = direction_to_light.normalize_or_zero();
    let rows_done = AtomicUsize::new(0);
    let seen: Vec<Seen> = rows(width, height, |x, y| see(scene, rays, depths, far, x, y), &|| {});
    let truth = rows(
        width,
        height,
        |x, y| judge(scene, &seen, rays.size, to_light, x, y),
        &|| progress(rows_done.fetch_add(1, Ordering::Relaxed) + 1),
    );
    let points = seen.into_iter().map(|seen| match seen {
        Seen::Point(point) => Some(point),
        _ => None,
    });
    Traced {
        truth,
        points: points.collect(),
    }
}

/// Fills a picture row by row on all cores.
pub(super) fn rows<T: Send>(
    width: usize,
    height: usize,
    pixel: impl Fn(usize, usize) -> T + Sync,
    row_done: &(impl Fn() + Sync),
) -> Vec<T> {
    let threads = thread::available_parallelism()
        .map_or(1, NonZero::get)
        .min(height.max(1));
    let next = AtomicUsize::new(0);
    let mut parts: Vec<(usize, Vec<T>)> = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|_| {
                scope.spawn(|| {
                    let mut done = Vec::new();
                    loop {
                        let y = next.fetch_add(1, Ordering::Relaxed);
                        if y >= height {
                            return done;
                        }
                        done.push((y, (0..width).map(|x| pixel(x, y)).collect::<Vec<T>>()));
                        row_done();
                    }
                })
            })
            .collect();
        workers
            .into_iter()
            .flat_map(|worker| match worker.join() {
                Ok(rows) => rows,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    });
    parts.sort_by_key(|(y, _)| *y);
    parts.into_iter().flat_map(|(_, row)| row).collect()
}

fn see(scene: &TruthScene, rays: &PixelRays, depths: &[f32], far: f64, x: usize, y: usize) -> Seen {
    let depth = f64::from(depths[y * rays.size.x as usize + x]);
    if !(depth > 0.0 && depth < far) {
        return Seen::Sky;
    }
    let direction = rays.direction(x as f64 + 0.5, y as f64 + 0.5);
    let tolerance = depth * DEPTH_TOLERANCE;
    match scene.first_surface(rays.eye, direction, depth - tolerance, depth + tolerance) {
        Some(surface) => Seen::Point(SurfacePoint {
            position_world: rays.eye + direction * depth,
            normal_world: surface.normal_world,
            view_depth: depth,
        }),
        None => Seen::Unmatched,
    }
}

fn judge(scene: &TruthScene, seen: &[Seen], size: UVec2, to_light: DVec3, x: usize, y: usize) -> PixelTruth {
    let (width, height) = (size.x as usize, size.y as usize);
    let point = match &seen[y * width + x] {
        Seen::Sky => return PixelTruth::Sky,
        Seen::Unmatched => return PixelTruth::Unmatched,
        Seen::Point(point) => point,
    };
    if point.normal_world.dot(to_light) <= SMALLEST_COSINE {
        return PixelTruth::FacesAway;
    }
    let at = |x: usize, y: usize| match &seen[y * width + x] {
        Seen::Point(point) => Some(point),
        _ => None,
    };
    let block = (y.saturating_sub(1)..=(y + 1).min(height - 1))
        .flat_map(|y| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |x| (x, y)));
    for (bx, by) in block.clone() {
        // Within the block, each pixel against its right and lower neighbour.
        let neighbors = [(bx + 1, by), (bx, by + 1)];
        for (nx, ny) in neighbors {
            if block.clone().any(|place| place == (nx, ny)) && is_edge(at(bx, by), at(nx, ny)) {
                return PixelTruth::Edge;
            }
        }
    }
    let [near, far] = OFFSETS.map(|offset| scene.is_in_shadow(point.position_world, to_light, offset));
    match (near, far) {
        (true, true) => PixelTruth::Shadow,
        (false, false) => PixelTruth::Lit,
        _ => PixelTruth::Unsure,
    }
}

fn is_edge(a: Option<&SurfacePoint>, b: Option<&SurfacePoint>) -> bool {
    let (Some(a), Some(b)) = (a, b) else {
        return true;
    };
    let between = b.position_world - a.position_world;
    let step = between.dot(a.normal_world).abs().max(between.dot(b.normal_world).abs());
    a.normal_world.dot(b.normal_world) < EDGE_COSINE || step > EDGE_STEP * a.view_depth.min(b.view_depth)
}
