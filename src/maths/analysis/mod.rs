//! What theory says about shadow maps before anything is drawn: errors along the view, storage factors, light directions.
//!
//! | question | function |
//! |---|---|
//! | how large is the error at a view depth, sun overhead? | [`overhead`]: every warp, pseudo planes, slices |
//! | how large is it at worst, and what would it take to remove it? | [`overhead::OverheadRange::largest_errors`], S̄ |
//! | how many maps are worth it? | [`storage`](super::storage): closed forms overhead and along the view |
//! | what about other light directions? | [`direction`]: any direction, faces, slices, by evaluation at vertices |
//! | how typical is the largest error? | [`means`]: L1 and L2 over the frustum |
//! | which direction is the worst? | [`hemisphere`]: maps over all directions, their mean and their peak |
//!
//! Limits. Only perspective aliasing counts ([`super::error`]). The closed forms hold for light from straight above and
//! from straight behind. Between them everything is evaluated at the vertices of the frustum, which is exact for the
//! errors that the map has. That parameters between those of `PSM` and `LiSPSM` need equal storage holds overhead only;
//! the authors say so themselves in an erratum to Lloyd et al. 2006. Inside the view cone (the angle between light and view
//! below Θ or above 180° − Θ) n_opt is no optimum: the frustum has no trapezoidal outline there, and a warp makes its map
//! worse ([`direction::TiltedWarp::Lispsm`] shows it, [`direction::TiltedWarp::Guarded`] avoids it).

pub mod direction;
pub mod faces;
pub mod hemisphere;
pub mod means;
pub mod overhead;
