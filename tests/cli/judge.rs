//! `umbrage judge`: its files and its verdict.

use crate::{glb, run_in, stderr};

/// A box on a plane: the best technique is nearly exact, and the report says the same as the table.
#[test]
fn a_box_on_a_plane_is_judged() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    let output = run_in(
        folder.path(),
        "judge box.glb --size 160x90 --technique bevy --technique zp4+lispsm --out j",
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let table = String::from_utf8_lossy(&output.stdout);
    assert_eq!(table.lines().count(), 3, "a head and two techniques: {table}");
    let report = std::fs::read(folder.path().join("j/report.json")).expect("report.json");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    let rows = report["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 2);
    for row in rows {
        let valid = row["overall"]["valid"].as_u64().expect("a count");
        assert!(valid > 1000, "{row}");
        for picture in ["truth", "difference"] {
            let name = row[picture].as_str().expect("a name");
            let picture = image::open(folder.path().join("j").join(name)).expect("a picture");
            assert_eq!((picture.width(), picture.height()), (160, 90), "{name}");
        }
    }
    let wrong = rows[1]["overall"]["wrong_percent"].as_f64().expect("a share");
    // Measured on llvmpipe: none; the bound leaves room for other drivers.
    assert!(wrong < 0.5, "{wrong} % wrong");
    let stats = std::fs::read(folder.path().join("j/stats.json")).expect("stats.json");
    let stats: serde_json::Value = serde_json::from_slice(&stats).expect("JSON");
    let full = &stats["takes"][1];
    assert!(full["pass_ms"]["umbrage_draw_casters"].is_object(), "{full}");
    let light_views = full["light_views"].as_array().expect("light views");
    let drawn: Vec<u64> = light_views
        .iter()
        .filter_map(|view| view["casters_drawn"].as_u64())
        .collect();
    assert!(drawn.len() == 4 && drawn.iter().any(|count| *count > 0), "{drawn:?}");
    let markdown = std::fs::read_to_string(folder.path().join("j/report.md")).expect("report.md");
    assert!(markdown.contains("`zp4+lispsm`"), "{markdown}");
}
