//! The exact step: meshes whose parts do not cover them, bowls, shelves, walls, and what cannot be parted.
#![allow(clippy::unwrap_used)]

mod common;

use common::meshes::{Placed, corners, meet};
use glam::{DVec3, Vec3};
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;
use rest3d_gpu::optimize::{self, Clearances, part_meshes, shape_requests};
use rest3d_gpu::scene::{Pose, Scene};
use rest3d_gpu::shape::{Mesh, Shape, ShapeSettings, build_shapes};
use serde_json::{Value, json};
use std::f32::consts::{PI, TAU};

/// A turned body: points (radius, height) from the bottom to the top, turned about the y axis.
fn lathe(outline: &[[f32; 2]], sides: u32) -> Mesh {
    let vertices = (0..sides)
        .flat_map(|i| {
            let (sin, cos) = (TAU * i as f32 / sides as f32).sin_cos();
            outline.iter().map(move |[r, y]| Vec3::new(r * cos, *y, r * sin))
        })
        .collect();
    let rows = outline.len() as u32;
    let triangles = (0..sides)
        .flat_map(|i| {
            let (a, b) = (i * rows, (i + 1) % sides * rows);
            (1..rows).flat_map(move |k| [[a + k - 1, a + k, b + k], [a + k - 1, b + k, b + k - 1]])
        })
        .collect::<Vec<[u32; 3]>>();
    let vertices: Vec<Vec3> = vertices;
    let corner = |i: u32| vertices[i as usize];
    let triangles =
        triangles.into_iter().filter(|&[a, b, c]| (corner(b) - corner(a)).cross(corner(c) - corner(a)) != Vec3::ZERO);
    Mesh { triangles: triangles.collect(), vertices }
}

fn ball(radius: f32) -> Mesh {
    // The poles lie on the axis to the bit.
    let ring = |i: u32| (PI * i as f32 / 24.0).sin_cos();
    let point = |i: u32| [if i.is_multiple_of(24) { 0.0 } else { radius * ring(i).0 }, -radius * ring(i).1];
    lathe(&(0..=24).map(point).collect::<Vec<_>>(), 48)
}

/// A bowl 24 cm wide with a wall of 4 mm.
fn bowl() -> Mesh {
    let round = |r: f32, i: u32| {
        let (sin, cos) = (0.5 * PI * i as f32 / 16.0).sin_cos();
        [r * sin, 0.12 - r * cos]
    };
    let outside = (0..=16).map(|i| round(0.12, i));
    lathe(&outside.chain((0..=16).rev().map(|i| round(0.116, i))).collect::<Vec<_>>(), 48)
}

fn cuboid(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let corner = |i: usize| Vec3::from_array(std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] }));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Mesh {
        vertices: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect(),
    }
}

fn joined(meshes: &[Mesh]) -> Mesh {
    meshes.iter().fold(Mesh::default(), |mut all, mesh| {
        let first = all.vertices.len() as u32;
        all.vertices.extend(&mesh.vertices);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first)));
        all
    })
}

/// Two shelves between two sides, without a back, 40 cm wide inside.
fn shelf() -> Mesh {
    joined(&[
        cuboid([-0.22, 0.0, -0.15], [-0.2, 0.8, 0.15]),
        cuboid([0.2, 0.0, -0.15], [0.22, 0.8, 0.15]),
        cuboid([-0.2, 0.0, -0.15], [0.2, 0.02, 0.15]),
        cuboid([-0.2, 0.4, -0.15], [0.2, 0.42, 0.15]),
    ])
}

/// A scene of meshes with the hulls of `parts` as their parts.
struct Room {
    scene: Scene,
    shapes: Vec<Shape>,
    layout: Vec<Pose>,
}

fn obj(mesh: &Mesh) -> String {
    let vertices = mesh.vertices.iter().map(|v| format!("v {} {} {}\n", v.x, v.y, v.z));
    let faces = mesh.triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect()
}

