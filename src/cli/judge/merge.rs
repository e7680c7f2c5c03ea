//! Reports of shards become one report.
//!
//! Each shard writes `report.I-of-N.json`. Shards that share a folder merge by themselves: the one that ends last finds all
//! parts complete and writes report.json, report.md and the plots. Reports from several folders are merged on request,
//! with their pictures, into the first folder.

use std::{
    fs,
    path::{Path, PathBuf},
};

use super::report::{Part, Report, part_name};
use crate::cli::{Failure, pictures, remark};

/// Merges the parts in folders, and writes the whole report into the first.
pub(super) fn merge(folders: &[PathBuf]) -> Result<Report, Failure> {
    let mut parts = Vec::new();
    for folder in folders {
        for file in part_files(folder)? {
            parts.push((folder.as_path(), read(&file)?));
        }
    }
    let Some(first) = folders.first() else {
        return Err(Failure::Failed("there is no folder to merge".to_owned()));
    };
    if parts.is_empty() {
        let folders: Vec<_> = folders.iter().map(|folder| folder.display().to_string()).collect();
        return Err(Failure::Failed(format!(
            "there is no report of a shard (report.I-of-N.json) in {}",
            folders.join(", ")
        )));
    }
    for (folder, part) in parts.iter().filter(|(folder, _)| folder != first) {
        for name in part.rows.iter().flat_map(|row| [&row.truth, &row.difference]) {
            let from = folder.join(name);
            let bytes =
                fs::read(&from).map_err(|error| Failure::Failed(format!("cannot read {}: {error}", from.display())))?;
            pictures::write_whole(&first.join(name), &bytes).map_err(Failure::failed)?;
        }
    }
    let parts = parts.into_iter().map(|(_, part)| part).collect();
    let mut whole = joined(parts).map_err(Failure::Failed)?;
    whole.finish(first)?;
    Ok(whole)
}

/// After a part: merges its folder if all parts are there. Parts of another run are left alone, with a remark.
pub(super) fn merge_if_complete(folder: &Path, part: Part) -> Result<(), Failure> {
    let files = (1..=part.count).map(|index| folder.join(part_name(Part { index, ..part })));
    let mut parts = Vec::new();
    for file in files {
        if !file.is_file() {
            return Ok(());
        }
        parts.push(read(&file)?);
    }
    if parts.iter().any(|part| !part.is_complete) {
        return Ok(());
    }
    match joined(parts) {
        Ok(mut whole) => whole.finish(folder),
        Err(problem) => {
            remark(format!("the parts are not merged: {problem}"));
            Ok(())
        }
    }
}

/// The files of parts in a folder, by name.
fn part_files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let cannot = |error| Failure::Failed(format!("cannot read the folder {}: {error}", folder.display()));
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("report.") && name.contains("-of-") && name.ends_with(".json") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn read(file: &Path) -> Result<Report, Failure> {
    let text = fs::read_to_string(file)
        .map_err(|error| Failure::Failed(format!("cannot read {}: {error}", file.display())))?;
    serde_json::from_str(&text)
        .map_err(|error| Failure::Failed(format!("{} is no report of this version: {error}", file.display())))
}

/// One report from all its parts: rows in the order of a run without shards.
fn joined(mut parts: Vec<Report>) -> Result<Report, String> {
    parts.sort_by_key(|part| part.part.index);
    let Some(first) = parts.first() else {
        return Err("there are no parts".to_owned());
    };
    let count = first.part.count;
    let fits =
        |part: &Report| part.part.count == count && part.settings == first.settings && part.umbrage == first.umbrage;
    if !parts.iter().all(fits) {
        return Err("they are parts of runs with different arguments or versions".to_owned());
    }
    if let Some(twice) = parts.windows(2).find(|pair| pair[0].part == pair[1].part) {
        return Err(format!("part {} of {count} is there twice", twice[0].part.index));
    }
    let missing: Vec<String> = (1..=count)
        .filter(|index| !parts.iter().any(|part| part.part.index == *index && part.is_complete))
        .map(|index| index.to_string())
        .collect();
    if !missing.is_empty() {
        return Err(format!(
            "of {count} parts these are missing or not complete: {}",
            missing.join(", ")
        ));
    }
    let mut whole = Report {
        umbrage: first.umbrage.clone(),
        settings: first.settings.clone(),
        part: Part::default(),
        ..Report::default()
    };
    for part in parts {
        whole.rows.extend(part.rows);
        for scene in part.scenes {
            if !whole.scenes.iter().any(|known| known.scene == scene.scene) {
                whole.scenes.push(scene);
            }
        }
    }
    // Rows of one shot are in one part, in the order of the techniques; the sort keeps it.
    whole.rows.sort_by_key(|row| row.place);
    let first_row = |scene: &str| whole.rows.iter().position(|row| row.scene == scene);
    let mut scenes = std::mem::take(&mut whole.scenes);
    scenes.sort_by_key(|scene| first_row(&scene.scene));
    whole.scenes = scenes;
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::judge::report::Row;

    /// A part of a run over three shots and two techniques.
    fn part(index: usize, count: usize) -> Report {
        let places = (0..3).filter(|place| place % count == index - 1);
        let rows = places.flat_map(|place| {
            ["lispsm", "bevy"].map(|technique| Row {
                place,
                scene: "forest".to_owned(),
                shot: format!("shot {place}"),
                technique: technique.to_owned(),
                ..Row::default()
            })
        });
        Report {
            umbrage: "1".to_owned(),
            part: Part { index, count },
            is_complete: true,
            rows: rows.collect(),
            ..Report::default()
        }
    }

    #[test]
    fn parts_make_the_whole_in_its_order() {
        let whole = joined(vec![part(2, 2), part(1, 2)]).expect("complete");
        assert_eq!(whole.rows, part(1, 1).rows);
        assert_eq!(whole.part, Part::default());
        let few_shots = joined((1..=5).map(|index| part(index, 5)).collect()).expect("complete");
        assert_eq!(few_shots.rows, whole.rows, "shards without shots count too");
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        let refused = |parts: Vec<Report>, expected: &str| {
            let problem = joined(parts).expect_err(expected);
            assert!(problem.contains(expected), "{problem}");
        };
        refused(vec![part(1, 3), part(3, 3)], "missing or not complete: 2");
        let mut running = part(2, 2);
        running.is_complete = false;
        refused(vec![part(1, 2), running], "not complete: 2");
        refused(vec![part(1, 2), part(1, 2)], "part 1 of 2 is there twice");
        refused(vec![part(1, 2), part(2, 3)], "different arguments");
        let mut other = part(2, 2);
        other.settings.techniques.push("psm".to_owned());
        refused(vec![part(1, 2), other], "different arguments");
        refused(Vec::new(), "no parts");
    }
}
