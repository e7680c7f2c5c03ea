//! Chong 2003: *Real-Time Perspective Optimal Shadow Maps* (BA thesis, Harvard). All in flatland.

use super::{
    Figure, Panels,
    data::{axis, curve, ratios},
};
use crate::{
    maths::light_plane::flat::{
        Exposure, Footprints, Light, Metric, Tilt,
        allocation::{FillFrom, whole_texels},
        lost_share,
        post_perspective::PostPerspective,
        printed_angle,
        split::SliceExtent,
        study::{
            COARSE_PIXELS, CoarseHull, Merging, Method, PUBLISHED, PublishedMethod, Scene, coarse_pass_error, row,
            scenes, split_average, split_scene,
        },
    },
    plot::{Axis, Bars, Curve, Curves, Row, Scale},
};

/// Said wherever scenes are ours.
const SCENES_NOTE: &str = "Chosen: scenes and film sizes, which the source does not give; 1000 pixels and texels. Patterns \
    compare, digits do not.";

pub(super) const FIGURES: &[Figure] = &[
    Figure {
        name: "flatland",
        title: "Texel footprints by film: the thesis's tables and ours",
        source: "Chong 2003, section 4.1.3; film angles in degrees from vertical",
        notes: &[
            SCENES_NOTE,
            "Erratum: the thesis's PSM is not what a perspective shadow map does. Its film is read off the near plane, which \
             does not matter to places; ours has both.",
            "Footprints grow with the share of pixels that see something: of our single plane's, 370 of 1000.",
        ],
        panels: || Panels::Bars(scenes().iter().map(table).collect()),
    },
    Figure {
        name: "chong-fig1-5-films",
        title: "Light rays through every 40th texel border: ordinary and best film",
        source: "After Chong 2003, figures 1.5 and 2.1",
        notes: &[SCENES_NOTE, "Both axes are in metres, on different scales."],
        panels: || {
            let of = |name| scenes().into_iter().find(|scene| scene.name == name);
            let chosen = ["single plane", "simple geometry"].into_iter().filter_map(of);
            let panels =
                chosen.flat_map(|scene| [Method::HalfAngle, Method::L1].map(|method| texel_rays(&scene, method)));
            Panels::Curves(panels.collect())
        },
    },
    Figure {
        name: "chong-fig2-2-over-the-picture",
        title: "Pixels per texel over the picture",
        source: "After Chong 2003, figure 2.2",
        notes: &[
            SCENES_NOTE,
            "Jumps are changes of surface. One plane can have the same everywhere, several cannot.",
        ],
        panels: || Panels::Curves(scenes().iter().map(over_the_picture).collect()),
    },
    Figure {
        name: "chong-sec3-1-metrics",
        title: "Metrics over all films, as multiples of their least",
        source: "After Chong 2003, sections 2.1.1 and 3.1",
        notes: &[
            SCENES_NOTE,
            "s = artanh k adds up over turns; in it all three are convex, so every film has one best, never an invalid one.",
        ],
        panels: || Panels::Curves(scenes().iter().map(metrics).collect()),
    },
    Figure {
        name: "chong-fig2-3-near-planes",
        title: "Film angles of a perspective shadow map by the thesis's rule over its near plane, single plane",
        source: "After Chong 2003, figure 2.3 and section 2.2.3",
        notes: &[
            SCENES_NOTE,
            "Erratum: the map's places do not depend on its near plane; the rule's angle does, and goes to the map's as the \
             near plane goes to the light.",
        ],
        panels: || Panels::Curves(scenes().iter().take(1).map(near_planes).collect()),
    },
    Figure {
        name: "chong-fig3-1-lost-texels",
        title: "Share of the film that serves no pixel",
        source: "After Chong 2003, section 3 and figure 3.1",
        notes: &[
            SCENES_NOTE,
            "Only the last scene has gaps in the light's hull. No tilt closes them; splitting does.",
        ],
        panels: || Panels::Bars(vec![lost()]),
    },
    Figure {
        name: "chong-fig4-1-coarse-pass",
        title: "Added error of a film chosen from a coarse first pass",
        source: "After Chong 2003, figure 4.1: 100, 50, 25, 10, 5 pixels against 1000",
        notes: &[SCENES_NOTE, "The hull is that of the few pixels themselves."],
        panels: || Panels::Curves([Metric::L1, Metric::L2].map(coarse_passes).to_vec()),
    },
    Figure {
        name: "chong-sec4-frusta",
        title: "Gain of several frusta over one, for the same number of texels",
        source: "After Chong 2003, sections 3.2 and 4.1.2: 16 slices of equal angle, L1",
        notes: &[
            SCENES_NOTE,
            "The thesis: about 1.3 in ordinary scenes, 2 to 3 with strong projection aliasing, most of it from the first split.",
        ],
        panels: || {
            Panels::Curves(vec![
                gains("greedy merge", Merging::Greedy, SliceExtent::Borders),
                gains("exact partition", Merging::Exact, SliceExtent::Borders),
                gains("exact, slices cut to their pixels", Merging::Exact, SliceExtent::Pixels),
            ])
        },
    },
    Figure {
        name: "chong-sec3-2-allocation",
        title: "Share of the film and of the texels of every frustum",
        source: "After Chong 2003, section 3.2: exact partition of 16 slices, L1, 1000 texels",
        notes: &[SCENES_NOTE],
        panels: || Panels::Bars(scenes().iter().map(allocation).collect()),
    },
];