fn room(objects: &[(Mesh, [f64; 3], Value)]) -> Room {
    let folder = tempfile::tempdir().unwrap();
    let listed: Vec<Value> = (objects.iter().enumerate())
        .map(|(i, (mesh, position, more))| {
            std::fs::write(folder.path().join(format!("{i}.obj")), obj(mesh)).unwrap();
            let mut object = json!({"name": format!("o{i}"), "mesh": format!("{i}.obj"), "position": position});
            object.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            object
        })
        .collect();
    let document = json!({"format": "rest3d-scene", "version": 1, "objects": listed});
    std::fs::write(folder.path().join("scene.json"), document.to_string()).unwrap();
    let scene = Scene::read(folder.path()).unwrap();
    let shapes = build_shapes(&shape_requests(&scene), &ShapeSettings::default(), None, &|_, _, _| ()).unwrap();
    let layout = scene.objects.iter().map(|object| object.pose).collect();
    Room { scene, shapes, layout }
}

impl Room {
    fn part(&mut self) -> Clearances {
        part_meshes(&self.scene, &self.shapes, &optimize::Room::default(), &mut self.layout)
    }

    fn placed(&self, i: usize) -> Placed<'_> {
        (&self.shapes[i].surface, &self.layout[i])
    }

    /// How far apart two meshes are by another library's projection of their corners, m; zero if they meet.
    fn gap(&self, i: usize, j: usize) -> f32 {
        let [a, b] = [i, j].map(|i| self.placed(i));
        if meet(a, b) {
            return 0.0;
        }
        let from = |other, (mesh, pose): Placed<'_>| {
            let surface = TriMesh::new(mesh.vertices.clone(), mesh.triangles.clone()).unwrap();
            let local = |p: DVec3| (pose.rotation.conjugate() * (p - pose.translation)).as_vec3();
            let gaps = corners(other).into_iter().map(|p| surface.distance_to_local_point(local(p), false).abs());
            gaps.fold(f32::INFINITY, f32::min)
        };
        from(a, b).min(from(b, a))
    }

    fn moved(&self, i: usize) -> DVec3 {
        self.layout[i].translation - self.scene.objects[i].pose.translation
    }
}

/// Meshes rest at most so far apart, m: the margin of 0.05 mm, and f32.
const RESTING: std::ops::Range<f32> = 0.01e-3..0.1e-3;

#[test]
fn what_is_sunk_is_raised_with_what_it_bears_and_no_farther() {
    let table = cuboid([-0.5, 0.0, -0.5], [0.5, 0.7, 0.5]);
    let mut room = room(&[
        (table, [0.0, -0.0007, 0.0], json!({})),
        (ball(0.1), [0.0, 0.795, 0.0], json!({"parent": "o0"})),
        (ball(0.05), [0.3, 0.747, 0.0], json!({"parent": "o0"})),
    ]);
    assert_eq!(room.gap(0, 1), 0.0, "a canary: these meshes meet");
    let clearances = room.part();
    assert!(clearances.overlaps.is_empty(), "{clearances:?}");
    for i in 1..3 {
        assert!(RESTING.contains(&room.gap(0, i)), "ball {i} rests at {} mm", 1e3 * room.gap(0, i));
        assert!(room.moved(i).with_y(0.0).length() < 1e-9, "a ball is raised, not pushed: {}", room.moved(i));
    }
    let foot = room.layout[0].translation.y;
    assert!((1e-5..1e-4).contains(&foot), "the table stands at {foot}");
    assert!(clearances.drops.iter().all(|drop| drop.is_some_and(|drop| drop < 1e-4)), "{clearances:?}");
}

#[test]
fn fruit_in_a_bowl_stays_in_the_bowl() {
    let inside = json!({"parent": "o0", "relation": "inside"});
    let mut room = room(&[
        (bowl(), [0.0, 0.0, 0.0], json!({})),
        (ball(0.04), [0.0, 0.042, 0.0], inside.clone()),
        (ball(0.03), [0.0711, 0.0702, 0.0], inside.clone()),
        (ball(0.03), [-0.064, 0.0655, 0.0], inside),
    ]);
    assert!([(0, 1), (0, 2), (0, 3)].iter().any(|&(i, j)| room.gap(i, j) == 0.0), "a canary: these meshes meet");
    let clearances = room.part();
    assert!(clearances.overlaps.is_empty(), "{clearances:?}");
    for (i, j) in (0..4).flat_map(|j| (0..j).map(move |i| (i, j))) {
        assert!(room.gap(i, j) > 1e-5, "{i} and {j}: {clearances:?}");
    }
    for i in 1..4 {
        assert!(room.moved(i).length() < 0.01, "fruit {i} has gone {}", room.moved(i));
    }
}

