//! `umbrage judge`: its files and its verdict.

use std::{fs, path::Path};

use serde_json::Value;

use crate::{assert_sentence, glb, run_in, stderr};

/// A box on a plane: the best technique is nearly exact, and the report says the same as the table.
#[test]
fn a_box_on_a_plane_is_judged() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    let output = run_in(
        folder.path(),
        "judge box.glb --size 160x90 --technique bevy --technique zp4+lispsm --floor --out j",
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let table = String::from_utf8_lossy(&output.stdout);
    assert_eq!(
        table.lines().count(),
        4,
        "a head of two lines and two techniques: {table}"
    );
    let report = fs::read(folder.path().join("j/report.json")).expect("report.json");
    let report: Value = serde_json::from_slice(&report).expect("JSON");
    let rows = report["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 2);
    for row in rows {
        let valid = row["overall"]["valid"].as_u64().expect("a count");
        assert!(valid > 1000, "{row}");
        let kinds = row["kinds"].as_object().expect("kinds");
        let sum: u64 = kinds.values().filter_map(Value::as_u64).sum();
        assert_eq!(sum, 160 * 90, "every pixel has a kind: {row}");
        let sampled = row["texel_pixel"]["pixels"].as_u64().expect("a count");
        assert_eq!(sampled, valid, "the maps hold everything in view: {row}");
        let floors = row["floor"].as_array().expect("floors");
        assert_eq!(floors.len(), 4, "three sizes and the median: {row}");
        let drawn = row["texels"]["drawn"].as_u64().expect("a count");
        let used = row["texels"]["over_receivers"].as_u64().expect("a count");
        assert!(0 < used && used < drawn, "{row}");
        for picture in ["truth", "difference"] {
            let name = row[picture].as_str().expect("a name");
            let picture = image::open(folder.path().join("j").join(name)).expect("a picture");
            assert_eq!((picture.width(), picture.height()), (160, 90), "{name}");
        }
    }
    let wrong = rows[1]["overall"]["wrong_percent"].as_f64().expect("a share");
    // Measured on llvmpipe: none; the bound leaves room for other drivers.
    assert!(wrong < 0.5, "{wrong} % wrong");
    for row in rows {
        let fine = &row["confirmation"];
        let (pixels, wrong) = (fine["pixels"].as_u64(), fine["wrong"].as_u64());
        assert_eq!(wrong, Some(0), "truth is confirmed: {fine}");
        assert!(pixels.is_some_and(|pixels| pixels > 500), "{fine}");
    }
    for plot in [
        "plot_all_wrong_bars.png",
        "plot_box_distance_curves.png",
        "plot_box_texel-pixel_curves.png",
    ] {
        assert!(image::open(folder.path().join("j").join(plot)).is_ok(), "{plot}");
    }
    let stats = fs::read(folder.path().join("j/stats.json")).expect("stats.json");
    let stats: Value = serde_json::from_slice(&stats).expect("JSON");
    let full = &stats["takes"][1];
    assert!(full["pass_ms"]["umbrage_draw_casters"].is_object(), "{full}");
    let light_views = full["light_views"].as_array().expect("light views");
    let drawn: Vec<u64> = light_views
        .iter()
        .filter_map(|view| view["casters_drawn"].as_u64())
        .collect();
    assert!(drawn.len() == 4 && drawn.iter().any(|count| *count > 0), "{drawn:?}");
    let markdown = fs::read_to_string(folder.path().join("j/report.md")).expect("report.md");
    assert!(markdown.contains("`zp4+lispsm`"), "{markdown}");
}

fn report(folder: &Path) -> Value {
    let bytes = fs::read(folder.join("report.json")).expect("report.json");
    serde_json::from_slice(&bytes).expect("JSON")
}

/// Shards give the same table as one run: in one folder by themselves, from several on request.
#[test]
fn reports_of_shards_merge() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    glb::write(&path("box.glb"), &glb::box_on_plane());
    let shot = |name: &str, x: i32| {
        format!(r#"{{"name":"{name}","position":[{x},3,9],"target":[0,1,0],"light_dir":[-1,-2,-1]}}"#)
    };
    let shots = [shot("left", -4), shot("middle", 0), shot("right", 4)].join(",");
    fs::write(path("shots.json"), format!("{{\"shots\":[{shots}]}}")).expect("a file");
    let judge = |rest: &str| {
        let output = run_in(
            folder.path(),
            &format!("judge box.glb --shots shots.json --size 96x54 --technique lispsm --technique bevy {rest}"),
        );
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let table = judge("--out whole");
    judge("--shard 1/2 --out parts");
    assert!(!path("parts/report.json").exists(), "one part is missing");
    judge("--shard 2/2 --out parts");
    assert_eq!(report(&path("parts")), report(&path("whole")));
    let text = |name: &str| fs::read_to_string(path(name)).expect("a text");
    assert_eq!(text("parts/report.md"), text("whole/report.md"));

    // The second part as another machine would leave it.
    fs::create_dir(path("other")).expect("a folder");
    for entry in fs::read_dir(path("parts")).expect("a folder") {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        let (from, to) = (path("parts").join(&name), path("other").join(&name));
        match name.as_str() {
            "report.json" | "report.md" => fs::remove_file(from).expect("removed"),
            _ if name == "report.2-of-2.json" || name.contains("_middle_") => fs::rename(from, to).expect("moved"),
            _ => {}
        }
    }
    let merged = run_in(folder.path(), "judge --merge parts other");
    assert_eq!(merged.status.code(), Some(0), "{}", stderr(&merged));
    assert_eq!(String::from_utf8_lossy(&merged.stdout), table);
    assert_eq!(report(&path("parts")), report(&path("whole")));
    for row in report(&path("parts"))["rows"].as_array().expect("rows") {
        let name = row["difference"].as_str().expect("a name");
        assert!(path("parts").join(name).is_file(), "{name} came with its report");
    }
    assert_sentence(
        &run_in(folder.path(), "judge --merge other"),
        1,
        &["of 2 parts", "missing", "1"],
    );
    assert_sentence(
        &run_in(folder.path(), "judge --merge whole"),
        1,
        &["no report of a shard", "whole"],
    );
    assert_sentence(&run_in(folder.path(), "judge --merge nowhere"), 1, &["nowhere"]);
}
