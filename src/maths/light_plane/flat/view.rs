//! Frames, cameras and what their pixels see.

use bevy_math::{DMat3, DVec2, DVec3};

use super::Degenerate;

/// Nearer than this share of the near distance nothing is seen: a surface through the eye has no pixels.
const NEAREST: f64 = 1.0e-9;

/// A place with an axis: the rigid motion of a camera or a light (Chong, A.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Eye or light.
    pub origin: DVec2,
    /// Of the axis, from −z towards +y, in radians.
    pub angle: f64,
}

impl Frame {
    /// Where it looks: −z of the frame.
    pub fn forward(&self) -> DVec2 {
        let (sine, cosine) = self.angle.sin_cos();
        DVec2::new(-cosine, sine)
    }

    /// Along its film, across the axis: +y of the frame.
    pub fn film(&self) -> DVec2 {
        let (sine, cosine) = self.angle.sin_cos();
        DVec2::new(sine, cosine)
    }

    /// From the frame to the world, for homogeneous (z, y, w).
    pub fn world_from_frame(&self) -> DMat3 {
        DMat3::from_cols(
            (-self.forward()).extend(0.0),
            self.film().extend(0.0),
            self.origin.extend(1.0),
        )
    }
}

/// What a film shows of its near plane, in metres from the axis (t and b in the source).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents {
    /// b.
    pub bottom: f64,
    /// t.
    pub top: f64,
}

/// From a frame to the cube −1..=1: the top of the film to y = 1, the near plane to z = +1, the far plane to −1, and w is
/// the distance along the axis (Chong, A.2, without the dropped coordinate).
///
/// In the source's signs, n = −`near` and f = −`far`, the last entry of the depth row is −2 f n ÷ (f − n). Printed is
/// −2 f n ÷ (n − f), which takes near and far of 1 and 50 to −1.08 and −3.08.
pub fn projection(extents: Extents, near: f64, far: f64) -> DMat3 {
    let Extents { bottom, top } = extents;
    let depth = DVec3::new((far + near) / (far - near), 0.0, 2.0 * far * near / (far - near));
    let across = DVec3::new((top + bottom) / (top - bottom), 2.0 * near / (top - bottom), 0.0);
    DMat3::from_cols(depth, across, DVec3::NEG_X).transpose()
}

/// A surface: a straight line from one point to another, seen from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// One end, in the world.
    pub from: DVec2,
    /// The other.
    pub to: DVec2,
}

impl Segment {
    /// A surface between two points.
    pub fn new(from: DVec2, to: DVec2) -> Self {
        Self { from, to }
    }

    /// Across the surface; NaN for a point.
    pub fn normal(&self) -> DVec2 {
        (self.to - self.from).perp().normalize()
    }

    /// The homogeneous line through it: its product with a homogeneous point is zero on the line.
    pub(super) fn line(&self) -> DVec3 {
        self.from.extend(1.0).cross(self.to.extend(1.0))
    }
}

/// What a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where the pixel's middle stands in the picture, −1..=1 from bottom to top.
    pub pixel: f64,
    /// In the world.
    pub point: DVec2,
    /// How far the point moves over its surface per pixel, in metres.
    pub step: DVec2,
    /// Which of the surfaces.
    pub segment: usize,
}

/// A camera with a picture of one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    frame: Frame,
    half_width: f64,
    near: f64,
    far: f64,
    pixels: u32,
}

impl Camera {
    /// A camera at `eye` that looks along −z, raised by `pitch`, and sees `half_fov` to both sides; radians. `near` and
    /// `far` (positive metres) matter to perspective shadow maps only: nothing is cut off.
    ///
    /// # Errors
    /// [`Degenerate::Camera`], [`Degenerate::NotFinite`].
    pub fn new(eye: DVec2, pitch: f64, half_fov: f64, near: f64, far: f64, pixels: u32) -> Result<Self, Degenerate> {
        if !(eye.is_finite() && pitch.is_finite() && half_fov.is_finite() && far.is_finite()) {
            return Err(Degenerate::NotFinite);
        }
        let half_width = half_fov.tan();
        let is_open = half_fov > 0.0 && half_fov < std::f64::consts::FRAC_PI_2;
        if !(is_open && near > 0.0 && far > near && pixels > 0) {
            return Err(Degenerate::Camera);
        }
        let frame = Frame {
            origin: eye,
            angle: pitch,
        };
        Ok(Self {
            frame,
            half_width,
            near,
            far,
            pixels,
        })
    }

    /// Eye and axis.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// In the picture.
    pub fn pixels(&self) -> u32 {
        self.pixels
    }

    /// The same camera with another picture.
    ///
    /// # Errors
    /// [`Degenerate::Camera`] without pixels.
    pub fn with_pixels(self, pixels: u32) -> Result<Self, Degenerate> {
        if pixels == 0 {
            return Err(Degenerate::Camera);
        }
        Ok(Self { pixels, ..self })
    }

    /// Tangent of half the opening: half the film's width at distance 1.
    pub fn half_width(&self) -> f64 {
        self.half_width
    }

    /// s_p: the size of a pixel on a film at distance 1.
    pub fn pixel_size(&self) -> f64 {
        2.0 * self.half_width / f64::from(self.pixels)
    }

    /// From the world to the camera's post-projective cube −1..=1, near at +1.
    pub fn cube_from_world(&self) -> DMat3 {
        let top = self.near * self.half_width;
        let extents = Extents { bottom: -top, top };
        projection(extents, self.near, self.far) * self.frame.world_from_frame().inverse()
    }

    /// The way of a ray through a place of the picture, with view depth 1.
    fn ray(&self, pixel: f64) -> DVec2 {
        self.frame.forward() + self.frame.film() * (pixel * self.half_width)
    }

    /// What the middles of the pixels see, from bottom to top; pixels that see nothing are left out (Ω, Chong 2.1).
    ///
    /// With the ray X = E + t D(p) on a surface with normal N, X moves per pixel by t (D' − D (N·D') ÷ (N·D)): along its
    /// surface, not along a picture of constant depth.
    pub fn see(&self, scene: &[Segment]) -> Vec<Hit> {
        let pixel_step = self.frame.film() * self.pixel_size();
        let middle = |index: u32| (2.0 * f64::from(index) + 1.0) / f64::from(self.pixels) - 1.0;
        let pixels = (0..self.pixels).map(middle);
        let hits = pixels.filter_map(|pixel| {
            let ray = self.ray(pixel);
            let depths = scene.iter().enumerate().filter_map(|(index, segment)| {
                let along = segment.to - segment.from;
                let to_surface = segment.from - self.frame.origin;
                let determinant = ray.perp_dot(along);
                let depth = to_surface.perp_dot(along) / determinant;
                let share = to_surface.perp_dot(ray) / determinant;
                let is_met = depth > NEAREST * self.near && (0.0..=1.0).contains(&share);
                is_met.then_some((index, depth))
            });
            let (segment, depth) = depths.min_by(|a, b| a.1.total_cmp(&b.1))?;
            let normal = scene[segment].normal();
            let slide = ray * (normal.dot(pixel_step) / normal.dot(ray));
            Some(Hit {
                pixel,
                point: self.frame.origin + ray * depth,
                step: (pixel_step - slide) * depth,
                segment,
            })
        });
        hits.collect()
    }
}
