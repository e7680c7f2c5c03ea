//! [`FilmMoments`]: all that the metrics need to know of the samples.

use std::{iter::Sum, ops::AddAssign};

use bevy_math::{DMat2, DVec2};

use super::FilmSample;

/// Sums over samples that can be added: the CPU twin of a GPU reduction. 47 numbers.
///
/// Both metrics are polynomials of k with these sums as coefficients. In single precision they are good for about 10⁻⁵ of
/// the metric while |u| stays around 1, as [`BaseFilm`](super::BaseFilm) sees to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmMoments {
    /// |Ω|: pixels that the samples stand for.
    pub pixels: f64,
    /// Sums of a u^i v^j for (i, j) = 00, 10, 01, 20, 11, 02, 30, 21, 12, 03; a = |det J| times the sample's pixels.
    pub area: [f64; 10],
    /// Sums of {G₀₀, G₀₁, G₁₁, (G u)₀, (G u)₁, uᵀ G u} (rows) times {1, u, v, u², u v, v²} (columns); G = Jᵀ J times the
    /// sample's pixels.
    pub stretch: [[f64; 6]; 6],
}

/// What films make of the badness: the sum of a w³ and its first two moments over v.
pub(super) struct Badness {
    /// S = Σ a w³.
    pub(super) total: f64,
    /// Σ a w³ v ÷ S.
    pub(super) mean: DVec2,
    /// Σ a w³ v vᵀ ÷ S.
    pub(super) square: DMat2,
}

impl FilmMoments {
    /// Those of one sample.
    pub fn of(sample: &FilmSample) -> Self {
        let DVec2 { x, y } = sample.film;
        let tensor = sample.pixels_from_film.transpose() * sample.pixels_from_film * sample.pixels;
        let area = sample.pixels_from_film.determinant().abs() * sample.pixels;
        let pushed = tensor * sample.film;
        let monomials = [1.0, x, y, x * x, x * y, y * y];
        let weights = [
            tensor.x_axis.x,
            tensor.y_axis.x,
            tensor.y_axis.y,
            pushed.x,
            pushed.y,
            pushed.dot(sample.film),
        ];
        let cubic = [x * x * x, x * x * y, x * y * y, y * y * y];
        let mut areas = [0.0; 10];
        for (sum, monomial) in areas.iter_mut().zip(monomials.iter().chain(&cubic)) {
            *sum = area * monomial;
        }
        Self {
            pixels: sample.pixels,
            area: areas,
            stretch: weights.map(|weight| monomials.map(|monomial| weight * monomial)),
        }
    }

    /// S(k) = Σ a w³: pixels that a texel of size 1 × 1 in v covers, summed over all pixels.
    ///
    /// w³ has the coefficients 1, 3 k_x, 3 k_y, 3 k_x², 6 k_x k_y, 3 k_y², k_x³, 3 k_x² k_y, 3 k_x k_y², k_y³.
    pub fn area_sum(&self, bend: DVec2) -> f64 {
        let DVec2 { x, y } = bend;
        let [m00, m10, m01, m20, m11, m02, m30, m21, m12, m03] = self.area;
        let linear = m10 * x + m01 * y;
        let square = m20 * x * x + 2.0 * m11 * x * y + m02 * y * y;
        let cube = m30 * x * x * x + 3.0 * x * y * (m21 * x + m12 * y) + m03 * y * y * y;
        m00 + 3.0 * (linear + square) + cube
    }

    /// M(k) = Σ w² (I + k uᵀ) G (I + u kᵀ) = Γ + k gᵀ + g kᵀ + h k kᵀ, where Γ, g and h are the sums of w² G, w² G u and
    /// w² uᵀ G u. A frame with sides e₁ and e₂ and n_x × n_y texels has the stretch e₁ᵀ M e₁ ÷ n_x² + e₂ᵀ M e₂ ÷ n_y².
    pub fn stretch_matrix(&self, bend: DVec2) -> DMat2 {
        let DVec2 { x, y } = bend;
        let squared_width = [1.0, 2.0 * x, 2.0 * y, x * x, 2.0 * x * y, y * y];
        let [g00, g01, g11, g0, g1, h] = self.stretch.map(|row| {
            row.iter()
                .zip(&squared_width)
                .map(|(sum, factor)| sum * factor)
                .sum::<f64>()
        });
        let g = DVec2::new(g0, g1);
        let outer = |a: DVec2, b: DVec2| DMat2::from_cols(a * b.x, a * b.y);
        DMat2::from_cols_array(&[g00, g01, g01, g11]) + outer(bend, g) + outer(g, bend) + outer(bend, bend) * h
    }

    /// The badness as a weight over the new film. a w³ v = a w² u and a w³ v vᵀ = a w u uᵀ.
    pub(super) fn badness(&self, bend: DVec2) -> Badness {
        let DVec2 { x, y } = bend;
        let [m00, m10, m01, m20, m11, m02, m30, m21, m12, m03] = self.area;
        let [w00, w10, w01] = [
            m00 + x * m10 + y * m01,
            m10 + x * m20 + y * m11,
            m01 + x * m11 + y * m02,
        ];
        // Sums of a w u uᵀ, then of a w² u = Σ a w u (1 + k · u), then of a w³ = Σ a w² (1 + k · u).
        let square = DMat2::from_cols_array(&[
            m20 + x * m30 + y * m21,
            m11 + x * m21 + y * m12,
            m11 + x * m21 + y * m12,
            m02 + x * m12 + y * m03,
        ]);
        let first = DVec2::new(w10, w01) + square * bend;
        let total = w00 + bend.dot(DVec2::new(w10, w01)) + bend.dot(first);
        Badness {
            total,
            mean: first / total,
            square: square * (1.0 / total),
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.pixels.is_finite()
            && self.area.iter().all(|sum| sum.is_finite())
            && self.stretch.iter().flatten().all(|sum| sum.is_finite())
    }
}

impl AddAssign for FilmMoments {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        for (sum, value) in self.area.iter_mut().zip(other.area) {
            *sum += value;
        }
        let rows = self.stretch.iter_mut().zip(other.stretch);
        for (sum, value) in rows.flat_map(|(sums, values)| sums.iter_mut().zip(values)) {
            *sum += value;
        }
    }
}

impl Sum for FilmMoments {
    fn sum<I: Iterator<Item = Self>>(moments: I) -> Self {
        let mut total = Self::default();
        for moments in moments {
            total += moments;
        }
        total
    }
}
