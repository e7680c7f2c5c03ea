//! Shadows of other levels than those that are seen.
//!
//! Shadows need less detail than what casts them, or more where a small map is sharp. A chain whose shadows are biased gets
//! a second chain: clones of its parts that no camera draws, while its own parts cast nothing. The second chain takes the
//! way of any other, with its distances multiplied: it crosses from level to level by itself, and its shadows change as
//! those of other chains do ([`LodShadows`](super::settings::LodShadows)).
//!
//! Limits: twice the entities for such chains. A chain gets its second one when it rests. One whose levels are replaced
//! begins anew. Truth, which rays are traced for, has the shadows of what is seen.

use std::any::TypeId;

use bevy::{
    camera::visibility::{VisibilitySystems, VisibleEntities},
    ecs::{lifecycle::HookContext, world::DeferredWorld},
    light::NotShadowCaster,
    prelude::*,
};

use super::{
    LodSystems,
    chain::{LodChain, LodCoat},
    eyes::LodEyes,
    settings::{LodSettings, LodTransition},
};

/// On a chain: factor on its distances for shadows, beside the global one and those of views. Above 1 coarser shadows, below
/// 1 finer ones.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct LodShadowBias(pub f32);

impl Default for LodShadowBias {
    fn default() -> Self {
        Self(1.0)
    }
}

/// On the second chain of another one, and on its parts.
#[derive(Component, Debug)]
#[relationship(relationship_target = Casters)]
pub struct CastsFor(pub Entity);

/// On a chain: its second one, and the parts of that.
#[derive(Component, Debug)]
#[relationship_target(relationship = CastsFor, linked_spawn)]
pub struct Casters(Vec<Entity>);

/// On a mesh that casts a shadow, but is in no camera's picture.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ShadowOnly;

/// On a part whose shadow another one casts.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(NotShadowCaster)]
#[component(on_remove = cast_again)]
pub struct Silenced;

fn cast_again(mut world: DeferredWorld, context: HookContext) {
    world.commands().entity(context.entity).try_remove::<NotShadowCaster>();
}

pub(super) fn plugin(app: &mut App) {
    app.register_type::<LodShadowBias>().add_systems(
        PostUpdate,
        (
            bias_shadows.after(LodSystems::Look).before(LodSystems::Select),
            hide_from_cameras
                .after(VisibilitySystems::CheckVisibility)
                .run_if(any_with_component::<ShadowOnly>),
        ),
    );
}

/// Product of factors; those that are not positive, or no numbers, count as 1.
pub(super) fn product(factors: impl IntoIterator<Item = f32>) -> f64 {
    let valid = |factor: f32| factor > 0.0 && factor.is_finite();
    factors
        .into_iter()
        .filter(|factor| valid(*factor))
        .map(f64::from)
        .product()
}

/// Gives chains a second one whose shadows are biased, and takes it from those whose are not.
fn bias_shadows(
    mut commands: Commands,
    settings: Res<LodSettings>,
    eyes: Res<LodEyes>,
    biases: Query<(), With<LodShadowBias>>,
    chains: Query<
        (
            Entity,
            Ref<LodChain>,
            &GlobalTransform,
            Option<&LodShadowBias>,
            Option<&LodTransition>,
            Option<&Casters>,
        ),
        Without<CastsFor>,
    >,
    seconds: Query<(Entity, Option<&LodShadowBias>, Option<&LodTransition>), (With<LodChain>, With<CastsFor>)>,
    (coated, not_casting): (Query<(), With<LodCoat>>, Query<(), With<NotShadowCaster>>),
) {
    let is_biased_for_all = product([settings.shadow_bias]) != 1.0 || eyes.have_biased_shadows();
    if !is_biased_for_all && biases.is_empty() && seconds.is_empty() {
        return;
    }
    for (entity, chain, place, bias, transition, casters) in &chains {
        let is_biased = is_biased_for_all || product(bias.map(|bias| bias.0)) != 1.0;
        let parts = || chain.levels.iter().flatten().copied();
        let second = casters.and_then(|casters| casters.iter().find_map(|caster| seconds.get(caster).ok()));
        match second {
            None if is_biased && parts().all(|part| !coated.contains(part)) => {
                let mut second = LodChain::clone(&chain);
                for parts in &mut second.levels {
                    parts.retain(|part| !not_casting.contains(*part));
                    for part in parts {
                        *part = cast_apart(&mut commands, entity, *part);
                    }
                }
                // Where the first one is, wherever that goes.
                let place = (ChildOf(entity), Transform::IDENTITY, *place);
                let bias = bias.copied().unwrap_or_default();
                let mut second = commands.spawn((second, bias, CastsFor(entity), place));
                if let Some(transition) = transition {
                    second.insert(*transition);
                }
            }
            Some(_) if !is_biased || chain.is_changed() => {
                commands.entity(entity).despawn_related::<Casters>();
                for part in parts() {
                    commands.entity(part).try_remove::<Silenced>();
                }
            }
            Some((second, known_bias, known_transition)) => {
                let mut second = commands.entity(second);
                let bias = bias.copied().unwrap_or_default();
                if known_bias != Some(&bias) {
                    second.insert(bias);
                }
                match transition {
                    Some(own) if known_transition != Some(own) => {
                        second.insert(*own);
                    }
                    None if known_transition.is_some() => {
                        second.remove::<LodTransition>();
                    }
                    _ => {}
                }
            }
            None => {}
        }
    }
}

/// Lets a clone of a part cast its shadow.
fn cast_apart(commands: &mut Commands, chain: Entity, part: Entity) -> Entity {
    let mut part = commands.entity(part);
    part.insert(Silenced);
    let mut clone = part.clone_and_spawn_with_opt_out(|cloner| {
        cloner.deny::<(Silenced, NotShadowCaster)>();
    });
    clone.insert((CastsFor(chain), ShadowOnly)).id()
}

/// Takes what only casts out of pictures.
fn hide_from_cameras(mut cameras: Query<&mut VisibleEntities, With<Camera>>, only_cast: Query<(), With<ShadowOnly>>) {
    for mut visible in &mut cameras {
        visible
            .get_mut(TypeId::of::<Mesh3d>())
            .retain(|entity| !only_cast.contains(*entity));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_factors_count_as_one() {
        assert_eq!(product([2.0, 0.5, 3.0]), 3.0);
        assert_eq!(product([f32::NAN, 0.0, -1.0, f32::INFINITY, 2.0]), 2.0);
        assert_eq!(product([]), 1.0);
    }
}
