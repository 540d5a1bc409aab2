//! Furniture made of blocks, and a room of it.

use crate::common::program::program;
use glam::{DQuat, DVec3};
use rest3d_gpu::canonicalize::{Canonicalization, canonicalize};
use rest3d_gpu::optimize::shape_requests;
use rest3d_gpu::scene::{Pose, Scene};
use rest3d_gpu::shape::{Mesh, scaled_mesh};
use serde_json::{Value, json};
use std::fs;
use std::process::Output;
use tempfile::TempDir;

/// Lowest and highest corner of a box, m.
pub type Block = [[f64; 3]; 2];

/// Front is +Z; origins are on the floor.
pub const DESK: &[Block] = &[
    [[-0.6, 0.72, -0.3], [0.6, 0.75, 0.3]],
    [[-0.6, 0.0, -0.3], [-0.57, 0.72, 0.3]],
    [[0.57, 0.0, -0.3], [0.6, 0.72, 0.3]],
    // The hutch: a wall behind and a board over the back of the top.
    [[-0.6, 0.75, -0.3], [0.6, 1.3, -0.28]],
    [[-0.6, 1.1, -0.28], [0.6, 1.12, -0.05]],
];
pub const CHAIR: &[Block] = &[
    [[-0.22, 0.43, -0.22], [0.22, 0.46, 0.22]],
    [[-0.22, 0.46, -0.22], [0.22, 0.95, -0.19]],
    [[-0.22, 0.0, -0.22], [-0.18, 0.43, -0.18]],
    [[0.18, 0.0, -0.22], [0.22, 0.43, -0.18]],
    [[-0.22, 0.0, 0.18], [-0.18, 0.43, 0.22]],
    [[0.18, 0.0, 0.18], [0.22, 0.43, 0.22]],
];
pub const SHELF: &[Block] = &[
    [[-0.4, 0.0, -0.15], [-0.38, 1.5, 0.15]],
    [[0.38, 0.0, -0.15], [0.4, 1.5, 0.15]],
    [[-0.38, 0.1, -0.15], [0.38, 0.12, 0.15]],
    [[-0.38, 0.5, -0.15], [0.38, 0.52, 0.15]],
    [[-0.38, 0.9, -0.15], [0.38, 0.92, 0.15]],
    [[-0.38, 1.48, -0.15], [0.38, 1.5, 0.15]],
];
pub const CRATE: &[Block] = &[[[-0.25, 0.0, -0.2], [0.25, 0.4, 0.2]]];
pub const TIN: &[Block] = &[[[-0.05, 0.0, -0.04], [0.05, 0.12, 0.04]]];
pub const BOOK: &[Block] = &[[[-0.1, 0.0, -0.07], [0.1, 0.03, 0.07]]];

