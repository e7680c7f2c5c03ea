//! A deer's flesh.

use bevy_math::Vec3;

use super::coat;
use crate::forge::{
    figure::{
        field::{Field, Flesh},
        grow::{Piece, pair},
        joint,
    },
    portable::smooth,
    rig::Joint,
};

/// Collects flesh along named joints.
struct Sculptor<'a> {
    joints: &'a [Joint],
    field: Field,
}

impl Sculptor<'_> {
    fn flesh(&self, joints: [&str; 2], ends: [[f32; 4]; 2], stretch: [f32; 3], blend: f32) -> Flesh {
        Flesh {
            ends: ends.map(|[x, y, z, _]| Vec3::new(x, y, z)),
            radii: ends.map(|[.., radius]| radius),
            stretch: stretch.into(),
            joints: joints.map(|name| joint(self.joints, name)),
            blend,
            carve: false,
        }
    }

    /// Flesh in the middle: ends are x, y, z and radius.
    fn middle(&mut self, joints: [&str; 2], ends: [[f32; 4]; 2], stretch: [f32; 3], blend: f32) {
        self.field.0.push(self.flesh(joints, ends, stretch, blend));
    }

    /// Flesh on the left, and on the right.
    fn pair(&mut self, joints: [&str; 2], ends: [[f32; 4]; 2], stretch: [f32; 3], blend: f32) {
        self.field
            .0
            .extend(pair(self.joints, self.flesh(joints, ends, stretch, blend)));
    }
}

/// Body and antlers.
pub(super) fn pieces(joints: &[Joint], material: usize, stag: bool) -> Vec<Piece> {
    let piece = |field: Field, cell: f32, levels: usize, antler: bool| Piece {
        field,
        cell,
        mirrored: true,
        material,
        coordinates: Box::new(move |p| coat::coordinates(p, antler)),
        importance: Box::new(move |p| if antler { 3.0 } else { importance(p) }),
        levels,
    };
    let mut pieces = vec![piece(body(joints, stag), 0.0095, 3, false)];
    if stag {
        pieces.push(piece(antlers(joints), 0.0075, 3, true));
    }
    pieces
}

/// Legs and head need more triangles than the barrel.
fn importance(p: Vec3) -> f32 {
    let head = smooth(0.62, 0.78, p.z) * smooth(1.25, 1.38, p.y);
    let legs = smooth(0.75, 0.60, p.y);
    1.0 + 6.0 * head + 3.0 * legs
}

fn body(joints: &[Joint], stag: bool) -> Field {
    let mut sculptor = Sculptor {
        joints,
        field: Field::default(),
    };
    trunk(&mut sculptor);
    neck_and_head(&mut sculptor, stag);
    legs(&mut sculptor);
    sculptor.field
}

fn trunk(s: &mut Sculptor) {
    let narrow = [0.83, 1.0, 1.0];
    s.middle(
        ["chest", "spine"],
        [[0.0, 0.945, 0.26, 0.225], [0.0, 0.955, -0.08, 0.225]],
        narrow,
        0.0,
    );
    s.middle(
        ["spine", "hips"],
        [[0.0, 0.955, -0.08, 0.225], [0.0, 1.005, -0.44, 0.185]],
        narrow,
        0.05,
    );
    s.middle(
        ["hips", "hips"],
        [[0.0, 1.01, -0.46, 0.180], [0.0, 0.99, -0.60, 0.145]],
        [0.85, 1.0, 1.0],
        0.06,
    );
    s.middle(
        ["chest", "spine"],
        [[0.0, 1.125, 0.20, 0.085], [0.0, 1.10, -0.10, 0.085]],
        [1.0; 3],
        0.10,
    );
    s.middle(
        ["spine", "hips"],
        [[0.0, 1.10, -0.10, 0.085], [0.0, 1.115, -0.48, 0.085]],
        [1.0; 3],
        0.10,
    );
    s.middle(
        ["chest", "chest"],
        [[0.0, 0.90, 0.36, 0.14], [0.0, 0.83, 0.26, 0.13]],
        [0.85, 1.0, 1.0],
        0.08,
    );
    s.middle(
        ["tail", "tail"],
        [[0.0, 1.075, -0.70, 0.042], [0.0, 0.965, -0.765, 0.022]],
        [1.1, 1.0, 0.8],
        0.04,
    );
}

