//! Sun and sky: from where the sun stands to everything that lights and veils a picture.
//!
//! ```text
//! SunSettings ─ course ─► light_dir ─ atmosphere ─► Dome ─┬─► the sun's colour and lux
//!                                                         ├─► sky picture, fog, exposure   on cameras under the sky
//!                                                         └─► light from sky and ground    (environment map)
//! ```
//!
//! All of it is worked out on the processor when the sun has moved, so a frame costs the GPU no more than a cube map.
//! Bevy's own `Atmosphere` computes the same model in every frame on the GPU: several look-up passes, and a target of
//! high dynamic range, which shots and demo otherwise do without. With Bevy 0.19.1 its passes end the process with a
//! segmentation fault on llvmpipe (LLVM 15), the software adapter that draws Umbrage's pictures and tests, so it is not
//! used.

use bevy::{
    asset::RenderAssetUsages,
    camera::Exposure,
    core_pipeline::tonemapping::Tonemapping,
    image::{ImageSampler, ImageSamplerDescriptor},
    light::Skybox,
    math::DVec3,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureViewDescriptor, TextureViewDimension},
};

use super::load::{LevelEntity, Sun};

pub mod atmosphere;
pub mod course;
pub mod dome;
pub mod exposure;
pub mod settings;

use atmosphere::Atmosphere;
use dome::{Dome, LUMA, cube_directions, srgb_bytes};
use settings::{Air, SunSettings};

/// On cameras that see a level's sky: they get its picture, its fog, its light and its exposure.
///
/// For cameras without high dynamic range and with [`Tonemapping::AcesFitted`], which needs no look-up table: the sky's
/// picture comes tone-mapped.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Exposure, Tonemapping = Tonemapping::AcesFitted)]
pub struct UnderSky;

/// On a sun that makes its sky.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct SkyLight(pub Air);

/// What cameras under the sky get.
#[derive(Resource, Clone)]
struct Sky {
    light_dir: Vec3,
    air: Air,
    exposure: Exposure,
    picture: Handle<Image>,
    light: EnvironmentMapLight,
    fog: DistanceFog,
}

/// Air is the same until its aerosols change: its tables are kept.
#[derive(Resource, Default)]
struct Tables(Option<(f32, Atmosphere)>);

/// The sky is made anew when the sun has moved by the angle of this sine: a fifth of a degree.
const MOVED: f32 = 0.0035;
/// Texels along a side of the sky's picture, of the light from all sides, and of what mirrors show.
const PICTURE_SIDE: u32 = 64;
const DIFFUSE_SIDE: u32 = 8;
const SPECULAR_SIDE: u32 = 32;
/// Contrast at which a dark thing before the horizon is lost (Koschmieder): the visibility of weather reports.
const LAST_CONTRAST: f32 = 0.05;
/// How much more of blue and less of red haze takes away.
const HAZE_TINT: Vec3 = Vec3::new(0.85, 1.0, 1.2);
/// Haze towards the sun: the exponent that is nearest to the forward peak of aerosols, and its height per steradian.
const GLOW_EXPONENT: f32 = 10.0;
const GLOW: f32 = 0.10;

/// Keeps sky, light and cameras in step with the sun, in `PostUpdate`.
pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Tables>()
        .add_systems(PostUpdate, (follow_sun, dress_cameras).chain());
}

/// Spawns the sun; its light and its sky follow from where it stands.
pub fn spawn_sun(commands: &mut Commands, settings: &SunSettings) {
    commands.spawn((
        Name::new("sun"),
        DirectionalLight {
            shadow_maps_enabled: true,
            ..default()
        },
        sun_transform(settings.light_dir()),
        SkyLight(settings.air),
        Sun,
        LevelEntity,
    ));
}

/// The transform of a light whose rays travel along `light_dir`.
pub fn sun_transform(light_dir: Vec3) -> Transform {
    let direction = light_dir.normalize_or(Vec3::NEG_Y);
    let up = if direction.y.abs() < 0.999 { Vec3::Y } else { Vec3::Z };
    Transform::default().looking_to(direction, up)
}

