//! Stingl 2011: *Robust Hard Shadows* (diploma thesis, TU Wien).

use super::{
    Figure, Panels,
    data::{CONE_NOTE, Configuration, along_view, single, sliced, tilted_along_view},
    lloyd::over_maps,
};
use crate::maths::{
    analysis::{direction::TiltedWarp, overhead::OverheadWarp},
    split::SplitScheme,
};

/// The practical split scheme with the thesis' default.
const PRACTICAL: SplitScheme = SplitScheme::Practical { lambda: 0.5 };

pub(super) const FIGURES: &[Figure] = &[
    Figure {
        name: "stingl-fig2-8-error-of-warps",
        title: "Error along the view: uniform, LiSPSM, PSM; light overhead",
        source: "Stingl 2011, figure 2.8: n = 1, f = 40",
        notes: &["Chosen: Θ = 30°, which the caption does not give; logarithmic axes."],
        panels: || {
            Panels::Curves(along_view(&[
                single("uniform", 1.0, 40.0, OverheadWarp::Uniform),
                single("LiSPSM", 1.0, 40.0, OverheadWarp::Lispsm),
                single("PSM", 1.0, 40.0, OverheadWarp::Psm),
            ]))
        },
    },
    Figure {
        name: "stingl-fig3-5-focusing",
        title: "Error along the view: standard and focused uniform maps",
        source: "Stingl 2011, figures 3.4 and 3.5: n = 1, f = 1500 and 500, Θ = 30°; light overhead",
        notes: &[],
        panels: || {
            Panels::Curves(along_view(&[
                single("standard, to 1500", 1.0, 1500.0, OverheadWarp::Uniform),
                single("focused, to 500", 1.0, 500.0, OverheadWarp::Uniform),
            ]))
        },
    },
    Figure {
        name: "stingl-fig3-8-reparametrised",
        title: "Error along the view with light at 20° to the view",
        source: "Stingl 2011, figure 3.8 (there a picture of sampling rates): Θ = 30°, γ = 20°",
        notes: &["Chosen: n = 1, f = 40.", CONE_NOTE],
        panels: || {
            Panels::Curves(tilted_along_view(
                40.0,
                20.0,
                &[
                    ("uniform", TiltedWarp::Uniform),
                    ("LiSPSM, n_opt", TiltedWarp::Lispsm),
                    ("LiSPSM re-parametrised", TiltedWarp::Reparametrised),
                ],
            ))
        },
    },
    Figure {
        name: "stingl-fig3-9-lispsm",
        title: "Error along the view: focused uniform and LiSPSM",
        source: "Stingl 2011, figure 3.9: Θ = 30°, γ = 90°",
        notes: &["Chosen: n = 1, f = 500, as in figure 3.5."],
        panels: || {
            Panels::Curves(along_view(&[
                single("uniform", 1.0, 500.0, OverheadWarp::Uniform),
                single("LiSPSM, n_opt", 1.0, 500.0, OverheadWarp::Lispsm),
            ]))
        },
    },
    Figure {
        name: "stingl-fig3-12-split-schemes",
        title: "Error along the view of two uniform slices by split scheme",
        source: "Stingl 2011, figure 3.12 (there a drawing), section 3.3.2; light overhead",
        notes: &["Chosen: n = 1, f = 500, Θ = 30°; practical with λ = 0.5."],
        panels: || {
            let configuration = |name, scheme: &SplitScheme| sliced(name, 1.0, 500.0, scheme, 2, OverheadWarp::Uniform);
            Panels::Curves(along_view(&[
                configuration("uniform", &SplitScheme::Uniform),
                configuration("logarithmic", &SplitScheme::Logarithmic),
                configuration("practical", &PRACTICAL),
            ]))
        },
    },
    Figure {
        name: "stingl-fig3-15-number-of-splits",
        title: "Error along the view for several numbers of slices, no warp, light overhead",
        source: "Stingl 2011, figure 3.15: PSSM, Θ = 30°",
        notes: &["Chosen: n = 1, f = 500, practical splits with λ = 0.5."],
        panels: || {
            let configuration = |name, count| sliced(name, 1.0, 500.0, &PRACTICAL, count, OverheadWarp::Uniform);
            Panels::Curves(along_view(&[
                configuration("2 slices", 2),
                configuration("4 slices", 4),
                configuration("8 slices", 8),
                configuration("16 slices", 16),
            ]))
        },
    },
    Figure {
        name: "stingl-fig3-18-warped-splits",
        title: "Error along the view for four LiSPSM slices, light overhead",
        source: "Stingl 2011, figure 3.18: Θ = 30°, γ = 90°",
        notes: &[
            "Chosen: n = 1, f = 500. With practical splits the first slice is warped far more than the second: its seam shows.",
        ],
        panels: || {
            let configuration = |name, scheme: &SplitScheme| sliced(name, 1.0, 500.0, scheme, 4, OverheadWarp::Lispsm);
            Panels::Curves(along_view(&[
                configuration("practical splits (PSSM)", &PRACTICAL),
                configuration("logarithmic splits", &SplitScheme::Logarithmic),
            ]))
        },
    },
    Figure {
        name: "stingl-fig3-19-storage",
        title: "Storage factor over the number of maps",
        source: "Stingl 2011, figure 3.19, after Lloyd et al. 2006, figure 12: f ÷ n = 1000, Θ = 30°",
        notes: &["The same numbers as in Lloyd's figure 12."],
        panels: || Panels::Curves(over_maps()),
    },
    Figure {
        name: "stingl-fig4-2-pseudo-planes",
        title: "Error along the view with pseudo planes, light overhead",
        source: "Stingl 2011, figure 4.2 (there a picture of sampling rates): γ = 90°, n ≈ 1, f ≈ 300, pseudo-near ≈ 30",
        notes: &[
            "Chosen: Θ = 30°, planes at 31 and 270: the caption's pseudo-far plane of 30 is taken as 30 before the far plane.",
        ],
        panels: || {
            let pseudo = OverheadWarp::PseudoPlanes { near: 31.0, far: 270.0 };
            Panels::Curves(along_view(&[
                single("LiSPSM, n_opt", 1.0, 300.0, OverheadWarp::Lispsm),
                single("levelled between 31 and 270", 1.0, 300.0, pseudo),
                single("uniform", 1.0, 300.0, OverheadWarp::Uniform),
            ]))
        },
    },
    Figure {
        name: "stingl-fig4-3-near-plane",
        title: "Error along the view: PSM with a low and with the true near plane",
        source: "Stingl 2011, figure 4.3 (there a picture of sampling rates): near 1 and about 6; light overhead",
        notes: &["Chosen: f = 300, Θ = 30°."],
        panels: || {
            Panels::Curves(along_view(&[
                single("PSM, near 1", 1.0, 300.0, OverheadWarp::Psm),
                single("PSM, near 6", 6.0, 300.0, OverheadWarp::Psm),
                single("LiSPSM, near 1", 1.0, 300.0, OverheadWarp::Lispsm),
                single("LiSPSM, near 6", 6.0, 300.0, OverheadWarp::Lispsm),
            ]))
        },
    },
    Figure {
        name: "stingl-fig5-8-error-graph",
        title: "The error graph of the framework: LiSPSM, light overhead",
        source: "Stingl 2011, figure 5.8: γ ≈ 90°",
        notes: &[
            "The range of the original is unknown. Chosen: that of the thesis' other screenshot, near 1, far 97.04, Θ = 30°.",
        ],
        panels: || Panels::Curves(along_view(&[single("LiSPSM, n_opt", 1.0, 97.04, OverheadWarp::Lispsm)])),
    },
    Figure {
        name: "stingl-fig7-7-near-ranges",
        title: "Error along the view: LiSPSM, with a pseudo-near plane, with an adjusted near plane",
        source: "Stingl 2011, figures 7.7 to 7.9 (error graphs beside screenshots)",
        notes: &[
            "Scene, camera and planes of the originals are unknown. Chosen: n = 1, f = 300, Θ = 30°; first surface at 12. \
            Left of it nothing is seen, so large errors there do no harm.",
        ],
        panels: || {
            let pseudo = OverheadWarp::PseudoPlanes { near: 12.0, far: 300.0 };
            let configurations: [Configuration; 3] = [
                single("n_opt, near 1", 1.0, 300.0, OverheadWarp::Lispsm),
                single("pseudo-near 12", 1.0, 300.0, pseudo),
                single("adjusted near 12", 12.0, 300.0, OverheadWarp::Lispsm),
            ];
            Panels::Curves(along_view(&configurations))
        },
    },
];
