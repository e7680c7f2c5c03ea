//! Defaults of options change nothing: light views to the last bit.

use bevy_math::{DVec2, DVec3, UVec2};
use umbrage::maths::{
    bounds::Bounds,
    fit::{FitInput, FitOptions, LightFit, fit_light_view},
    view::ViewVolume,
    warp::Warp,
};

use crate::support::bodies;

/// A digest of every number of a light view (Fowler, Noll and Vo's hash of their bits).
fn digest(fit: &LightFit) -> u64 {
    let matrices =
        [fit.world_from_light, fit.clip_from_light, fit.clip_from_world].map(|matrix| matrix.to_cols_array());
    let scalars = [
        fit.warp_near,
        fit.eta,
        fit.texel_size,
        fit.near_texel_size,
        fit.relative_texel_size,
        fit.depth_per_metre,
    ];
    matrices
        .as_flattened()
        .iter()
        .chain(&scalars)
        .flat_map(|value| value.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
        })
}

/// A camera without trigonometry, whose last bits differ between machines.
fn camera(eye: DVec3, tilt: f64) -> ViewVolume {
    let (forward, up) = (DVec3::new(0.1, tilt, -1.0), DVec3::Y);
    let right = forward.cross(up).normalize();
    let up = right.cross(forward).normalize();
    let corners = [1.0, 2.0].map(|depth: f64| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
            let half = DVec2::new(0.9 * x, 0.5 * y) * depth;
            eye + forward.normalize() * depth + right * half.x + up * half.y
        })
    });
    ViewVolume::from_corners(eye, forward, up, corners, 0.1, 500.0).expect("a proper camera")
}

/// Taken before there were options: four lights, two slices each, with no warp, `LiSPSM`, `PSM` and eta = −0.5.
const DIGESTS: [[u64; 4]; 8] = [
    [
        0x966f_a2f8_1a46_dfd1,
        0xb1ea_a839_bfaa_05a4,
        0x2f82_0da8_71ea_dc8e,
        0xfc01_9b15_ec25_d60f,
    ],
    [
        0x3519_e0be_af75_afb4,
        0xb226_15aa_a726_4e64,
        0x29a2_780c_d6c6_2c6d,
        0x1ff2_de3f_437a_75f6,
    ],
    [
        0x6100_8add_228c_e882,
        0x419a_f063_7bcc_3142,
        0xc0f9_0083_4e1e_aebd,
        0xe348_62de_99f0_6bd2,
    ],
    [
        0x53bf_64aa_a475_d37c,
        0x6b82_b10c_aa2f_d89f,
        0xb3e2_efb0_4066_e6b2,
        0xfc3b_4b40_38a3_9fe4,
    ],
    [
        0xbe20_5655_2124_68a2,
        0x47d9_2ff7_38b5_9a8a,
        0x8c5c_3767_cd1e_7f98,
        0xb73d_f0be_2980_00d9,
    ],
    [
        0x6158_89cc_13ac_9860,
        0x1baf_25fa_79d2_fffa,
        0xea6a_7416_b6d9_9e7a,
        0x6bcc_2315_6377_87e6,
    ],
    [
        0xaa62_3104_42f1_6a11,
        0x5be7_1b47_8833_118a,
        0x4434_3854_ecc2_a932,
        0x5f3c_6a66_b2d4_9f7c,
    ],
    [
        0xd118_406c_583e_44d6,
        0x5ba4_49f7_325a_23fe,
        0x3ae1_f086_5da9_33f8,
        0x920c_af13_88dd_bd33,
    ],
];

#[test]
fn options_change_nothing_unless_asked() {
    let scene = Bounds::new(DVec3::new(-150.0, -3.0, -300.0), DVec3::new(120.0, 25.0, 60.0));
    let lights = [
        DVec3::new(0.3, -1.0, 0.2),
        DVec3::new(0.0, -0.4, -1.0),
        DVec3::new(0.2, -0.3, 1.0),
        DVec3::new(0.1, -0.05, -1.0),
    ];
    for (index, expected) in DIGESTS.into_iter().enumerate() {
        let light_travel = lights[index / 2];
        let view = camera(DVec3::new(1.0, 1.7, 2.0), -0.05 * (index / 2) as f64);
        let slice = [view.split(0.5, 300.0), view.split(5.0, 40.0)][index % 2].clone();
        let (visible, body) = bodies(&slice, &scene, light_travel);
        let digests = [Warp::Uniform, Warp::Lispsm, Warp::Psm, Warp::Free { eta: -0.5 }].map(|warp| {
            let input = FitInput {
                view: &slice,
                visible: &visible,
                body: &body,
                light_travel,
                warp,
                map_size: UVec2::splat(1024),
                guard_texels: 2.0,
                guard_metres: 0.1,
                options: FitOptions::default(),
            };
            digest(&fit_light_view(&input).fitted().expect("a light view"))
        });
        assert_eq!(digests, expected, "light and slice {index}");
    }
}