/// The thesis's rows of a scene and ours.
fn table(scene: &Scene) -> Bars {
    let angle = |angle: Option<f64>| angle.map_or_else(String::new, |angle| format!(" {angle:.1}°"));
    let mut rows = Vec::new();
    for method in Method::ALL {
        rows.push(match row(scene, method) {
            Ok(found) => {
                let footprints = found.footprints;
                Row {
                    label: format!("ours: {}{}", method.name(), angle(found.angle)),
                    values: [footprints.worst, footprints.average, footprints.average_and_deviation()]
                        .map(Some)
                        .to_vec(),
                }
            }
            Err(_) => Row {
                label: format!("ours: {}, no valid film", method.name()),
                values: vec![None; 3],
            },
        });
    }
    if let Ok(average) = split_average(scene, 2, Merging::Greedy, SliceExtent::Borders) {
        rows.push(Row {
            label: "ours: L1, two frusta".to_owned(),
            values: vec![None, Some(average), None],
        });
    }
    for published in PUBLISHED.iter().filter(|published| published.scene == scene.name) {
        let name = match published.method {
            PublishedMethod::Both => "L1 and L2",
            PublishedMethod::L1 => "L1",
            PublishedMethod::L2 => "L2",
            PublishedMethod::TwoFrusta => "L1, two frusta",
            PublishedMethod::PostPerspective => "PSM",
            PublishedMethod::HalfAngle => "half-angle",
        };
        rows.push(Row {
            label: format!("thesis: {name}{}", angle(published.angle)),
            values: vec![
                published.worst,
                Some(published.average),
                published.average_and_deviation,
            ],
        });
    }
    Bars {
        title: scene.name.to_owned(),
        label: "pixels per texel".to_owned(),
        series: ["worst", "average", "mean + σ"].map(str::to_owned).to_vec(),
        rows,
    }
}

/// The exposure of a scene with a method's tilt; neither can be missing in our scenes.
fn exposed(scene: &Scene, method: Method) -> Option<(Exposure, Tilt)> {
    let exposure = scene.exposure().ok()?;
    let tilt = method.tilt(scene, &exposure).ok()?;
    Some((exposure, tilt))
}