pub fn obj(blocks: &[Block]) -> String {
    const FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::new();
    for block in blocks {
        for i in 0..8 {
            let [x, y, z] = std::array::from_fn(|axis| block[i >> axis & 1][axis]);
            text += &format!("v {x} {y} {z}\n");
        }
    }
    for first in (0..blocks.len()).map(|n| 8 * n + 1) {
        for [a, b, c, d] in FACES.map(|face| face.map(|i| first + i)) {
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

/// An object of a known layout.
pub struct Thing {
    pub name: &'static str,
    pub mesh: &'static str,
    pub pose: Pose,
    pub parent: &'static str,
    pub relation: &'static str,
    pub movable: bool,
}

pub fn thing(name: &'static str, mesh: &'static str, at: [f64; 3], yaw: f64, parent: &'static str) -> Thing {
    let pose = Pose { rotation: DQuat::from_rotation_y(yaw), translation: DVec3::from(at) };
    Thing { name, mesh, pose, parent, relation: "on", movable: true }
}

/// A room in which everything stands where it belongs.
pub fn room() -> Vec<Thing> {
    let mut things = vec![
        thing("desk", "desk", [0.0, 0.0, -1.5], 0.1, "ground"),
        thing("chair", "chair", [0.1, 0.0, -0.8], 3.0, "ground"),
        thing("shelf", "shelf", [-1.5, 0.0, -1.0], 1.5, "ground-wall"),
        thing("crate", "crate", [1.2, 0.0, 0.3], 0.4, "ground"),
        thing("second crate", "crate", [-1.0, 0.0, 0.9], -0.8, "ground"),
        thing("tin", "tin", [0.2, 0.75, -1.35], 0.5, "desk"),
        thing("tin below", "tin", [-0.3, 0.75, -1.62], 0.2, "desk"),
        thing("tin above", "tin", [0.3, 1.12, -1.66], -0.4, "desk"),
        thing("book", "book", [0.1, 0.46, -0.8], 2.0, "chair"),
        thing("shelf book", "book", [-1.5, 0.52, -1.0], 1.5, "shelf"),
        thing("top book", "book", [-1.5, 0.55, -1.0], 1.2, "shelf book"),
        thing("clock", "tin", [0.0, 1.7, -1.9], 0.0, "wall"),
        thing("lamp", "tin", [0.0, 2.3, 0.0], 0.0, "ceiling"),
        thing("cabinet", "crate", [1.5, 0.0, -1.5], 0.0, "ground"),
    ];
    things[9].relation = "inside";
    things[12].relation = "hanging";
    things[13].movable = false;
    things
}

/// A scene on disk with its meshes.
pub struct Case {
    pub folder: TempDir,
}

impl Case {
    /// `change` is what the reconstruction gets wrong about all objects alike.
    pub fn new(things: &[Thing], change: Pose) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, blocks) in
            [("desk", DESK), ("chair", CHAIR), ("shelf", SHELF), ("crate", CRATE), ("tin", TIN), ("book", BOOK)]
        {
            fs::write(folder.path().join(format!("{name}.obj")), obj(blocks)).unwrap();
        }
        let place = |p: DVec3| change.translation + change.rotation * p;
        let entry = |thing: &Thing| {
            json!({
                "name": thing.name, "mesh": format!("{}.obj", thing.mesh), "parent": thing.parent,
                "position": place(thing.pose.translation).to_array(),
                "rotation_xyzw": (change.rotation * thing.pose.rotation).to_array(),
                "relation": thing.relation, "movable": thing.movable, "colour": "red",
            })
        };
        let objects: Vec<Value> = things.iter().map(entry).collect();
        let wall = json!({
            "name": "back", "point": place(DVec3::new(0.0, 1.0, -2.0)).to_array(),
            "normal": (change.rotation * DVec3::Z).to_array(),
        });
        let room = json!({"ceiling": place(DVec3::new(0.0, 2.5, 0.0)).y, "walls": [wall]});
        let document = json!({
            "format": "rest3d-scene", "version": 1, "name": "room", "room": room, "objects": objects, "origin": "test"
        });
        fs::write(folder.path().join("scene.json"), document.to_string()).unwrap();
        Self { folder }
    }

    pub fn read(&self) -> (Scene, Vec<Mesh>) {
        let scene = Scene::read(self.folder.path()).unwrap();
        let meshes = shape_requests(&scene).iter().map(|request| scaled_mesh(request).unwrap()).collect();
        (scene, meshes)
    }

    pub fn canonical(&self) -> (Scene, Canonicalization) {
        let (mut scene, meshes) = self.read();
        let report = canonicalize(&mut scene, &meshes);
        (scene, report)
    }

    pub fn run(&self, command: &str, more: &[&str]) -> Output {
        let mut run = program();
        run.arg(command).arg(self.folder.path()).arg("-o").arg(self.folder.path().join("out")).args(more);
        run.output().unwrap()
    }
}

pub fn tilt(direction: f64, degrees: f64) -> DQuat {
    DQuat::from_axis_angle(DVec3::new(direction.cos(), 0.0, direction.sin()), degrees.to_radians())
}

pub fn up(pose: &Pose) -> DVec3 {
    pose.rotation * DVec3::Y
}

pub fn by_name<'a>(scene: &'a Scene, name: &str) -> &'a Pose {
    &scene.objects.iter().find(|object| object.name == name).unwrap().pose
}

/// Everything upright and at its height, with the horizontal distances of the known layout.
pub fn assert_restored(scene: &Scene, things: &[Thing], tolerance: f64) {
    assert_eq!(scene.objects.len(), things.len());
    for (object, thing) in scene.objects.iter().zip(things) {
        assert!(up(&object.pose).angle_between(DVec3::Y) < tolerance, "{}: {:?}", thing.name, object.pose);
        let height = object.pose.translation.y - thing.pose.translation.y;
        assert!(height.abs() < tolerance, "{}: {height} m too high", thing.name);
    }
    let distance = |a: DVec3, b: DVec3| a.distance(b);
    for (object, thing) in scene.objects.iter().zip(things).skip(1) {
        let now = distance(object.pose.translation, scene.objects[0].pose.translation);
        let known = distance(thing.pose.translation, things[0].pose.translation);
        assert!((now - known).abs() < tolerance, "{}: {now} m, not {known} m from the desk", thing.name);
    }
}
