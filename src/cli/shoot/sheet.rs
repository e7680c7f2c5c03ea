//! Pictures of all techniques side by side.

use std::path::Path;

use bevy::math::UVec2;

use super::stats::Take;
use crate::{
    cli::{Failure, pictures},
    plot::{Pixels, Sheet},
};

/// Writes one sheet per kind of picture from the files of one shot's takes; their names.
pub(super) fn write(folder: &Path, takes: &[Take], columns: u32) -> Result<Vec<String>, Failure> {
    let Some(first) = takes.first() else {
        return Ok(Vec::new());
    };
    first
        .files
        .keys()
        .map(|pass| {
            let files = takes.iter().filter_map(|take| Some((take, take.files.get(pass)?)));
            let cells = files
                .map(|(take, file)| Ok((take.technique.clone(), read(&folder.join(file))?)))
                .collect::<Result<_, Failure>>()?;
            let sheet = Sheet { columns, cells }.draw().map_err(Failure::failed)?;
            let name = pictures::file_name(&first.scene, &first.shot.name, "sheet", pass);
            let png = sheet.png().map_err(Failure::failed)?;
            pictures::write_whole(&folder.join(&name), &png).map_err(Failure::failed)?;
            Ok(name)
        })
        .collect()
}

fn read(path: &Path) -> Result<Pixels, Failure> {
    let image = image::open(path)
        .map_err(|error| Failure::Failed(format!("cannot read {}: {error}", path.display())))?
        .into_rgb8();
    Ok(Pixels {
        size: UVec2::new(image.width(), image.height()),
        bytes: image.into_raw(),
    })
}
