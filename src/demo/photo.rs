//! Photos: the next frame without the head-up display, as a PNG in `out/`.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, ScreenshotCaptured},
};

use super::{
    DemoSystems,
    hud::Notice,
    input::{Action, Intent},
    screens::Activity,
    technique::Chosen,
};
use crate::{level::LoadedScene, ui::hud::HudRoot};

const FOLDER: &str = "out";

pub(super) fn plugin(app: &mut App) {
    app.add_systems(
        Update,
        (show_hud, take)
            .chain()
            .in_set(DemoSystems::Act)
            .run_if(in_state(Activity::Running)),
    );
}

/// The head-up display comes back with the frame after a photo.
fn show_hud(mut huds: Query<&mut Visibility, With<HudRoot>>) {
    for mut visibility in &mut huds {
        visibility.set_if_neq(Visibility::Inherited);
    }
}

fn take(
    mut commands: Commands,
    intent: Res<Intent>,
    scene: Res<LoadedScene>,
    chosen: Res<Chosen>,
    mut notice: ResMut<Notice>,
    mut huds: Query<&mut Visibility, With<HudRoot>>,
) {
    if !intent.started(Action::Photo) {
        return;
    }
    let Some(path) = free_path(Path::new(FOLDER), &scene.name, &chosen.0.to_string()) else {
        notice.show(format!("there are too many photos in {FOLDER}/"));
        return;
    };
    for mut visibility in &mut huds {
        *visibility = Visibility::Hidden;
    }
    commands.spawn(Screenshot::primary_window()).observe(
        move |captured: On<ScreenshotCaptured>, mut notice: ResMut<Notice>| {
            notice.show(match save(&captured.image, &path) {
                Ok(()) => format!("saved {}", path.display()),
                Err(error) => format!("cannot save {}: {error}", path.display()),
            });
        },
    );
}

/// `SCENE_photo-NNN_TECHNIQUE_beauty.png` with the first number that is free.
fn free_path(folder: &Path, scene: &str, technique: &str) -> Option<PathBuf> {
    let (scene, technique) = (slug(scene), slug(technique));
    (1..10_000)
        .map(|number| folder.join(format!("{scene}_photo-{number:03}_{technique}_beauty.png")))
        .find(|path| !path.exists())
}

fn slug(name: &str) -> String {
    let plain = |letter: char| {
        if letter.is_ascii_alphanumeric() {
            letter.to_ascii_lowercase()
        } else {
            '-'
        }
    };
    name.chars().map(plain).collect()
}

/// Writes beside the file first, so that there is never half a picture.
fn save(image: &Image, path: &Path) -> Result<(), String> {
    let picture = image.clone().try_into_dynamic().map_err(|error| error.to_string())?;
    let partial = path.with_extension("partial");
    let write = || -> Result<(), io::Error> {
        fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
        picture
            .to_rgb8()
            .save_with_format(&partial, image::ImageFormat::Png)
            .map_err(io::Error::other)?;
        fs::rename(&partial, path)
    };
    write().map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use bevy::{
        asset::RenderAssetUsages,
        render::render_resource::{Extent3d, TextureDimension, TextureFormat},
    };

    use super::*;

    #[test]
    fn photos_are_numbered_and_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let next = || free_path(folder.path(), "room/fence", "zp4+lispsm:size=512").unwrap();
        assert_eq!(
            next().file_name().unwrap(),
            "room-fence_photo-001_zp4-lispsm-size-512_beauty.png"
        );
        fs::write(next(), "").unwrap();
        assert!(next().to_str().unwrap().contains("photo-002"));
    }

    #[test]
    fn a_photo_is_a_whole_png_in_a_new_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/a.png");
        let image = Image::new_fill(
            Extent3d {
                width: 3,
                height: 2,
                depth_or_array_layers: 1,
            },
            TextureDimension::D2,
            &[10, 20, 30, 255],
            TextureFormat::Rgba8UnormSrgb,
            RenderAssetUsages::default(),
        );
        save(&image, &path).unwrap();
        let read = image::open(&path).unwrap().to_rgb8();
        assert_eq!(read.dimensions(), (3, 2));
        assert_eq!(read.get_pixel(2, 1).0, [10, 20, 30]);
        assert_eq!(
            fs::read_dir(path.parent().unwrap()).unwrap().count(),
            1,
            "nothing else is left"
        );
    }
}
