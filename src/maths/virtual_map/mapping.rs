//! [`TileMappingMap`]: where every pixel of the picture will look into the light map, and how finely (Giegl, sections
//! 5.5, 5.6 and 5.17).
//!
//! # The patch of a pixel
//!
//! M = `light clip_from_world` · `camera world_from_clip` takes the picture to the light map in one projective step. A
//! plane is an affine function z(x, y) of depth over the picture ([`DepthPicture`]), so one step of a pixel moves clip
//! coordinates by c' = M (δ, z') with the depth's slope z', and the quotient rule gives the Jacobian of the map over
//! the picture, exactly for planes and for every warp:
//!
//! ```text
//! ∂u = ½ (c'_x − (c_x ÷ c_w) c'_w) ÷ c_w      ∂v = −½ (c'_y − (c_y ÷ c_w) c'_w) ÷ c_w
//! ```
//!
//! # The need
//!
//! Let J = (g_x g_y) have the columns ∂(u, v) per pixel to the right and down. Its inverse has the columns s_u, s_v:
//! what one map length along u, v is in pixels. A map of N_u × N_v texels has texels with sides s_u ÷ N_u, s_v ÷ N_v in
//! the picture, so
//!
//! ```text
//! N_u = |s_u| = √(∂v_x² + ∂v_y²) ÷ |det J|      N_v = |s_v| = √(∂u_x² + ∂u_y²) ÷ |det J|        NeedMeasure::Sides
//! ```
//!
//! makes both sides at most one pixel. The thesis asks for less: the box of the pixel in the map, N_u = 1 ÷ max |∂u|
//! ([`NeedMeasure::Box`]). The two agree where pixels project to rectangles along u and v. Where they project to
//! slivers *across* the axes (a surface that light grazes, turned against the map), the box is one texel while a texel
//! may cover hundreds of pixels: there the thesis's map is coarse. An error of a texel's sides is at most 1 then, its
//! area too, and its longest extent at most √2. For that to be 1 as well, both needs grow by √(1 + |cos φ|) with φ
//! between s_u and s_v ([`NeedMeasure::Extent`]): unit columns have the Gram matrix ((1, cos φ), (cos φ, 1)),
//! eigenvalues 1 ± cos φ, and shorter columns have smaller ones.
//!
//! # On the GPU
//!
//! `collect_needs.wgsl`, 8 × 8, one invocation per picture pixel: patch, need, then maxima of needs and rectangle and a count
//! by atomics into the cell of the position ([`NeedGrid`](super::grid::NeedGrid)). A maximum is read before it is raised:
//! most pixels raise none. The low-resolution form, `map_needs.wgsl`, writes a [`MappingTexel`] per invocation to a buffer
//! that is read back, or the thesis's four bytes.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2, Vec2};

use super::{
    bytes::{byte_level, byte_need, byte_place, place_of_byte},
    feedback::PictureMotion,
    picture::DepthPicture,
};

/// Largest log2 of a need.
pub const MAX_LEVEL: u8 = 31;

/// How a patch becomes a need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum NeedMeasure {
    /// Sides of a texel at most one pixel long: exact whatever the orientation.
    #[default]
    Sides,
    /// Every extent of a texel at most one pixel; up to ½ level more.
    Extent,
    /// The listing of the thesis: half the box, in the map, of the four points one step to each side, with linear
    /// depths.
    Box,
}

/// Which of the two neighbours on an axis gives the slope of a patch. The thesis says both (section 5.5: larger; 5.6
/// and the listing: smaller).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum NeighbourPick {
    /// The one that differs less in depth: the same surface at a silhouette. Safe.
    #[default]
    Smaller,
    /// The one that differs more: underestimates the need at silhouettes.
    Larger,
}

/// Settings of a mapping map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappingOptions {
    /// How a patch becomes a need.
    pub measure: NeedMeasure,
    /// Which neighbour counts.
    pub pick: NeighbourPick,
    /// Neighbours are one texel of the mapping map away, as in the thesis, not one pixel of the picture.
    pub wide_steps: bool,
    /// Store bytes as the thesis does; see [`bytes`](super::bytes).
    pub bytes: bool,
    /// Levels subtracted before rounding up; 0 never undersamples, ½ is the thesis's rounding.
    pub need_bias: f64,
    /// Leave out pixels on surfaces that face away from the light: they are dark by their own shading. Surfaces with
    /// smooth normals may be shaded there, so it is off by default.
    pub skip_facing_away: bool,
    /// Needs that hold for any camera within this motion: see [`feedback`](super::feedback). `None`: for this one.
    pub motion: Option<PictureMotion>,
}

