//! Pictures from the command line: what is left on disk, what is refused, and that no result is lost for want of one.
#![allow(clippy::unwrap_used)]

mod common;

use common::meshes::CUBE;
use common::program::program;
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;
use std::process::Output;
use tempfile::TempDir;

struct Case(TempDir);

impl Case {
    /// A folder with a table and a box above it, as `scene.json`.
    fn new() -> Self {
        let case = Self(tempfile::tempdir().unwrap());
        fs::write(case.path("cube.obj"), CUBE).unwrap();
        case.write("scene.json", &scene("<kitchen>"));
        case
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, scene: &Value) {
        fs::write(self.path(name), scene.to_string()).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        program().args(arguments).current_dir(self.0.path()).output().unwrap()
    }

    /// Draws on the processor and returns the picture.
    fn draws(&self, arguments: &[&str]) -> image::RgbImage {
        let output = self.run(&[&["render", "--backend", "cpu", "-o", "picture.png"], arguments].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        image::open(self.path("picture.png")).unwrap().into_rgb8()
    }
}

fn scene(name: &str) -> Value {
    let object = |name: &str, parent: &str, y: f64, size: f64| {
        json!({
            "name": name, "mesh": "cube.obj", "parent": parent, "position": [0, y, 0], "scale": size
        })
    };
    let objects = [object("table & <b>", "ground", 0.55, 1.0), object("box", "table & <b>", 1.3, 0.3)];
    json!({"format": "rest3d-scene", "version": 1, "name": name, "objects": objects})
}

#[test]
fn a_picture_has_the_size_and_the_view_that_were_asked_for() {
    let case = Case::new();
    let front = case.draws(&[".", "--size", "200x100", "--camera", "front"]);
    assert_eq!(front.dimensions(), (200, 100));
    let top = case.draws(&["scene.json", "--size", "200x100", "--camera", "top"]);
    let exact = case.draws(&[".", "--size", "200x100", "--camera", "0,1,9,0,1,0"]);
    assert!(front != top && exact != top && exact != front);
    assert_eq!(front, case.draws(&[".", "--size", "200x100", "--camera", "front"]));
}

#[test]
fn json_says_what_was_drawn() {
    let case = Case::new();
    let output = case.run(&["render", ".", "-o", "new/a.png", "--size", "64x48", "--backend", "cpu", "--json"]);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&summary["width"], &summary["pictures"], &summary["painter"]), (&json!(64), &json!(1), &json!("cpu")));
    assert!(case.path("new/a.png").is_file());
}

#[test]
fn bad_input_is_refused_and_nothing_is_written() {
    let case = Case::new();
    fs::create_dir(case.path("folder.png")).unwrap();
    let mut broken = scene("broken");
    broken["objects"][1]["mesh"] = json!("broken.glb");
    fs::write(case.path("broken.glb"), "glTF is not what follows").unwrap();
    case.write("broken.json", &broken);
    let mut tiny = scene("tiny");
    tiny["objects"][1]["scale"] = json!(1e-6);
    case.write("tiny.json", &tiny);
    for (arguments, words) in [
        (&["nowhere"][..], &["nowhere"][..]),
        (&["broken.json"], &["broken.json", "box", "mesh", "broken.glb"]),
        (&["tiny.json"], &["tiny.json", "box", "scale"]),
        (&[".", "--camera", "nan,nan"], &["--camera", "nan,nan", "auto"]),
        (&[".", "--camera", "sideways"], &["--camera", "sideways", "auto"]),
        (&[".", "--size", "0x0"], &["--size", "16"]),
        (&[".", "--adapter", "no such card"], &["no such card", "--backend cpu"]),
        (&[".", "-o", "folder.png"], &["folder.png"]),
        (&[".", "-o", "picture.jpg"], &["picture.jpg", ".png"]),
        (&[".", "-o", "cube.obj"], &["cube.obj", "-o"]),
        (&[".", "-o", "cube.obj/a.png"], &["cube.obj", "-o"]),
        (&[".", "--results", "x"], &["--sheet"]),
        (&["--sheet", "nowhere"], &["nowhere"]),
        (&["--sheet", ".", "--size", "8192x8192", "-o", "many.png", ".", ".", ".", "."], &["--size", "smaller"]),
    ] {
        let mut all = [&["render"], arguments].concat();
        if !arguments.contains(&"-o") {
            all.extend(["-o", "picture.png"]);
        }
        let before = fs::read_dir(case.0.path()).unwrap().count();
        let output = case.run(&all);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{all:?}: {message}");
        for word in words {
            assert!(message.contains(word), "{all:?}: no {word:?} in: {message}");
        }
        assert!(!message.contains("panicked"), "{message}");
        assert_eq!(fs::read_dir(case.0.path()).unwrap().count(), before, "{all:?} wrote something");
    }
    assert_eq!(fs::read_to_string(case.path("cube.obj")).unwrap(), CUBE);
}

