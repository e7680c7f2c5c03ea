//! People's flesh and clothes.

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    figure::{
        field::{Field, Flesh},
        grow::{Piece, pair},
        joint,
    },
    portable::smooth,
    rig::Joint,
    texture::picture::{Channels, Picture},
};

/// Colours that are not tinted (sRGB).
const PALETTE: [[u8; 3]; 8] = [
    [205, 152, 122],
    [58, 40, 28],
    [38, 44, 62],
    [92, 82, 66],
    [48, 33, 25],
    [26, 26, 28],
    [122, 84, 48],
    [150, 112, 66],
];
const SKIN: usize = 0;
const DARK_HAIR: usize = 1;
const NAVY: usize = 2;
const KHAKI: usize = 3;
const BROWN: usize = 4;
const BLACK: usize = 5;
const LEATHER: usize = 6;
const FAIR_HAIR: usize = 7;
/// Texels per side of a colour's square.
const SQUARE: usize = 8;

/// What someone wears.
pub(super) struct Outfit {
    pub(super) name: &'static str,
    /// Height of the upper garment's hem in metres.
    hem: f32,
    long_hair: bool,
    hat: bool,
    bag: bool,
    hair: usize,
    trousers: usize,
    shoes: usize,
    /// Factor on the width of the shoulders.
    shoulders: f32,
}

pub(super) const OUTFITS: [Outfit; 3] = [
    Outfit {
        name: "walker_jacket",
        hem: 0.83,
        long_hair: false,
        hat: false,
        bag: false,
        hair: DARK_HAIR,
        trousers: NAVY,
        shoes: BROWN,
        shoulders: 1.0,
    },
    Outfit {
        name: "walker_coat",
        hem: 0.56,
        long_hair: true,
        hat: false,
        bag: true,
        hair: FAIR_HAIR,
        trousers: BLACK,
        shoes: LEATHER,
        shoulders: 0.9,
    },
    Outfit {
        name: "walker_hat",
        hem: 0.80,
        long_hair: false,
        hat: true,
        bag: false,
        hair: DARK_HAIR,
        trousers: KHAKI,
        shoes: BLACK,
        shoulders: 1.03,
    },
];

/// The untinted colours, side by side.
pub(super) fn palette() -> Picture {
    Picture::from_fn("walker", SQUARE * PALETTE.len(), SQUARE, Channels::Rgb, |x, _| {
        let [r, g, b] = PALETTE[x / SQUARE];
        [r, g, b, 255]
    })
}

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

    fn middle(&mut self, joints: [&str; 2], ends: [[f32; 4]; 2], stretch: [f32; 3], blend: f32) {
        self.field.0.push(self.flesh(joints, ends, stretch, blend));
    }

    fn pair(&mut self, joints: [&str; 2], ends: [[f32; 4]; 2], stretch: [f32; 3], blend: f32) {
        self.field
            .0
            .extend(pair(self.joints, self.flesh(joints, ends, stretch, blend)));
    }

    fn carve(&mut self, ends: [[f32; 4]; 2], stretch: [f32; 3], blend: f32) {
        let flesh = self.flesh(["hips", "hips"], ends, stretch, blend);
        self.field.0.push(Flesh { carve: true, ..flesh });
    }

    /// Takes away all that is below a height, within 0.6 m of the middle.
    fn cut_below(&mut self, height: f32) {
        self.carve(
            [[0.0, height - 0.3, 0.0, 0.3], [0.0, height - 0.3, 0.0, 0.3]],
            [20.0, 1.0, 20.0],
            0.006,
        );
    }

    fn done(&mut self) -> Field {
        std::mem::take(&mut self.field)
    }
}

/// All surfaces of a person; `materials` are the tinted one and the one with the palette.
pub(super) fn pieces(joints: &[Joint], outfit: &Outfit, [cloth, rest]: [usize; 2]) -> Vec<Piece> {
    let mut s = Sculptor {
        joints,
        field: Field::default(),
    };
    let piece = |field: Field, material: usize, color: usize, levels: usize| Piece {
        field,
        cell: 0.009,
        mirrored: true,
        material,
        coordinates: Box::new(move |_| Vec2::new((color as f32 + 0.5) / PALETTE.len() as f32, 0.5)),
        importance: Box::new(importance),
        levels,
    };
    garment(&mut s, outfit);
    let mut pieces = vec![piece(s.done(), cloth, SKIN, 3)];
    head(&mut s);
    pieces.push(piece(s.done(), rest, SKIN, 3));
    eye(&mut s);
    pieces.push(Piece {
        cell: 0.004,
        importance: Box::new(|_| 1000.0),
        ..piece(s.done(), rest, BLACK, 1)
    });
    hand(&mut s);
    pieces.push(piece(s.done(), rest, SKIN, 3));
    hair(&mut s, outfit);
    pieces.push(piece(s.done(), rest, outfit.hair, 3));
    trousers(&mut s, outfit);
    pieces.push(piece(s.done(), rest, outfit.trousers, 3));
    shoe(&mut s);
    pieces.push(piece(s.done(), rest, outfit.shoes, 3));
    if outfit.hat {
        hat(&mut s);
        pieces.push(piece(s.done(), rest, outfit.shoes, 3));
    }
    if outfit.bag {
        bag(&mut s);
        pieces.push(Piece {
            mirrored: false,
            ..piece(s.done(), rest, LEATHER, 3)
        });
        strap(&mut s);
        pieces.push(Piece {
            mirrored: false,
            ..piece(s.done(), rest, LEATHER, 1)
        });
    }
    pieces
}

