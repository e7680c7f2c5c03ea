//! [`Tilt`]: the family of films.

/// A film relative to another one of the same light and hull.
///
/// Turning a film by an angle moves places by a map that keeps both ends of the hull. Chong writes its derivative with six
/// trigonometric functions of the angle (section 3.1). It is the one-parameter group
///
/// ```text
/// l' = (l + k) / (1 + k l)        dl/dl' = (1 + k l)² / (1 − k²)        k = tanh s
///    = tanh(artanh l + s)                = (cosh s + l sinh s)²
/// ```
///
/// Here s is kept: it adds up over turns in sequence, reaches every valid film (k in −1..1) and no invalid one, and does
/// not run out of digits near the ends as k and the angle do. With μ = (1 + l) ÷ 2, cosh s + l sinh s is
/// μ eˢ + (1 − μ) e⁻ˢ: a sum of exponentials with positive weights, whose powers are all convex in s.
///
/// Every projection from the light that takes the hull to −1..=1 is in the family, in whatever space its film stands
/// (Chong's question in section 4.2.2): places on it are cross ratios of the ends and of the ray on which w = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Tilt {
    /// s. Positive moves places up, and texels to the upper end (l = 1).
    pub parameter: f64,
}

impl Tilt {
    /// The tilt of parameter s.
    pub fn new(parameter: f64) -> Self {
        Self { parameter }
    }

    /// The tilt of strength k. `None` outside of −1..1: a film of infinite length or one with the hull behind it.
    pub fn of_strength(strength: f64) -> Option<Self> {
        (strength.abs() < 1.0).then(|| Self::new(strength.atanh()))
    }

    /// k = tanh s: on the old film, w of the new one is 1 + k l.
    pub fn strength(self) -> f64 {
        self.parameter.tanh()
    }

    /// This tilt and then another one, of the tilted film.
    pub fn then(self, next: Self) -> Self {
        Self::new(self.parameter + next.parameter)
    }

    /// The way back.
    pub fn inverse(self) -> Self {
        Self::new(-self.parameter)
    }

    /// l': where a ray of old place l in −1..=1 meets the tilted film.
    pub fn place(self, place: f64) -> f64 {
        let (low, high) = self.weights(place);
        (high - low) / (high + low)
    }

    /// dl/dl': by how much badness grows. Never zero or negative, 1 without a tilt, and the values at both ends multiply
    /// to 1.
    pub fn stretch(self, place: f64) -> f64 {
        let (low, high) = self.weights(place);
        (high + low).powi(2)
    }

    /// (1 − μ) e⁻ˢ and μ eˢ.
    fn weights(self, place: f64) -> (f64, f64) {
        let growth = self.parameter.exp();
        ((1.0 - place) / 2.0 / growth, (1.0 + place) / 2.0 * growth)
    }
}