/// Input, result and truth of each folder; where there is no result, the place stays empty, without any its column
/// goes.
#[test]
fn a_sheet_has_a_row_for_every_folder() {
    let case = Case::new();
    let draw =
        |folders: &[&str]| case.draws(&[&["--sheet", "--size", "160x120", "--results", "found"], folders].concat());
    let input_only = draw(&["."]);
    case.write("truth.json", &scene("truth"));
    let with_truth = draw(&["."]);
    assert!(with_truth.width() > input_only.width());
    fs::create_dir_all(case.path("other")).unwrap();
    fs::write(case.path("other/cube.obj"), CUBE).unwrap();
    case.write("other/scene.json", &scene("other"));
    // A result that is the input looks like it, from the same camera.
    fs::create_dir_all(case.path("found/other")).unwrap();
    fs::write(case.path("found/other/cube.obj"), CUBE).unwrap();
    case.write("found/other/scene.json", &scene("other"));
    let sheet = draw(&["other"]);
    let two = draw(&[".", "other"]);
    assert!(two.width() > sheet.width() && two.height() > 2 * 120 && two.height() > with_truth.height());
    let picture = |column: u32| image::imageops::crop_imm(&sheet, 16 + column * 176, 48, 160, 120).to_image();
    assert_eq!(picture(0), picture(1));
}

#[test]
fn several_scenes_make_one_row() {
    let case = Case::new();
    case.write("truth.json", &scene("truth"));
    let row = case.draws(&["scene.json", "truth.json", "scene.json", "--size", "100x80"]);
    assert_eq!(row.width(), 16 + 3 * 116);
}

#[test]
fn optimize_leaves_pictures_and_a_page() {
    let case = Case::new();
    let optimize = ["optimize", ".", "-o", "out", "--candidates", "16", "--iterations", "3"];
    let output = case.run(&optimize);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && told.contains("pictures: drawn by"), "{told}");
    let [before, after] = ["before.png", "after.png"].map(|name| image::open(case.path("out").join(name)).unwrap());
    assert_eq!((before.width(), before.height()), (1200, 900));
    assert!(before != after);
    let page = fs::read_to_string(case.path("out/report.html")).unwrap();
    assert!(page.contains("table &amp; &lt;b&gt;") && !page.contains(" <b>") && !page.contains("<kitchen>"));
    assert_eq!(page.matches("data:image/png;base64,").count(), 2);
    assert!(page.matches("src=").count() == 2 && !page.contains("href="));
    // The only addresses are names.
    assert_eq!(page.matches("://").count(), page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
    // Without pictures the page is there all the same, and those of the earlier run are not left beside it.
    assert!(case.run(&[&optimize[..], &["--no-pictures"]].concat()).status.success());
    assert!(!case.path("out/before.png").exists() && !case.path("out/after.png").exists());
    assert!(!fs::read_to_string(case.path("out/report.html")).unwrap().contains("<img"));
}
