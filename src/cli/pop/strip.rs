//! What was watched at one place, and the film strip of it.

use bevy::math::UVec2;

use crate::{
    lod::{LodCounts, settings::LodKind},
    plot::{Pixels, PlotError, Sheet},
    render::capture::Texels,
};

/// Frames of a strip after the one before the largest pop.
const OFFSETS: [usize; 7] = [0, 1, 4, 8, 12, 18, 26];
/// Pixels of a picture of the strip, at most.
const CROP: UVec2 = UVec2::new(64, 48);
/// Times that it is enlarged.
const SCALE: u32 = 3;

/// The pictures of one kind at one place.
pub(super) struct Watched {
    pub(super) kind: LodKind,
    pictures: Vec<Texels>,
    /// Energy of the change to each picture but the first.
    pub(super) energies: Vec<f64>,
    /// Most objects that showed two levels at once.
    pub(super) most_crossings: u32,
    /// Most parts that were drawn beside those of levels at rest.
    pub(super) most_fading_parts: u32,
}

impl Watched {
    pub(super) fn new(kind: LodKind, first: Texels) -> Self {
        Self {
            kind,
            pictures: vec![first],
            energies: Vec::new(),
            most_crossings: 0,
            most_fading_parts: 0,
        }
    }

    pub(super) fn add(&mut self, picture: Texels, energy: f64, counts: LodCounts) {
        self.pictures.push(picture);
        self.energies.push(energy);
        self.most_crossings = self.most_crossings.max(counts.crossings);
        self.most_fading_parts = self.most_fading_parts.max(counts.fading_parts);
    }

    pub(super) fn last(&self) -> &Texels {
        &self.pictures[self.pictures.len() - 1]
    }

    /// The frame whose change is seen most, from 1, and its energy; zeros without frames.
    pub(super) fn peak(&self) -> (usize, f64) {
        let peak = self.energies.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        peak.map_or((0, 0.0), |(index, energy)| (index + 1, *energy))
    }
}

/// One row per kind: what happens around the first kind's largest pop, where it changes most.
pub(super) fn draw(watched: &[Watched]) -> Result<Pixels, PlotError> {
    let first = &watched[0];
    let peak = first.peak().0.max(1);
    let (before, after) = (&first.pictures[peak - 1], &first.pictures[peak]);
    let size = UVec2::new(before.width, before.height);
    let crop = CROP.min(size);
    let corner = busiest(size, crop, &before.bytes, &after.bytes);
    let mut cells = Vec::new();
    for kind in watched {
        // Dither ends where others begin.
        let begin = match kind.kind {
            LodKind::Dither => peak.saturating_sub(25),
            _ => peak - 1,
        };
        for offset in OFFSETS {
            let frame = (begin + offset).min(kind.pictures.len() - 1);
            let label = format!("{}, frame {frame}", kind.kind.name());
            cells.push((label, enlarged(&kind.pictures[frame], corner, crop)));
        }
    }
    let columns = OFFSETS.len() as u32;
    Sheet { columns, cells }.draw()
}

/// The corner of the part of two pictures with the largest change, on a raster of a quarter of its size.
fn busiest(size: UVec2, crop: UVec2, before: &[u8], after: &[u8]) -> UVec2 {
    let step = (crop / 4).max(UVec2::ONE);
    let change = |corner: UVec2| -> u64 {
        let rows = corner.y..corner.y + crop.y;
        let row = |y: u32| {
            let start = ((y * size.x + corner.x) * 4) as usize;
            let range = start..start + (crop.x * 4) as usize;
            let pairs = before[range.clone()].iter().zip(&after[range]);
            pairs.map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum::<u64>()
        };
        rows.map(row).sum()
    };
    let free = size - crop;
    let corners = (0..=free.y).step_by(step.y as usize).flat_map(|y| {
        let xs = (0..=free.x).step_by(step.x as usize);
        xs.map(move |x| UVec2::new(x, y))
    });
    corners.max_by_key(|corner| change(*corner)).unwrap_or_default()
}

fn enlarged(picture: &Texels, corner: UVec2, crop: UVec2) -> Pixels {
    let size = crop * SCALE;
    let mut bytes = Vec::with_capacity((size.x * size.y * 3) as usize);
    for y in 0..size.y {
        for x in 0..size.x {
            let from = corner + UVec2::new(x, y) / SCALE;
            let start = ((from.y * picture.width + from.x) * 4) as usize;
            bytes.extend_from_slice(&picture.bytes[start..start + 3]);
        }
    }
    Pixels { size, bytes }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strip_looks_where_something_happens() {
        let size = UVec2::new(400, 300);
        let before = vec![0; (size.x * size.y * 4) as usize];
        let mut after = before.clone();
        let spot = UVec2::new(310, 40);
        after[((spot.y * size.x + spot.x) * 4) as usize] = 200;
        let corner = busiest(size, CROP, &before, &after);
        assert!(
            corner.cmple(spot).all() && (corner + CROP).cmpgt(spot).all(),
            "{corner}"
        );
        assert!((corner + CROP).cmple(size).all());
    }
}