fn neck_and_head(s: &mut Sculptor, stag: bool) {
    let narrow = [0.78, 1.0, 1.0];
    let thick = if stag { 1.0 } else { 0.82 };
    let base = [0.0, 1.00, 0.36, 0.165];
    let half = [0.0, 1.22, 0.595, 0.112 * thick];
    s.middle(["neck_low", "neck_high"], [base, half], narrow, 0.10);
    s.middle(
        ["neck_high", "head"],
        [half, [0.0, 1.46, 0.715, 0.074 * thick]],
        narrow,
        0.06,
    );
    if stag {
        // The mane hangs below the neck.
        s.middle(
            ["neck_low", "neck_high"],
            [[0.0, 0.93, 0.44, 0.12], [0.0, 1.14, 0.625, 0.10]],
            narrow,
            0.07,
        );
        s.middle(
            ["neck_high", "neck_high"],
            [[0.0, 1.14, 0.625, 0.10], [0.0, 1.33, 0.715, 0.06]],
            narrow,
            0.06,
        );
    }
    s.middle(
        ["head", "head"],
        [[0.0, 1.515, 0.745, 0.078], [0.0, 1.492, 0.83, 0.064]],
        [0.86, 1.0, 1.0],
        0.04,
    );
    s.middle(
        ["head", "head"],
        [[0.0, 1.492, 0.83, 0.060], [0.0, 1.405, 1.035, 0.036]],
        [0.80, 1.0, 1.0],
        0.03,
    );
    s.middle(
        ["head", "head"],
        [[0.0, 1.435, 0.80, 0.050], [0.0, 1.385, 0.99, 0.026]],
        [0.80, 1.0, 1.0],
        0.03,
    );
    s.middle(
        ["head", "head"],
        [[0.0, 1.412, 1.04, 0.033], [0.0, 1.395, 1.05, 0.030]],
        [1.0; 3],
        0.02,
    );
    // Brow and cheek.
    s.pair(
        ["head", "head"],
        [[0.042, 1.528, 0.80, 0.024], [0.034, 1.500, 0.87, 0.020]],
        [1.0; 3],
        0.02,
    );
    let flat = [1.0, 1.0, 0.42];
    s.pair(
        ["head", "ear_l"],
        [[0.052, 1.555, 0.700, 0.018], [0.125, 1.622, 0.675, 0.042]],
        flat,
        0.02,
    );
    s.pair(
        ["ear_l", "ear_l"],
        [[0.125, 1.622, 0.675, 0.042], [0.200, 1.668, 0.655, 0.008]],
        flat,
        0.01,
    );
}

