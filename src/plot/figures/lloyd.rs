//! Lloyd, Tuft, Yoon and Manocha 2006: *Warping and Partitioning for Low Error Shadow Maps*.

use super::{
    Figure, Panels,
    data::{
        CONE_NOTE, ERRATUM_NOTE, OPENING, along_view, axis, camera, curve, light_at, overhead, ratios, single, sliced,
    },
};
use crate::{
    maths::{
        analysis::{
            direction::{Scheme, TiltedWarp},
            hemisphere::StorageHemisphere,
            overhead::OverheadWarp,
        },
        error::LargestErrors,
        split::SplitScheme,
        storage::{LightPlace, PartitionScheme, closed_storage_factor, crossover_maps, storage_factor_of_maps},
    },
    plot::{Axis, Curve, Curves, HeatMap, Scale},
};

pub(super) const FIGURES: &[Figure] = &[
    Figure {
        name: "lloyd-fig5-error-along-view",
        title: "Error along the view for several warps, light overhead",
        source: "Lloyd et al. 2006, figure 5: n = 1, f = 20",
        notes: &["Chosen: Θ = 30°, which scales m_z only; logarithmic axes."],
        panels: || {
            let configuration = |name, warp| single(name, 1.0, 20.0, warp);
            Panels::Curves(along_view(&[
                configuration("n' = ∞ (uniform)", OverheadWarp::Uniform),
                configuration("n' = 10", OverheadWarp::Near(10.0)),
                configuration("n' = n + √(nf) (LiSPSM)", OverheadWarp::Lispsm),
                configuration("n' = 2", OverheadWarp::Near(2.0)),
                configuration("n' = n (PSM)", OverheadWarp::Psm),
            ]))
        },
    },
    Figure {
        name: "lloyd-fig6-warp-strength",
        title: "Largest errors and storage over the strength of the warp, light overhead",
        source: "Lloyd et al. 2006, figure 6: n = 1, f = 100; each divided by its largest value",
        notes: &[
            "Chosen: Θ = 30°; a logarithmic axis. Left of 0 the shares of M_x and M_z are the same.",
            ERRATUM_NOTE,
        ],
        panels: || Panels::Curves(vec![over_strength()]),
    },
    Figure {
        name: "lloyd-sec4-warp-strength-tilted",
        title: "Storage over the strength of the warp for light at several angles",
        source: "After Lloyd et al. 2006, section 4.4 and erratum: n = 1, f = 1000, Θ = 30°",
        notes: &[ERRATUM_NOTE, CONE_NOTE],
        panels: || Panels::Curves(vec![over_strength_tilted()]),
    },
    Figure {
        name: "lloyd-fig7-hemisphere",
        title: "Storage factor over all light directions",
        source: "Lloyd et al. 2006, figure 7: logarithmic scale; overhead in the middle, the horizon around it",
        notes: &[
            "Chosen: f ÷ n = 1000, Θ = 30°; the warp falls back to none where that is better, as the paper says it must.",
            CONE_NOTE,
        ],
        panels: || {
            Panels::HeatMaps(hemispheres(&[
                ("No warp", Scheme::depth(1, TiltedWarp::Uniform)),
                ("Warp (LiSPSM)", Scheme::depth(1, TiltedWarp::Guarded)),
                ("Warp and face partitions", Scheme::faces(1)),
            ]))
        },
    },
    Figure {
        name: "lloyd-fig7-hemisphere-slices",
        title: "Storage factor over all light directions, four slices",
        source: "As Lloyd et al. 2006, figure 7, with z-partitions (section 5.3)",
        notes: &[
            "Chosen: f ÷ n = 1000, Θ = 30°. Slices bring most of the benefit; the warp lowers the mean, not the peak.",
            CONE_NOTE,
        ],
        panels: || {
            Panels::HeatMaps(hemispheres(&[
                ("ZP4", Scheme::depth(4, TiltedWarp::Uniform)),
                ("ZP4+W", Scheme::depth(4, TiltedWarp::Guarded)),
                ("FP+ZP4+W", Scheme::faces(4)),
            ]))
        },
    },
    Figure {
        name: "lloyd-sec4-light-angle",
        title: "Storage factor for light in the vertical plane of the view",
        source: "After Lloyd et al. 2006, section 4.4: the slice of figure 7 from ahead over overhead to behind",
        notes: &["Chosen: f ÷ n = 1000, Θ = 30°.", CONE_NOTE],
        panels: || Panels::Curves(vec![light_angle()]),
    },
    Figure {
        name: "lloyd-fig10-maps-overhead",
        title: "Storage factor of warped z-partitions, light overhead",
        source: "Lloyd et al. 2006, figure 10 and appendix C",
        notes: &["Chosen: Θ = 30°. Which slices the paper draws is not given in its text."],
        panels: || Panels::Curves(vec![over_depth_ratio()]),
    },
    Figure {
        name: "lloyd-fig12-maps",
        title: "Storage factor over the number of maps",
        source: "Lloyd et al. 2006, figure 12: f ÷ n = 1000, Θ = 30°",
        notes: &[
            "Face partitions count four maps per slice, the near face none; their slices are real numbers, j ÷ 4.",
        ],
        panels: || Panels::Curves(over_maps()),
    },
    Figure {
        name: "lloyd-fig13-crossover",
        title: "Which scheme needs least storage with light from behind",
        source: "Lloyd et al. 2006, figure 13",
        notes: &["Below the curve z-partitions (ZP, ZP+W), above it face partitions (FP+ZP+W)."],
        panels: || Panels::Curves(vec![crossovers()]),
    },
    Figure {
        name: "lloyd-sec5-seams",
        title: "Error along the view of four slices: what jumps at their seams, light overhead",
        source: "After Lloyd et al. 2006, section 5.2: f ÷ n = 1000",
        notes: &[
            "Chosen: Θ = 30°. With LiSPSM m_z is continuous and m_x jumps by α^(1 ÷ 2k); with PSM m_x is continuous and m_z \
            jumps by α^(1 ÷ k).",
        ],
        panels: || {
            let slices = |name, warp| sliced(name, 1.0, 1000.0, &SplitScheme::Logarithmic, 4, warp);
            Panels::Curves(along_view(&[
                slices("ZP4", OverheadWarp::Uniform),
                slices("ZP4+W, LiSPSM", OverheadWarp::Lispsm),
                slices("ZP4+W, PSM", OverheadWarp::Psm),
            ]))
        },
    },
    Figure {
        name: "lloyd-sec5-worst-direction",
        title: "Storage factor of the worst direction and in the mean, over the number of slices",
        source: "After Lloyd et al. 2006, section 5.3: f ÷ n = 1000, Θ = 30°; 19 x 36 light directions above the horizon",
        notes: &[
            "Slices per face where there are faces. Means are geometric. In the worst direction ZP and ZP+W are nearly the same.",
            CONE_NOTE,
        ],
        panels: || Panels::Curves(worst_and_mean()),
    },
];

