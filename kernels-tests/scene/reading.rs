//! What is read, and what it means.

use crate::fixture::*;
use glam::{DQuat, DVec3};
use rest3d_gpu::scene::{Parent, Pose, Relation, Root, Scene};
use serde_json::json;
use std::path::Path;

#[test]
fn everything_that_the_contract_names_is_read() {
    let folder = Folder::new();
    let scene = folder.read(&full()).unwrap();
    assert_eq!((scene.name.as_str(), scene.objects.len()), ("study", 2));
    assert_eq!(scene.file, folder.path("scene.json"));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let mug = &scene.objects[0];
    assert_eq!(mug.mesh, folder.path("meshes/mug.glb"));
    assert_eq!(mug.convex_parts, [folder.path("meshes/mug_0.obj")]);
    assert_eq!(mug.pose, Pose { rotation: DQuat::IDENTITY, translation: DVec3::new(0.1, 0.75, -0.3) });
    assert_eq!((mug.parent, mug.relation, mug.mass), (Parent::Object(1), Relation::On, Some(0.3)));
    let desk = &scene.objects[1];
    assert_eq!((desk.parent, desk.relation, desk.movable), (Parent::Root(Root::Ground), Relation::On, true));
    assert_eq!((desk.pose, desk.scale, desk.mass), (Pose::IDENTITY, DVec3::ONE, None));
    assert!(desk.category.is_empty() && desk.convex_parts.is_empty());
    assert_eq!(scene.room.ceiling, Some(2.6));
    assert_eq!((scene.room.walls[0].name.as_str(), scene.room.walls[0].normal), ("back", DVec3::Z));
}

#[test]
fn a_folder_stands_for_its_scene_and_gives_it_a_name() {
    let folder = Folder::new();
    let scene = folder.read(&without("/name")).unwrap();
    assert_eq!(scene.name, folder.0.path().file_name().unwrap().to_str().unwrap());
    assert_eq!(Scene::read(folder.0.path()).unwrap().objects, scene.objects);
}

#[test]
fn null_stands_for_absent_and_a_byte_order_mark_for_nothing() {
    let document = minimal(json!([{"name": "desk", "mesh": "meshes/desk.glb", "mass": null, "convex_parts": null}]));
    let scene = Folder::new().read_text(format!("\u{feff}{document}")).unwrap();
    assert_eq!(scene.objects[0].mass, None);
}

#[test]
fn names_of_the_released_pipeline_are_read_and_kept() {
    let relations = [
        ("hang", Relation::Hanging),
        ("attach", Relation::Attached),
        ("on-attach", Relation::Attached),
        ("hanging", Relation::Hanging),
        ("attached", Relation::Attached),
        ("inside", Relation::Inside),
    ];
    for (name, relation) in relations {
        let scene = read(&with("/objects/0/relation", json!(name))).unwrap();
        assert_eq!(scene.objects[0].relation, relation);
        assert!(scene.to_json(Path::new(".")).contains(&format!("\"relation\": \"{name}\"")));
    }
    let roots = [
        ("floor", Root::Ground),
        ("floor-wall", Root::GroundWall),
        ("ground-wall", Root::GroundWall),
        ("wall", Root::Wall),
        ("ceiling", Root::Ceiling),
    ];
    for (name, root) in roots {
        let scene = read(&with("/objects/0/parent", json!(name))).unwrap();
        assert_eq!(scene.objects[0].parent, Parent::Root(root));
        assert!(scene.to_json(Path::new(".")).contains(&format!("\"parent\": \"{name}\"")));
    }
}

#[test]
fn the_tree_is_walked_children_first() {
    let object = |name: &str, parent: &str| json!({"name": name, "mesh": "meshes/mug.glb", "parent": parent});
    let scene = read(&minimal(json!([
        object("cup", "tray"),
        object("lamp", "ground"),
        object("tray", "desk"),
        object("desk", "ground-wall"),
        object("book", "desk"),
    ])))
    .unwrap();
    assert_eq!(scene.children(3).collect::<Vec<_>>(), [2, 4]);
    assert_eq!(scene.children(0).count(), 0);
    assert_eq!(scene.post_order(), [1, 0, 2, 4, 3]);
}

#[test]
fn what_is_static() {
    for (field, value, expected) in [
        ("parent", "ground", false),
        ("parent", "ground-wall", false),
        ("parent", "wall", true),
        ("parent", "ceiling", true),
        ("relation", "hang", true),
        ("relation", "attached", false),
    ] {
        let scene = read(&with(&format!("/objects/0/{field}"), json!(value))).unwrap();
        assert_eq!(scene.is_static(0), expected, "{field} {value}");
    }
    assert!(read(&with("/objects/0/movable", json!(false))).unwrap().is_static(0));
}
