//! The light planes of a take: how many films there are, what they gain and what damping costs.

use bevy::prelude::*;
use serde::Serialize;

use crate::shadow::light_plane::LightPlaneStates;

/// One camera's films.
#[derive(Clone, Debug, Serialize)]
pub(in crate::cli) struct FilmStats {
    /// Films; 0 where a uniform map stands in.
    count: usize,
    /// Why a uniform map stands in.
    #[serde(skip_serializing_if = "Option::is_none")]
    missing: Option<String>,
    /// Mean of the metric over the pixels: pixels per texel for the area.
    mean_error: f64,
    /// Total error of a uniform map of as many texels over that of the films.
    gain: f64,
    /// What damping costs: the error over that of the best films, less 1, in percent.
    damping_cost_percent: f64,
}

/// The films of a sun for a camera; `None` without light planes.
pub(in crate::cli) fn stats_of(app: &App, sun: Entity, camera: Entity) -> Option<FilmStats> {
    let states = app.world().get::<LightPlaneStates>(sun)?;
    let films = states.cameras.get(&camera)?.films?;
    Some(match films {
        Ok(report) => FilmStats {
            count: report.count,
            missing: None,
            mean_error: report.mean_error,
            gain: report.gain,
            damping_cost_percent: report.damping_cost * 100.0,
        },
        Err(reason) => FilmStats {
            count: 0,
            missing: Some(reason.to_string()),
            mean_error: 0.0,
            gain: 1.0,
            damping_cost_percent: 0.0,
        },
    })
}
