//! Decides what every chain shows.

use bevy::{camera::visibility::VisibilityRange, log::warn_once, prelude::*};

use super::{
    LodCounts,
    chain::{LodChain, LodCoat, LodState},
    eyes::LodEyes,
    settings::{LodDriver, LodKind, LodSettings, LodShadows, LodTransition},
};
use crate::maths::lod::{
    blend::{Coat, coats, wins_ties},
    crossing::{Crossing, Shown},
};

/// Parts as the system writes them.
type Parts<'w, 's> = Query<'w, 's, (&'static mut Visibility, Option<&'static mut LodCoat>)>;

/// Brings all chains up to date.
pub(super) fn select_levels(
    mut commands: Commands,
    time: Res<Time>,
    settings: Res<LodSettings>,
    eyes: Res<LodEyes>,
    mut chains: Query<(
        Entity,
        Ref<LodChain>,
        Option<Ref<LodTransition>>,
        Ref<Transform>,
        Ref<GlobalTransform>,
        Has<ChildOf>,
        &mut LodState,
    )>,
    mut parts: Parts,
    mut counts: ResMut<LodCounts>,
) {
    *counts = LodCounts::default();
    if eyes.is_empty() {
        return;
    }
    let step_seconds = time.delta_secs_f64();
    for (entity, chain, own_transition, local, global, is_child, mut state) in &mut chains {
        counts.chains += 1;
        let is_crossing = matches!(state.shown, Some(Shown::Crossing(_)));
        let has_moved = local.is_changed() || (is_child && global.is_changed());
        let is_touched = chain.is_changed() || own_transition.as_ref().is_some_and(Ref::is_changed);
        if eyes.travelled() < state.rests_until && !is_crossing && !has_moved && !is_touched && !eyes.are_new() {
            continue;
        }
        counts.compared += 1;
        let transition = own_transition.map_or(settings.transition, |own| *own);
        let position = if is_child {
            global.translation()
        } else {
            local.translation
        };
        let view = View {
            distance: eyes.distance(position, chain.metric),
            factor: eyes.largest_factor(chain.metric),
            step_seconds: (!eyes.have_jumped()).then_some(step_seconds),
        };
        if transition.kind == LodKind::Dither {
            let offset = eyes.camera_offset(position);
            let band = transition.driver.band();
            let blend = chain.borders.blend_at(view.distance, band.into());
            let is_moved = offset.is_some() && state.dithered != Some(blend);
            if state.dithered.is_none() || is_touched || eyes.are_new() || is_moved {
                dither(
                    &mut commands,
                    &mut parts,
                    &chain,
                    [view.factor as f32, band, offset.unwrap_or(0.0)],
                );
                *state = LodState {
                    dithered: Some(blend),
                    ..default()
                };
            }
            // Bevy looks at the distance of cameras, but not at that of eyes elsewhere.
            state.rests_until = if offset.is_some() { 0.0 } else { f64::INFINITY };
            continue;
        }
        if state.dithered.take().is_some() {
            for part in chain.levels.iter().flatten() {
                commands.entity(*part).try_remove::<VisibilityRange>();
            }
        }
        if transition.kind == LodKind::Geomorph {
            warn_once!(
                "geomorphing needs meshes whose levels correspond, and no loaded file has them: switching at once"
            );
        }
        let (shown, slack) = next(&chain, state.shown, transition, &settings, &view);
        state.rests_until = eyes.travelled() + slack;
        if let Shown::Crossing(crossing) = shown {
            counts.crossings += 1;
            let fading = |level: usize| chain.levels.get(level).map_or(0, Vec::len) as u32;
            let [old, new] = coats(transition.kind.blend(), crossing.t);
            for (coat, level) in [(old, crossing.from), (new, crossing.to)] {
                counts.fading_parts += if coat.alpha > 0.0 && !coat.writes_depth {
                    fading(level)
                } else {
                    0
                };
            }
        }
        if state.shown != Some(shown) {
            show(
                &mut commands,
                &mut parts,
                (entity, &chain),
                shown,
                transition.kind,
                settings.shadows,
            );
            state.shown = Some(shown);
        }
    }
}

/// How the eyes see a chain.
struct View {
    /// What borders are compared with, metres.
    distance: f64,
    /// By how much more than an eye the distance can change.
    factor: f64,
    /// Since the last frame; `None`: nothing fades.
    step_seconds: Option<f64>,
}