#[test]
fn a_shelf_that_is_held_stays_and_what_is_in_it_gives_way() {
    let on_board = json!({"parent": "o0", "relation": "inside"});
    let books = cuboid([-0.1, 0.0, -0.1], [0.1, 0.25, 0.1]);
    let mut room = room(&[
        (shelf(), [0.0, 0.0, 0.0], json!({"movable": false})),
        (books, [0.103, 0.419, 0.0], on_board.clone()),
        (cuboid([-0.095, 0.0, -0.1], [0.095, 0.25, 0.1]), [-0.0955, 0.4205, 0.0], on_board),
    ]);
    let clearances = room.part();
    assert!(clearances.overlaps.is_empty(), "{clearances:?}");
    assert_eq!(room.moved(0), DVec3::ZERO);
    assert!(room.gap(0, 1) > 1e-5 && room.gap(1, 2) > 1e-5 && room.gap(0, 2) > 1e-5);
    assert!(room.moved(1).length() < 6e-3, "{}", room.moved(1));
}

#[test]
fn pictures_on_a_wall_are_parted_though_nothing_moves_them() {
    let picture = cuboid([-0.2, -0.15, 0.0], [0.2, 0.15, 0.02]);
    let on_wall = json!({"parent": "wall", "relation": "attached"});
    let mut room = room(&[
        (picture.clone(), [0.0, 1.5, 0.0], on_wall.clone()),
        (picture.clone(), [0.38, 1.5, 0.0], on_wall),
        (picture, [1.0, 0.15, 0.0], json!({})),
    ]);
    assert!(room.part().overlaps.is_empty());
    assert!(room.gap(0, 1) > 1e-5);
    assert!(room.moved(0).length() + room.moved(1).length() < 0.022);
    assert!(room.moved(2).length() < 1e-3, "what touches nothing stays: {}", room.moved(2));
}

/// A coat hanger 2 cm above its rod, a towel 3 cm beside its rail, a bag behind whose hook there is a post, one that is too
/// far off and one that nobody may move.
#[test]
fn what_hangs_on_an_object_is_taken_to_it() {
    let rod = || cuboid([-0.5, 0.0, -0.01], [0.5, 0.02, 0.01]);
    let hook = || {
        joined(&[
            cuboid([-0.01, 0.02, -0.01], [0.01, 0.03, 0.03]),
            cuboid([-0.01, -0.2, 0.02], [0.01, 0.02, 0.03]),
            cuboid([-0.2, -0.3, 0.02], [0.2, -0.2, 0.03]),
        ])
    };
    let block = || cuboid([-0.05, -0.05, -0.05], [0.05, 0.05, 0.05]);
    let hangs = || json!({"parent": "o0", "relation": "hanging"});
    let mut room = room(&[
        (rod(), [0.0, 1.0, 0.0], json!({"movable": false})),
        (hook(), [-0.3, 1.02, 0.0], hangs()),
        (block(), [0.3, 1.01, 0.09], hangs()),
        (block(), [0.15, 1.01, -0.09], hangs()),
        (cuboid([-0.01, 0.0, -0.01], [0.01, 2.0, 0.01]), [0.15, 0.00005, -0.025], json!({})),
        (block(), [0.0, 1.01, 0.12], hangs()),
        (block(), [0.45, 1.01, -0.09], json!({"parent": "o0", "relation": "hanging", "movable": false})),
    ]);
    room.part();
    assert!((room.moved(1) + DVec3::Y * 0.01995).length() < 1e-6, "comes down: {}", room.moved(1));
    assert!((room.moved(2) + DVec3::Z * 0.0295).length() < 1e-6, "the nearest way: {}", room.moved(2));
    assert_eq!([3, 4, 5, 6].map(|i| room.moved(i)), [DVec3::ZERO; 4], "behind a post, the post, too far off, held");
}

#[test]
fn neighbours_get_half_a_millimetre_where_there_is_room() {
    let block = cuboid([-0.05, 0.0, -0.05], [0.05, 0.1, 0.05]);
    let mut room = room(&[(block.clone(), [0.0, 0.00005, 0.0], json!({})), (block, [0.1001, 0.00005, 0.0], json!({}))]);
    room.part();
    assert!((0.4e-3..0.7e-3).contains(&room.gap(0, 1)), "{} mm", 1e3 * room.gap(0, 1));
}