fn legs(s: &mut Sculptor) {
    let flat = [0.72, 1.0, 1.0];
    s.pair(
        ["scapula_l", "humerus_l"],
        [[0.085, 1.04, 0.22, 0.10], [0.115, 0.86, 0.35, 0.098]],
        flat,
        0.08,
    );
    s.pair(
        ["humerus_l", "radius_l"],
        [[0.115, 0.86, 0.35, 0.090], [0.10, 0.73, 0.265, 0.070]],
        flat,
        0.06,
    );
    s.pair(
        ["radius_l", "radius_l"],
        [[0.10, 0.73, 0.265, 0.060], [0.10, 0.45, 0.285, 0.031]],
        [0.9, 1.0, 1.0],
        0.04,
    );
    s.pair(
        ["radius_l", "cannon_l"],
        [[0.10, 0.435, 0.290, 0.033], [0.10, 0.385, 0.288, 0.029]],
        [1.0; 3],
        0.02,
    );
    s.pair(
        ["cannon_l", "cannon_l"],
        [[0.10, 0.385, 0.285, 0.024], [0.10, 0.15, 0.275, 0.021]],
        [1.0; 3],
        0.02,
    );
    s.pair(
        ["cannon_l", "hoof_l"],
        [[0.10, 0.135, 0.272, 0.027], [0.10, 0.120, 0.275, 0.027]],
        [1.0; 3],
        0.015,
    );
    s.pair(
        ["hoof_l", "hoof_l"],
        [[0.10, 0.120, 0.278, 0.023], [0.10, 0.055, 0.312, 0.026]],
        [1.0; 3],
        0.015,
    );
    s.pair(
        ["hoof_l", "hoof_l"],
        [[0.10, 0.036, 0.318, 0.034], [0.10, 0.016, 0.350, 0.020]],
        [1.0; 3],
        0.012,
    );
    s.pair(
        ["femur_l", "tibia_l"],
        [[0.085, 0.985, -0.50, 0.150], [0.115, 0.79, -0.39, 0.100]],
        flat,
        0.07,
    );
    s.pair(
        ["femur_l", "tibia_l"],
        [[0.080, 0.96, -0.60, 0.105], [0.105, 0.74, -0.51, 0.070]],
        flat,
        0.07,
    );
    s.pair(
        ["tibia_l", "tibia_l"],
        [[0.112, 0.78, -0.405, 0.082], [0.11, 0.56, -0.625, 0.036]],
        [0.85, 1.0, 1.0],
        0.06,
    );
    s.pair(
        ["tibia_l", "metatarsus_l"],
        [[0.11, 0.575, -0.675, 0.018], [0.11, 0.50, -0.645, 0.032]],
        [1.0; 3],
        0.03,
    );
    s.pair(
        ["metatarsus_l", "metatarsus_l"],
        [[0.11, 0.50, -0.645, 0.029], [0.11, 0.15, -0.578, 0.022]],
        [1.0; 3],
        0.02,
    );
    s.pair(
        ["metatarsus_l", "hind_hoof_l"],
        [[0.11, 0.14, -0.578, 0.028], [0.11, 0.12, -0.573, 0.027]],
        [1.0; 3],
        0.015,
    );
    s.pair(
        ["hind_hoof_l", "hind_hoof_l"],
        [[0.11, 0.12, -0.57, 0.023], [0.11, 0.055, -0.538, 0.026]],
        [1.0; 3],
        0.015,
    );
    s.pair(
        ["hind_hoof_l", "hind_hoof_l"],
        [[0.11, 0.036, -0.532, 0.034], [0.11, 0.016, -0.50, 0.020]],
        [1.0; 3],
        0.012,
    );
}

/// Twelve points: two beams with brow, bez and trez tine and a crown of three.
fn antlers(joints: &[Joint]) -> Field {
    let mut sculptor = Sculptor {
        joints,
        field: Field::default(),
    };
    let beams: [&[[f32; 4]]; 6] = [
        &[
            [0.045, 1.555, 0.735, 0.026],
            [0.075, 1.615, 0.705, 0.021],
            [0.170, 1.735, 0.615, 0.020],
            [0.300, 1.925, 0.540, 0.019],
            [0.350, 2.100, 0.535, 0.018],
            [0.310, 2.290, 0.610, 0.006],
        ],
        &[
            [0.075, 1.620, 0.715, 0.017],
            [0.105, 1.660, 0.860, 0.014],
            [0.115, 1.790, 0.960, 0.005],
        ],
        &[
            [0.130, 1.690, 0.650, 0.016],
            [0.190, 1.740, 0.770, 0.012],
            [0.215, 1.850, 0.830, 0.005],
        ],
        &[
            [0.290, 1.900, 0.545, 0.016],
            [0.360, 1.940, 0.680, 0.012],
            [0.385, 2.060, 0.740, 0.005],
        ],
        &[
            [0.350, 2.090, 0.535, 0.016],
            [0.430, 2.200, 0.505, 0.011],
            [0.440, 2.285, 0.530, 0.005],
        ],
        &[
            [0.348, 2.090, 0.535, 0.016],
            [0.345, 2.210, 0.430, 0.011],
            [0.310, 2.290, 0.400, 0.005],
        ],
    ];
    for beam in beams {
        for ends in beam.windows(2) {
            sculptor.pair(["head", "head"], [ends[0], ends[1]], [1.0; 3], 0.012);
        }
    }
    sculptor.field
}
