//! Writes the head-up display: technique, its settings, frame time, place.

use std::time::Duration;

use bevy::{
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
    render::renderer::RenderAdapterInfo,
    time::common_conditions::on_real_timer,
};

use super::{
    DemoSystems,
    player::Player,
    screens::Screen,
    sun::{Day, SunAngles},
    technique::{Chosen, Setting},
    walker::Mode,
};
use crate::{
    level::{LoadedScene, Sun, sky::course::clock},
    lod::LodCounts,
    shadow::{measured::VisibleDepthRange, technique::Technique},
    ui::hud::HudText,
};

/// A line that says what just happened, for a few seconds.
#[derive(Resource, Default)]
pub struct Notice {
    text: String,
    left: Duration,
}

impl Notice {
    /// How long a notice stays, in real time.
    const STAYS: Duration = Duration::from_secs(4);

    /// Shows `text` in place of the last notice.
    pub fn show(&mut self, text: impl Into<String>) {
        self.text = text.into();
        self.left = Self::STAYS;
    }

    /// The text; empty when its time is over.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// How often numbers change on screen: often enough to follow, seldom enough to read.
const REFRESH: Duration = Duration::from_millis(250);

pub(super) fn plugin(app: &mut App) {
    if !app.is_plugin_added::<FrameTimeDiagnosticsPlugin>() {
        app.add_plugins(FrameTimeDiagnosticsPlugin::default());
    }
    app.init_resource::<Notice>().add_systems(
        Update,
        (
            fade_notice,
            write_technique,
            write_status.run_if(on_real_timer(REFRESH).or_else(resource_exists_and_changed::<LoadedScene>)),
        )
            .chain()
            .in_set(DemoSystems::Show)
            .run_if(in_state(Screen::Play)),
    );
}

fn fade_notice(time: Res<Time<Real>>, mut notice: ResMut<Notice>, mut hud: ResMut<HudText>) {
    if !notice.text.is_empty() {
        notice.left = notice.left.saturating_sub(time.delta());
        if notice.left.is_zero() {
            notice.text.clear();
        }
    }
    if hud.notice != notice.text {
        hud.notice.clone_from(&notice.text);
    }
}

fn write_technique(chosen: Res<Chosen>, mut hud: ResMut<HudText>) {
    if !chosen.is_changed() && !hud.title.is_empty() {
        return;
    }
    hud.title = chosen.0.to_string();
    hud.settings = match &chosen.0 {
        Technique::Bevy(_) => "Bevy's stock cascades\nT: next technique   F1: help".into(),
        Technique::Umbrage(settings) => Setting::ALL
            .iter()
            .zip(Setting::KEYS)
            .map(|(setting, key)| {
                let value = if setting.applies_to(settings) {
                    setting.value(settings)
                } else {
                    "Bevy's".to_owned()
                };
                format!("{key}  {:<10}  {value}", setting.name())
            })
            .chain(["T: next technique   F1: help".to_owned()])
            .collect::<Vec<_>>()
            .join("\n"),
    };
}

fn write_status(
    diagnostics: Res<DiagnosticsStore>,
    scene: Res<LoadedScene>,
    adapter: Option<Res<RenderAdapterInfo>>,
    players: Query<(&Player, Option<&VisibleDepthRange>)>,
    suns: Query<&Transform, With<Sun>>,
    day: Res<Day>,
    levels: Option<Res<LodCounts>>,
    mut hud: ResMut<HudText>,
) {
    let smoothed = |path| diagnostics.get(&path).and_then(|diagnostic| diagnostic.smoothed());
    let frame_time = smoothed(FrameTimeDiagnosticsPlugin::FRAME_TIME);
    let mut lines = vec![match frame_time {
        Some(milliseconds) if milliseconds > 0.0 => {
            let decimals = usize::from(milliseconds > 100.0);
            format!("{milliseconds:.1} ms   {:.decimals$} frames/s", 1000.0 / milliseconds)
        }
        _ => "- ms".to_owned(),
    }];
    lines.push(scene.name.clone());
    if let Some(adapter) = adapter {
        lines.push(ascii(&adapter.name));
    }
    if let Ok((player, measured)) = players.single() {
        let eye = player.walker.eye();
        let mode = match player.walker.mode {
            Mode::Walk => "walking",
            Mode::Fly => "flying",
        };
        lines.push(format!("{mode} at {:.1} {:.1} {:.1}", eye.x, eye.y, eye.z));
        if let Some(depths) = measured.and_then(|measured| measured.depths) {
            lines.push(format!(
                "depths in the picture {:.2} to {:.1} m",
                depths.nearest, depths.farthest
            ));
        }
    }
    if let Some(sun) = suns.iter().next() {
        let angles = SunAngles::from_light_dir(sun.forward().as_vec3());
        lines.push(format!(
            "sun {:.0} deg from north, {:.1} deg high",
            angles.azimuth.to_degrees().rem_euclid(360.0),
            angles.elevation.to_degrees()
        ));
    }
    if let Some(counts) = levels.filter(|counts| counts.chains > 0) {
        lines.push(format!(
            "{} objects in levels, {} changing",
            counts.chains, counts.crossings
        ));
    }
    if let Some(hour) = day.hour {
        let course = scene.sun.course();
        lines.push(format!(
            "{} on day {} at {:.0} deg north",
            clock(hour),
            course.day,
            course.latitude_deg
        ));
    }
    let status = lines.join("\n");
    if hud.status != status {
        hud.status = status;
    }
}

/// The built-in font has ASCII only.
fn ascii(text: &str) -> String {
    text.chars()
        .map(|letter| if letter.is_ascii() { letter } else { '?' })
        .collect()
}
