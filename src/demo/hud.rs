//! Writes the head-up display: technique, its settings, frame time, place, tiles of virtual maps.

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
    render::virtual_map::report::{VirtualMapReport, VirtualMapReports},
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
    players: Query<(Entity, &Player, Option<&VisibleDepthRange>)>,
    virtual_maps: Option<Res<VirtualMapReports>>,
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
    if let Ok((camera, player, measured)) = players.single() {
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
        if let Some(report) = virtual_maps.and_then(|reports| reports.get(camera)) {
            lines.extend(virtual_map_lines(&report));
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

/// Sizes of tiles that have a place in a line; the others are counted.
const LISTED_SIZES: usize = 4;

/// What a virtual map has drawn: tiles, texels, resolution, and how many tiles of each size.
fn virtual_map_lines(report: &VirtualMapReport) -> Vec<String> {
    if report.tiles.is_empty() {
        return vec!["virtual map without tiles".to_owned()];
    }
    let mut first = format!(
        "{} tiles, {:.1} M texels, as fine as {} x {}",
        report.tiles.len(),
        report.texels() as f64 / 1.0e6,
        report.effective_resolution(),
        report.effective_resolution()
    );
    if let Some(counts) = &report.fitted {
        first += &format!(", {:.1} % capped", counts.capped_percent());
    }
    let sizes = report.sizes();
    let (listed, others) = sizes.split_at(sizes.len().min(LISTED_SIZES));
    let mut list: Vec<String> = listed
        .iter()
        .map(|(size, count)| format!("{count} of {} x {}", size.x, size.y))
        .collect();
    if !others.is_empty() {
        let count: usize = others.iter().map(|(_, count)| count).sum();
        list.push(format!("{count} smaller"));
    }
    vec![first, list.join(", ")]
}

/// The built-in font has ASCII only.
fn ascii(text: &str) -> String {
    text.chars()
        .map(|letter| if letter.is_ascii() { letter } else { '?' })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        maths::virtual_map::{
            picture::PixelRect,
            tile::{Tile, TileWindow},
        },
        render::virtual_map::{fitted::plan::FittedCounts, report::DrawnTile, tiles::TileDraw},
    };

    #[test]
    fn tiles_of_virtual_maps_are_listed() {
        let tile = |side: u32, margin: u32| DrawnTile {
            draw: TileDraw::filling(
                Tile {
                    place: UVec2::ZERO,
                    counts: UVec2::splat(32),
                },
                TileWindow::of_size(UVec2::splat(side), margin),
                PixelRect::EMPTY,
            ),
            report: None,
            decision: None,
        };
        let sides = [66, 2050, 130, 258, 66, 514, 514, 34];
        let mut report = VirtualMapReport::default();
        assert_eq!(virtual_map_lines(&report), ["virtual map without tiles"]);
        report.tiles = sides.map(|side| tile(side, 1)).to_vec();
        assert_eq!(
            virtual_map_lines(&report),
            [
                "8 tiles, 4.8 M texels, as fine as 65536 x 65536",
                "1 of 2050 x 2050, 2 of 514 x 514, 1 of 258 x 258, 1 of 130 x 130, 3 smaller"
            ]
        );
        report.fitted = Some(FittedCounts {
            pixels: 200,
            capped: 3,
            ..default()
        });
        assert!(virtual_map_lines(&report)[0].ends_with(", 1.5 % capped"));
    }
}
