//! [`LodChain`]: an object in levels of detail.

use std::sync::Arc;

use bevy::{mesh::morph::MeshMorphWeights, prelude::*};

use super::settings::{LodKind, LodShadows};
use crate::maths::lod::{
    crossing::Shown,
    selection::{LodBorders, LodMetric},
};

/// An object in levels of detail. Its distance is that of its own origin.
///
/// Levels may differ in all but what they stand for: meshes, materials, skeletons. Parts fade if their material is a
/// [`StandardMaterial`]; others switch in the middle of a crossing. Chains own the [`Visibility`] of their parts.
#[derive(Component, Clone, Debug)]
#[require(Transform, LodState)]
pub struct LodChain {
    /// The entities that are drawn, level by level from fine to coarse.
    pub levels: Vec<Vec<Entity>>,
    /// Where levels end, shared among chains.
    pub borders: Arc<LodBorders>,
    /// What the borders mean.
    pub metric: LodMetric,
}

/// What a chain shows.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct LodState {
    /// `None` before the first camera, and where Bevy's dither decides.
    pub(super) shown: Option<Shown>,
    /// How that is drawn.
    pub(super) drawn_as: Option<(LodKind, LodShadows)>,
    /// The eyes' way in metres up to which nothing can change.
    pub(super) rests_until: f64,
    /// Parts carry Bevy's visibility ranges, made when the levels were blended like this.
    pub(super) dithered: Option<(usize, Option<f64>)>,
}

impl LodState {
    /// A level at rest or a crossing; `None` before the first camera, and where Bevy's dither decides.
    #[must_use]
    pub fn shown(&self) -> Option<Shown> {
        self.shown
    }
}

/// On a part whose mesh has where its vertices lie in the next coarser level as its first morph target, with the normals
/// there: what [`LodKind::Geomorph`] needs of all levels but the last. The first weight is the chain's.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
#[require(MeshMorphWeights = MeshMorphWeights::Value { weights: vec![0.0] })]
pub struct LodMorph;

/// On a part while it fades.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct LodCoat {
    /// 0..=1.
    pub alpha: f32,
    /// Share of a shadow that it casts, 0..=1.
    pub shadow: f32,
    /// Whether it is drawn over the other level where depths are equal.
    pub wins_ties: bool,
    /// Whether the other level fades, too: shares of both in one texel of a map would hide each other, so the shadow is
    /// dithered.
    pub dithers_shadow: bool,
    /// The same for all parts of an object: of each of its levels only the nearest surface is blended.
    pub object: u32,
}
