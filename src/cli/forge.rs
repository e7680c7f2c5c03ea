//! `umbrage forge`: the models in `assets/models`, rebuilt from code.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::{
    Failure,
    args::Forge,
    pictures::{make_folder, write_whole},
    say,
};
use crate::{
    forge::{Recipe, assets, bake::preview, glb, mesh::Model},
    level::find::asset_root,
};

/// Height of previews in pixels.
const PREVIEW_HEIGHT: usize = 512;

/// Writes or compares the chosen models, one line each.
pub(super) fn run(root: Option<&Path>, args: &Forge) -> Result<(), Failure> {
    let chosen = chosen(&args.only)?;
    let folder = asset_root(root).map_err(Failure::failed)?.assets().join("models");
    if !args.check {
        make_folder(&folder).map_err(Failure::Failed)?;
    }
    if let Some(folder) = &args.preview {
        make_folder(folder).map_err(Failure::Failed)?;
    }
    let mut stale = Vec::new();
    for recipe in chosen {
        let model = recipe.model();
        let bytes = glb::bytes(&model);
        let path = folder.join(format!("{}.glb", recipe.name));
        let size = format!("{:<10} {:>6} KiB", recipe.name, bytes.len().div_ceil(1024));
        if !args.check {
            write_whole(&path, &bytes).map_err(Failure::failed)?;
            say(size);
        } else if fs::read(&path).is_ok_and(|there| there == bytes) {
            say(format!("{size}  same"));
        } else {
            say(format!("{size}  differs"));
            stale.push(path.display().to_string());
        }
        if let Some(folder) = &args.preview {
            write_previews(folder, &model)?;
        }
    }
    if stale.is_empty() {
        return Ok(());
    }
    Err(Failure::Failed(format!(
        "not what the code makes: {}; run `umbrage forge` and commit what it writes",
        stale.join(", ")
    )))
}

/// The recipes with these names; all without names.
fn chosen(names: &[String]) -> Result<Vec<&'static Recipe>, Failure> {
    if names.is_empty() {
        return Ok(assets().iter().collect());
    }
    let find = |name: &String| assets().iter().find(|recipe| recipe.name == name);
    let found = names.iter().map(|name| find(name).ok_or_else(|| unknown(name)));
    found.collect()
}

fn unknown(name: &str) -> Failure {
    let names: Vec<&str> = assets().iter().map(|recipe| recipe.name).collect();
    Failure::Usage(format!("there is no asset `{name}`; there are {}", names.join(", ")))
}

fn write_previews(folder: &Path, model: &Model) -> Result<(), Failure> {
    for variant in &model.variants {
        let path: PathBuf = folder.join(format!("{}.png", variant.name));
        let picture = preview::variant(model, variant, PREVIEW_HEIGHT);
        write_whole(&path, &picture.png()).map_err(Failure::failed)?;
    }
    Ok(())
}