fn storage_axis() -> Axis {
    axis("storage factor: texels per pixel", Scale::Logarithmic)
}

fn strengths() -> impl Iterator<Item = f64> + Clone {
    (-200..=200).map(|step| f64::from(step) / 200.0)
}

fn over_strength() -> Curves {
    let range = overhead(1.0, 100.0);
    let relative = |label: &str, of: fn(&LargestErrors) -> f64| {
        let value = |eta: f64| of(&range.largest_errors(range.warp_near(OverheadWarp::Strength { eta })));
        let largest = strengths().map(value).fold(0.0, f64::max);
        curve(label, strengths().map(|eta| (eta, value(eta) / largest)))
    };
    Curves {
        title: "Share of the largest value".to_owned(),
        x: axis("strength η: −1 uniform, 0 LiSPSM, 1 PSM", Scale::Linear),
        y: Axis {
            range: Some(0.008..1.2),
            ..axis("share", Scale::Logarithmic)
        },
        curves: vec![
            relative("M_x, largest error across", |errors| errors.across),
            relative("M_z, largest error along", |errors| errors.along),
            relative("S, storage factor", LargestErrors::storage_factor),
        ],
    }
}

fn over_strength_tilted() -> Curves {
    let view = camera(1000.0);
    let of_light = |(label, degrees): (&str, f64)| {
        let storage = strengths().filter_map(|eta| {
            let scheme = Scheme::depth(1, TiltedWarp::Strength { eta });
            Some((eta, scheme.storage_factor(&view, light_at(degrees)).ok()?))
        });
        curve(label, storage)
    };
    let lights = [
        ("90° (overhead)", 90.0),
        ("70°", 70.0),
        ("50°", 50.0),
        ("35°", 35.0),
        ("25° (inside the cone)", 25.0),
    ];
    Curves {
        title: "Angle between light and view".to_owned(),
        x: axis("strength η: −1 uniform, 0 n_opt, 1 PSM", Scale::Linear),
        y: storage_axis(),
        curves: lights.into_iter().map(of_light).collect(),
    }
}

