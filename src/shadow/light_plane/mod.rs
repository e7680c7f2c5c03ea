//! Perspective-optimal light planes (Chong 2003): films whose texels cover as few pixels of the picture as they can, from
//! what the camera really sees.
//!
//! All other warps of this crate follow from the shape of the view volume. This one follows from the surfaces in it: a
//! low-resolution view of the prepass comes back from the GPU ([`SeenSurfaces`], written by the render room), and
//! [`plan_films`](crate::maths::light_plane::space::plan_films) chooses one film or several, every frame.
//!
//! ```text
//! SunShadows::light_planes ─► SurfaceSampling on cameras ─► (render room) ─► SeenSurfaces, a frame later
//!   ─► films ─► SunViews                                                 LightPlaneStates: what is kept, what it costs
//! ```
//!
//! # Limits
//! What is seen is a frame old or more. Surfaces that have come into sight since are in another map: a coarse one over all
//! that the camera may see ([`FilmCover::Seen`](crate::maths::light_plane::space::FilmCover)), or every film covers all of
//! that ([`FilmCover::Body`](crate::maths::light_plane::space::FilmCover)). Without a picture, and where films have no
//! answer, one uniform map does ([`NoFilms`] says why).

mod compute;
mod layout;
mod settings;
mod systems;

use bevy::{
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    ecs::entity::EntityHashMap,
    prelude::*,
};
use thiserror::Error;

pub use compute::{LightPlaneInput, compute_light_plane_views};
pub use settings::LightPlanes;
pub(super) use systems::{ask_cameras, clip_from_world, film_views};

use super::{layout::AtlasLayout, views::LightView};
use crate::maths::light_plane::space::{FilmError, FilmMemory, SeenPicture};

/// On a camera: what it sees is sampled for light planes, block by block of its picture. Given to cameras and taken from
/// them as suns ask for it. Needs `Msaa::Off`.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(DepthPrepass, NormalPrepass)]
pub struct SurfaceSampling {
    /// Blocks across the picture, 8..=128.
    pub columns: u32,
    /// Blocks down, 8..=128.
    pub rows: u32,
}

impl Default for SurfaceSampling {
    /// 48 × 27: at 36 × 24 films are within 0.3 % of those of all pixels, but outlines of what is seen are as wide as a block.
    fn default() -> Self {
        Self { columns: 48, rows: 27 }
    }
}

impl SurfaceSampling {
    /// Blocks across and down, in range.
    #[must_use]
    pub fn block_count(self) -> UVec2 {
        UVec2::new(self.columns, self.rows).clamp(UVec2::splat(8), UVec2::splat(128))
    }
}

/// On a camera: what it saw in one of the last frames.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct SeenSurfaces {
    /// The blocks of its picture.
    pub picture: SeenPicture,
}

/// Why a uniform map stands in for films.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NoFilms {
    /// Nothing has come back from the GPU yet; or several cameras share the split distances of the drop-in path.
    #[error("no picture has been sampled yet, or several cameras share one list of splits")]
    NoPicture,
    /// The picture is the same at every depth: a uniform map is its optimum, for every plane.
    #[error("an orthographic camera has no perspective to follow")]
    Orthographic,
    /// Only sky, surfaces in one plane of light, or numbers that are not finite.
    #[error(transparent)]
    Film(#[from] FilmError),
}

/// On the entity of a light with [`SunShadows`](super::settings::SunShadows): its light planes of this frame by camera.
/// Empty while the settings ask for none.
#[derive(Component, Clone, Debug, Default)]
pub struct LightPlaneStates {
    /// By camera entity.
    pub cameras: EntityHashMap<LightPlaneState>,
}

/// Light planes of one sun and one camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightPlaneState {
    /// What the next frame goes on from.
    pub memory: FilmMemory,
    /// Where the maps of several films lie: they stay while that is about right.
    pub layout: Option<AtlasLayout>,
    /// One uniform map over what the films cover: what they are measured against.
    pub unbent: Option<LightView>,
    /// What was found, or why nothing was.
    pub films: Option<Result<FilmReport, NoFilms>>,
}

/// Numbers of the films of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmReport {
    /// Films.
    pub count: usize,
    /// Mean of the metric over the pixels, for as many texels as all their maps have: pixels per texel for the area.
    pub mean_error: f64,
    /// Total error of a uniform map of as many texels over that of the films.
    pub gain: f64,
    /// What damping costs: the error over that of the best films, less 1.
    pub damping_cost: f64,
}