/// Faces, hands and shoes need more triangles.
fn importance(p: Vec3) -> f32 {
    1.0 + 5.0 * smooth(1.50, 1.56, p.y)
        + 4.0 * smooth(0.92, 0.88, p.y) * smooth(0.32, 0.36, p.x.abs())
        + 2.0 * smooth(0.12, 0.08, p.y)
}

/// Jacket or coat.
fn garment(s: &mut Sculptor, outfit: &Outfit) {
    let wide = outfit.shoulders;
    let flat = [1.36 * wide, 1.0, 1.0];
    s.middle(
        ["chest", "chest"],
        [[0.0, 1.355, -0.020, 0.112], [0.0, 1.22, -0.008, 0.112]],
        flat,
        0.0,
    );
    s.middle(
        ["chest", "spine"],
        [[0.0, 1.22, -0.008, 0.112], [0.0, 1.06, 0.0, 0.104]],
        flat,
        0.02,
    );
    s.middle(
        ["spine", "hips"],
        [[0.0, 1.06, 0.0, 0.104], [0.0, 0.93, -0.005, 0.117]],
        [1.40, 1.0, 1.0],
        0.03,
    );
    // Shoulders slope from the neck.
    s.pair(
        ["chest", "upper_arm_l"],
        [[0.055, 1.445, -0.022, 0.050], [0.178 * wide, 1.402, -0.020, 0.060]],
        [1.0, 1.0, 1.05],
        0.05,
    );
    s.pair(
        ["upper_arm_l", "upper_arm_l"],
        [[0.180 * wide, 1.395, -0.020, 0.062], [0.298, 1.155, -0.030, 0.049]],
        [1.0; 3],
        0.035,
    );
    s.pair(
        ["lower_arm_l", "lower_arm_l"],
        [[0.300, 1.150, -0.030, 0.049], [0.374, 0.925, -0.002, 0.038]],
        [1.0; 3],
        0.02,
    );
    // The seat and the skirt, which goes half with the legs.
    s.middle(
        ["hips", "hips"],
        [[0.0, 0.92, -0.025, 0.118], [0.0, 0.88, -0.020, 0.125]],
        [1.35, 1.0, 1.0],
        0.04,
    );
    if outfit.hem < 0.75 {
        let low = outfit.hem - 0.02;
        s.pair(
            ["hips", "thigh_l"],
            [[0.070, 0.90, -0.005, 0.130], [0.098, low, 0.0, 0.128]],
            [1.0, 1.0, 1.12],
            0.10,
        );
        s.middle(
            ["hips", "hips"],
            [[0.0, 0.88, -0.01, 0.130], [0.0, low, 0.0, 0.135]],
            [1.2, 1.0, 1.1],
            0.10,
        );
    } else {
        let low = outfit.hem - 0.02;
        s.middle(
            ["hips", "hips"],
            [[0.0, 0.88, -0.008, 0.130], [0.0, low, -0.004, 0.142]],
            [1.45, 1.0, 1.0],
            0.05,
        );
    }
    // The collar stands around the neck; the sleeves are open.
    s.middle(
        ["chest", "neck"],
        [[0.0, 1.455, -0.020, 0.070], [0.0, 1.505, -0.016, 0.064]],
        [1.05, 1.0, 1.0],
        0.03,
    );
    s.carve(
        [[0.0, 1.60, 0.02, 0.075], [0.0, 1.50, 0.10, 0.050]],
        [1.0, 1.0, 1.0],
        0.01,
    );
    s.cut_below(outfit.hem);
}

