//! Texels to PNG files, and files that are there whole or not at all.

use std::{
    fmt::Display,
    fs,
    io::{self, Cursor, Write},
    path::{Path, PathBuf},
};

use bevy::{math::UVec2, render::render_resource::TextureFormat};
use image::{ColorType, ImageFormat};
use thiserror::Error;

use super::pass::Pass;
use crate::render::capture::Texels;

/// The color of pixels that do not count, in pictures of measurements.
pub const NOT_VALID: [u8; 3] = [40, 50, 90];

/// Why a file could not be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The system refused.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The encoder refused.
    #[error("cannot encode {}: {reason}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the encoder said.
        reason: String,
    },
}

/// `SCENE_SHOT_TECHNIQUE_PASS.png`; characters outside `[a-z0-9]` in the three names become `-`.
#[must_use]
pub fn file_name(scene: &str, shot: &str, technique: &str, pass: impl Display) -> String {
    let clean = |name: &str| -> String {
        name.chars()
            .map(|letter| match letter {
                'a'..='z' | '0'..='9' => letter,
                _ => '-',
            })
            .collect()
    };
    format!("{}_{}_{}_{pass}.png", clean(scene), clean(shot), clean(technique))
}

/// Writes texels of a pass as PNG, encoded as [`Pass::about`] says. `far` is the shot's far plane.
///
/// # Errors
/// The file cannot be written, or the texels have a format that the pass does not have.
pub fn write_png(path: &Path, texels: &Texels, pass: Pass, far: f32) -> Result<(), WriteError> {
    let (bytes, color) = match texels.format {
        TextureFormat::Rgba8UnormSrgb | TextureFormat::Rgba8Unorm => {
            let (pixels, _) = texels.bytes.as_chunks::<4>();
            (
                pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect(),
                ColorType::Rgb8,
            )
        }
        TextureFormat::R8Unorm => (texels.bytes.clone(), ColorType::L8),
        TextureFormat::R32Float => {
            let depths = texels.to_f32();
            (
                depths
                    .iter()
                    .flat_map(|depth| depth_code(*depth, far).to_ne_bytes())
                    .collect(),
                ColorType::L16,
            )
        }
        format => {
            return Err(WriteError::Encode {
                path: path.to_owned(),
                reason: format!("{pass} has the format {format:?}"),
            });
        }
    };
    write_pixels(path, UVec2::new(texels.width, texels.height), &bytes, color)
}

/// Writes pixels, row 0 on top, as PNG.
///
/// # Errors
/// The file cannot be written, or the pixels do not fill the size.
pub fn write_pixels(path: &Path, size: UVec2, bytes: &[u8], color: ColorType) -> Result<(), WriteError> {
    let mut png = Cursor::new(Vec::new());
    image::write_buffer_with_format(&mut png, bytes, size.x, size.y, color, ImageFormat::Png).map_err(|error| {
        WriteError::Encode {
            path: path.to_owned(),
            reason: error.to_string(),
        }
    })?;
    write_whole(path, png.get_ref())
}

/// 16 bits of linear depth; 0 metres is how the pass marks the sky.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=65535"
)]
fn depth_code(depth: f32, far: f32) -> u16 {
    if depth <= 0.0 || depth >= far {
        u16::MAX
    } else {
        (depth / far * f32::from(u16::MAX)).round() as u16
    }
}

/// Writes a file under another name first, so that it never exists half-written.
///
/// # Errors
/// The file cannot be written; the other name is removed.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let part = path.with_file_name(format!(".{name}.{}.part", std::process::id()));
    let write = || {
        let mut file = fs::File::create(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&part, path)
    };
    write().map_err(|source| {
        // It may not be there at all.
        let _ = fs::remove_file(&part);
        WriteError::Io {
            path: path.to_owned(),
            source,
        }
    })
}

/// Makes the output folder, with those above it.
///
/// # Errors
/// It cannot be made, or is a file.
pub fn make_folder(path: &Path) -> Result<(), String> {
    if path.exists() && !path.is_dir() {
        return Err(format!(
            "the output folder {} is a file; name another with --out",
            path.display()
        ));
    }
    fs::create_dir_all(path).map_err(|error| format!("cannot make the output folder {}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_small_letters_and_digits_only() {
        assert_eq!(
            file_name("room/fence", "Shot 1", "zp4+lispsm:size=512", Pass::Mask),
            "room-fence_-hot-1_zp4-lispsm-size-512_mask.png"
        );
    }

    #[test]
    fn depth_is_linear_and_sky_is_far() {
        let codes = [0.0, 25.0, 50.0, 100.0, 200.0].map(|depth| depth_code(depth, 100.0));
        assert_eq!(codes, [65535, 16384, 32768, 65535, 65535]);
    }

    #[test]
    fn a_file_is_there_whole_or_not_at_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.bin");
        write_whole(&path, b"one").expect("written");
        write_whole(&path, b"two").expect("replaced");
        assert_eq!(fs::read(&path).expect("there"), b"two");
        let missing = folder.path().join("none/a.bin");
        assert!(write_whole(&missing, b"x").is_err_and(|error| error.to_string().contains("cannot write")));
        assert_eq!(
            fs::read_dir(folder.path()).expect("a folder").count(),
            1,
            "no other file is left"
        );
    }

    #[test]
    fn sixteen_bits_survive_the_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("depth.png");
        let texels = Texels {
            width: 2,
            height: 1,
            format: TextureFormat::R32Float,
            bytes: [10.0f32, 0.0].iter().flat_map(|depth| depth.to_le_bytes()).collect(),
        };
        write_png(&path, &texels, Pass::Depth, 100.0).expect("written");
        let image = image::open(&path).expect("a picture").into_luma16();
        assert_eq!(image.as_raw(), &[6554, 65535]);
    }

    #[test]
    fn a_file_is_no_folder() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        assert!(make_folder(file.path()).is_err_and(|message| message.contains("is a file")));
    }
}
