//! Virtual shadow maps: a map far larger than any texture, of which only tiles are drawn (Giegl 2007, chapters 3 to 5).
//!
//! Every form takes one light view of the whole map, fitted and warped in any way, and cuts its clip box into tiles:
//!
//! * [`tiled`]: all of them, at full size. The reference.
//! * [`queried`]: coarse to fine, as long as the picture changes.
//! * [`fitted`]: the picture's depths say beforehand what is needed where: [`mapping`] → [`grid`] → [`fitted`].
//!
//! ```
//! use bevy_math::{DMat4, DVec3, UVec2};
//! use umbrage::maths::virtual_map::{
//!     fitted::FittedMap,
//!     grid::{GridOptions, NeedGrid},
//!     mapping::{MappingOptions, TileMappingMap},
//!     picture::DepthPicture,
//! };
//!
//! // A wall 10 m in front of a camera that looks along −z; light from behind the camera onto 400 m of it.
//! let size = UVec2::splat(64);
//! let clip_from_world = DMat4::perspective_infinite_reverse_rh(60_f64.to_radians(), 1.0, 0.1);
//! let depths = vec![0.1 / 10.0; 64 * 64];
//! let picture = DepthPicture::new(size, &depths, clip_from_world.inverse()).unwrap();
//! let light = DMat4::from_translation(DVec3::Z * 0.5) * DMat4::from_scale(DVec3::new(1.0 / 200.0, 1.0 / 200.0, 1.0 / 1000.0));
//!
//! let map = TileMappingMap::new(&picture, &light, size, &MappingOptions::default());
//! let settings = FittedMap::default();
//! let options = GridOptions { tiles_per_axis: settings.grid_tiles_per_axis(), ..GridOptions::default() };
//! let plan = settings.plan(&NeedGrid::new(&map, &options));
//! assert_eq!(plan.tiles.len(), 1, "2217 texels across the map: one tile of 4096");
//! ```
//!
//! # Steps of a frame
//!
//! Each GPU step has its twin here; the modules say what an invocation does.
//!
//! | step | reads | writes | twin |
//! |---|---|---|---|
//! | `mapping` | depth, `map_from_picture` | cells (atomics), or a mapping map that is read back | [`mapping::pixel_need`] |
//! | `pyramid` | cells | parents | [`grid::NeedGrid`] |
//! | `plan` | pyramid | tiles, indirect draws | [`fitted::FittedMap::plan`] |
//! | raster passes | `array<TileUniform>` | depth, one viewport per tile | [`tile::Tile::clip_from_world`] |
//! | `apply` | depth, tile depth, `TileUniform` | shadow result; reports (queried) | [`tile::Tile::contains`], [`tile::Tile::texture_uv`], [`queried::changed_result`] |
//! | `decide` | reports | tiles of the next level, jumps | [`queried::QueriedMap::decide`] |
//!
//! ```wgsl
//! struct TileUniform {
//!     clip_from_world: mat4x4<f32>,   // crop · map, composed in double precision
//!     place: vec2<u32>, counts: vec2<u32>,
//!     size: vec2<u32>, margin: u32, texture: u32,
//!     rect: vec4<u32>,                // min, max
//! }
//! struct NeedCell { need_x: atomic<u32>, need_y: atomic<u32>, pixels: atomic<u32>, rect: array<atomic<u32>, 4> }
//! struct TileReport { changed: atomic<u32>, inside: atomic<u32>, rect: array<atomic<u32>, 4> }
//! ```
//!
//! A tiled map is `raster` and `apply` over the whole picture, tile by tile, through one texture.
//!
//! # Memory
//!
//! Besides the tile textures, which [`memory`] bounds: the shadow result, 1 byte per pixel; the grid, 32 bytes per cell
//! and a third more for the pyramid (43 KiB for n = 32, 43 MiB for 1024), 256 more per cell with a histogram; a mapping
//! map that is read back, 4 bytes per texel as bytes, 20 as numbers.
//!
//! # Agreement of both sides
//!
//! The shaders decide in single precision. A need that lies within 10⁻⁵ of a whole level may be rounded to the other
//! side there, so plans are compared with tolerance, pictures without: any plan that is fine enough is right. But
//! within a frame `mapping` and `apply` must compute the same place for a pixel, by the same function from the same
//! inputs, or a pixel on the border of a tile finds itself in a cell that no one asked for.

pub mod bytes;
pub mod feedback;
pub mod fitted;
pub mod grid;
pub mod mapping;
pub mod memory;
pub mod picture;
pub mod queried;
pub mod reach;
mod thrift;
pub mod tile;
pub mod tiled;
pub mod transparent;
