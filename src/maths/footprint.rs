//! Exact footprints of texels and pixels in the world, from the Jacobian of a projection.
//!
//! A projection takes a point p to clip = M p and to texel coordinates u = ½ N (clip_x ÷ w), v likewise, for a map of N
//! texels per side. With the rows m_x and m_w of M (without their last column), the quotient rule gives
//!
//! ```text
//! ∇u = ½ N (m_x − (clip_x ÷ w) m_w) ÷ w          texels per metre, a row of the Jacobian ∂(u, v) ÷ ∂p
//! ```
//!
//! The direction along which u and v both stand still is the ray through p: r = ∇u × ∇v, normalised. In the plane across
//! the ray the Jacobian is square; its inverse has the columns (∇v × n) ÷ n² and (n × ∇u) ÷ n² with n = ∇u × ∇v: the
//! world-space steps of one texel, [`Footprint::across`] and [`Footprint::along`]. On a surface through p with normal s the
//! same texel steps end where the ray meets the surface, at d − r (d · s) ÷ (r · s) ([`Footprint::on_plane`]), which stretches
//! areas by 1 ÷ |r · s| = 1 ÷ cos θ.
//!
//! With the map's steps on the surface T = (t₁ t₂) and the picture's P = (p₁ p₂), both in a basis of the surface, one texel
//! is the parallelogram P⁻¹ T in pixels. Its area is the aliasing error of Lloyd et al. 2006, equation 1, in both
//! dimensions at once:
//!
//! ```text
//! |det T| ÷ |det P| = (A_l ÷ cos θ_l) ÷ (A_i ÷ cos θ_i) = (A_l ÷ A_i) · (cos θ_i ÷ cos θ_l) = perspective × projection
//! ```
//!
//! where A_l and A_i are the areas across the rays: w_l² and w_i² of the paper.

use bevy_math::{DMat2, DMat4, DVec2, DVec3, UVec2, Vec4Swizzles};

/// The footprint of one texel (or pixel) at a world-space point, in the plane perpendicular to the ray through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// World-space vector in metres for one texel in the map's x direction.
    pub across: DVec3,
    /// World-space vector in metres for one texel in the map's y direction (of clip space, upwards).
    pub along: DVec3,
    /// Unit vector along the ray through the point: moving along it stays in the same texel.
    pub ray: DVec3,
    /// Gradients of the texel coordinates in the world, in texels per metre.
    gradients: [DVec3; 2],
}

/// The footprint of one texel of a map drawn with `clip_from_world`, at a world-space point: for light views the plane
/// is the light plane. Pass a camera's matrix and picture size for the footprint of a pixel.
///
/// `None` where the projection has none: behind its centre, or a singular or NaN matrix.
pub fn texel_footprint(clip_from_world: &DMat4, map_size: UVec2, point: DVec3) -> Option<Footprint> {
    let clip = *clip_from_world * point.extend(1.0);
    if !(clip.w > 0.0) {
        return None;
    }
    let gradient = |row: usize, coordinate: f64, size: u32| {
        let row_gradient = clip_from_world.row(row).xyz();
        (row_gradient - clip_from_world.row(3).xyz() * (coordinate / clip.w)) * (0.5 * f64::from(size) / clip.w)
    };
    let gradients = [gradient(0, clip.x, map_size.x), gradient(1, clip.y, map_size.y)];
    let normal = gradients[0].cross(gradients[1]);
    let square = normal.length_squared();
    let footprint = Footprint {
        across: gradients[1].cross(normal) / square,
        along: normal.cross(gradients[0]) / square,
        ray: normal.try_normalize()?,
        gradients,
    };
    (footprint.across.is_finite() && footprint.along.is_finite()).then_some(footprint)
}

impl Footprint {
    /// Lengths of both sides, in metres.
    pub fn lengths(&self) -> DVec2 {
        DVec2::new(self.across.length(), self.along.length())
    }

    /// Area in square metres.
    pub fn area(&self) -> f64 {
        self.across.cross(self.along).length()
    }

    /// World-space steps of one texel in the map's x and y direction on a surface with a unit normal, in metres: where the
    /// rays of the steps meet the surface. Not finite where the surface is edge-on.
    pub fn on_plane(&self, normal: DVec3) -> [DVec3; 2] {
        [self.across, self.along].map(|step| step - self.ray * (step.dot(normal) / self.ray.dot(normal)))
    }

    /// Texels per metre along two tangents of a surface.
    fn texels_per_metre(&self, tangents: [DVec3; 2]) -> DMat2 {
        DMat2::from_cols_array_2d(&tangents.map(|tangent| self.gradients.map(|gradient| gradient.dot(tangent))))
    }
}

/// The size of a texel on a surface, measured in pixels: the aliasing error m of the papers, perspective × projection.
/// Above 1: under-sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelsOnPixels {
    /// Length in pixels of one texel step in the map's x direction.
    pub across: f64,
    /// Length in pixels of one texel step in the map's y direction.
    pub along: f64,
    /// The longest extent in any direction: the largest singular value.
    pub largest: f64,
    /// Pixels covered by one texel.
    pub area: f64,
    /// The part of `area` that perspective causes: texel area ÷ pixel area, each perpendicular to its ray.
    pub perspective: f64,
    /// The part that the surface's orientation causes: cosine towards the camera ÷ cosine towards the light. Unbounded
    /// where light grazes the surface.
    pub projection: f64,
}

/// Compares a texel with a pixel on a surface with the given normal through the point of both footprints. `None` when
/// the surface is edge-on to the light or the camera.
pub fn texels_on_pixels(texel: &Footprint, pixel: &Footprint, normal: DVec3) -> Option<TexelsOnPixels> {
    let normal = normal.try_normalize()?;
    let (right, up) = normal.any_orthonormal_pair();
    let map_from_surface = texel.texels_per_metre([right, up]);
    let picture_from_surface = pixel.texels_per_metre([right, up]);
    let picture_from_map = picture_from_surface * map_from_surface.inverse();
    let (across, along) = (picture_from_map.x_axis, picture_from_map.y_axis);
    let area = picture_from_map.determinant().abs();
    if !picture_from_map.is_finite() || area == 0.0 {
        return None;
    }
    let square_sum = across.length_squared() + along.length_squared();
    let gap = (square_sum * square_sum - 4.0 * area * area).max(0.0).sqrt();
    Some(TexelsOnPixels {
        across: across.length(),
        along: along.length(),
        largest: ((square_sum + gap) * 0.5).sqrt(),
        area,
        perspective: texel.area() / pixel.area(),
        projection: (pixel.ray.dot(normal) / texel.ray.dot(normal)).abs(),
    })
}
