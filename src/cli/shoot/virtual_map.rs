//! The virtual map of a take: its tiles, what they cost and why they were drawn.

use bevy::prelude::*;
use serde::Serialize;

use super::stats::Maps;
use crate::{
    maths::virtual_map::{picture::PixelRect, queried::Decision},
    render::virtual_map::{
        fitted::plan::FittedCounts,
        report::{DrawnTile, VirtualMapReport, VirtualMapReports},
    },
};

/// One camera's virtual map.
#[derive(Clone, Debug, Serialize)]
pub(in crate::cli) struct VirtualMapStats {
    /// Texels per axis of one map with the resolution of the finest tile.
    effective_resolution: u64,
    /// Texels drawn, margins included.
    texels: u64,
    /// Bytes of tile textures alive at once.
    texture_bytes: u64,
    /// Bytes of its other buffers, without draws and shadow result.
    buffer_bytes: u64,
    /// k of the 1 + 4 k + l tiles of a queried map.
    splits: u32,
    /// l.
    jumps: u32,
    /// How often the frame waited for the GPU.
    read_backs: u32,
    /// What a fitted map measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    needs: Option<NeedStats>,
    /// In the order in which they were applied.
    tiles: Vec<TileStats>,
}

/// What a fitted map measured before it was drawn.
#[derive(Clone, Debug, Serialize)]
struct NeedStats {
    /// Cells per axis of the grid of needs.
    cells: u32,
    /// Pixels, or texels of a mapping map, that look into the map.
    pixels: u64,
    /// Share of them that need more than the finest tiles have: their texels are coarser than asked for.
    capped_percent: f64,
    /// Share of all whose surface lies beside the map: they are lit.
    outside_percent: f64,
    /// At most so many were left out by the discard rule.
    discarded: u64,
    /// Waiting for the GPU.
    read_back_ms: f64,
    /// Grid, pyramid and traversal on the CPU.
    planning_ms: f64,
}

impl From<&FittedCounts> for NeedStats {
    fn from(counts: &FittedCounts) -> Self {
        Self {
            cells: counts.cells,
            pixels: counts.pixels,
            capped_percent: counts.capped_percent(),
            outside_percent: counts.outside_percent(),
            discarded: counts.discarded,
            read_back_ms: counts.read_back.as_secs_f64() * 1.0e3,
            planning_ms: counts.planning.as_secs_f64() * 1.0e3,
        }
    }
}

/// One tile.
#[derive(Clone, Debug, Serialize)]
struct TileStats {
    /// Column and row from the top left of the map.
    place: [u32; 2],
    /// Tiles per axis.
    counts: [u32; 2],
    /// Texels drawn.
    size: [u32; 2],
    /// Texels on each side that belong to the neighbours.
    margin: u32,
    /// Pixels of the picture that it was applied to: first column and row, and one after the last.
    rect: [u32; 4],
    /// Pixels of the shadow result that it changed, and that lie in it, where they were counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    changed: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    inside: Option<u32>,
    /// What became of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    decision: Option<&'static str>,
}

impl From<&DrawnTile> for TileStats {
    fn from(drawn: &DrawnTile) -> Self {
        Self {
            place: drawn.draw.tile.place.to_array(),
            counts: drawn.draw.tile.counts.to_array(),
            size: drawn.draw.window.size.to_array(),
            margin: drawn.draw.window.margin,
            rect: {
                let PixelRect { min, max } = drawn.draw.rect;
                [min.x, min.y, max.x, max.y]
            },
            changed: drawn.report.map(|report| report.changed),
            inside: drawn.report.map(|report| report.inside),
            decision: drawn.decision.map(|decision| match decision {
                Decision::Final => "final",
                Decision::MaximumJump => "maximum jump",
                Decision::OpportunityJump => "opportunity jump",
                Decision::Split => "split",
                Decision::Dropped => "dropped",
            }),
        }
    }
}

impl From<&VirtualMapReport> for VirtualMapStats {
    fn from(report: &VirtualMapReport) -> Self {
        Self {
            effective_resolution: report.effective_resolution(),
            texels: report.texels(),
            texture_bytes: report.texture_bytes,
            buffer_bytes: report.buffer_bytes,
            splits: report.splits,
            jumps: report.jumps,
            read_backs: report.read_backs,
            needs: report.fitted.as_ref().map(NeedStats::from),
            tiles: report.tiles.iter().map(TileStats::from).collect(),
        }
    }
}

/// What the camera's virtual map was in the frame just drawn.
pub(in crate::cli) fn report_of(app: &App, camera: Entity) -> Option<VirtualMapReport> {
    app.world().get_resource::<VirtualMapReports>()?.get(camera)
}

/// The same for the file.
pub(in crate::cli) fn stats_of(app: &App, camera: Entity) -> Option<VirtualMapStats> {
    report_of(app, camera).as_ref().map(VirtualMapStats::from)
}

/// Tiles as maps.
pub(super) fn maps_of(report: &VirtualMapReport, fallback_size: u32) -> Maps {
    let fallback = u64::from(fallback_size).pow(2);
    Maps {
        count: u32::try_from(report.tiles.len()).unwrap_or(u32::MAX),
        size: u32::try_from(report.effective_resolution()).unwrap_or(u32::MAX),
        fallback_size,
        texels: report.texels() + fallback,
        bytes: report.texture_bytes + fallback * size_of::<f32>() as u64,
    }
}