fn follow_sun(
    mut commands: Commands,
    mut suns: Query<(&Transform, &SkyLight, &mut DirectionalLight), With<Sun>>,
    sky: Option<ResMut<Sky>>,
    mut tables: ResMut<Tables>,
    mut images: ResMut<Assets<Image>>,
) {
    let Some((transform, SkyLight(air), mut light)) = suns.iter_mut().next() else {
        return;
    };
    let light_dir = transform.forward().as_vec3();
    let is_new_light = light.is_added();
    if let Some(sky) = &sky
        && !is_new_light
        && sky.air == *air
        && sky.light_dir.distance(light_dir) < MOVED
    {
        return;
    }
    let kept = tables.0.take().filter(|(depth, _)| *depth == air.aerosol_depth);
    let (depth, atmosphere) =
        kept.unwrap_or_else(|| (air.aerosol_depth, Atmosphere::new(f64::from(air.aerosol_depth))));
    let to_sun = -light_dir.as_dvec3();
    let dome = Dome::new(&atmosphere, to_sun);
    tables.0 = Some((depth, atmosphere));

    let lux = dome.sun_lux.dot(LUMA);
    light.illuminance = lux as f32;
    light.color = color(dome.sun_lux / lux.max(1e-6));
    commands.insert_resource(GlobalAmbientLight::NONE);

    let handles = sky.map(|sky| {
        let light = sky.light.clone();
        [sky.picture.clone(), light.diffuse_map, light.specular_map]
    });
    let handles =
        handles.unwrap_or_else(|| [PICTURE_SIDE, DIFFUSE_SIDE, SPECULAR_SIDE].map(|side| images.add(cube(side))));
    commands.insert_resource(make_sky(&dome, light_dir, *air, handles, &mut images));
}

/// Draws the pictures of a sky and derives what cameras get.
fn make_sky(dome: &Dome, light_dir: Vec3, air: Air, handles: [Handle<Image>; 3], images: &mut Assets<Image>) -> Sky {
    let exposure = Exposure {
        ev100: exposure::ev100(dome, -f64::from(light_dir.y)) as f32,
    };
    let scale = f64::from(exposure.exposure());
    let lights = dome.lights();
    let brightest = lights
        .iter()
        .fold(1e-3, |most, (_, light)| light.max_element().max(most));
    let [picture, diffuse_map, specular_map] = handles;
    let mut draw = |handle: &Handle<Image>, side: u32, value: &dyn Fn(DVec3) -> DVec3| {
        if let Some(mut image) = images.get_mut(handle) {
            let mut level_side = side;
            let mut level: Vec<DVec3> = cube_directions(side).map(value).collect();
            let mut bytes = Vec::new();
            for _ in 0..image.texture_descriptor.mip_level_count {
                bytes.push(level.iter().flat_map(|color| srgb_bytes(*color)).collect::<Vec<u8>>());
                level = halved(&level, level_side);
                level_side /= 2;
            }
            image.data = Some(by_face(&bytes));
        }
    };
    draw(&picture, PICTURE_SIDE, &|view| dome.seen(view, scale));
    draw(&diffuse_map, DIFFUSE_SIDE, &|normal| {
        dome.received(&lights, normal) / brightest
    });
    draw(&specular_map, SPECULAR_SIDE, &|view| {
        dome.surroundings(view) / brightest
    });
    let haze = -LAST_CONTRAST.ln() / air.visibility * HAZE_TINT;
    Sky {
        light_dir,
        air,
        exposure,
        picture,
        light: EnvironmentMapLight {
            diffuse_map,
            specular_map,
            intensity: brightest as f32 * air.sky_share,
            ..default()
        },
        fog: DistanceFog {
            color: color(dome.horizon * scale),
            // The shader multiplies this by the sun's lux and the exposure.
            directional_light_color: Color::linear_rgb(GLOW, GLOW, GLOW),
            directional_light_exponent: GLOW_EXPONENT,
            falloff: FogFalloff::Atmospheric {
                extinction: haze,
                inscattering: haze,
            },
        },
    }
}

fn dress_cameras(
    mut commands: Commands,
    sky: Option<Res<Sky>>,
    cameras: Query<Entity, With<UnderSky>>,
    new: Query<(), Added<UnderSky>>,
) {
    let Some(sky) = sky else { return };
    for camera in &cameras {
        if sky.is_changed() || new.contains(camera) {
            commands.entity(camera).insert((
                sky.exposure,
                sky.light.clone(),
                sky.fog.clone(),
                Skybox {
                    image: Some(sky.picture.clone()),
                    // Tone-mapped already: what Bevy multiplies by is taken back.
                    brightness: 1.0 / sky.exposure.exposure(),
                    ..default()
                },
            ));
        }
    }
}

fn color(linear: DVec3) -> Color {
    let [r, g, b] = linear.as_vec3().to_array();
    Color::linear_rgb(r, g, b)
}

/// A black cube map; more than 8 texels wide mirrors get smaller levels.
fn cube(side: u32) -> Image {
    let mut image = Image::new(
        Extent3d {
            width: side,
            height: side,
            depth_or_array_layers: 6,
        },
        TextureDimension::D2,
        vec![0; 24 * (side * side) as usize],
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    if side == SPECULAR_SIDE {
        image.texture_descriptor.mip_level_count = side.ilog2() + 1;
    }
    image.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::Cube),
        ..default()
    });
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor::linear());
    image
}