impl Default for MappingOptions {
    fn default() -> Self {
        Self {
            measure: NeedMeasure::Sides,
            pick: NeighbourPick::Smaller,
            wide_steps: false,
            bytes: false,
            need_bias: 0.0,
            skip_facing_away: false,
            motion: None,
        }
    }
}

impl MappingOptions {
    /// The mapping map of the thesis, bytes and all.
    pub const PAPER: Self = Self {
        measure: NeedMeasure::Box,
        pick: NeighbourPick::Smaller,
        wide_steps: true,
        bytes: true,
        need_bias: 0.0,
        skip_facing_away: false,
        motion: None,
    };
}

/// One pixel's surface in the light map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelPatch {
    /// Texture coordinates of the map, v down.
    pub uv: DVec2,
    /// Change of the texture coordinates for one pixel to the right and one down.
    pub steps: [DVec2; 2],
    /// The patch's clip-space place and depth in the picture.
    pub clip: DVec3,
    /// Change of the depth for one pixel to the right and one down.
    pub slopes: DVec2,
}

impl PixelPatch {
    /// Positive where light and camera see the same side of the surface: neither projection mirrors, so one pixel keeps
    /// its orientation in the map.
    pub fn facing(&self) -> f64 {
        self.steps[0].perp_dot(self.steps[1])
    }

    /// One map length along u and along v, in pixels: the columns of the inverse Jacobian. Not finite for patches that
    /// are edge-on to the light.
    pub fn sides(&self) -> [DVec2; 2] {
        let [right, down] = self.steps;
        [DVec2::new(down.y, -right.y), DVec2::new(-down.x, right.x)].map(|side| side / self.facing())
    }

    /// Texels per axis of the whole map that the patch needs. Not finite when edge-on to the light.
    pub fn need(&self, measure: NeedMeasure) -> DVec2 {
        let [right, down] = self.steps;
        match measure {
            NeedMeasure::Box => 1.0 / right.abs().max(down.abs()),
            NeedMeasure::Sides | NeedMeasure::Extent => {
                let [along_u, along_v] = self.sides();
                let lengths = DVec2::new(along_u.length(), along_v.length());
                let cosine = along_u.dot(along_v).abs() / (lengths.x * lengths.y);
                lengths
                    * (if measure == NeedMeasure::Extent {
                        (1.0 + cosine).sqrt()
                    } else {
                        1.0
                    })
            }
        }
    }
}

/// log2 of a need in whole levels, rounded up after taking off a bias, within 0..=31: ⌈log2 N − bias⌉. Infinite needs
/// and NaN (edge-on patches) have the largest level.
pub fn need_level(need: f64, bias: f64) -> u8 {
    let level = (need.log2() - bias).ceil();
    // NaN compares false.
    if level < f64::from(MAX_LEVEL) {
        level.max(0.0) as u8
    } else {
        MAX_LEVEL
    }
}

/// The slope towards + of a value from its neighbours, one step away on each side, by the pick rule. Signed: the
/// negative neighbour's difference is taken the other way round. A neighbour outside of the picture or without geometry
/// leaves the choice to the other; without both the patch counts as facing the camera, 0.
pub fn picked_slope(center: f64, negative: Option<f64>, positive: Option<f64>, pick: NeighbourPick) -> f64 {
    let slopes = [
        negative.map(|value| center - value),
        positive.map(|value| value - center),
    ];
    match slopes {
        [Some(before), Some(after)] => {
            let is_before_smaller = before.abs() < after.abs();
            if is_before_smaller == (pick == NeighbourPick::Smaller) {
                before
            } else {
                after
            }
        }
        [before, after] => before.or(after).unwrap_or(0.0),
    }
}

/// A pixel of the mapping map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappingTexel {
    /// Texture coordinates in the light map, v down.
    pub uv: Vec2,
    /// log2 of the texels per axis of the whole map that one picture pixel needs.
    pub levels: [u8; 2],
    /// Half the box, in the map, of the picture pixels that this texel stands for.
    pub reach: Vec2,
}

/// What the picture needs of the light map.
#[derive(Clone, Debug, PartialEq)]
pub struct TileMappingMap {
    /// Texels of the mapping map.
    pub size: UVec2,
    /// Pixels of the picture.
    pub picture: UVec2,
    /// Row by row; `None` without geometry.
    pub texels: Vec<Option<MappingTexel>>,
    /// Texels whose surface lies outside the light map: none with correct focusing.
    pub outside: u32,
}

