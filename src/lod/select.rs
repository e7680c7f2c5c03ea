//! Decides what every chain shows.

use bevy::{camera::visibility::VisibilityRange, log::warn_once, mesh::morph::MeshMorphWeights, prelude::*};

use super::{
    LodCounts,
    casters::{CastsFor, LodShadowBias, product},
    chain::{LodChain, LodCoat, LodMorph, LodState},
    eyes::LodEyes,
    settings::{LodDriver, LodKind, LodSettings, LodShadows, LodTransition},
};
use crate::maths::lod::{
    blend::{Coat, coats, wins_ties},
    crossing::{Crossing, Shown},
};

/// Parts as the system writes them.
type Parts<'w, 's> = Query<
    'w,
    's,
    (
        &'static mut Visibility,
        Option<&'static mut LodCoat>,
        Option<&'static mut Mesh3d>,
        Option<&'static mut MeshMorphWeights>,
        Has<LodMorph>,
    ),
>;

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
        (Has<CastsFor>, Option<Ref<LodShadowBias>>),
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
    for (entity, chain, own_transition, local, global, is_child, (only_casts, shadow_bias), mut state) in &mut chains {
        counts.chains += u32::from(!only_casts);
        let is_crossing = matches!(state.shown, Some(Shown::Crossing(_)));
        let has_moved = local.is_changed() || (is_child && global.is_changed());
        let is_touched = chain.is_changed()
            || own_transition.as_ref().is_some_and(Ref::is_changed)
            || shadow_bias.as_ref().is_some_and(Ref::is_changed);
        let may_rest = !is_crossing && !has_moved && !is_touched && !eyes.are_new() && settings.right_half.is_none();
        if eyes.travelled() < state.rests_until && may_rest {
            continue;
        }
        counts.compared += 1;
        let position = if is_child {
            global.translation()
        } else {
            local.translation
        };
        let mut transition = match (own_transition, settings.right_half) {
            (Some(own), _) => *own,
            (None, Some(kind)) if eyes.is_right(position) => LodTransition {
                kind,
                ..settings.transition
            },
            (None, _) => settings.transition,
        };
        if transition.kind == LodKind::Geomorph && !corresponds(&chain, &parts) {
            warn_once!("there are levels of detail whose meshes do not correspond: they fade instead of morphing");
            transition.kind = LodKind::Unpopping;
        }
        let (distance, factor) = if only_casts {
            let bias = product([settings.shadow_bias, shadow_bias.map_or(1.0, |bias| bias.0)]);
            let distance = eyes.shadow_distance(position, chain.metric);
            (distance * bias, eyes.largest_shadow_factor(chain.metric) * bias)
        } else {
            (eyes.distance(position, chain.metric), eyes.largest_factor(chain.metric))
        };
        let view = View {
            distance,
            factor,
            step_seconds: (!eyes.have_jumped()).then_some(step_seconds),
        };
        if transition.kind == LodKind::Dither {
            let offset = eyes.camera_offset(position);
            let band = transition.driver.band();
            let blend = chain.borders.blend_at(view.distance, band.into());
            let is_moved = offset.is_some() && state.dithered != Some(blend);
            if state.dithered.is_none() || is_touched || eyes.are_new() || is_moved {
                if state.dithered.is_none() {
                    for part in chain.levels.iter().flatten() {
                        touch_mesh(&mut parts, *part);
                    }
                }
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
                touch_mesh(&mut parts, *part);
            }
        }
        let (shown, slack) = next(&chain, state.shown, transition, &settings, &view);
        state.rests_until = eyes.travelled() + slack;
        if let Shown::Crossing(crossing) = shown {
            counts.crossings += u32::from(!only_casts);
            let fading = |level: usize| chain.levels.get(level).map_or(0, Vec::len) as u32;
            // A morph is one level, and nothing fades.
            let coats = (transition.kind != LodKind::Geomorph).then(|| coats(transition.kind.blend(), crossing.t));
            let [old, new] = coats.unwrap_or([Coat::HIDDEN; 2]);
            for (coat, level) in [(old, crossing.from), (new, crossing.to)] {
                counts.fading_parts += if coat.alpha > 0.0 && !coat.writes_depth {
                    fading(level)
                } else {
                    0
                };
            }
        }
        let drawn_as = Some((transition.kind, settings.shadows));
        if state.shown != Some(shown) || state.drawn_as != drawn_as || chain.is_changed() {
            show(
                &mut commands,
                &mut parts,
                (entity, &chain),
                shown,
                transition.kind,
                settings.shadows,
            );
            state.shown = Some(shown);
            state.drawn_as = drawn_as;
        }
    }
}

/// Whether a chain can morph: all of its levels but the last know where their vertices lie in the next.
fn corresponds(chain: &LodChain, parts: &Parts) -> bool {
    let morphs = |part: &Entity| parts.get(*part).is_ok_and(|(.., morphs)| morphs);
    let finer = chain.levels.split_last().map_or(&[][..], |(_, finer)| finer);
    finer.iter().flatten().all(morphs)
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
    let fades = matches!(transition.kind, LodKind::Plain | LodKind::Unpopping | LodKind::Geomorph);
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
    let next_wanted = match (transition.kind, before) {
        // Levels correspond with their neighbours only.
        (LodKind::Geomorph, Some(Shown::Level(level))) => wanted.clamp(level.saturating_sub(1), level + 1),
        _ => wanted,
    };
    let mut shown = before.unwrap_or(Shown::Level(wanted)).advanced(next_wanted, step);
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
        let mut morph = 0.0;
        let (coat, other) = match shown {
            Shown::Level(at) if at == level => (Coat::OPAQUE, level),
            Shown::Crossing(crossing) if kind == LodKind::Geomorph => {
                let is_finer = level == crossing.from.min(crossing.to);
                if is_finer {
                    morph = crossing.coarseness() as f32;
                }
                (if is_finer { Coat::OPAQUE } else { Coat::HIDDEN }, level)
            }
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
            dithers_shadow: kind == LodKind::Plain,
            object: entity.index_u32(),
        });
        let visibility = if coat.alpha > 0.0 {
            Visibility::Inherited
        } else {
            Visibility::Hidden
        };
        for part in entities {
            let Ok((mut own_visibility, own_coat, _, weights, morphs)) = parts.get_mut(*part) else {
                continue;
            };
            own_visibility.set_if_neq(visibility);
            if let (Some(mut weights), true) = (weights, morphs)
                && let MeshMorphWeights::Value { weights: known } = weights.bypass_change_detection()
                && let Some(first) = known.first_mut().filter(|first| **first != morph)
            {
                *first = morph;
                weights.set_changed();
            }
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

/// Marks a part's mesh as changed: Bevy chooses the shader, with dither or without, when a mesh or its material is new, but
/// not when a [`VisibilityRange`] is.
fn touch_mesh(parts: &mut Parts, part: Entity) {
    if let Ok((_, _, Some(mut mesh), ..)) = parts.get_mut(part) {
        mesh.set_changed();
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
            if let Ok((mut visibility, ..)) = parts.get_mut(*part) {
                visibility.set_if_neq(Visibility::Inherited);
                commands.entity(*part).remove::<LodCoat>().insert(visible.clone());
            }
        }
    }
}