/// Storage over the hemisphere for several schemes, on one scale.
fn hemispheres(schemes: &[(&str, Scheme)]) -> Vec<HeatMap> {
    const RINGS: usize = 45;
    const SECTORS: usize = 120;
    let view = camera(1000.0);
    let maps = schemes.iter().filter_map(|(title, scheme)| {
        let hemisphere = StorageHemisphere::new(&view, scheme, RINGS, SECTORS).ok()?;
        let rings = (0..=RINGS).map(|ring| {
            let count = if ring == 0 { 1 } else { SECTORS };
            (0..count).map(|sector| hemisphere.value(ring, sector)).collect()
        });
        Some((*title, rings.collect::<Vec<Vec<f64>>>()))
    });
    let maps: Vec<_> = maps.collect();
    let values = maps.iter().flat_map(|(_, rings)| rings.iter().flatten().copied());
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    maps.into_iter()
        .map(|(title, rings)| HeatMap {
            title: title.to_owned(),
            label: "storage factor: texels per pixel".to_owned(),
            rings,
            range: Some(low..high),
        })
        .collect()
}

fn light_angle() -> Curves {
    let view = camera(1000.0);
    let of_scheme = |label: &str, scheme: Scheme| {
        let angles = (0..=360).map(|step| f64::from(step) * 0.5);
        let points = angles.filter_map(|degrees| {
            // Towards the light in the plot: 0 ahead.
            let storage = scheme.storage_factor(&view, light_at(180.0 - degrees)).ok()?;
            Some((degrees, storage))
        });
        curve(label, points)
    };
    Curves {
        title: "One map, and its face partitions".to_owned(),
        x: axis(
            "direction to the light, degrees: 0 ahead, 90 overhead, 180 behind",
            Scale::Linear,
        ),
        y: storage_axis(),
        curves: vec![
            of_scheme("no warp", Scheme::depth(1, TiltedWarp::Uniform)),
            of_scheme("LiSPSM, n_opt", Scheme::depth(1, TiltedWarp::Lispsm)),
            of_scheme("re-parametrised", Scheme::depth(1, TiltedWarp::Reparametrised)),
            of_scheme("best n'", Scheme::depth(1, TiltedWarp::Best)),
            of_scheme("face partitions, warped", Scheme::faces(1)),
        ],
    }
}

fn over_depth_ratio() -> Curves {
    let depth_ratios = ratios(2.0, 1.0e4, 120);
    let of_slices = |slices: usize| {
        let label = if slices == 1 {
            "1 slice".to_owned()
        } else {
            format!("{slices} slices")
        };
        let storage = |ratio| {
            closed_storage_factor(
                PartitionScheme::SlicedWarped,
                LightPlace::Overhead,
                ratio,
                slices as f64,
                OPENING,
            )
        };
        curve(
            label,
            depth_ratios.clone().filter_map(|ratio| Some((ratio, storage(ratio)?))),
        )
    };
    let mut curves: Vec<Curve> = [1, 2, 3, 4, 8, 16].into_iter().map(of_slices).collect();
    let optimal =
        |ratio| closed_storage_factor(PartitionScheme::Logarithmic, LightPlace::Overhead, ratio, 1.0, OPENING);
    let points = depth_ratios.filter_map(|ratio| Some((ratio, optimal(ratio)?)));
    curves.push(curve("logarithmic map (optimal)", points));
    Curves {
        title: "ZP+W".to_owned(),
        x: axis("depth ratio f ÷ n", Scale::Logarithmic),
        y: storage_axis(),
        curves,
    }
}