#[test]
fn what_its_parts_hold_up_by_a_hair_is_lowered_with_what_it_bears() {
    let block = cuboid([-0.05, 0.0, -0.05], [0.05, 0.1, 0.05]);
    let mut room = room(&[
        (block.clone(), [0.0, 0.00013, 0.0], json!({})),
        (block.clone(), [0.0, 0.10029, 0.0], json!({"parent": "o0"})),
        (block.clone(), [1.0, 0.0004, 0.0], json!({})),
        (block, [2.0, 0.00013, 0.0], json!({"parent": "wall", "relation": "attached"})),
    ]);
    room.part();
    for (i, hovered) in [(0, 0.13e-3), (1, 0.29e-3)] {
        let rests = 0.05e-3 * (i + 1) as f64;
        assert!((room.moved(i).y - (rests - hovered)).abs() < 2e-6, "{i}: {}", room.moved(i));
        assert_eq!(room.moved(i).with_y(0.0), DVec3::ZERO);
    }
    assert_eq!(room.moved(2), DVec3::ZERO, "too high for its parts to be what holds it up");
    assert_eq!(room.moved(3), DVec3::ZERO, "on its wall");
}

#[test]
fn what_has_no_free_place_is_reported() {
    let mut room = room(&[
        (cuboid([-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]), [0.0, 0.0, 0.0], json!({"movable": false})),
        (cuboid([-0.3, 0.3, -0.7], [0.3, 0.7, 0.7]), [0.0, 0.0, 0.0], json!({})),
        (cuboid([-0.1, 0.0, -0.1], [0.1, 0.1, 0.1]), [2.0, 0.00005, 0.0], json!({})),
    ]);
    let clearances = room.part();
    assert_eq!(clearances.overlaps.len(), 1);
    assert_eq!((clearances.overlaps[0].objects, clearances.overlaps[0].depth), ([0, 1], None));
    assert!(room.layout.iter().all(|pose| pose.is_finite()));
    assert!(room.moved(1).length() < 0.01 && room.moved(2).length() == 0.0);
}

/// Two cupboards that nobody may move, 5 cm in each other, and a box beside them.
#[test]
fn what_is_not_movable_stays_and_is_reported() {
    let cube = || cuboid([-0.1, 0.0, -0.1], [0.1, 0.2, 0.1]);
    let fixed = || json!({"movable": false});
    let objects =
        [(cube(), [0.0, 0.0, 0.0], fixed()), (cube(), [0.15, 0.0, 0.0], fixed()), (cube(), [0.5, 0.0, 0.0], json!({}))];
    let mut room = room(&objects);
    let clearances = room.part();
    let [overlap] = &clearances.overlaps[..] else { panic!("{:?}", clearances.overlaps) };
    assert_eq!(overlap.objects, [0, 1]);
    assert!((overlap.depth.unwrap() - 0.05).abs() < 1e-3, "{overlap:?}");
    assert!(clearances.complete && (0..3).all(|i| room.moved(i) == DVec3::ZERO));
}

#[test]
fn odd_meshes_do_no_harm_and_the_result_is_the_same_every_time() {
    let triangle = |a: [f32; 3], b: [f32; 3], c: [f32; 3]| Mesh {
        vertices: [a, b, c].map(Vec3::from_array).to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let sheet = joined(&[
        triangle([-0.2, 0.0, -0.2], [0.2, 0.0, -0.2], [0.0, 0.0, 0.2]),
        triangle([-0.2, 0.0, -0.2], [-0.2, 0.0, -0.2], [0.0, 0.0, 0.2]),
        triangle([-0.2, 0.0, -0.2], [0.0, 0.0, 0.0], [0.2, 0.0, 0.2]),
    ]);
    let twice = joined(&[ball(0.05), ball(0.05)]);
    let build = || {
        room(&[
            (sheet.clone(), [0.0, 0.00003, 0.0], json!({})),
            (twice.clone(), [0.0, 0.049, 0.0], json!({"parent": "o0"})),
            (twice.clone(), [0.0, 0.049, 0.0], json!({"parent": "o0"})),
            (sheet.clone(), [0.02, 0.02, 0.0], json!({})),
        ])
    };
    let (mut first, mut second) = (build(), build());
    assert_eq!(first.part(), second.part());
    assert_eq!(first.layout, second.layout);
    assert!(first.layout.iter().all(|pose| pose.is_finite()));
}
