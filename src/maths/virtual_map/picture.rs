//! [`DepthPicture`]: what the camera's depth prepass knows, as the source of needs; [`PixelRect`].

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2};

/// Half-open rectangle of picture pixels, from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// First column and row.
    pub min: UVec2,
    /// One after the last column and row.
    pub max: UVec2,
}

impl PixelRect {
    /// Contains no pixel; the neutral element of [`Self::union`].
    pub const EMPTY: Self = Self {
        min: UVec2::MAX,
        max: UVec2::ZERO,
    };

    /// A whole picture.
    pub const fn whole(size: UVec2) -> Self {
        Self {
            min: UVec2::ZERO,
            max: size,
        }
    }

    /// True without pixels.
    pub fn is_empty(&self) -> bool {
        !self.min.cmplt(self.max).all()
    }

    /// The smallest rectangle around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// What both share.
    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// Larger by some pixels on each side, within a picture. Nothing stays nothing.
    pub fn grown(self, pixels: u32, picture: UVec2) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let wide = Self {
            min: self.min.saturating_sub(UVec2::splat(pixels)),
            max: self.max.saturating_add(UVec2::splat(pixels)),
        };
        wide.intersection(Self::whole(picture))
    }

    /// Whether a pixel lies inside.
    pub fn contains(&self, pixel: UVec2) -> bool {
        pixel.cmpge(self.min).all() && pixel.cmplt(self.max).all()
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        let size = self.max.saturating_sub(self.min);
        u64::from(size.x) * u64::from(size.y)
    }
}

/// The depths of a camera's prepass: reverse z (1 or more nearest), 0 where there is nothing.
///
/// This stands for the eye-space depth buffer of Giegl, section 3.3.3, which stores linear depth in a texture of its
/// own because the depth buffers of 2007 lost precision. Reverse depth in single precision does not, and has a virtue:
/// on a plane it is an affine function of the pixel's place, since both are projective coordinates of one point, so
/// that differences between neighbours are exact slopes. Differences of linear depth are not.
#[derive(Clone, Copy, Debug)]
pub struct DepthPicture<'a> {
    size: UVec2,
    depths: &'a [f32],
    world_from_clip: DMat4,
}

impl<'a> DepthPicture<'a> {
    /// Row by row from the top left. `None` for no picture, another number of depths than pixels, or a matrix with NaN
    /// or infinity.
    pub fn new(size: UVec2, depths: &'a [f32], world_from_clip: DMat4) -> Option<Self> {
        let pixels = u64::from(size.x) * u64::from(size.y);
        let is_usable = pixels > 0 && depths.len() as u64 == pixels && world_from_clip.is_finite();
        is_usable.then_some(Self {
            size,
            depths,
            world_from_clip,
        })
    }

    /// Pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// The camera's inverse matrix.
    pub fn world_from_clip(&self) -> &DMat4 {
        &self.world_from_clip
    }

    /// Depth of a pixel; `None` outside the picture and where it shows nothing.
    pub fn depth(&self, pixel: UVec2) -> Option<f64> {
        let depth =
            *(pixel.cmplt(self.size).all()).then(|| &self.depths[(pixel.y * self.size.x + pixel.x) as usize])?;
        (depth > 0.0 && depth.is_finite()).then_some(f64::from(depth))
    }

    /// Clip-space place, −1..=1 with y up, of a place in pixels from the top left: pixel centres are at halves.
    pub fn clip_place(&self, pixels: DVec2) -> DVec2 {
        let uv = pixels / self.size.as_dvec2();
        DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y)
    }

    /// Linear depth at a clip-space place and depth: view depth in metres (1 ÷ w of the unprojected point) for
    /// perspective cameras, the depth itself for parallel ones.
    pub(super) fn linear_depth(&self, place: DVec2, depth: f64) -> f64 {
        let row = self.world_from_clip.row(3);
        let w = row.dot(DVec4::new(place.x, place.y, depth, 1.0));
        // Parallel projections: depth is linear already.
        if self.is_parallel(&row) { depth } else { 1.0 / w }
    }

    /// The depth at a clip-space place whose linear depth is given: the inverse of [`Self::linear_depth`].
    pub(super) fn depth_of_linear(&self, place: DVec2, linear: f64) -> f64 {
        let row = self.world_from_clip.row(3);
        if self.is_parallel(&row) {
            return linear;
        }
        (1.0 / linear - row.x * place.x - row.y * place.y - row.w) / row.z
    }

    fn is_parallel(&self, row: &DVec4) -> bool {
        row.truncate().abs().max_element() <= 1.0e-12 * row.w.abs()
    }
}

/// View-space point of a place in the picture (texture coordinates 0..=1, y down) with a linear view depth d > 0 in
/// metres: Giegl, equation 3.1, for right-handed view space that looks along −z.
///
/// `scale` = (a_x, a_y) are the first two diagonal elements of `clip_from_view`, `offset` = (b_x, b_y) the first two of
/// its third column: not zero for off-centre frusta and under jitter. With w_clip = −z the projection is x_ndc = a_x x
/// ÷ d − b_x, so
///
/// ```text
/// x = d (2u − 1 + b_x) ÷ a_x      y = d (1 − 2v + b_y) ÷ a_y      z = −d
/// ```
///
/// The thesis is left-handed (w_clip = z), where b changes its sign; its printed matrix maps 0..1 to 1..3 for want of a
/// minus sign.
pub fn view_from_picture(uv: DVec2, view_depth: f64, scale: DVec2, offset: DVec2) -> DVec3 {
    let place = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
    ((place + offset) / scale * view_depth).extend(-view_depth)
}
