//! Which fading things share a layer of nearest surfaces.
//!
//! Of a fading level only the nearest surface may be blended ([`blend`](super::blend)), so every pixel has to know it. A
//! layer holds one surface per pixel: two levels that fade at once share it well where they never cover the same pixel, and
//! get layers of their own where they may.

use bevy_math::Vec3;

/// A ball around a thing, world space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its middle.
    pub center: Vec3,
    /// Half its width.
    pub radius: f32,
}

impl Ball {
    /// A ball around both, not much larger than needed.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let way = other.center - self.center;
        let distance = way.length();
        if distance + other.radius <= self.radius {
            return self;
        }
        if distance + self.radius <= other.radius {
            return other;
        }
        let radius = 0.5 * (distance + self.radius + other.radius);
        Self {
            center: self.center + way * ((radius - self.radius) / distance),
            radius,
        }
    }
}

/// Whether two balls overlap in the picture of an eye, wherever it looks. An eye in a ball sees it everywhere.
#[must_use]
pub fn overlap(eye: Vec3, a: Ball, b: Ball) -> bool {
    let (to_a, to_b) = (a.center - eye, b.center - eye);
    let (far_a, far_b) = (to_a.length(), to_b.length());
    if far_a <= a.radius || far_b <= b.radius {
        return true;
    }
    let half_width = |radius: f32, far: f32| bevy_math::ops::asin(radius / far);
    let between = to_a.angle_between(to_b);
    between <= half_width(a.radius, far_a) + half_width(b.radius, far_b)
}

/// The layer for a new ball beside others in theirs: the first of `count` in which no eye sees another one overlap it, else
/// the first of those in which fewest do.
#[must_use]
pub fn free_layer(new: Ball, others: impl IntoIterator<Item = (Ball, u32)>, eyes: &[Vec3], count: u32) -> u32 {
    let mut rivals = vec![0_u32; count.max(1) as usize];
    for (ball, layer) in others {
        let Some(rivals) = rivals.get_mut(layer as usize) else {
            continue;
        };
        *rivals += u32::from(eyes.iter().any(|eye| overlap(*eye, new, ball)));
    }
    let fewest = rivals.iter().enumerate().min_by_key(|(_, rivals)| **rivals);
    fewest.map_or(0, |(layer, _)| layer as u32)
}