/// Surfaces and light rays in the plane, z to the right.
fn texel_rays(scene: &Scene, method: Method) -> Curves {
    const RAYS: i32 = 25;
    let mut curves: Vec<Curve> = Vec::new();
    let surfaces = scene.surfaces.iter().flat_map(|surface| [surface.from, surface.to]);
    curves.push(curve("surfaces", surfaces.map(|point| (point.x, point.y))));
    if let (Some((exposure, tilt)), Light::Point { position }) = (exposed(scene, method), scene.light) {
        let frame = exposure.film.frame();
        let ends = (0..=RAYS).filter_map(|index| {
            let place = tilt.inverse().place(2.0 * f64::from(index) / f64::from(RAYS) - 1.0);
            let direction = frame.forward() + frame.film() * exposure.hull.coordinate(place);
            let depths = scene.surfaces.iter().filter_map(|surface| {
                let along = surface.to - surface.from;
                let determinant = direction.perp_dot(along);
                let depth = (surface.from - position).perp_dot(along) / determinant;
                let share = (surface.from - position).perp_dot(direction) / determinant;
                // The hull's end rays meet ends of surfaces, give or take rounding.
                (depth > 0.0 && (-1.0e-6..=1.0 + 1.0e-6).contains(&share)).then_some(depth)
            });
            Some(position + direction * depths.reduce(f64::min)?)
        });
        let rays = ends.flat_map(|end| [position, end]);
        curves.push(curve("light rays", rays.map(|point| (point.x, point.y))));
    }
    Curves {
        title: format!("{}, {}", scene.name, method.name()),
        x: axis("z, metres; the camera is at z = 0", Scale::Linear),
        y: axis("y, metres", Scale::Linear),
        curves,
    }
}

fn over_the_picture(scene: &Scene) -> Curves {
    let hits = scene.camera.see(&scene.surfaces);
    let curves = [Method::L1, Method::L2, Method::HalfAngle, Method::PostPerspective]
        .into_iter()
        .filter_map(|method| {
            let (exposure, tilt) = exposed(scene, method)?;
            let per_texel = 2.0 / f64::from(scene.camera.pixels());
            let points = hits.iter().zip(&exposure.samples);
            let points = points.map(|(hit, sample)| (hit.pixel, sample.tilted(tilt).badness * per_texel));
            Some(curve(method.name(), points))
        });
    Curves {
        title: scene.name.to_owned(),
        x: axis("place in the picture, bottom to top", Scale::Linear),
        y: axis("pixels per texel", Scale::Logarithmic),
        curves: curves.collect(),
    }
}

fn metrics(scene: &Scene) -> Curves {
    let mut curves = Vec::new();
    if let Some((exposure, best)) = exposed(scene, Method::L1) {
        let sample = |of: &dyn Fn(Footprints) -> f64| -> Vec<(f64, f64)> {
            let steps = (-80..=80).map(|step| best.parameter + f64::from(step) / 40.0);
            let values = steps.filter_map(|parameter| {
                let footprints = Footprints::of(&exposure.samples, Tilt::new(parameter), 1.0)?;
                Some((parameter, of(footprints)))
            });
            let values: Vec<(f64, f64)> = values.collect();
            let least = values.iter().map(|(_, value)| *value).fold(f64::INFINITY, f64::min);
            values
                .into_iter()
                .map(|(parameter, value)| (parameter, value / least))
                .collect()
        };
        let squares = |footprints: Footprints| footprints.average.powi(2) + footprints.deviation.powi(2);
        curves.push(curve("L1", sample(&|footprints| footprints.average)));
        curves.push(curve("L2", sample(&squares)));
        curves.push(curve("L∞", sample(&|footprints| footprints.worst)));
        for method in [Method::HalfAngle, Method::PostPerspective] {
            if let Some((_, tilt)) = exposed(scene, method) {
                curves.push(curve(method.name(), [(tilt.parameter, 1.0), (tilt.parameter, 10.0)]));
            }
        }
    }
    Curves {
        title: scene.name.to_owned(),
        x: axis("s, from the half-angle film", Scale::Linear),
        y: Axis {
            range: Some(0.9..20.0),
            ..axis("times its least", Scale::Logarithmic)
        },
        curves,
    }
}

