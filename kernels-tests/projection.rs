//! The projection onto what does not overlap: rooms of boxes whose answers are known.
#![allow(clippy::unwrap_used)]

mod common;

use common::hulls::cuboid;
use glam::{DVec3, Quat, Vec3};
use parry3d::math::Pose as Isometry;
use parry3d::query::contact;
use parry3d::shape::Cuboid;
use rest3d_gpu::optimize::{Projection, Scope, project};
use rest3d_gpu::scene::{Pose, Scene};
use rest3d_gpu::shape::{Alternative, MassProperties, Mesh, Part, Shape};
use serde_json::{Value, json};

/// Overlap that counts as touching, m.
const TOUCHING: f64 = 1e-3;

const SCOPES: [Scope; 2] = [Scope::Objects, Scope::Groups];

/// Upright boxes, each one convex part.
struct Room {
    scene: Scene,
    shapes: Vec<Shape>,
    sizes: Vec<Vec3>,
    layout: Vec<Pose>,
}

/// Boxes by name, size, middle and further fields.
fn room(boxes: &[(&str, [f32; 3], [f64; 3], Value)]) -> Room {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("box.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let listed = boxes.iter().map(|(name, _, position, more)| {
        let mut object = json!({"name": name, "mesh": "box.obj", "position": position});
        object.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        object
    });
    let document = json!({"format": "rest3d-scene", "version": 1, "objects": listed.collect::<Vec<_>>()});
    std::fs::write(folder.path().join("scene.json"), document.to_string()).unwrap();
    let scene = Scene::read(folder.path()).unwrap();
    let shape = |size: Vec3| {
        let parts = vec![Part { vertices: cuboid(0.5 * size) }];
        let mass = MassProperties {
            mass: 1.0,
            volume: 1e-3,
            center: Vec3::ZERO,
            axes: Quat::IDENTITY,
            inertia: Vec3::splat(0.01),
        };
        Shape {
            surface: Mesh::default(),
            alternatives: vec![Alternative { parts: parts.clone(), mass: mass.clone() }; 2],
            parts,
            mass,
            bounds: [-0.5 * size, 0.5 * size],
            quality: Default::default(),
            notes: Vec::new(),
        }
    };
    let sizes: Vec<Vec3> = boxes.iter().map(|(_, size, ..)| Vec3::from(*size)).collect();
    let layout = scene.objects.iter().map(|object| object.pose).collect();
    Room { scene, shapes: sizes.iter().map(|&size| shape(size)).collect(), sizes, layout }
}

impl Room {
    fn project(&mut self, scope: Scope) -> Projection {
        project(&self.scene, &self.shapes, &mut self.layout, scope)
    }

    /// Overlap of two boxes by the cuboids of another library, m.
    fn overlap(&self, i: usize, j: usize) -> f64 {
        let placed = |k: usize| {
            let pose = &self.layout[k];
            let at = Isometry::from_parts(pose.translation.as_vec3(), pose.rotation.as_quat());
            (at, Cuboid::new(0.5 * self.sizes[k]))
        };
        let ((a, first), (b, second)) = (placed(i), placed(j));
        contact(&a, &first, &b, &second, 0.0).unwrap().map_or(0.0, |contact| f64::from(-contact.dist).max(0.0))
    }

    fn deepest(&self) -> f64 {
        let count = self.layout.len();
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j)));
        pairs.map(|(i, j)| self.overlap(i, j)).fold(0.0, f64::max)
    }

    fn lowest(&self) -> f64 {
        let bottom = |(pose, size): (&Pose, &Vec3)| pose.translation.y - 0.5 * f64::from(size.y);
        self.layout.iter().zip(&self.sizes).map(bottom).fold(f64::INFINITY, f64::min)
    }
}

fn ground() -> Value {
    json!({})
}

fn on(parent: &str) -> Value {
    json!({"parent": parent})
}

/// A table with two boxes and a lamp in it and in each other, a chair in the table, a stool in the chair and the
/// ground.
fn jumble() -> Room {
    room(&[
        ("table", [1.2, 0.7, 0.8], [0.0, 0.35, 0.0], ground()),
        ("red box", [0.3, 0.2, 0.3], [-0.1, 0.77, 0.0], on("table")),
        ("blue box", [0.3, 0.2, 0.3], [0.1, 0.78, 0.05], on("table")),
        ("lamp", [0.1, 0.4, 0.1], [0.2, 0.85, 0.1], on("table")),
        ("chair", [0.4, 0.9, 0.4], [0.7, 0.45, 0.1], ground()),
        ("stool", [0.3, 0.4, 0.3], [0.9, 0.15, 0.2], ground()),
    ])
}

#[test]
fn nothing_overlaps_afterwards() {
    for scope in SCOPES {
        let mut room = jumble();
        assert!(room.deepest() > 0.05 && room.lowest() < -0.04, "the test's own start");
        let projection = room.project(scope);
        assert!(projection.converged, "{scope:?}: {projection:?}");
        assert!(room.deepest() <= TOUCHING, "{scope:?}: {} m", room.deepest());
        assert!(room.lowest() >= -TOUCHING, "{scope:?}: {} m", room.lowest());
        let farthest = projection.shifts.iter().map(|shift| shift.length()).fold(0.0, f64::max);
        assert!(farthest < 0.35, "{scope:?}: {farthest} m for overlaps of half as much");
    }
}