/// The next smaller level of a cube map: means of two by two texels.
fn halved(level: &[DVec3], side: u32) -> Vec<DVec3> {
    let half = side / 2;
    (0..6 * half * half)
        .map(|i| {
            let (x, y, face) = (i % half, i / half.max(1) % half.max(1), i / (half * half).max(1));
            let at = |dx, dy| level[(face * side * side + (2 * y + dy) * side + 2 * x + dx) as usize];
            (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0
        })
        .collect()
}

/// The bytes of levels, each with six faces, in the order of textures: face by face, each with all its levels.
fn by_face(levels: &[Vec<u8>]) -> Vec<u8> {
    (0..6)
        .flat_map(|face| {
            levels.iter().flat_map(move |level| {
                let size = level.len() / 6;
                level[face * size..(face + 1) * size].iter().copied()
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_shines_along_its_direction() {
        for light_dir in [
            Vec3::new(1.0, -2.0, 0.5),
            Vec3::NEG_Y,
            Vec3::new(0.0, -5.0, 1e-4),
            Vec3::Y,
            Vec3::X,
        ] {
            let transform = sun_transform(light_dir);
            assert!(transform.is_finite(), "{light_dir}");
            assert!(transform.forward().dot(light_dir.normalize()) > 0.999_99, "{light_dir}");
        }
    }

    #[test]
    fn smaller_levels_are_means_and_lie_behind_each_face() {
        let level: Vec<DVec3> = (0..24).map(|i| DVec3::splat(f64::from(i))).collect();
        let half = halved(&level, 2);
        assert_eq!(
            half.iter().map(|color| color.x).collect::<Vec<_>>(),
            [1.5, 5.5, 9.5, 13.5, 17.5, 21.5]
        );
        let levels = [(0..12).collect::<Vec<u8>>(), (100..106).collect()];
        assert_eq!(by_face(&levels)[..6], [0, 1, 100, 2, 3, 101]);
        assert_eq!(cube(SPECULAR_SIDE).texture_descriptor.mip_level_count, 6);
    }

    fn app() -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default()))
            .init_asset::<Image>()
            .add_plugins(plugin);
        app
    }

    /// The lux of the sun and the exposure of a camera after a frame under this sun.
    fn lit(app: &mut App, light_dir: Vec3) -> (f32, f32) {
        app.world_mut().flush();
        let mut suns = app.world_mut().query_filtered::<&mut Transform, With<Sun>>();
        *suns.single_mut(app.world_mut()).expect("one sun") = sun_transform(light_dir);
        app.update();
        let mut lights = app.world_mut().query::<&DirectionalLight>();
        let lux = lights.single(app.world()).expect("one light").illuminance;
        let mut cameras = app.world_mut().query_filtered::<(&Exposure, &Skybox), With<UnderSky>>();
        let (exposure, skybox) = cameras.single(app.world()).expect("one camera under the sky");
        assert!((skybox.brightness * exposure.exposure() - 1.0).abs() < 1e-4);
        (lux, exposure.ev100)
    }

    #[test]
    fn light_and_cameras_follow_the_sun() {
        let mut app = app();
        let settings = SunSettings::default();
        spawn_sun(&mut app.world_mut().commands(), &settings);
        app.world_mut().spawn(UnderSky);
        let noon = lit(&mut app, Vec3::new(0.2, -1.0, 0.0));
        let low = lit(&mut app, Vec3::new(1.0, -0.1, 0.0));
        assert!(noon.0 > 90_000.0 && low.0 < 50_000.0, "{noon:?} {low:?}");
        assert!(low.1 < noon.1 - 0.5, "the camera opens: {noon:?} {low:?}");
        assert_eq!(lit(&mut app, Vec3::new(0.2, -1.0, 0.0)), noon, "and back");

        let image = app.world().resource::<Sky>().picture.clone();
        let images = app.world().resource::<Assets<Image>>();
        let data = images
            .get(&image)
            .and_then(|image| image.data.as_ref())
            .expect("a picture");
        assert_eq!(data.len(), (6 * 4 * PICTURE_SIDE * PICTURE_SIDE) as usize);
        assert_eq!(app.world().resource::<GlobalAmbientLight>().brightness, 0.0);
    }

    #[test]
    fn a_new_level_sets_a_new_suns_light() {
        let mut app = app();
        app.world_mut().spawn(UnderSky);
        for _ in 0..2 {
            spawn_sun(&mut app.world_mut().commands(), &SunSettings::default());
            let (lux, _) = lit(&mut app, SunSettings::default().light_dir());
            assert!(lux > 60_000.0, "{lux}");
            let sun = app
                .world_mut()
                .query_filtered::<Entity, With<Sun>>()
                .single(app.world())
                .expect("one sun");
            app.world_mut().despawn(sun);
        }
    }
}
