//! Overlays: what the shadow systems computed, as lines in the scene ([`outside`](super::outside) draws them) or as a heat
//! map ([`heat_map`](super::heat_map)); and levels of detail.

use bevy::prelude::*;

use super::{
    DemoSystems,
    hud::Notice,
    input::{Action, Intent},
    screens::Activity,
};
use crate::{maths::sampling_rate::RateMeasure, shadow::gizmos::SunShadowGizmos};

/// The overlay that is shown.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlay {
    /// None.
    #[default]
    Off,
    /// Intersection bodies.
    Bodies,
    /// Slices of the view frustum.
    SplitFrusta,
    /// Clip boxes of the light views.
    LightViews,
    /// All three.
    All,
    /// Texel ÷ pixel in color.
    TexelRatio,
    /// The same of one uniform map of as many texels over what light planes cover; nothing under other techniques.
    TexelRatioBefore,
    /// Texels per pixel in the measures and colors of Stingl 2011.
    SamplingRate(RateMeasure),
    /// Which map is read, in color.
    Maps,
    /// Tiles of a virtual map.
    Tiles,
    /// Needs of a fitted map.
    Needs,
    /// Levels of detail.
    Levels,
}

impl Overlay {
    /// The one that follows.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::Off => Self::Bodies,
            Self::Bodies => Self::SplitFrusta,
            Self::SplitFrusta => Self::LightViews,
            Self::LightViews => Self::All,
            Self::All => Self::TexelRatio,
            Self::TexelRatio => Self::TexelRatioBefore,
            Self::TexelRatioBefore => Self::SamplingRate(RateMeasure::Area),
            Self::SamplingRate(RateMeasure::Area) => Self::SamplingRate(RateMeasure::Across),
            Self::SamplingRate(RateMeasure::Across) => Self::SamplingRate(RateMeasure::Along),
            Self::SamplingRate(RateMeasure::Along) => Self::Maps,
            Self::Maps => Self::Tiles,
            Self::Tiles => Self::Needs,
            Self::Needs => Self::Levels,
            Self::Levels => Self::Off,
        }
    }

    /// Its name on screen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Bodies => "intersection bodies",
            Self::SplitFrusta => "split frusta",
            Self::LightViews => "light views",
            Self::All => "bodies, split frusta and light views",
            Self::TexelRatio => "texel / pixel: dark blue 1/8, blue 1/4, cyan 1/2, green 1, yellow 2, orange 4, red 8",
            Self::TexelRatioBefore => "texel / pixel without a light plane: one uniform map",
            Self::SamplingRate(RateMeasure::Area) => {
                "texels per pixel, by area: dark red 0, yellow 1/3, green 1, light blue 3, dark blue 10"
            }
            Self::SamplingRate(RateMeasure::Across) => "texels per pixel across the map, x, in the same colors",
            Self::SamplingRate(RateMeasure::Along) => "texels per pixel along the map, y, in the same colors",
            Self::Maps => "maps: red, yellow, green, blue, and again",
            Self::Tiles => "tiles of virtual maps, blue coarsest, the next color for each doubling",
            Self::Needs => {
                "needs of fitted maps: blue 256 texels across the map, green 16 thousand, red 256 thousand, pink unmet"
            }
            Self::Levels => "levels of detail: white, green, yellow, red from fine to coarse, magenta while they cross",
        }
    }

    /// Whether lines show it.
    pub fn has_lines(self) -> bool {
        !self.is_heat_map() && !matches!(self, Self::Off | Self::Tiles | Self::Needs | Self::Levels)
    }

    /// Whether posts on objects show it.
    pub fn has_posts(self) -> bool {
        self == Self::Levels
    }

    /// Whether colors show it.
    pub fn is_heat_map(self) -> bool {
        matches!(
            self,
            Self::TexelRatio | Self::TexelRatioBefore | Self::SamplingRate(_) | Self::Maps
        )
    }

    /// The lines that show it; a partition's are red, yellow, green, blue in turn.
    pub fn gizmos(self) -> SunShadowGizmos {
        SunShadowGizmos {
            camera: None,
            bodies: matches!(self, Self::Bodies | Self::All),
            split_frusta: matches!(self, Self::SplitFrusta | Self::All),
            light_views: matches!(self, Self::LightViews | Self::All),
        }
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Overlay>().add_systems(
        Update,
        cycle.run_if(in_state(Activity::Running)).in_set(DemoSystems::Act),
    );
}

fn cycle(intent: Res<Intent>, mut overlay: ResMut<Overlay>, mut notice: ResMut<Notice>) {
    if intent.started(Action::NextOverlay) {
        *overlay = overlay.next();
        notice.show(format!("overlay {}", overlay.name()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlays_come_round_and_differ() {
        let mut overlay = Overlay::Off;
        let mut seen = Vec::new();
        loop {
            let gizmos = overlay.gizmos();
            let shown = (
                gizmos.bodies,
                gizmos.split_frusta,
                gizmos.light_views,
                overlay.is_heat_map().then_some(overlay.name()),
                overlay == Overlay::Tiles,
                overlay == Overlay::Needs,
                overlay.has_posts(),
            );
            assert!(!seen.contains(&shown), "{overlay:?} shows nothing new");
            assert!(overlay.name().is_ascii(), "the font has ASCII only");
            seen.push(shown);
            overlay = overlay.next();
            if overlay == Overlay::Off {
                break;
            }
        }
        assert_eq!(
            (seen.len(), seen[0]),
            (14, (false, false, false, None, false, false, false))
        );
    }
}