impl TileMappingMap {
    /// Samples a picture with `size` texels, at most one per pixel; full size misses nothing. `light_clip_from_world`
    /// is the light view of the whole map, with reverse z, focused and warped in any way.
    pub fn new(picture: &DepthPicture, light_clip_from_world: &DMat4, size: UVec2, options: &MappingOptions) -> Self {
        let size = size.clamp(UVec2::ONE, picture.size());
        let sampler = Sampler::new(picture, light_clip_from_world, size, options);
        let mut outside = 0;
        let mut texels = Vec::with_capacity((size.x * size.y) as usize);
        for y in 0..size.y {
            for x in 0..size.x {
                let texel = sampler.texel(UVec2::new(x, y));
                outside += u32::from(texel == Err(Nothing::OutsideMap));
                texels.push(texel.ok());
            }
        }
        Self {
            size,
            picture: picture.size(),
            texels,
            outside,
        }
    }

    /// Texels that need more than 2^`level` on some axis.
    pub fn texels_above(&self, level: u32) -> u32 {
        let above = |texel: &&MappingTexel| texel.levels.iter().any(|need| u32::from(*need) > level);
        self.texels.iter().flatten().filter(above).count() as u32
    }

    /// Texels with geometry in the map.
    pub fn valid_texels(&self) -> u32 {
        self.texels.iter().flatten().count() as u32
    }
}

/// The patch of one pixel of a picture. `None` without geometry and behind the light map's projection centre.
pub fn pixel_patch(
    picture: &DepthPicture,
    light_clip_from_world: &DMat4,
    pixel: UVec2,
    options: &MappingOptions,
) -> Option<PixelPatch> {
    let sampler = Sampler::new(picture, light_clip_from_world, picture.size(), options);
    sampler.patch(pixel, picture.depth(pixel)?, UVec2::ONE)
}

/// Texels per axis of the whole map that one pixel of a picture needs, not rounded: what [`TileMappingMap`] rounds to
/// levels. `None` where [`pixel_patch`] is.
pub fn pixel_need(
    picture: &DepthPicture,
    light_clip_from_world: &DMat4,
    pixel: UVec2,
    options: &MappingOptions,
) -> Option<DVec2> {
    let patch = pixel_patch(picture, light_clip_from_world, pixel, options)?;
    let sampler = Sampler::new(picture, light_clip_from_world, picture.size(), options);
    Some(sampler.need(pixel, &patch, UVec2::ONE))
}

/// Why a texel has no need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Nothing {
    Empty,
    FacingAway,
    OutsideMap,
}

struct Sampler<'a> {
    picture: &'a DepthPicture<'a>,
    map_from_picture: DMat4,
    /// Texels of the mapping map.
    size: UVec2,
    /// Pixels per texel.
    ratio: DVec2,
    options: &'a MappingOptions,
}

impl<'a> Sampler<'a> {
    fn new(
        picture: &'a DepthPicture<'a>,
        light_clip_from_world: &DMat4,
        size: UVec2,
        options: &'a MappingOptions,
    ) -> Self {
        Self {
            picture,
            map_from_picture: *light_clip_from_world * *picture.world_from_clip(),
            size,
            ratio: picture.size().as_dvec2() / size.as_dvec2(),
            options,
        }
    }

    /// The need of one picture pixel, dilated by the motion.
    fn need(&self, pixel: UVec2, patch: &PixelPatch, step: UVec2) -> DVec2 {
        let need = match self.options.measure {
            NeedMeasure::Box => {
                let extent = self.listed_extent(pixel, patch.clip.z, step);
                f64::from(step.max_element()) / extent
            }
            measure => patch.need(measure),
        };
        match &self.options.motion {
            Some(motion) => motion.dilated_need(need, patch, self.picture),
            None => need,
        }
    }

