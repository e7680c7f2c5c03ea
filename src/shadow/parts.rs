//! [`Part`]: what the view frustum is cut into; each part gets a light view.

use bevy::math::DVec3;

use super::{
    measured::DepthPlan,
    settings::{Faces, PartitionSelection, SeamWidth, SunShadows},
};
use crate::maths::{
    body::{intersection_body, light_visible},
    bounds::Bounds,
    face::{FaceOptions, FaceSet, FrustumFace, face_partitions},
    fit::{FitOptions, WarpAxis},
    polytope::Polytope,
    split::SplitScheme,
    view::ViewVolume,
    warp::Warp,
};

/// A part of what is seen, and how its light view is fitted.
#[derive(Clone)]
pub(super) struct Part {
    /// The slice of the view volume that it lies in.
    pub(super) slice: ViewVolume,
    /// View depths between which its map is meant to be used, in metres.
    pub(super) depths: [f64; 2],
    /// Length of view depth at the end of the interval over which the next map takes over, in metres.
    pub(super) seam: f64,
    /// H: the receivers.
    pub(super) visible: Polytope,
    /// B: H and what casts shadows into it.
    pub(super) body: Polytope,
    /// Its warp.
    pub(super) warp: Warp,
    /// How it is fitted.
    pub(super) options: FitOptions,
    /// Its place among equal maps: the same from frame to frame.
    pub(super) slot: u32,
}

/// What is cut.
pub(super) struct Cutter<'a> {
    /// What the camera sees.
    pub(super) view: &'a ViewVolume,
    /// What is known of the depths in the picture.
    pub(super) plan: &'a DepthPlan,
    /// Bounds of what receives shadows.
    pub(super) receivers: Bounds,
    /// Bounds of the scene.
    pub(super) scene: Bounds,
    /// Direction in which light travels.
    pub(super) light_travel: DVec3,
    /// Settings in range.
    pub(super) settings: &'a SunShadows,
    /// Split distances in metres of view depth.
    pub(super) depths: &'a [f64],
}

impl Cutter<'_> {
    /// The parts, and the set of faces that they were chosen from, if there are face partitions. `previous` is the set of
    /// the frame before.
    pub(super) fn parts(&self, previous: Option<FaceSet>) -> (Vec<Part>, Option<FaceSet>) {
        match self.settings.partitions.faces {
            Faces::Together => (self.slices(), None),
            Faces::Apart { near_map } => self.faces(near_map, previous),
        }
    }

    /// Everything between two view depths, as one part without a warp.
    pub(super) fn whole(&self, near: f64, far: f64) -> Part {
        let part = self.slice(0, [near, far], 0.0);
        Part {
            warp: Warp::Uniform,
            ..part
        }
    }

    /// One part per z-partition. Where maps are blended by depth, each reaches into the seam in front of it.
    fn slices(&self) -> Vec<Part> {
        let count = self.depths.len().saturating_sub(1);
        let seam = |index: usize| match self.depths.get(index..index + 3) {
            Some([start, end, _]) => self.seam(end - start),
            // Nothing takes over behind the last.
            _ => 0.0,
        };
        (0..count)
            .map(|index| {
                let lead = if index == 0 { 0.0 } else { seam(index - 1) };
                let range = [self.depths[index], self.depths[index + 1]];
                let mut part = self.slice(index, [range[0] - lead, range[1]], seam(index));
                part.depths = range;
                part
            })
            .collect()
    }

    /// Length of the seam at the end of a partition of this length, in metres of view depth.
    fn seam(&self, length: f64) -> f64 {
        match (self.settings.selection, self.settings.seams.width) {
            (PartitionSelection::Depth, SeamWidth::Share(share)) => length * f64::from(share),
            (PartitionSelection::Depth, SeamWidth::Metres(metres)) => f64::from(metres).min(length),
            _ => 0.0,
        }
    }

    fn slice(&self, index: usize, depths: [f64; 2], seam: f64) -> Part {
        let slice = self.view.split(depths[0], depths[1]);
        let visible = light_visible(&slice, &self.receivers);
        Part {
            body: intersection_body(&visible, &self.scene, self.light_travel),
            visible,
            slice,
            depths,
            seam,
            warp: self.warp(index),
            options: self.options(),
            slot: index as u32,
        }
    }

    /// How light views are fitted: as the settings say, and to the depths that the picture has shown.
    fn options(&self) -> FitOptions {
        let of_settings = self.settings.fit.options(self.light_travel);
        FitOptions {
            pseudo_near: of_settings
                .pseudo_near
                .into_iter()
                .chain(self.plan.near)
                .reduce(f64::max),
            visible_far: self.plan.far,
            ..of_settings
        }
    }

    /// The warp of a slice.
    fn warp(&self, slice: usize) -> Warp {
        match (self.settings.warp, self.settings.partitions.etas.get(slice)) {
            _ if !self.settings.fit.align => Warp::Uniform,
            (Warp::Free { .. }, Some(eta)) => Warp::Free { eta: *eta },
            (warp, _) => warp,
        }
    }

    /// One part per slice of each face.
    fn faces(&self, near_map: bool, previous: Option<FaceSet>) -> (Vec<Part>, Option<FaceSet>) {
        let slices = self.settings.partitions.count;
        let inner = self.depths.get(1..self.depths.len().saturating_sub(1));
        let options = FaceOptions {
            slices: slices as usize,
            scheme: SplitScheme::Manual(inner.unwrap_or(&[]).iter().map(|depth| *depth as f32).collect()),
            near_partition: near_map,
            warp: true,
            previous,
        };
        let visible = light_visible(self.view, &self.receivers);
        let partitions = face_partitions(self.view, &visible, self.light_travel, &options);
        let set = partitions.first().map(|partition| partition.set);
        let of_settings = self.options();
        let parts = partitions.into_iter().map(|partition| {
            let side = match partition.face {
                FrustumFace::All | FrustumFace::Bottom => 0,
                FrustumFace::Right => 1,
                FrustumFace::Top => 2,
                FrustumFace::Left => 3,
                FrustumFace::Near => 4,
            };
            Part {
                slice: self.view.split(partition.depths[0], partition.depths[1]),
                depths: partition.depths,
                seam: 0.0,
                body: intersection_body(&partition.receivers, &self.scene, self.light_travel),
                warp: if partition.warped {
                    self.warp(partition.slice)
                } else {
                    Warp::Uniform
                },
                options: FitOptions {
                    axis: match of_settings.axis {
                        fixed @ WarpAxis::Direction(_) => fixed,
                        _ => WarpAxis::Direction(partition.axes.y),
                    },
                    face_start: Some(partition.near_along),
                    ..of_settings
                },
                slot: side * slices + partition.slice as u32,
                visible: partition.receivers,
            }
        });
        (parts.collect(), set)
    }
}
