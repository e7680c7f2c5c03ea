//! `umbrage bench`: its files, and what it refuses. Times are never asserted: they belong to the machine.

use std::fs;

use crate::{assert_sentence, glb, run_in, stderr};

/// The smallest run: three techniques, four frames.
#[test]
fn every_technique_sees_the_same_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run_in(
        folder.path(),
        "bench room/plane_box --path around --size 160x90 --frames 4 --technique lispsm --technique zp2:path=dropin \
         --against bevy --out b",
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = fs::read(folder.path().join("b/bench.json")).expect("bench.json");
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    assert_eq!(
        (report["frames"].as_u64(), report["path"].as_str()),
        (Some(4), Some("around"))
    );
    assert_eq!(report["against"].as_str(), Some("bevy"));
    let techniques = report["techniques"].as_array().expect("techniques");
    let names: Vec<_> = techniques
        .iter()
        .filter_map(|report| report["technique"].as_str())
        .collect();
    assert_eq!(names, ["lispsm", "zp2:path=dropin", "bevy"]);
    for technique in techniques {
        let seconds: Vec<_> = technique["all"]
            .as_array()
            .expect("frames")
            .iter()
            .filter_map(|frame| frame["path_s"].as_f64().map(|seconds| (seconds * 1e3).round()))
            .collect();
        assert_eq!(seconds, [0.0, 2667.0, 5333.0, 8000.0], "{technique}");
        for number in ["all", "bevy_maps"] {
            assert!(technique["memory"][number].as_u64() > Some(1 << 20), "{technique}");
        }
        assert!(technique["draw_calls"]["all"].as_f64() > Some(0.0), "{technique}");
        assert!(technique["casters_drawn"]["all"].as_f64() > Some(0.0), "{technique}");
        assert!(technique["system_ms"]["update_sun_views"].is_number(), "{technique}");
        assert!(technique["ratio"]["frame"]["of_medians"].is_number(), "{technique}");
    }
    let pass = |technique: usize, pass: &str| techniques[technique]["pass_ms"][pass].is_object();
    assert!(
        pass(0, "umbrage_draw_casters") && pass(0, "early prepass"),
        "the full path"
    );
    let bevy_maps = |technique: usize| techniques[technique]["draw_calls"]["bevy_maps"].as_f64();
    assert!(
        bevy_maps(0) == Some(0.0) && bevy_maps(1) > Some(0.0) && bevy_maps(2) > Some(0.0),
        "{:?} draw calls",
        [0, 1, 2].map(bevy_maps)
    );
    assert!(
        pass(1, "bevy_shadow_pass") && pass(2, "bevy_shadow_pass"),
        "Bevy's maps"
    );
    assert!(
        !pass(1, "umbrage_draw_casters") && !pass(2, "umbrage_draw_casters"),
        "nothing of the full path is left"
    );
    assert!(
        !pass(1, "early prepass") && !pass(2, "early prepass"),
        "what is not needed is not drawn"
    );
    let light_views = |technique: usize| {
        techniques[technique]["casters_drawn"]["light_views"]
            .as_array()
            .map(Vec::len)
    };
    assert_eq!([0, 1, 2].map(light_views), [Some(1), Some(2), Some(4)]);
    let texels: Vec<_> = techniques
        .iter()
        .filter_map(|report| report["maps"]["texels"].as_u64())
        .collect();
    // 4096² without a fallback map, which nothing reads, two of 2048², four of 2048².
    assert_eq!(texels, [16_777_216, 8_388_608, 16_777_216]);
    assert_eq!(techniques[2]["ratio"]["frame"]["of_medians"].as_f64(), Some(1.0));

    let csv = fs::read_to_string(folder.path().join("b/bench.csv")).expect("bench.csv");
    assert_eq!(csv.lines().count(), 1 + 3 * 4, "{csv}");
    let table = String::from_utf8_lossy(&output.stdout);
    for name in names {
        assert!(table.lines().any(|line| line.starts_with(name)), "{table} lacks {name}");
    }
}

#[test]
fn a_scene_without_paths_is_circled() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    let output = run_in(
        folder.path(),
        "bench box.glb --size 96x54 --frames 2 --technique bevy --out b",
    );
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("goes round"), "{}", stderr(&output));
    let unknown = run_in(folder.path(), "bench box.glb --path walk --out c");
    assert_sentence(&unknown, 2, &["no path `walk`", "none"]);
    assert!(!folder.path().join("c/bench.json").exists(), "nothing was measured");
}

#[test]
fn paths_are_listed() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run_in(folder.path(), "list paths forest");
    let text = String::from_utf8_lossy(&output.stdout);
    let names: Vec<_> = text.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names, ["walk", "flight"], "{text}");
    let none = run_in(folder.path(), "list paths room/fence");
    assert_eq!((none.status.code(), none.stdout.len()), (Some(0), 0));
    assert!(stderr(&none).contains("no camera paths"), "{}", stderr(&none));
}
