//! Scherzer 2005: *Robust Shadow Maps for Large Environments*. The paper has no plots; these are about its rules.

use super::{
    Figure, Panels,
    data::{along_view, axis, curve, ratios, single},
};
use crate::{
    maths::{
        analysis::overhead::OverheadWarp,
        warp::{OptimumRule, WarpSpan},
    },
    plot::{Curves, Scale},
};

pub(super) const FIGURES: &[Figure] = &[
    Figure {
        name: "scherzer-sec4-n-opt",
        title: "Optimal parameter over the angle between light and view",
        source: "After Scherzer 2005, equation 1: near 0.1, depth extent 69.9",
        notes: &[
            "The extent is held for all angles. As printed, equation 1 takes it for a view depth; levelled errors take its \
            part along the view, extent · sin γ, and warp more. The copied program also divides the near depth by sin γ.",
        ],
        panels: || Panels::Curves(vec![optimal_parameters()]),
    },
    Figure {
        name: "scherzer-sec4-visible-depth",
        title: "Error along the view when n_opt takes the visible depth only, light overhead",
        source: "After Scherzer 2005, section 4.4: near 0.1, far 70, Θ = 30°",
        notes: &["The product of the largest errors stays the same: error moves to where nothing is seen."],
        panels: || {
            let visible = |far| OverheadWarp::PseudoPlanes { near: 0.1, far };
            Panels::Curves(along_view(&[
                single("visible to 70", 0.1, 70.0, visible(70.0)),
                single("visible to 30", 0.1, 70.0, visible(30.0)),
                single("visible to 10", 0.1, 70.0, visible(10.0)),
                single("visible to 5", 0.1, 70.0, visible(5.0)),
                single("no warp", 0.1, 70.0, OverheadWarp::Uniform),
            ]))
        },
    },
];

fn optimal_parameters() -> Curves {
    let (near, extent) = (0.1, 69.9);
    let angles = ratios(0.1, 90.0, 200);
    let reading = |label: &str, rule| {
        let optimum = |degrees: f64| {
            let sine = degrees.to_radians().sin();
            WarpSpan::directional_by(rule, extent, near, sine).optimal_warp_near()
        };
        curve(label, angles.clone().map(|degrees| (degrees, optimum(degrees))))
    };
    Curves {
        title: "n_opt".to_owned(),
        x: axis("angle between light and view, degrees", Scale::Logarithmic),
        y: axis("n_opt, metres", Scale::Logarithmic),
        curves: vec![
            reading("from levelled errors", OptimumRule::Derived),
            reading("as printed", OptimumRule::Literal),
            reading("of the widely copied program", OptimumRule::Demo),
        ],
    }
}