fn head(s: &mut Sculptor) {
    let both = ["head", "head"];
    s.middle(
        both,
        [[0.0, 1.653, -0.020, 0.079], [0.0, 1.650, 0.022, 0.078]],
        [0.90, 1.10, 1.0],
        0.0,
    );
    s.middle(
        both,
        [[0.0, 1.612, 0.038, 0.060], [0.0, 1.560, 0.060, 0.036]],
        [0.98, 1.0, 1.0],
        0.04,
    );
    s.pair(
        both,
        [[0.034, 1.575, 0.015, 0.028], [0.018, 1.552, 0.062, 0.018]],
        [1.0; 3],
        0.03,
    );
    // Brow, nose, lips, chin.
    s.pair(
        both,
        [[0.012, 1.668, 0.092, 0.012], [0.042, 1.668, 0.074, 0.012]],
        [1.0; 3],
        0.012,
    );
    s.middle(
        both,
        [[0.0, 1.655, 0.095, 0.009], [0.0, 1.620, 0.108, 0.012]],
        [1.0; 3],
        0.012,
    );
    s.pair(
        both,
        [[0.0, 1.616, 0.102, 0.010], [0.011, 1.614, 0.097, 0.009]],
        [1.0; 3],
        0.008,
    );
    s.middle(
        both,
        [[0.0, 1.586, 0.092, 0.012], [0.0, 1.584, 0.092, 0.012]],
        [1.7, 0.8, 0.8],
        0.008,
    );
    s.middle(
        both,
        [[0.0, 1.556, 0.086, 0.016], [0.0, 1.553, 0.084, 0.016]],
        [1.2, 1.0, 1.0],
        0.02,
    );
    s.pair(
        both,
        [[0.074, 1.640, -0.004, 0.020], [0.078, 1.618, 0.002, 0.014]],
        [0.45, 1.2, 0.8],
        0.008,
    );
    s.middle(
        ["head", "neck"],
        [[0.0, 1.57, -0.008, 0.052], [0.0, 1.47, -0.018, 0.054]],
        [1.0; 3],
        0.03,
    );
    s.middle(
        ["neck", "chest"],
        [[0.0, 1.47, -0.018, 0.054], [0.0, 1.42, -0.020, 0.062]],
        [1.0; 3],
        0.02,
    );
    // Eye sockets.
    for side in [-1.0, 1.0] {
        s.carve(
            [[0.031 * side, 1.648, 0.110, 0.014], [0.033 * side, 1.648, 0.108, 0.014]],
            [1.2, 0.8, 1.0],
            0.012,
        );
    }
}

fn eye(s: &mut Sculptor) {
    s.pair(
        ["head", "head"],
        [[0.031, 1.649, 0.088, 0.0085], [0.035, 1.649, 0.087, 0.0085]],
        [1.1, 0.8, 0.9],
        0.0,
    );
}

fn hand(s: &mut Sculptor) {
    let both = ["hand_l", "hand_l"];
    s.pair(
        ["lower_arm_l", "hand_l"],
        [[0.366, 0.95, -0.004, 0.026], [0.381, 0.90, 0.001, 0.025]],
        [0.9, 1.0, 1.0],
        0.0,
    );
    s.pair(
        both,
        [[0.385, 0.885, 0.002, 0.038], [0.398, 0.835, 0.010, 0.040]],
        [0.50, 1.0, 1.0],
        0.02,
    );
    s.pair(
        both,
        [[0.400, 0.825, 0.012, 0.038], [0.402, 0.755, 0.026, 0.024]],
        [0.42, 1.0, 1.0],
        0.02,
    );
    s.pair(
        both,
        [[0.384, 0.880, 0.030, 0.014], [0.384, 0.820, 0.058, 0.010]],
        [1.0; 3],
        0.015,
    );
}

fn hair(s: &mut Sculptor, outfit: &Outfit) {
    let both = ["head", "head"];
    s.middle(
        both,
        [[0.0, 1.660, -0.028, 0.096], [0.0, 1.668, 0.014, 0.090]],
        [0.90, 1.08, 1.0],
        0.0,
    );
    s.middle(
        both,
        [[0.0, 1.60, -0.040, 0.062], [0.0, 1.575, -0.040, 0.050]],
        [1.05, 1.0, 0.9],
        0.03,
    );
    if outfit.long_hair {
        s.middle(
            ["head", "neck"],
            [[0.0, 1.61, -0.050, 0.080], [0.0, 1.46, -0.072, 0.062]],
            [1.05, 1.0, 0.8],
            0.03,
        );
        s.pair(
            ["head", "head"],
            [[0.072, 1.66, -0.005, 0.026], [0.074, 1.55, -0.012, 0.026]],
            [0.8, 1.0, 1.3],
            0.03,
        );
        s.carve(
            [[0.0, 1.635, 0.140, 0.090], [0.0, 1.52, 0.120, 0.095]],
            [0.80, 1.0, 1.0],
            0.012,
        );
    } else {
        s.carve(
            [[0.0, 1.615, 0.120, 0.094], [0.0, 1.54, 0.100, 0.095]],
            [1.1, 1.0, 1.0],
            0.012,
        );
    }
}

