//! The import of stage2 folders.

use crate::fixture::*;
use glam::DVec3;
use rest3d_gpu::import;
use rest3d_gpu::scene::{Parent, Pose, Relation, Root, Scene};
use serde_json::json;
use std::path::PathBuf;

#[test]
fn a_stage2_folder_is_a_scene() {
    let tree = json!({
        "roots": ["floor", "wall"],
        "nodes": ["floor", "desk_000", {"name": "mug_001", "movable": true}, {"id": "shelf", "type": "fixed"}, "lamp"],
        "edges": [
            {"child": "desk_000", "parent": "floor", "relation": "on", "type": "movable"},
            {"child": "mug_001", "parent": "desk_000", "relation": "on", "type": "movable"},
            {"child": "mug_001", "parent": "shelf", "relation": "inside"},
            {"child": "shelf", "parent": "wall", "relation": "on-attach", "type": "fixed"},
            {"child": "red_ball_002", "parent": "floor-wall", "relation": "on", "type": "fixed"}
        ]
    });
    let folder = stage2(&tree, &["desk_000", "mug_001", "shelf", "lamp", "red_ball_002"]);
    let stage2 = folder.path().join("stage2");
    for path in [folder.path().to_path_buf(), stage2.clone(), stage2.join("scene_tree.json")] {
        let scene = import::read(&path).unwrap();
        let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
        assert_eq!(names, ["desk_000", "mug_001", "shelf", "lamp", "red_ball_002"]);
        assert_eq!(scene.name, "stage2");
        assert!(scene.objects.iter().all(|object| object.pose == Pose::IDENTITY && object.scale == DVec3::ONE));
        assert_eq!(scene.objects[1].parent, Parent::Object(0));
        assert_eq!(
            (scene.objects[2].parent, scene.objects[2].relation),
            (Parent::Root(Root::Wall), Relation::Attached)
        );
        assert_eq!((scene.objects[2].movable, scene.objects[0].movable), (false, true));
        assert_eq!((scene.objects[4].parent, scene.objects[4].movable), (Parent::Root(Root::GroundWall), false));
        assert_eq!(scene.objects[4].category, "red ball");
        assert_eq!(scene.objects[0].mesh, path_of(&scene, "scene_canon/obj_files/scene_canon_desk_000.obj"));
        // The second parent of the mug, and the lamp that stands on nothing.
        assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
        assert!(scene.warnings[0].contains("object \"mug_001\", field \"edges[2]\""), "{}", scene.warnings[0]);
        assert!(scene.warnings[1].contains("object \"lamp\""), "{}", scene.warnings[1]);
        let written = scene.to_json(&stage2);
        assert!(written.contains("\"parent\": \"ground\"") && written.contains("\"relation\": \"attached\""));
    }
}

fn path_of(scene: &Scene, path: &str) -> PathBuf {
    scene.file.parent().unwrap().join(path)
}

#[test]
fn a_damaged_stage2_folder_is_an_error() {
    let object = json!({"name": "desk"});
    for (tree, object, field, problem) in [
        (json!({}), None, Some("nodes"), "missing"),
        (json!({"nodes": {}}), None, Some("nodes"), "not a list"),
        (json!({"nodes": [7]}), None, Some("nodes[0]"), "no name"),
        (json!({"nodes": [""]}), None, Some("nodes[0]"), "no name"),
        (json!({"nodes": [object], "edges": 1}), None, Some("edges"), "not a list"),
        (json!({"nodes": [object], "edges": [{"child": "desk"}]}), None, Some("edges[0].parent"), "missing"),
        (json!({"nodes": ["mug"]}), Some("mug"), Some("mesh"), "scene_canon_mug.obj cannot be found"),
        (
            json!({"nodes": [object], "edges": [{"child": "desk", "parent": "moon"}]}),
            Some("desk"),
            Some("parent"),
            "no \"moon\"",
        ),
        (
            json!({"nodes": [object], "edges": [{"child": "desk", "parent": "floor", "relation": "near"}]}),
            Some("desk"),
            Some("relation"),
            "near",
        ),
    ] {
        let folder = stage2(&tree, &["desk"]);
        assert_error(import::read(folder.path()), object, field, problem);
    }
}
