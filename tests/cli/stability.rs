//! `umbrage judge --along`: its files and its numbers.

use crate::{assert_sentence, glb, run_in, stderr};

/// A cube on a plane while the camera walks, while it zooms, and while the sun moves. Every frame is drawn and traced
/// from its own camera and sun: otherwise many pixels are wrong or have no surface, and under the sun nothing changes.
#[test]
fn a_cube_on_a_plane_hardly_crawls() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run_in(
        folder.path(),
        "judge room/plane_box --shot corner --along camera,fov,sun --frames 16 --size 160x90 \
         --technique zp4+lispsm:size=512 --out s",
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let table = String::from_utf8_lossy(&output.stdout);
    assert_eq!(table.lines().count(), 4, "a head and three motions: {table}");
    let report = std::fs::read(folder.path().join("s/stability.json")).expect("stability.json");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    let rows = report["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 3);
    for row in rows {
        let number = |name: &str| row[name].as_f64().expect("a number");
        assert_eq!(row["steps"].as_array().map(Vec::len), Some(15), "{row}");
        // Measured on llvmpipe: at least 72 %, at most 0.02 % and 0.02 thousandths; the bounds leave room for other
        // drivers.
        assert!(number("compared_percent") > 60.0, "{row}");
        assert!(number("wrong_percent") < 0.1, "{row}");
        assert!(number("crawl_energy") < 1.0e-4, "{row}");
        if row["along"] == "sun" {
            // The camera stands still: pixels are compared with themselves, there is nothing to resample.
            let resampled = number("crawl_energy") - number("certain_energy");
            assert!(number("crawl_energy") > 0.0 && resampled.abs() < 1.0e-15, "{row}");
        }
        let picture = folder.path().join("s").join(row["picture"].as_str().expect("a name"));
        let picture = image::open(picture).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (160, 90));
    }
    assert!(folder.path().join("s/stats.json").exists());
}

#[test]
fn motions_that_are_not_there() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    for (arguments, code, parts) in [
        ("--along camera --path walk", 2, &["no camera path `walk`", "none"][..]),
        ("--along sun --passes mask", 2, &["--passes", "--along"]),
        (
            "--along sun,sun --frames 2 --size 32x18",
            2,
            &["two pictures", "crawl-sun"],
        ),
    ] {
        assert_sentence(
            &run_in(folder.path(), &format!("judge box.glb {arguments}")),
            code,
            parts,
        );
    }
}
