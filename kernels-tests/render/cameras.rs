//! From where the scene is seen and lit.

use crate::fixture::*;
use glam::DVec3;
use rest3d_gpu::render::{Camera, Size, Viewpoint, camera, lights};
use serde_json::json;

#[test]
fn cameras_are_understood_or_refused_with_a_remedy() {
    for (text, expected) in [
        ("auto", Viewpoint::Auto),
        (" Top ", Viewpoint::Toward { azimuth: 0.0, elevation: 90.0 }),
        ("-30, 25.5", Viewpoint::Toward { azimuth: -30.0, elevation: 25.5 }),
        ("1,2,3,0,0,0", Viewpoint::Exact { eye: DVec3::new(1.0, 2.0, 3.0), target: DVec3::ZERO }),
    ] {
        assert_eq!(text.parse(), Ok(expected), "{text}");
    }
    for text in ["", "north", "nan,3", "1,2,3", "0,91", "1,inf", "1,2,3,1,2,3", "1,2,3,4,5,x"] {
        let error = text.parse::<Viewpoint>().unwrap_err();
        assert!(error.len() > 20, "{text}: {error}");
    }
    for text in ["", "1600", "0x10", "9000x100", "-3x5", "1e3x1e3"] {
        assert!(text.parse::<Size>().is_err(), "{text}");
    }
    assert_eq!("640X480".parse(), Ok(Size { width: 640, height: 480 }));
}

/// All of the scene is in the picture, and it touches the margin.
#[test]
fn the_camera_frames_the_scene_tightly() {
    let case = Case::new();
    let scene = case.scene(&document(&boxes()));
    let stage = staged(&scene);
    for (azimuth, elevation) in [(0.0, 0.0), (33.0, 27.0), (180.0, -20.0), (70.0, 90.0)] {
        let camera = Camera::framing(azimuth, elevation, &stage.framed, SIZE.aspect());
        let widest = stage.framed.iter().map(|p| {
            let p = *p - camera.eye;
            let depth = p.dot(camera.forward) * camera.slope;
            assert!(depth > 0.0, "{azimuth} {elevation}");
            (p.dot(camera.right) / camera.aspect / depth).abs().max((p.dot(camera.up) / depth).abs())
        });
        let widest = widest.fold(0.0, f64::max);
        assert!((widest - 0.9).abs() < 1e-6, "{azimuth} {elevation}: {widest}");
    }
}

/// An object before another one hides it: the view that is chosen is another.
#[test]
fn the_view_that_is_chosen_hides_nothing() {
    let case = Case::new();
    for (side, hider) in [("front", [0.0, 0.75, 0.6]), ("left", [-0.6, 0.75, 0.0])] {
        let mut size = [1.2, 1.5, 1.2];
        size[if side == "front" { 2 } else { 0 }] = 0.05;
        let objects = [cuboid("small", [0.0, 0.1, 0.0], [0.2; 3]), cuboid("screen", hider, size)];
        let mut document = document(&objects);
        document["room"] = json!({});
        let scene = case.scene(&document);
        let stage = staged(&scene);
        let camera = camera(Viewpoint::Auto, &scene, &[&stage], SIZE);
        let back = camera.toward_viewer();
        let toward = if side == "front" { back.z } else { -back.x };
        // Up to 45° off, the screen hides it.
        assert!(toward < 0.7, "{side}: {back}");
    }
}

#[test]
fn lights_see_all_that_casts_shadows() {
    let case = Case::new();
    let scene = case.scene(&document(&boxes()));
    let stage = staged(&scene);
    let camera = camera(Viewpoint::Auto, &scene, &[&stage], SIZE);
    let lights = lights(&stage, &camera);
    assert!(!lights.is_empty() && !stage.casters.positions.is_empty());
    for light in lights {
        for p in &stage.casters.positions {
            let at = [light.u, light.v, light.depth].map(|row| row.dot(*p));
            assert!(at.iter().all(|x| (0.0..1.0).contains(x)), "{at:?}");
        }
    }
}