fn hat(s: &mut Sculptor) {
    let both = ["head", "head"];
    s.middle(
        both,
        [[0.0, 1.715, -0.010, 0.092], [0.0, 1.775, -0.010, 0.078]],
        [0.95, 0.7, 1.12],
        0.0,
    );
    s.middle(
        both,
        [[0.0, 1.705, -0.005, 0.150], [0.0, 1.705, 0.0, 0.150]],
        [0.93, 0.06, 1.12],
        0.015,
    );
}

fn trousers(s: &mut Sculptor, outfit: &Outfit) {
    // Under a coat, thighs are hidden.
    let slim = if outfit.hem < 0.75 { 0.86 } else { 1.0 };
    let top = if outfit.hem < 0.75 { 0.70 } else { 0.90 };
    if outfit.hem >= 0.75 {
        s.middle(
            ["hips", "hips"],
            [[0.0, 0.90, -0.012, 0.090], [0.0, 0.87, -0.015, 0.088]],
            [1.35, 1.0, 1.0],
            0.0,
        );
    }
    s.pair(
        ["thigh_l", "thigh_l"],
        [[0.090, top, -0.005, 0.086 * slim], [0.095, 0.50, 0.010, 0.066 * slim]],
        [1.0; 3],
        0.03,
    );
    s.pair(
        ["shin_l", "shin_l"],
        [[0.095, 0.49, 0.010, 0.066 * slim], [0.095, 0.33, -0.012, 0.064 * slim]],
        [1.0; 3],
        0.02,
    );
    s.pair(
        ["shin_l", "shin_l"],
        [[0.095, 0.33, -0.012, 0.064 * slim], [0.095, 0.06, -0.018, 0.052 * slim]],
        [1.0; 3],
        0.02,
    );
    s.cut_below(0.075);
}

fn shoe(s: &mut Sculptor) {
    s.pair(
        ["foot_l", "foot_l"],
        [[0.095, 0.105, -0.022, 0.042], [0.095, 0.055, -0.045, 0.044]],
        [1.0; 3],
        0.0,
    );
    s.pair(
        ["foot_l", "foot_l"],
        [[0.095, 0.062, -0.02, 0.044], [0.098, 0.038, 0.085, 0.044]],
        [1.0, 0.9, 1.0],
        0.02,
    );
    s.pair(
        ["toe_l", "toe_l"],
        [[0.098, 0.036, 0.095, 0.045], [0.100, 0.030, 0.150, 0.036]],
        [1.0, 0.8, 1.0],
        0.015,
    );
    s.cut_below(0.0);
}

/// A bag at the right hip, and its strap over the left shoulder.
fn bag(s: &mut Sculptor) {
    let turned = [0.42, 1.0, 1.0];
    s.middle(
        ["hips", "hips"],
        [[-0.215, 0.95, -0.075, 0.085], [-0.215, 0.95, 0.075, 0.085]],
        turned,
        0.0,
    );
    s.middle(
        ["hips", "hips"],
        [[-0.215, 0.88, -0.080, 0.080], [-0.215, 0.88, 0.080, 0.080]],
        turned,
        0.02,
    );
    s.carve(
        [[-0.215, 0.70, 0.0, 0.10], [-0.215, 0.70, 0.0, 0.10]],
        [10.0, 1.0, 10.0],
        0.01,
    );
}

fn strap(s: &mut Sculptor) {
    let runs: [&[(&str, [f32; 4])]; 2] = [
        &[
            ("chest", [0.085, 1.498, -0.02, 0.015]),
            ("chest", [0.045, 1.420, 0.072, 0.015]),
            ("spine", [-0.060, 1.210, 0.110, 0.015]),
            ("hips", [-0.175, 1.010, 0.075, 0.015]),
        ],
        &[
            ("chest", [0.085, 1.498, -0.02, 0.015]),
            ("chest", [0.045, 1.410, -0.120, 0.015]),
            ("spine", [-0.060, 1.210, -0.118, 0.015]),
            ("hips", [-0.175, 1.010, -0.075, 0.015]),
        ],
    ];
    for run in runs {
        for pair in run.windows(2) {
            s.middle([pair[0].0, pair[1].0], [pair[0].1, pair[1].1], [1.0, 1.0, 0.9], 0.005);
        }
    }
}
