//! [`LodSettings`]: how levels of detail are chosen and take each other's place.

use bevy::prelude::*;

use crate::maths::lod::blend::BlendKind;

/// Settings of all chains.
#[derive(Resource, Clone, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Debug, Clone, PartialEq)]
pub struct LodSettings {
    /// How levels take each other's place, unless a chain has a [`LodTransition`] of its own.
    pub transition: LodTransition,
    /// Factor on every distance: above 1 coarser and cheaper, below 1 finer. Useful 0.5..=2; default 1, what the models'
    /// borders say.
    pub bias: f32,
    /// Factor on every distance for shadows, beside that: above 1 they are those of coarser levels than are seen, below 1 of
    /// finer ones. Useful 1..=3, as maps are coarser than pictures; default 1, where what is seen casts. Else chains cost
    /// twice the entities ([`casters`](super::casters)).
    pub shadow_bias: f32,
    /// How far within a border, as a share of its distance, a finer level comes back. Default 0.05: eyes that sway by less
    /// switch once.
    pub hysteresis: f32,
    /// How much later than other kinds [`LodKind::Late`] switches: factor on distances, cost grows with its square.
    pub late_factor: f32,
    /// Which levels cast shadows during a crossing.
    pub shadows: LodShadows,
    /// The kind in the right half of the first eye's picture, for two kinds side by side: objects are of the kind of the
    /// half in which their origin lies, unless they have one of their own. Compares all chains in every frame. `None`:
    /// the same kind everywhere.
    pub right_half: Option<LodKind>,
    /// How many fading objects may stand before each other and still be drawn with their nearest surface only, 1..=8. Default
    /// 4. Each costs 15 bytes per pixel and a pass over what fades, from the first time on that so many do.
    pub fading_layers: u32,
    /// An eye that moves farther than this between two frames has been put elsewhere, and nothing fades then. Metres,
    /// default 10: 600 m/s at 60 Hz.
    pub teleport: f32,
}

impl Default for LodSettings {
    fn default() -> Self {
        Self {
            transition: LodTransition::default(),
            bias: 1.0,
            shadow_bias: 1.0,
            hysteresis: 0.05,
            late_factor: 2.0,
            shadows: LodShadows::default(),
            right_half: None,
            fading_layers: 4,
            teleport: 10.0,
        }
    }
}

/// How the levels of a chain take each other's place; on a chain's entity, in place of the global one.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct LodTransition {
    /// In which way.
    pub kind: LodKind,
    /// What moves it on.
    pub driver: LodDriver,
}

/// In which way levels take each other's place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum LodKind {
    /// At once: pops.
    Hard,
    /// At once, but [`late_factor`](LodSettings::late_factor) farther away: smaller pops, at the cost of finer levels.
    Late,
    /// Both levels semitransparent: the background shines through solid things.
    Plain,
    /// Bevy's [`VisibilityRange`](bevy::camera::visibility::VisibilityRange): ordered dither with 16 levels, always driven by
    /// distance.
    Dither,
    /// Vertices that move to where they lie in the next coarser level. Needs chains whose parts have
    /// [`LodMorph`](super::chain::LodMorph); others take [`Unpopping`](Self::Unpopping) instead, with a warning. Parts may
    /// have any material.
    Geomorph,
    /// One level opaque at all times, the other faded over it.
    #[default]
    Unpopping,
}

impl LodKind {
    /// Every kind.
    pub const ALL: [Self; 6] = [
        Self::Hard,
        Self::Late,
        Self::Plain,
        Self::Dither,
        Self::Geomorph,
        Self::Unpopping,
    ];

    /// What it is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hard => "hard",
            Self::Late => "late",
            Self::Plain => "plain",
            Self::Dither => "dither",
            Self::Geomorph => "geomorph",
            Self::Unpopping => "unpopping",
        }
    }

    /// The kind of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Whether the shadow of a level that fades may be a share of the light. Where both levels fade it is dithered.
    #[must_use]
    pub fn shares_shadow(self) -> bool {
        // Chains that cannot morph fade.
        matches!(self, Self::Geomorph | Self::Unpopping)
    }

    /// How both levels are drawn.
    #[must_use]
    pub fn blend(self) -> BlendKind {
        match self {
            Self::Hard | Self::Late | Self::Dither | Self::Geomorph => BlendKind::Hard,
            Self::Plain => BlendKind::Plain,
            Self::Unpopping => BlendKind::Unpopping,
        }
    }
}

/// What moves a crossing on.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub enum LodDriver {
    /// Time: few objects are drawn twice.
    Time {
        /// Of a whole crossing. Useful 0.2..=1, default 0.4.
        seconds: f32,
    },
    /// The eye's distance: who stands still sees a mixed, but solid object.
    Distance {
        /// How much nearer than its border a crossing begins, metres; it ends at the border.
        metres: f32,
    },
}

impl Default for LodDriver {
    fn default() -> Self {
        Self::Time { seconds: 0.4 }
    }
}

impl LodDriver {
    /// Metres of [`LodDriver::Distance`] when nothing else is said, and of [`LodKind::Dither`] where time drives.
    pub const METRES: f32 = 1.0;

    /// The width of a crossing in metres where distance drives it.
    #[must_use]
    pub fn band(self) -> f32 {
        match self {
            Self::Time { .. } => Self::METRES,
            Self::Distance { metres } => metres,
        }
    }
}

/// Which levels cast shadows during a crossing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum LodShadows {
    /// The opaque one: the shadow changes at once, in the middle.
    Solid,
    /// Both: the shadow grows at once at the beginning and shrinks at the end.
    Both,
    /// The opaque one, and the fading one as much as it is opaque: the shadow changes little by little. On the full path its
    /// share of the light lies beside its depth in maps of their own; of several that fade behind each other in a texel the
    /// nearest counts. In Bevy's own maps it casts through as many texels as it is opaque (ordered dither, smoothed by the
    /// shadow filter), and the shadow changes in steps.
    #[default]
    Fading,
}
