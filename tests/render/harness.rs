//! A headless app with Umbrage, and what tests read out of it.

use std::path::Path;

use bevy::{
    asset::RenderAssetUsages,
    camera::RenderTarget,
    core_pipeline::prepass::DepthPrepass,
    image::Image,
    prelude::*,
    render::{
        RenderApp,
        render_resource::{Extent3d, Texture, TextureDimension, TextureFormat},
        sync_world::RenderEntity,
    },
};
use umbrage::{
    cli::headless::{self, Pipelines},
    level::find::asset_root,
    prelude::*,
    render::{
        atlas::{ShadowAtlas, ShadowResult},
        capture::{self, Texels},
        mask::{MaskPlugin, ShadowMask},
    },
};

/// Frames until pipelines, assets and bounds are settled.
pub(crate) const WARM_UP: usize = 6;

/// A headless app and its first camera.
pub(crate) struct Harness {
    pub(crate) app: App,
    pub(crate) camera: Entity,
    pub(crate) target: Handle<Image>,
}

/// A camera in front of the origin.
pub(crate) fn eye() -> Transform {
    Transform::from_xyz(0.0, 3.0, 14.0).looking_at(Vec3::new(0.0, 1.0, 0.0), Vec3::Y)
}

impl Harness {
    /// An app with Umbrage and one perspective camera; nothing else.
    pub(crate) fn new(size: UVec2, eye: Transform) -> Self {
        let root = asset_root(Some(Path::new(env!("CARGO_MANIFEST_DIR")))).unwrap_or_else(|error| panic!("{error}"));
        let mut app = headless::app(&root).unwrap_or_else(|error| panic!("{error}"));
        app.add_plugins(UmbragePlugins);
        let target = add_target(&mut app, size);
        let camera = app
            .world_mut()
            .spawn((
                Camera3d::default(),
                RenderTarget::Image(target.clone().into()),
                Msaa::Off,
                DepthPrepass,
                Projection::Perspective(PerspectiveProjection {
                    near: 0.2,
                    far: 120.0,
                    ..default()
                }),
                eye,
            ))
            .id();
        Self { app, camera, target }
    }

    /// Ends the set-up and draws the warm-up frames.
    pub(crate) fn start(&mut self) {
        headless::finish(&mut self.app);
        self.frames(WARM_UP);
    }

    pub(crate) fn frames(&mut self, count: usize) {
        for _ in 0..count {
            headless::frame(&mut self.app);
        }
        if let Pipelines::Failed(error) = headless::pipelines(&self.app) {
            panic!("{error}");
        }
    }

    /// A sun with settings.
    pub(crate) fn sun(&mut self, light_dir: Vec3, settings: SunShadows) -> Entity {
        self.app
            .world_mut()
            .spawn((
                DirectionalLight {
                    illuminance: 10_000.0,
                    shadow_maps_enabled: true,
                    ..default()
                },
                Transform::default().looking_to(light_dir, Vec3::Y),
                settings,
            ))
            .id()
    }

    pub(crate) fn mesh(&mut self, mesh: impl Into<Mesh>) -> Handle<Mesh> {
        self.app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
    }

    pub(crate) fn material(&mut self, material: impl Into<StandardMaterial>) -> Handle<StandardMaterial> {
        self.app
            .world_mut()
            .resource_mut::<Assets<StandardMaterial>>()
            .add(material)
    }

    /// A material with a 16² checkerboard of holes.
    pub(crate) fn holes(&mut self) -> Handle<StandardMaterial> {
        let texels = (0..256_u32)
            .flat_map(|i| [60, 200, 60, if (i % 16 / 2 + i / 32) % 2 == 0 { 255 } else { 0 }])
            .collect();
        let size = Extent3d {
            width: 16,
            height: 16,
            depth_or_array_layers: 1,
        };
        let image = Image::new(
            size,
            TextureDimension::D2,
            texels,
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::RENDER_WORLD,
        );
        let texture = self.app.world_mut().resource_mut::<Assets<Image>>().add(image);
        self.material(StandardMaterial {
            base_color_texture: Some(texture),
            alpha_mode: AlphaMode::Mask(0.5),
            cull_mode: None,
            double_sided: true,
            ..default()
        })
    }

    /// Lets the camera draw what it sees of a light's shadows; the mask, row 0 on top: 255 lit, 0 in shadow.
    pub(crate) fn add_mask(&mut self, light: Entity, size: UVec2) -> Handle<Image> {
        if !self.app.is_plugin_added::<MaskPlugin>() {
            self.app.add_plugins(MaskPlugin);
        }
        let [mask, depth, normal] = [
            ShadowMask::MASK_FORMAT,
            ShadowMask::DEPTH_FORMAT,
            ShadowMask::NORMAL_FORMAT,
        ]
        .map(|format| capture::readable_target(size.x, size.y, format))
        .map(|image| self.app.world_mut().resource_mut::<Assets<Image>>().add(image));
        self.app.world_mut().entity_mut(self.camera).insert(ShadowMask {
            light,
            mask: mask.clone(),
            depth,
            normal,
        });
        mask
    }

    /// What a component of the camera's render entity says.
    pub(crate) fn of_camera<C: Component, T>(&self, ask: impl Fn(&C) -> T) -> T {
        let render_entity = self.app.world().get::<RenderEntity>(self.camera);
        let render_entity = render_entity.expect("the camera is drawn").id();
        let render_world = self.app.sub_app(RenderApp).world();
        ask(render_world
            .get::<C>(render_entity)
            .expect("the camera has the component"))
    }

    /// Reads a texture that a component of the camera's render entity holds.
    pub(crate) fn camera_texture<C: Component>(&self, camera: Entity, texture: impl Fn(&C) -> &Texture) -> Texels {
        let render_entity = self
            .app
            .world()
            .get::<RenderEntity>(camera)
            .expect("the camera is drawn")
            .id();
        let render_world = self.app.sub_app(RenderApp).world();
        let component = render_world
            .get::<C>(render_entity)
            .expect("the camera has the component");
        capture::read_texture(render_world, texture(component), 0).expect("the texture can be read")
    }

    /// Caster depths.
    pub(crate) fn atlas(&self) -> Texels {
        self.camera_texture::<ShadowAtlas>(self.camera, |atlas| &atlas.texture)
    }

    /// The shadow result, 0..=1, row 0 on top.
    pub(crate) fn shadow_result(&self, camera: Entity) -> Vec<f32> {
        results(&self.camera_texture::<ShadowResult>(camera, |result| &result.texture))
    }
}

/// The numbers of a texture with the format of shadow results.
pub(crate) fn results(texels: &Texels) -> Vec<f32> {
    let halves = texels.bytes.chunks_exact(2);
    halves
        .map(|half| half_to_f32(u16::from_le_bytes([half[0], half[1]])))
        .collect()
}

/// An image that a camera can draw into and a test can read.
pub(crate) fn add_target(app: &mut App, size: UVec2) -> Handle<Image> {
    let image = capture::readable_target(size.x, size.y, TextureFormat::Rgba8UnormSrgb);
    app.world_mut().resource_mut::<Assets<Image>>().add(image)
}

/// Half precision without infinities.
fn half_to_f32(bits: u16) -> f32 {
    let exponent = i32::from(bits >> 10 & 0x1f);
    let mantissa = f32::from(bits & 0x3ff) / 1024.0;
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    sign * if exponent == 0 {
        mantissa * 2f32.powi(-14)
    } else {
        (1.0 + mantissa) * 2f32.powi(exponent - 15)
    }
}