/// What a chain shows next, and how far eyes may move until that can change.
fn next(
    chain: &LodChain,
    before: Option<Shown>,
    transition: LodTransition,
    settings: &LodSettings,
    view: &View,
) -> (Shown, f64) {
    let late = f64::from(settings.late_factor).max(1.0);
    let (distance, factor) = match transition.kind {
        LodKind::Late => (view.distance / late, view.factor / late),
        _ => (view.distance, view.factor),
    };
    let fades = matches!(transition.kind, LodKind::Plain | LodKind::Unpopping);
    if let (true, LodDriver::Distance { metres }) = (fades, transition.driver) {
        let (level, t) = chain.borders.blend_at(distance, metres.into());
        return match t {
            Some(t) => {
                let crossing = Crossing {
                    from: level,
                    to: level + 1,
                    t,
                };
                (Shown::Crossing(crossing), 0.0)
            }
            None => {
                let range = chain.borders.range(level);
                let start = (range.end - f64::from(metres)).max(range.start);
                let slack = (start - distance).min(distance - range.start).max(0.0);
                (Shown::Level(level), slack / factor)
            }
        };
    }
    let hysteresis = f64::from(settings.hysteresis);
    let wanted = match before {
        Some(shown) => chain.borders.held_level(shown.goal(), distance, hysteresis),
        None => chain.borders.level_at(distance),
    };
    // A crossing of a kind that fades takes its time; all else happens at once.
    let step = match (before, view.step_seconds, transition.driver) {
        (Some(_), Some(seconds), LodDriver::Time { seconds: whole }) if fades && whole > 0.0 => {
            seconds / f64::from(whole)
        }
        _ => 1.0,
    };
    let mut shown = before.unwrap_or(Shown::Level(wanted)).advanced(wanted, step);
    if step >= 1.0 {
        shown = Shown::Level(wanted);
    }
    let slack = match shown {
        Shown::Level(level) => chain.borders.slack(level, distance, hysteresis) / factor,
        Shown::Crossing(_) => 0.0,
    };
    (shown, slack)
}

/// Dresses all parts of a chain for what it shows.
fn show(
    commands: &mut Commands,
    parts: &mut Parts,
    (entity, chain): (Entity, &LodChain),
    shown: Shown,
    kind: LodKind,
    shadows: LodShadows,
) {
    for (level, entities) in chain.levels.iter().enumerate() {
        let (coat, other) = match shown {
            Shown::Level(at) if at == level => (Coat::OPAQUE, level),
            Shown::Crossing(crossing) => {
                let [old, new] = coats(kind.blend(), crossing.t);
                if level == crossing.from {
                    (old, crossing.to)
                } else if level == crossing.to {
                    (new, crossing.from)
                } else {
                    (Coat::HIDDEN, level)
                }
            }
            Shown::Level(_) => (Coat::HIDDEN, level),
        };
        let wanted = (coat.alpha > 0.0 && !coat.writes_depth).then(|| LodCoat {
            alpha: coat.alpha as f32,
            shadow: match (shadows, kind) {
                // Neither level is opaque: both cast as much as they show.
                (_, LodKind::Plain) | (LodShadows::Fading, _) => coat.alpha as f32,
                (LodShadows::Solid, _) => 0.0,
                (LodShadows::Both, _) => 1.0,
            },
            wins_ties: wins_ties(level, other),
            object: entity.index_u32(),
        });
        let visibility = if coat.alpha > 0.0 {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        };
        for part in entities {
            let Ok((mut own_visibility, own_coat)) = parts.get_mut(*part) else {
                continue;
            };
            own_visibility.set_if_neq(visibility);
            match (own_coat, wanted) {
                (Some(mut own), Some(wanted)) => {
                    own.set_if_neq(wanted);
                }
                (None, Some(wanted)) => {
                    commands.entity(*part).insert(wanted);
                }
                (Some(_), None) => {
                    commands.entity(*part).remove::<LodCoat>();
                }
                (None, None) => {}
            }
        }
    }
}

/// Hands a chain to Bevy's visibility ranges. `factor` is that of the lens, crossings begin `band` metres before borders,
/// and Bevy's distances are `offset` too large.
fn dither(commands: &mut Commands, parts: &mut Parts, chain: &LodChain, [factor, band, offset]: [f32; 3]) {
    // Ranges of Bevy's may not fall.
    let margin = |border: f64| {
        let border = border as f32;
        let [from, to] = [border - band, border].map(|end| (end / factor + offset).max(0.0));
        if border > 0.0 && border.is_finite() {
            from..to
        } else {
            border..border
        }
    };
    for (level, entities) in chain.levels.iter().enumerate() {
        let range = chain.borders.range(level);
        let visible = VisibilityRange {
            start_margin: margin(range.start),
            end_margin: margin(range.end),
            use_aabb: false,
        };
        for part in entities {
            if let Ok((mut visibility, _)) = parts.get_mut(*part) {
                visibility.set_if_neq(Visibility::Inherited);
                commands.entity(*part).remove::<LodCoat>().insert(visible.clone());
            }
        }
    }
}