    fn texel(&self, place: UVec2) -> Result<MappingTexel, Nothing> {
        // The middle pixel: 4 i + 2 of four, whose centre is that of no texel. In whole numbers, as the shader has it.
        let pixel = (2 * place + 1) * self.picture.size() / (2 * self.size);
        let depth = self.picture.depth(pixel).ok_or(Nothing::Empty)?;
        let step = if self.options.wide_steps {
            self.ratio.round().as_uvec2().max(UVec2::ONE)
        } else {
            UVec2::ONE
        };
        let patch = self.patch(pixel, depth, step).ok_or(Nothing::OutsideMap)?;
        let is_inside = patch.uv.cmpge(DVec2::ZERO).all() && patch.uv.cmple(DVec2::ONE).all();
        if !is_inside {
            return Err(Nothing::OutsideMap);
        }
        if self.options.skip_facing_away && patch.facing() <= 0.0 {
            return Err(Nothing::FacingAway);
        }
        let need = self.need(pixel, &patch, step);
        let half = 0.5 * self.ratio;
        let reach = patch.steps[0].abs() * half.x + patch.steps[1].abs() * half.y;
        let texel = MappingTexel {
            uv: patch.uv.as_vec2(),
            levels: [need.x, need.y].map(|need| need_level(need, self.options.need_bias)),
            reach: if self.ratio == DVec2::ONE {
                Vec2::ZERO
            } else {
                reach.as_vec2()
            },
        };
        Ok(if self.options.bytes {
            self.in_bytes(texel, need)
        } else {
            texel
        })
    }

    /// The plane through a pixel, in the light map. `None` behind the map's projection centre.
    fn patch(&self, pixel: UVec2, depth: f64, step: UVec2) -> Option<PixelPatch> {
        let slopes = DVec2::new(
            self.slope(pixel, depth, step.with_y(0), |depth, _| depth),
            self.slope(pixel, depth, step.with_x(0), |depth, _| depth),
        ) / step.as_dvec2();
        let place = self.picture.clip_place(pixel.as_dvec2() + 0.5);
        let size = self.picture.size().as_dvec2();
        let clip = self.map_from_picture * place.extend(depth).extend(1.0);
        let moves = [
            DVec4::new(2.0 / size.x, 0.0, slopes.x, 0.0),
            DVec4::new(0.0, -2.0 / size.y, slopes.y, 0.0),
        ];
        let ndc = clip.truncate().truncate() / clip.w;
        let steps = moves.map(|step| {
            let change = self.map_from_picture * step;
            (change.truncate().truncate() - ndc * change.w) / clip.w * DVec2::new(0.5, -0.5)
        });
        let uv = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
        (clip.w > 0.0 && uv.is_finite()).then_some(PixelPatch {
            uv,
            steps,
            clip: place.extend(depth),
            slopes,
        })
    }

    /// The picked slope of a function of depth and clip-space place, per `step`.
    fn slope(&self, pixel: UVec2, depth: f64, step: UVec2, value: impl Fn(f64, DVec2) -> f64) -> f64 {
        let at = |pixel: UVec2, depth| value(depth, self.picture.clip_place(pixel.as_dvec2() + 0.5));
        let before = pixel.cmpge(step).all().then(|| pixel - step);
        let neighbour = |pixel: UVec2| Some(at(pixel, self.picture.depth(pixel)?));
        picked_slope(
            at(pixel, depth),
            before.and_then(neighbour),
            neighbour(pixel + step),
            self.options.pick,
        )
    }

    /// The listing of section 5.17: half the box of four points at ± one step, with linear depths. The steep slopes of
    /// [`NeighbourPick::Larger`] can put a point behind the eye; it is projected like any other, as the listing does.
    fn listed_extent(&self, pixel: UVec2, depth: f64, step: UVec2) -> DVec2 {
        let center = pixel.as_dvec2() + 0.5;
        let linear = self.picture.linear_depth(self.picture.clip_place(center), depth);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for step in [step.with_y(0), step.with_x(0)] {
            let slope = self.slope(pixel, depth, step, |depth, place| {
                self.picture.linear_depth(place, depth)
            });
            for sign in [-1.0, 1.0] {
                let place = self.picture.clip_place(center + step.as_dvec2() * sign);
                let depth = self.picture.depth_of_linear(place, linear + slope * sign);
                let clip = self.map_from_picture * place.extend(depth).extend(1.0);
                let uv = clip.truncate().truncate() / clip.w * 0.5;
                if !uv.is_finite() {
                    return DVec2::ZERO;
                }
                (low, high) = (low.min(uv), high.max(uv));
            }
        }
        0.5 * (high - low)
    }

    fn in_bytes(&self, texel: MappingTexel, need: DVec2) -> MappingTexel {
        let steps = if self.options.wide_steps {
            self.ratio.max_element()
        } else {
            1.0
        };
        let level = |need: f64| byte_level(byte_need(steps / need), steps).clamp(0.0, f64::from(MAX_LEVEL)) as u8;
        let place = |uv: f32| place_of_byte(byte_place(f64::from(uv))) as f32;
        MappingTexel {
            uv: Vec2::new(place(texel.uv.x), place(texel.uv.y)),
            levels: [level(need.x), level(need.y)],
            reach: Vec2::ZERO,
        }
    }
}