#[test]
fn what_is_feasible_keeps_every_bit() {
    for scope in SCOPES {
        // Odd numbers, a gap, and a box that has sunk in by half of what counts as touching.
        let mut room = room(&[
            ("table", [1.2, 0.7, 0.8], [0.1, 0.35, 1.0 / 3.0], ground()),
            ("box", [0.3, 0.2, 0.3], [0.1, 0.7995, 1.0 / 3.0], on("table")),
            ("chair", [0.4, 0.9, 0.4], [0.9001, 0.4495, 0.1], ground()),
        ]);
        let before = room.layout.clone();
        let projection = room.project(scope);
        assert!(projection.converged && projection.rounds == 0, "{projection:?}");
        assert_eq!(room.layout, before, "{scope:?}");
    }
}

#[test]
fn two_share_the_way() {
    for scope in SCOPES {
        let mut room = room(&[
            ("a", [0.4, 0.5, 0.4], [0.0, 0.25, 0.0], ground()),
            ("b", [0.4, 0.5, 0.4], [0.3, 0.25, 0.0], ground()),
        ]);
        let shifts = room.project(scope).shifts;
        for (shift, wanted) in shifts.iter().zip([-0.05, 0.05]) {
            assert!(shift.distance(DVec3::X * wanted) < 2e-3, "{scope:?}: {shifts:?}");
        }
    }
}

#[test]
fn a_child_is_lifted_and_its_children_go_along() {
    let mut room = room(&[
        ("table", [1.2, 0.7, 0.8], [0.0, 0.35, 0.0], ground()),
        ("tray", [0.4, 0.1, 0.3], [0.5, 0.7, 0.0], on("table")),
        ("cup", [0.1, 0.1, 0.1], [0.5, 0.8, 0.0], on("tray")),
    ]);
    let shifts = room.project(Scope::Groups).shifts;
    assert_eq!(shifts[0], DVec3::ZERO);
    assert!(shifts[1].distance(DVec3::Y * 0.05) < 1.2e-3, "{shifts:?}");
    assert_eq!(shifts[1], shifts[2]);
}

#[test]
fn what_is_nested_stays_in_its_container() {
    for scope in SCOPES {
        let mut room = room(&[
            ("cabinet", [1.0, 0.6, 0.5], [0.0, 0.3, 0.0], ground()),
            ("player", [0.4, 0.1, 0.3], [0.1, 0.3, 0.02], json!({"parent": "cabinet", "relation": "inside"})),
            ("disc", [0.1, 0.05, 0.1], [0.1, 0.34, 0.02], on("player")),
            ("chair", [0.4, 0.9, 0.4], [0.6, 0.45, 0.0], ground()),
        ]);
        let projection = room.project(scope);
        assert!(projection.converged, "{scope:?}: {projection:?}");
        assert!(projection.shifts[0].length() > 0.01, "the cabinet leaves the chair: {projection:?}");
        assert_eq!(projection.shifts[0], projection.shifts[1], "{scope:?}");
        assert!(room.overlap(0, 3) <= TOUCHING);
    }
}

#[test]
fn what_is_fixed_stays() {
    for scope in SCOPES {
        let mut room = room(&[
            ("stove", [0.6, 0.9, 0.6], [0.0, 0.45, 0.0], json!({"movable": false})),
            ("pot", [0.3, 0.2, 0.3], [0.0, 0.95, 0.0], on("stove")),
            ("bin", [0.3, 0.5, 0.3], [0.4, 0.25, 0.1], ground()),
        ]);
        let projection = room.project(scope);
        assert!(projection.converged && room.deepest() <= TOUCHING, "{scope:?}: {projection:?}");
        assert_eq!(projection.shifts[0], DVec3::ZERO);
        assert!(projection.shifts[1].distance(DVec3::Y * 0.05) < 1.2e-3, "{scope:?}: {projection:?}");
        assert!(projection.shifts[2].distance(DVec3::X * 0.05) < 2e-3, "{scope:?}: {projection:?}");
    }
}

/// A box that two walls, each metres thick, squeeze has nowhere to go.
#[test]
fn a_contradiction_is_told() {
    let wall = || json!({"movable": false});
    let mut room = room(&[
        ("left", [6.0, 3.0, 9.0], [-3.1, 1.5, 0.0], wall()),
        ("right", [6.0, 3.0, 9.0], [3.1, 1.5, 0.0], wall()),
        ("box", [0.5, 0.5, 0.5], [0.0, 0.25, 0.0], ground()),
    ]);
    assert!(!room.project(Scope::Groups).converged);
    assert!(room.layout.iter().all(Pose::is_finite));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |threads: usize, scope| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut room = jumble();
        let projection = pool.install(|| room.project(scope));
        (projection, room.layout)
    };
    for scope in SCOPES {
        assert_eq!(run(1, scope), run(3, scope));
    }
}
