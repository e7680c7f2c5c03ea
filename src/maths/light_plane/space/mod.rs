//! Light planes in space: a film with two degrees of freedom, for the sun and for lights at a point.
//!
//! The thesis (Chong 2003, *Real-Time Perspective Optimal Shadow Maps*) solves flatland and leaves space as future work
//! (section 4.2.1): which metric, which extents, which solver. This is an answer. What is a fact about projections (its
//! Theorem 1 and Proposition 3) carries over; the rest is derived here.
//!
//! # The family of films
//!
//! A *base film* ([`BaseFilm`]) gives every point that the light sees two coordinates u: for the sun the position in the
//! light plane, for a light at a point that on a plane across some axis. All other perspectives of that light are
//!
//! ```text
//! v = u ÷ w,   w = 1 + k · u,        k ∈ R²: the bend
//! ```
//!
//! up to an affine map. w = 0 is a plane that contains the light: for a light at a point it is parallel to the film, so
//! that k tilts the film. For the sun tilting the film changes nothing (a texel's shape at most), but the same w is a warp
//! as in light space perspective shadow maps, with its axis along k. k is valid while w > 0 over everything that has to be
//! covered, the hull. As (w v, w) = (I 0; kᵀ 1) (u, 1) has determinant 1,
//!
//! ```text
//! ∂v/∂u = (I − u kᵀ ÷ w) ÷ w,     det = 1 ÷ w³,     ∂u/∂v = w (I + u kᵀ)
//! ```
//!
//! # Errors
//!
//! A sample of the picture ([`FilmSample`]) knows J = ∂pixel/∂u. With a frame v = c + E (ξ, η), ξ and η in 0..1, and
//! n = n_x n_y texels, one texel covers the parallelogram J w (I + u kᵀ) E diag(1/n_x, 1/n_y) in pixels. Two metrics
//! ([`FilmMetric`]) sum over all pixels of the picture and depend on the samples by sums only ([`FilmMoments`]), so that
//! tiles, slices and work groups of a GPU can be added up:
//!
//! ```text
//! area      |det E| ÷ n · Σ a w³                  a = |det J|
//! stretch   e₁ᵀ M e₁ ÷ n_x² + e₂ᵀ M e₂ ÷ n_y²      M(k) = Σ w² (I + k uᵀ) Jᵀ J (I + u kᵀ)
//! ```
//!
//! The area is the thesis's L1 in both dimensions. Its two proposals for space, the sum of squared partial derivatives and
//! the geometric stretch, are the same number: the trace of the metric tensor of the texel's parallelogram. It is the sum of
//! its squared *singular* values, not eigenvalues as printed. The thesis sums it over texels; here every sum goes over
//! pixels, since a sum over texels weights what is sampled well more.
//!
//! # One minimum
//!
//! Where the frame fits the hull itself, the area metric is P(k) S(k) with the area P of the hull's image and S = Σ a w³.
//! Multiply w by a constant: P falls with its third power, S rises with it. So look at all w = a₀ + a · u that are positive
//! on the hull. S^(1/3) is a norm of order 3 of values that are linear in (a₀, a): convex. P = ∫ w⁻³ du over the hull, and
//! P^(−1/3) is a mean of order −3: concave. A convex function over a positive concave one is quasi-convex: **P S has one
//! minimum**, inside the valid films, and no path along a straight line between two films is worse than its worse end.
//! At the minimum
//!
//! ```text
//! Σ a w³ v ÷ Σ a w³ = ∫ v dv ÷ ∫ dv        the badness-weighted mean of v is the centroid of the film
//! ```
//!
//! the thesis's condition of flatland in space. [`FilmProblem::balanced_bend`] finds it by Newton's method.
//!
//! A parallelogram along two edges of the hull, with the farthest vertices p and q, has the area
//! T_p T_q ÷ (w_p w_q |w_x|), where T are constants and x is the point in which the edges meet: the same argument
//! makes its metric quasi-convex while p, q and the sign of w_x stay, and over their changes too as long as w_x does not
//! vanish. The least of many such functions may have more than one minimum, so [`FilmProblem::solve`] goes down from the
//! minimum of P S and from what else is proposed to it.
//!
//! # What it costs
//!
//! A film can be no better than the projection aliasing of the scene lets it be: mean area ≥ |Ω| ÷ n when every texel is
//! seen by one pixel. One plane alone reaches that with the bend of [`BaseFilm::bend_of_plane`].

mod base;
mod cut;
mod damping;
mod film_block;
mod fit;
mod frame;
mod hull;
mod moments;
mod partition;
mod plan;
mod sample;
mod seen;
mod slices;
mod solve;
mod tiles;

pub use base::{BaseFilm, FilmError, depth_form, plane_form};
pub use damping::{Damped, Damping};
pub use film_block::{BlockCorner, FilmBlock};
pub use fit::{FilmFitInput, fit_film, point_light_clip_from_world};
pub use frame::{FilmFrame, FilmShape};
pub use hull::FilmHull;
pub use moments::FilmMoments;
pub use partition::{FilmBin, FilmFrustum, FilmPartition, depth_order};
pub use plan::{FilmCover, FilmDivision, FilmMemory, FilmPlan, FilmPlanInput, FilmPlanOptions, plan_films};
pub use sample::{FilmSample, LEAST_COSINE, SampleGrid, Unsampled};
pub use seen::{BlockDepths, BlockPlane, SeenBlock, SeenPicture, block_pixels, reduce_block};
pub use slices::{DepthSlices, slice_by_depth};
pub use solve::{Film, FilmMetric, FilmObjective, FilmProblem, MapSides};
pub use tiles::{FilmTiles, MergeLimits, TileOwners};
