//! glTF files as scenes: spawned as they are, with their levels of detail, a sun of ours and a shot that frames them.

use std::{collections::HashMap, path::Path};

use bevy::{
    asset::{AssetPath, LoadState, RecursiveDependencyLoadState},
    camera::primitives::{Aabb, MeshAabb},
    gltf::{Gltf, GltfLoaderSettings},
    prelude::*,
    world_serialization::WorldInstanceReady,
};

use super::{
    format::{Air, Spawn, SunSettings},
    gltf_lods::{self, GltfScene},
    ground::Ground,
    load::{Job, LevelEntity, LoadedScene, SceneStatus, loading, one_sentence},
    shot::Shot,
    sky,
};

/// A glTF file that is being loaded.
pub(super) enum GltfJob {
    /// Waiting for the file and all that it names.
    File {
        handle: Handle<Gltf>,
        file: String,
        name: String,
    },
    /// Waiting for its entities.
    Instance {
        root: Entity,
        handle: Handle<Gltf>,
        file: String,
        name: String,
    },
}

/// On the root of a glTF scene whose entities are all there.
#[derive(Component)]
pub(super) struct Instanced;

impl GltfJob {
    pub(super) fn start(server: &AssetServer, path: &Path) -> Self {
        // Bevy would look for relative paths in its assets folder.
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        let settings = |settings: &mut GltfLoaderSettings| {
            settings.load_cameras = false;
            // Which nodes are levels of others is said by an extension that Bevy does not read.
            settings.include_source = true;
        };
        Self::File {
            handle: server
                .load_builder()
                .with_settings(settings)
                .load(AssetPath::from_path_buf(absolute)),
            file: path.display().to_string(),
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }
}

/// Takes the next step of a glTF file, if one is due.
pub(super) fn advance_gltf(
    mut commands: Commands,
    server: Res<AssetServer>,
    files: Option<Res<Assets<Gltf>>>,
    meshes: Res<Assets<Mesh>>,
    instanced: Query<(), With<Instanced>>,
    children: Query<&Children>,
    parts: Query<(&Mesh3d, &GlobalTransform)>,
    mut scene: GltfScene,
    mut job: ResMut<Job>,
    mut status: ResMut<SceneStatus>,
) {
    let Job::Gltf(gltf) = &mut *job else { return };
    let next = match gltf {
        GltfJob::File { handle, file, name } => {
            let load_state = server.load_state(&*handle);
            let all = server.recursive_dependency_load_state(&*handle);
            match (load_state, all, files.as_ref().and_then(|files| files.get(&*handle))) {
                (LoadState::Failed(error), ..) | (_, RecursiveDependencyLoadState::Failed(error), _) => {
                    Err(format!("cannot load {file}: {}", one_sentence(&error)))
                }
                (_, RecursiveDependencyLoadState::Loaded, Some(gltf)) => {
                    match gltf.default_scene.as_ref().or(gltf.scenes.first()) {
                        None => Err(format!("{file} holds no scene: export one that has nodes")),
                        Some(world) => {
                            let root = commands
                                .spawn((WorldAssetRoot(world.clone()), Name::new(name.clone()), LevelEntity))
                                .observe(|ready: On<WorldInstanceReady>, mut commands: Commands| {
                                    commands.entity(ready.entity).insert(Instanced);
                                })
                                .id();
                            *status = loading(700, format!("Placing {name}"));
                            Ok(Job::Gltf(GltfJob::Instance {
                                root,
                                handle: handle.clone(),
                                file: std::mem::take(file),
                                name: std::mem::take(name),
                            }))
                        }
                    }
                }
                (state, ..) => {
                    let done = if state.is_loaded() { 400 } else { 50 };
                    status.set_if_neq(loading(done, format!("Reading {file}")));
                    return;
                }
            }
        }
        GltfJob::Instance {
            root,
            handle,
            file,
            name,
        } => {
            // The marker came after the last Update; transforms were propagated since.
            if !instanced.contains(*root) {
                return;
            }
            let entities = children
                .iter_descendants(*root)
                .filter_map(|entity| parts.get(entity).ok());
            match bounds(entities, &meshes) {
                None => Err(format!(
                    "{file} holds no triangles with finite positions: export one that has meshes"
                )),
                Some((min, max)) => {
                    let mut notes = vec![format!(
                        "{file} has no shots: using one named {SHOT} that frames its bounds, and a sun at 45 degrees"
                    )];
                    let gltf = files.as_ref().and_then(|files| files.get(&*handle));
                    if let Some((gltf, source)) = gltf.and_then(|gltf| Some((gltf, gltf.source.as_ref()?))) {
                        let document = source.as_json();
                        let (chains, problems) = gltf_lods::chains(document);
                        notes.extend(problems.into_iter().map(|problem| format!("{file}: {problem}")));
                        let bounds_of = |entities: &[Entity]| {
                            bounds(entities.iter().filter_map(|entity| parts.get(*entity).ok()), &meshes)
                        };
                        scene.make_chains(&mut commands, (gltf, document), *root, chains, bounds_of);
                    }
                    let mut air = Air::default();
                    // Whatever a unit is, haze shall not hide the scene.
                    air.visibility = air.visibility.max(CLEAR_SIZES * (max - min).length());
                    let sun = SunSettings {
                        light_dir: Some(SUN),
                        air,
                        ..default()
                    };
                    sky::spawn_sun(&mut commands, &sun);
                    let shot = framing_shot(name, min, max);
                    commands.insert_resource(LoadedScene {
                        spawn: Spawn {
                            position: shot.position.into(),
                            look_at: shot.target.into(),
                        },
                        shots: vec![shot],
                        named_only: Vec::new(),
                        sun,
                        ground: Ground::flat(min.y),
                        paths: Vec::new(),
                        notes,
                        name: std::mem::take(name),
                    });
                    *status = SceneStatus::Ready;
                    Ok(Job::None)
                }
            }
        }
    };
    *job = next.unwrap_or_else(|sentence| {
        *status = SceneStatus::Failed(sentence);
        Job::None
    });
}

/// One sees as far as this many times the scene's diagonal, at least.
const CLEAR_SIZES: f32 = 20.0;
/// The made-up shot's name.
const SHOT: &str = "overview";
/// At 45°, from the left of the made-up shot and a little behind it.
const SUN: Vec3 = Vec3::new(0.223_607, -std::f32::consts::FRAC_1_SQRT_2, -0.670_820);

/// Box around meshes in world space; `None` where there is nothing, or something that is not finite.
fn bounds<'a>(
    parts: impl Iterator<Item = (&'a Mesh3d, &'a GlobalTransform)>,
    meshes: &Assets<Mesh>,
) -> Option<(Vec3, Vec3)> {
    let mut boxes: HashMap<AssetId<Mesh>, Option<Aabb>> = HashMap::new();
    let mut total: Option<(Vec3, Vec3)> = None;
    for (mesh, transform) in parts {
        let own = *boxes
            .entry(mesh.id())
            .or_insert_with(|| meshes.get(mesh.id())?.compute_aabb());
        let Some(own) = own else { continue };
        for corner in 0..8 {
            let sign = [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 });
            let local = Vec3::from(own.center) + Vec3::from(own.half_extents) * Vec3::from(sign);
            let p = transform.transform_point(local);
            let (min, max) = total.unwrap_or((p, p));
            total = Some((min.min(p), max.max(p)));
        }
    }
    total.filter(|(min, max)| min.is_finite() && max.is_finite() && (*max - *min).length() < 1e9)
}

