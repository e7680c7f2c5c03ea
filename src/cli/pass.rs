//! [`Pass`]: the kinds of pictures.

use std::{fmt, str::FromStr};

/// A kind of picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pass {
    /// The picture, with shadows.
    Beauty,
    /// The picture without the sun's shadows.
    Lit,
    /// The sun's visibility.
    Mask,
    /// Distance along the view direction.
    Depth,
    /// Surface normals.
    Normal,
}

impl Pass {
    /// Every pass.
    pub const ALL: [Self; 5] = [Self::Beauty, Self::Lit, Self::Mask, Self::Depth, Self::Normal];

    /// The name on the command line and in file names.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Beauty => "beauty",
            Self::Lit => "lit",
            Self::Mask => "mask",
            Self::Depth => "depth",
            Self::Normal => "normal",
        }
    }

    /// What the file contains.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Beauty => "the picture, with shadows; 8-bit sRGB",
            Self::Lit => "the same without the sun's shadows",
            Self::Mask => "the sun's visibility; 8-bit: 255 lit, 0 in shadow or facing away, sky 255",
            Self::Depth => "view depth ÷ the shot's far plane × 65535; 16-bit, linear, sky and beyond 65535",
            Self::Normal => "world-space normal, (n + 1) ÷ 2 × 255 in red, green and blue; 8-bit, sky black",
        }
    }

    /// Whether [`ShadowMask`](crate::render::mask::ShadowMask) draws it.
    #[must_use]
    pub fn is_of_surfaces(self) -> bool {
        matches!(self, Self::Mask | Self::Depth | Self::Normal)
    }
}

impl fmt::Display for Pass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Pass {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|pass| pass.name() == text).ok_or_else(|| {
            format!(
                "there is no pass `{text}`; there are {}",
                Self::ALL.map(Self::name).join(", ")
            )
        })
    }
}