fn near_planes(scene: &Scene) -> Curves {
    let map = PostPerspective::new(&scene.camera, scene.light, &scene.camera.see(&scene.surfaces));
    let mut curves = Vec::new();
    if let Ok(map) = map {
        let angles = ratios(0.01, 1.0, 100).filter_map(|share| {
            let angle = map.printed_rule_angle(share)?;
            Some((share, printed_angle(angle)))
        });
        curves.push(curve("thesis's rule", angles));
    }
    for method in [Method::PostPerspective, Method::L1, Method::HalfAngle] {
        if let Some(angle) = row(scene, method).ok().and_then(|row| row.angle) {
            curves.push(curve(method.name(), [(0.01, angle), (1.0, angle)]));
        }
    }
    Curves {
        title: scene.name.to_owned(),
        x: axis(
            "near plane on the way from the light to the nearest point",
            Scale::Logarithmic,
        ),
        y: axis("film angle, degrees from vertical", Scale::Linear),
        curves,
    }
}

fn lost() -> Bars {
    let methods = [Method::HalfAngle, Method::L1, Method::L2, Method::PostPerspective];
    let rows = scenes().into_iter().map(|scene| {
        let share = |method| {
            let (exposure, tilt) = exposed(&scene, method)?;
            lost_share(&exposure.samples, tilt).ok().map(|share| 100.0 * share)
        };
        Row {
            label: scene.name.to_owned(),
            values: methods.map(share).to_vec(),
        }
    });
    Bars {
        title: "lost texels".to_owned(),
        label: "% of the film".to_owned(),
        series: methods.map(|method| method.name().to_owned()).to_vec(),
        rows: rows.collect(),
    }
}

fn coarse_passes(metric: Metric) -> Curves {
    let curves = scenes().into_iter().map(|scene| {
        let points = COARSE_PIXELS.iter().filter_map(|pixels| {
            let error = coarse_pass_error(&scene, *pixels, metric, CoarseHull::Own).ok()?;
            Some((f64::from(*pixels), 100.0 * error))
        });
        curve(scene.name, points)
    });
    let (title, label) = match metric {
        Metric::L1 => ("L1", "added mean, %"),
        Metric::L2 => ("L2", "added mean + σ, %"),
    };
    Curves {
        title: title.to_owned(),
        x: axis("pixels of the first pass", Scale::Logarithmic),
        y: axis(label, Scale::Linear),
        curves: curves.collect(),
    }
}

fn gains(title: &str, merging: Merging, extent: SliceExtent) -> Curves {
    let curves = scenes().into_iter().map(|scene| {
        let average = |frusta| split_average(&scene, frusta, merging, extent).unwrap_or(f64::NAN);
        let one = average(1);
        curve(scene.name, (1..=8).map(|frusta| (frusta as f64, one / average(frusta))))
    });
    Curves {
        title: title.to_owned(),
        x: axis("frusta", Scale::Linear),
        y: Axis {
            range: Some(0.95..4.0),
            ..axis("mean with one ÷ mean", Scale::Linear)
        },
        curves: curves.collect(),
    }
}

fn allocation(scene: &Scene) -> Bars {
    let mut rows = Vec::new();
    for count in 1..=4 {
        let Ok(split) = split_scene(scene, count, Metric::L1, Merging::Exact, SliceExtent::Borders) else {
            continue;
        };
        let texels = whole_texels(&split.errors(), 1000, Metric::L1, FillFrom::One).unwrap_or_default();
        for (index, (frustum, texels)) in split.frusta.iter().zip(texels).enumerate() {
            rows.push(Row {
                label: format!("{} of {}", index + 1, split.frusta.len()),
                values: vec![
                    Some(50.0 * (frustum.high - frustum.low)),
                    Some(f64::from(texels) / 10.0),
                ],
            });
        }
    }
    Bars {
        title: scene.name.to_owned(),
        label: "%".to_owned(),
        series: ["of the initial film", "of the texels"].map(str::to_owned).to_vec(),
        rows,
    }
}
