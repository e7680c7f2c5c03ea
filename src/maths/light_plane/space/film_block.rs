//! [`FilmBlock`]: a block of pixels on a film.

use bevy_math::DVec2;

use super::FilmSample;

/// A block on the base film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmBlock {
    /// Stands for the block's pixels; `None` where the surface says nothing about films ([`Unsampled`](super::Unsampled)).
    pub sample: Option<FilmSample>,
    /// The ends of the rays through the block's corners, in turn: all its pixels lie in the hexahedron between them. The
    /// ends are at the depths of the nearest and of the farthest pixel, or on two planes that are closer to each other:
    /// all that one surface needs.
    pub corners: [[BlockCorner; 2]; 4],
    /// View depths of the nearest and of the farthest pixel: w of the camera's matrix.
    pub depths: [f64; 2],
    /// View depths where the hexahedron is cut off.
    pub(super) cut: [f64; 2],
}

/// A corner of a block: where it lies on the base film, and its view depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BlockCorner {
    /// On the base film.
    pub place: DVec2,
    /// w of the camera's matrix.
    pub depth: f64,
}

impl FilmBlock {
    /// The whole hexahedron.
    pub(super) const UNCUT: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// The part of the block between two view depths; `None` if there is none. The sample stays with the part that has its
    /// depth, of two neighbours with the farther one.
    pub fn between(&self, near: f64, far: f64) -> Option<Self> {
        let [first, last] = self.depths;
        if first >= far || last < near {
            return None;
        }
        let [cut_near, cut_far] = self.cut;
        Some(Self {
            sample: self.sample.filter(|sample| (near..far).contains(&sample.depths[0])),
            corners: self.corners,
            depths: [first.max(near), last.min(far)],
            cut: [
                if near > first { near } else { cut_near },
                if far < last { far } else { cut_far },
            ],
        })
    }

    /// Points whose hull holds all pixels of the block: the corners of the hexahedron, and of its cuts. Places on the film
    /// of the sun and view depths are linear along its edges.
    pub fn points(&self) -> Vec<DVec2> {
        let [near, far] = self.cut;
        let corners = self.corners.as_flattened().iter();
        let mut points: Vec<DVec2> = corners
            .filter(|corner| (near..=far).contains(&corner.depth))
            .map(|corner| corner.place)
            .collect();
        for cut in self.cut.into_iter().filter(|cut| cut.is_finite()) {
            points.extend(self.edges().filter_map(|[a, b]| {
                let share = (cut - a.depth) / (b.depth - a.depth);
                (0.0..=1.0).contains(&share).then(|| a.place.lerp(b.place, share))
            }));
        }
        points
    }

    fn edges(&self) -> impl Iterator<Item = [BlockCorner; 2]> + '_ {
        (0..4).flat_map(|corner| {
            let ([near, far], [next_near, next_far]) = (self.corners[corner], self.corners[(corner + 1) % 4]);
            [[near, far], [near, next_near], [far, next_far]]
        })
    }
}
