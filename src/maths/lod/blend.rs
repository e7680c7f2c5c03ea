//! How the two levels of a crossing are drawn (Giegl 2007, section 7.2, figure 7.2).
//!
//! | | alpha, t < ½ | alpha, t ≥ ½ | writes depth, t < ½ | writes depth, t ≥ ½ |
//! |---|---|---|---|---|
//! | Unpopping, old level | 1 | 2 (1 − t) | yes | no |
//! | Unpopping, new level | 2 t | 1 | no | yes |
//! | plain, old level | 1 − t | 1 − t | no | no |
//! | plain, new level | t | t | no | no |
//!
//! The figure of the thesis prints the last column the other way round; its text has it as here. Both levels test depth at
//! all times. The level that writes depth is drawn first, and opaque: nothing behind it shines through, and the depth
//! buffer is that of a solid object. The other is blended over it: source · alpha + destination · (1 − alpha).
//!
//! At t = ½ both are opaque, so the picture is that of both solids together, whichever side it is approached from. This
//! holds under two conditions that the thesis leaves open:
//!
//! - *Ties.* Where both levels have equal depth, the same one must win in both halves: the finer wins ties
//!   ([`wins_ties`]). Levels that share surfaces jump at t = ½ otherwise.
//! - *Layers.* Where the fading level has several layers in a pixel (foliage, hollows), only its nearest may be blended.
//!   Layers in any other order than from far to near end as the last one drawn, not as the nearest.

/// How levels take each other's place in time or over distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum BlendKind {
    /// At once.
    Hard,
    /// Both semitransparent, alpha 1 − t and t: the background shines through.
    Plain,
    /// One opaque at all times, the other faded over it.
    #[default]
    Unpopping,
}

/// How one level is drawn. All levels test depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// 0..=1; 0: not at all.
    pub alpha: f64,
    /// Whether it leaves its depth behind; such a level is opaque and drawn first.
    pub writes_depth: bool,
}

impl Coat {
    /// Not drawn.
    pub const HIDDEN: Self = Self {
        alpha: 0.0,
        writes_depth: false,
    };
    /// Drawn as ever.
    pub const OPAQUE: Self = Self {
        alpha: 1.0,
        writes_depth: true,
    };

    const fn faded(alpha: f64) -> Self {
        Self {
            alpha,
            writes_depth: false,
        }
    }
}

/// How the old and the new level of a crossing are drawn. `t` is clamped to 0..=1; at 0 and 1 one level is drawn alone.
#[must_use]
pub fn coats(kind: BlendKind, t: f64) -> [Coat; 2] {
    let t = t.clamp(0.0, 1.0);
    if t <= 0.0 {
        return [Coat::OPAQUE, Coat::HIDDEN];
    }
    if t >= 1.0 {
        return [Coat::HIDDEN, Coat::OPAQUE];
    }
    match kind {
        BlendKind::Hard => [Coat::HIDDEN, Coat::OPAQUE],
        BlendKind::Plain => [Coat::faded(1.0 - t), Coat::faded(t)],
        BlendKind::Unpopping if t < 0.5 => [Coat::OPAQUE, Coat::faded(2.0 * t)],
        BlendKind::Unpopping => [Coat::faded(2.0 * (1.0 - t)), Coat::OPAQUE],
    }
}

/// Whether a level is drawn over another one of equal depth: the finer one is, in both halves of a crossing.
#[must_use]
pub fn wins_ties(level: usize, other: usize) -> bool {
    level < other
}

/// A layer of a level in one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Larger is nearer to the eye, as in Bevy's depth buffer.
    pub depth: f64,
    /// Of any channel.
    pub color: f64,
}

/// A pixel: one channel and the depth buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// The channel.
    pub color: f64,
    /// What the depth buffer holds.
    pub depth: f64,
}

impl Pixel {
    /// Draws layers in their order as one level, with what the levels' rank says about ties: the twin of what the GPU does.
    #[must_use]
    pub fn drawn(mut self, layers: &[Layer], coat: Coat, wins_ties: bool) -> Self {
        if coat.alpha <= 0.0 {
            return self;
        }
        let before = self.depth;
        for layer in layers {
            // Layers of a level that writes depth are tested against each other, too.
            let behind = if coat.writes_depth { self.depth } else { before };
            if layer.depth > behind || (layer.depth == behind && wins_ties) {
                if coat.writes_depth {
                    self = Self {
                        color: layer.color,
                        depth: layer.depth,
                    };
                } else {
                    self.color += coat.alpha * (layer.color - self.color);
                }
            }
        }
        self
    }
}

/// The nearest of some layers, alone; none of none.
#[must_use]
pub fn nearest(layers: &[Layer]) -> Vec<Layer> {
    let nearest = layers
        .iter()
        .copied()
        .reduce(|a, b| if b.depth > a.depth { b } else { a });
    nearest.into_iter().collect()
}

/// A pixel of a crossing, from the layers of its old and new level. `ranks`: their levels, for ties. `is_nearest_only`:
/// whether fading levels are reduced to their nearest layer, as the conditions above ask for.
#[must_use]
pub fn blended(
    background: Pixel,
    [old, new]: [&[Layer]; 2],
    ranks: [usize; 2],
    kind: BlendKind,
    t: f64,
    is_nearest_only: bool,
) -> Pixel {
    let [old_coat, new_coat] = coats(kind, t);
    let mut order = [
        (old, old_coat, wins_ties(ranks[0], ranks[1])),
        (new, new_coat, wins_ties(ranks[1], ranks[0])),
    ];
    // What writes depth comes first; else the farther one does, as among transparent things.
    let depth = |layers: &[Layer]| layers.iter().map(|layer| layer.depth).fold(f64::NEG_INFINITY, f64::max);
    order.sort_by(|a, b| {
        let by_writes = b.1.writes_depth.cmp(&a.1.writes_depth);
        by_writes.then(depth(a.0).total_cmp(&depth(b.0)))
    });
    order.into_iter().fold(background, |pixel, (layers, coat, wins)| {
        // An opaque level stands alone when it is drawn: against the background it wins ties.
        let wins = wins || coat.writes_depth;
        if is_nearest_only && !coat.writes_depth {
            pixel.drawn(&nearest(layers), coat, wins)
        } else {
            pixel.drawn(layers, coat, wins)
        }
    })
}