/// S̄ over the number of maps, a panel per place of the light.
pub(super) fn over_maps() -> Vec<Curves> {
    let panel = |title: &str, place, schemes: &[(&str, PartitionScheme)]| {
        let of_scheme = |(label, scheme): &(&str, PartitionScheme)| {
            let maps = (0..=312).map(|step| 1.0 + f64::from(step) * 0.125);
            let storage = |maps| storage_factor_of_maps(*scheme, place, 1000.0, maps, OPENING);
            curve(*label, maps.filter_map(|maps| Some((maps, storage(maps)?))))
        };
        let mut curves: Vec<Curve> = schemes.iter().map(of_scheme).collect();
        let optimal = closed_storage_factor(PartitionScheme::Logarithmic, place, 1000.0, 1.0, OPENING);
        let points = [1.0, 40.0].into_iter().filter_map(|maps| Some((maps, optimal?)));
        curves.push(curve("logarithmic maps (limit)", points));
        Curves {
            title: title.to_owned(),
            x: axis("number of maps", Scale::Linear),
            y: Axis {
                range: Some(4.0..1.0e4),
                ..storage_axis()
            },
            curves,
        }
    };
    vec![
        panel(
            "Light overhead",
            LightPlace::Overhead,
            &[
                ("ZP", PartitionScheme::Sliced),
                ("ZP+W", PartitionScheme::SlicedWarped),
                ("FP+ZP+W", PartitionScheme::FacesSlicedWarped),
            ],
        ),
        panel(
            "Light from behind",
            LightPlace::AlongView,
            &[
                ("ZP and ZP+W", PartitionScheme::Sliced),
                ("FP+ZP+W", PartitionScheme::FacesSlicedWarped),
            ],
        ),
    ]
}

fn crossovers() -> Curves {
    let maps = ratios(5.0, 1.0e5, 300).filter_map(|ratio| Some((ratio, crossover_maps(ratio)?)));
    let maps: Vec<(f64, f64)> = maps.collect();
    let whole = maps.iter().map(|(ratio, maps)| (*ratio, (maps / 4.0).ceil() * 4.0));
    Curves {
        title: "From this number of maps on, face partitions win".to_owned(),
        x: axis("depth ratio f ÷ n", Scale::Logarithmic),
        y: axis("number of maps", Scale::Linear),
        curves: vec![
            curve("crossover, real number of maps", maps.iter().copied()),
            curve("next whole number of slices per face", whole),
        ],
    }
}

fn worst_and_mean() -> Vec<Curves> {
    let view = camera(1000.0);
    let schemes = |slices| {
        [
            ("ZP", Scheme::depth(slices, TiltedWarp::Uniform)),
            ("ZP+W", Scheme::depth(slices, TiltedWarp::Guarded)),
            ("FP+ZP+W", Scheme::faces(slices)),
        ]
    };
    let mut worst: Vec<Curve> = schemes(1).map(|(label, _)| curve(label, [])).into();
    let mut mean = worst.clone();
    for slices in 1..=16 {
        for (index, (_, scheme)) in schemes(slices).into_iter().enumerate() {
            if let Ok(map) = StorageHemisphere::new(&view, &scheme, 18, 36) {
                worst[index].points.push((slices as f64, map.largest().0));
                mean[index].points.push((slices as f64, map.geometric_mean()));
            }
        }
    }
    [("Worst direction", worst), ("Mean of all directions", mean)]
        .map(|(title, curves)| Curves {
            title: title.to_owned(),
            x: axis("number of slices", Scale::Linear),
            y: Axis {
                range: Some(10.0..3.0e6),
                ..storage_axis()
            },
            curves,
        })
        .into()
}