/// A shot that sees a whole box from above its corner.
fn framing_shot(scene: &str, min: Vec3, max: Vec3) -> Shot {
    let middle = (min + max) * 0.5;
    let radius = ((max - min).length() * 0.5).max(1e-3);
    let fov_y_deg = 45.0_f32;
    let distance = radius / (0.5 * fov_y_deg.to_radians()).sin();
    let position = middle + Vec3::new(1.0, 0.6, 1.0).normalize() * distance;
    Shot {
        scene: Some(scene.into()),
        name: SHOT.into(),
        position: position.to_array(),
        target: middle.to_array(),
        up: [0.0, 1.0, 0.0],
        fov_y_deg,
        near: (distance - radius) * 0.5,
        far: distance + radius * 1.5,
        width: 1280,
        height: 720,
        light_dir: SUN.to_array(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_made_up_shot_sees_all_corners() {
        for (min, max) in [
            (Vec3::splat(-1.0), Vec3::ONE),
            (Vec3::new(-200.0, 0.0, -200.0), Vec3::new(200.0, 30.0, 200.0)),
            (Vec3::new(5.0, 5.0, 5.0), Vec3::new(5.01, 9.0, 5.02)),
        ] {
            let shot = framing_shot("x", min, max);
            let view = Transform::from_translation(shot.position.into()).looking_at(shot.target.into(), Vec3::Y);
            let clip_from_view = Mat4::perspective_rh(shot.fov_y_deg.to_radians(), 16.0 / 9.0, shot.near, shot.far);
            let clip_from_world = clip_from_view * view.to_matrix().inverse();
            for corner in 0..8 {
                let pick = |axis: usize| {
                    if corner >> axis & 1 == 0 { min[axis] } else { max[axis] }
                };
                let p = clip_from_world.project_point3(Vec3::new(pick(0), pick(1), pick(2)));
                assert!(
                    p.x.abs() <= 1.0 && p.y.abs() <= 1.0 && (0.0..=1.0).contains(&p.z),
                    "{p} for {min} {max}"
                );
            }
        }
    }

    #[test]
    fn the_made_up_sun_stands_at_45_degrees() {
        assert!((SUN.length() - 1.0).abs() < 1e-4);
        assert!((SUN.y + std::f32::consts::FRAC_1_SQRT_2).abs() < 1e-6);
    }
}
