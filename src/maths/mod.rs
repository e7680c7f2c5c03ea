//! Pure mathematics of shadow maps: values in, values out; no ECS, no GPU, no clock, no randomness.
//!
//! Double precision inside, metres, right-handed; single precision only where a value leaves the room.
//! Inputs that have no answer (empty, flat, enormous, NaN) give named results, never a panic.
//!
//! From a camera to a light view:
//!
//! ```
//! use bevy_math::{DVec3, UVec2};
//! use umbrage::maths::{body, bounds::Bounds, fit, split, view::ViewVolume, warp::Warp};
//!
//! let scene = Bounds::new(DVec3::new(-50.0, 0.0, -50.0), DVec3::new(50.0, 12.0, 50.0));
//! let light_travel = DVec3::new(0.3, -1.0, 0.2);
//! let eye = DVec3::new(0.0, 1.7, 0.0);
//! let camera = ViewVolume::perspective(eye, DVec3::NEG_Z, DVec3::Y, 1.0, 16.0 / 9.0, 0.1, 1000.0).unwrap();
//! let visible = body::light_visible(&camera, &scene);
//! let (near, far) = body::adjusted_depths(&visible, &camera).unwrap();
//! let depths = split::split_depths(&split::SplitScheme::Logarithmic, near, far, 4);
//! for range in depths.windows(2) {
//!     let slice = camera.split(range[0], range[1]);
//!     let visible = body::light_visible(&slice, &scene);
//!     let input = fit::FitInput {
//!         view: &slice,
//!         visible: &visible,
//!         body: &body::intersection_body(&visible, &scene, light_travel),
//!         light_travel,
//!         warp: Warp::Lispsm,
//!         map_size: UVec2::splat(2048),
//!         guard_texels: 2.0,
//!         guard_metres: 0.0,
//!         options: fit::FitOptions::default(),
//!     };
//!     let light_view = fit::fit_light_view(&input).fitted().unwrap();
//!     assert!(light_view.warp_near.is_finite(), "LiSPSM warps every slice here");
//! }
//! ```
//!
//! # Glossary
//!
//! Papers: S = Stingl 2011 (*Robust Hard Shadows*), L = Lloyd et al. 2006 (*Warping and Partitioning for Low Error
//! Shadow Maps*), G = Giegl 2007 (*Practical CG Research, Game Development and the European Union GameTools Project*),
//! C = Chong 2003 (*Real-Time Perspective Optimal Shadow Maps*).
//!
//! | paper | here | where |
//! |---|---|---|
//! | S (scene box) | [`bounds::Bounds`] | S 3.1.1 |
//! | V, V_i | [`view::ViewVolume`], [`view::ViewVolume::split`] | S 3.1.1, 3.3 |
//! | Θ | half the opening: [`view::ViewVolume::opening`] is 2 tan Θ | S 2.3.3 |
//! | n, f (n_e, f_e) | `near`, `far`: view depths | S 2.3.3 |
//! | H = V ∩ S, LVS = L ∩ V ∩ S | [`body::light_visible`] | S 3.1.1, 3.2.1 |
//! | B = M ∩ S | [`body::intersection_body`] | S 3.1.1 |
//! | adjusted n, f | [`body::adjusted_depths`] | S 3.3.1 |
//! | C_i, λ | [`split::split_depths`], [`split::SplitScheme::Practical`] | S 3.3.2, eq. 3.6 to 3.8; L eq. 15, 16 |
//! | v, l, γ | `forward`, `light_travel`; sin γ = v · y of [`fit::LightAxes`] | S 3.2.1 |
//! | LS, R | [`fit::LightAxes`] | S 3.2.1 (there towards −z); L 4 (there y and z swapped, mirrored) |
//! | n', n_opt | `warp_near`, [`warp::WarpSpan::optimal_warp_near`] | S eq. 3.2; L 4.1 |
//! | η | `eta`, [`warp::WarpSpan::warp_near`], [`warp::WarpSpan::eta`] | L eq. 11; S eq. 3.4 |
//! | d, z0, z1, α = z1/z0 | [`warp::WarpSpan`] | S 3.2.1 |
//! | guard for γ < Θ | [`warp::guarded_eta`] | L 4.4 |
//! | C (projection centre) | `projection_center` in [`fit::fit_light_view`] | S 4.1 |
//! | P, W, A_fit | `clip_from_light` of [`fit::LightFit`] | S 3.1.2 eq. 3.1, 3.2.1 |
//! | m_x, m_z | [`error::error_across`], [`error::error_along`] | S eq. 2.3 to 2.8; L eq. 7, 8 |
//! | M_x, M_z, S̄ | [`error::LargestErrors`], [`error::largest_errors`] | L eq. 9, 10, 12, section 4.4 |
//! | m, w_l, w_i, cos θ_i / cos θ_l | [`footprint::TexelsOnPixels`] | L eq. 1; S eq. 2.2 |
//! | a; dSdX, dSdY | [`sampling_rate::TexelsPerPixel`]; its Jacobian | S 5.7, A.3 |
//! | η(γ), W_lz | [`warp::reparametrised_eta`], [`warp::frustum_extent`] | S eq. 3.3, 3.5 |
//! | n_p, f_p (pseudo planes), z_vis | [`fit::FitOptions`], [`warp::WarpSpan::levelled_between`] | S 4.2 eq. 4.2; Scherzer 2005, 4.4 |
//! | δ, ξ (80 % rule) | [`warp::trapezoidal_warp_near`] | L 4.1 |
//! | e, C_start | [`fit::ProjectionCenter`] | S 3.2.1, 4.1 |
//! | V_P, middle vector | [`fit::WarpAxis`] | Scherzer 2005, eq. 3, 4.4 |
//! | Δz | [`warp::OptimumRule`] | Scherzer 2005, eq. 1 |
//! | L, l (light frustum, light position) | [`light::Light::half_spaces`], [`light::Light::position`] | S 3.1 |
//! | B = hull(H ∪ {l}) ∩ S ∩ L | [`body::intersection_body_of_light`] | S 3.1.1 |
//! | B of Stamminger and Drettakis | [`body::unfocused_body`] | S 3.1.1, fig. 3.1 |
//! | A_fit of a spot light, e, e + v | [`light::PointLightView::focused`], [`light::aligned_axes`] | S 3.1.2, 3.2.1 |
//! | linear z, near plane of Brabec | [`light::LinearDepth`], [`depth_offset::linear_depth`] | S 3.1.2; L 6.4 |
//! | r, H | [`depth_offset::DepthFormat::step`]; 1 ÷ `depth_per_metre` | Scherzer 2005, 4.2 |
//! | r_l, s_i, l_sc | radius in metres; [`filter::kernel::kernel_per_metre`]; the map's rectangle in the atlas | S 3.6.1, eq. 3.9 |
//! | z0 and iterations of the blur | [`filter::eye_blur::EyeBlur`] | Scherzer 2005, 4.3 |
//! | 64 levels of scale | [`stable::levels::ScaleLevels`] | S 3.5 |
//! | temporal reprojection | [`stable::blend_history`] | Scherzer et al. 2007, cited by S 3.5 |
//! | minimum depth | [`near_plane::DepthChain`], [`near_plane::late_near`] | S 4.3, A.2 |
//! | dp/ds; W, n, d, φ, ψ, dG/dt | [`error::simple_error`]; [`error::Beam`] | S eq. 2.1; 2.2 |
//! | res_s*, res_t*; S_0 | [`error::LargestErrors::critical_resolution`]; [`error::LargestErrors::balanced_resolution`] | L 4.2, eq. 13, 14 |
//! | n, f, Θ under light from overhead | [`analysis::overhead::OverheadRange`] | L 4.1 |
//! | k, j; ZP, FP, W | `slices`, `maps`; [`storage::PartitionScheme`] | L 5.2, 5.3 |
//! | n_p, f_p | [`split::PseudoPlanes`] | S 4.2, eq. 4.1 |
//! | FP, ZP, W | [`face::face_partitions`]; z-partitions: [`split::split_depths`]; [`warp::Warp`] | L 5.1 to 5.3 |
//! | v · y | its sign chooses [`face::FaceSet`]; y is light-space z here | L 5.1 |
//! | e0', e1' and their bisector | `axes.y` of [`face::FacePartition`] | L 5.1 |
//! | k, j | slices per side, maps: [`storage::closed_storage_factor`], [`storage::crossover_maps`] | L eq. 17 to 21, figure 13 |
//! | res_s*, res_t*, S* | [`storage::critical_size`] | L 4.2 |
//! | res_s, res_t for S_0 texels | [`storage::budgeted_size`], [`storage::allocate`] | L eq. 13, 14 |
//! | mask | [`selection::selection_mask`] | L 6.3 |
//! | firstSplit, lastSplit | [`cull::partition_range`] | S 3.3.6 |
//! | n (tiles), θ | `tiles_per_axis`; `margin`: [`virtual_map::tile::filter_margin`] | G 3.3, 3.5 |
//! | a, b (projection) | `scale`, `offset` in [`virtual_map::picture::view_from_picture`] | G eq. 3.1 |
//! | ξ, ξ_max (tiles) | `counts` of [`virtual_map::tile::Tile`], [`virtual_map::queried::QueriedMap::max_tiles_per_axis`] | G 4.3, 4.4 |
//! | η, η_min, f_η | `changed`, [`virtual_map::queried::ChangeThreshold`], `decay` | G 4.3.2, 4.4.2 |
//! | s, s_max; t_max | `tile_size`, `tile_size_max` | G 4.5; 5.9 |
//! | k, l | `splits`, `jumps` of [`virtual_map::queried::Refinement`] | G 4.5 |
//! | Δ, N, R | extent, need, level: [`virtual_map::mapping::need_level`], [`virtual_map::bytes::byte_need`] | G 5.5, 5.6 |
//! | SMTMM, SMTG, SMTGP | [`virtual_map::mapping::TileMappingMap`], [`virtual_map::grid::NeedGrid`] and its levels | G 5.5 to 5.8 |
//! | η_0, η_1 | [`virtual_map::grid::Histogram`]: all levels | G 5.7 |
//! | ξ (quality), p | `quality_drop`, `splits` of a node: [`virtual_map::fitted::FittedMap`] | G 5.11, 5.9 |
//! | ESDB, SRT | [`virtual_map::picture::DepthPicture`]; the shadow result | G 3.3.3, 3.4 |
//! | lexel; l | texel; `place`: −1..=1 on a film | C 1.3, 2.1 |
//! | Ω | pixels that see a surface: [`light_plane::flat::Camera::see`] | C 2.1 |
//! | d = \|dp/dl\| (printed dp/dt, too) | [`light_plane::flat::Sample::badness`] | C 2.1.1 |
//! | θ_t, θ_b; T, B | [`light_plane::flat::Hull`]: their tangents | C 3.1 |
//! | x, dl/dl'; k, s = artanh k | turn; [`light_plane::flat::Tilt`] | C 3.1; k and s are ours |
//! | f, s_p, d_p, d_l, θ_p, θ_l | [`light_plane::flat::PixelFootprint`] | C 1.3.4 |
//! | q (single plane) | [`light_plane::flat::construction::view_plane_point`] | C 2.2.1 |
//! | e_i, x_i, L | [`light_plane::flat::split::Frustum::error`], texels: [`light_plane::flat::allocation`] | C 3.2 |
//! | film (near) plane, P_t M_t⁻¹ | [`light_plane::space::Film`] over a [`light_plane::space::BaseFilm`] | C 1.4, A.2 |
//! | |dp/dl|, x_u² + y_u² + x_v² + y_v² | [`light_plane::space::FilmMetric`] | C 2.1.1, 4.2.1 |
//! | Ω | [`light_plane::space::FilmSample`], summed in [`light_plane::space::FilmMoments`] | C 2.1 |
//! | k | `bend`: w = 1 + k · u | beyond C, for its angle x of the film |
//! | E | `sides` of [`light_plane::space::FilmFrame`] | beyond C, for its extents of the film |
//! | e_i, x_i | `error` of a film; [`light_plane::space::FilmPartition::shares`] | C 3.2 |
//! | `LIGHT_FRUSTA_BUDGET` | [`light_plane::space::MergeLimits`] | C 3.2, Algorithm 2 |
//! | LOD1, LOD2, t | old and new level; `t` of [`lod::crossing::Crossing`] | G 7.2 |
//! | α, z-write (figure 7.2) | [`lod::blend::Coat`], [`lod::blend::coats`] | G 7.2 |

pub mod analysis;
pub mod bias;
pub mod body;
pub mod bounds;
mod clip;
pub mod coverage;
pub mod cull;
pub mod depth_offset;
pub mod drop_in;
pub mod error;
pub mod face;
pub mod filter;
pub mod fit;
pub mod footprint;
mod hull;
pub mod light;
pub mod light_plane;
pub mod lod;
pub mod near_plane;
pub mod polytope;
pub mod sampling_rate;
pub mod selection;
pub mod split;
pub mod stable;
pub mod storage;
pub mod view;
pub mod virtual_map;
pub mod warp;
