//! What parts hold: as much as their mesh, with the centre of mass where it has it.

use crate::fixture::*;
use glam::Vec3;
use parry3d::shape::{ConvexPolyhedron, Shape as _};
use rest3d_gpu::shape::{Part, Shape};

/// A ball of 60 cm is cut into octants and further: without the corner in the middle, which no surface shows, its parts
/// held half of it and its centre of mass was elsewhere.
#[test]
fn a_ball_is_not_hollow() {
    let folder = tempfile::tempdir().unwrap();
    let (vertices, triangles) = between_poles(16, 32, |along, around| {
        0.3 * Vec3::new(along.sin() * around.cos(), -along.cos(), along.sin() * around.sin())
    });
    let shape = build(of_file(obj(folder.path(), "ball.obj", &vertices, &triangles), "ball"), None);
    check("ball", &shape);
    let points: Vec<Vec3> = vertices.iter().map(|&v| Vec3::from_array(v)).collect();
    let whole = ConvexPolyhedron::from_convex_hull(&points).unwrap().mass_properties(1.0).mass();
    let ratio = shape.mass.volume / whole;
    assert!(shape.parts.len() >= 8 && (0.99..1.05).contains(&ratio), "{} parts, {ratio}", shape.parts.len());
    assert!(shape.mass.center.length() < 1e-3, "its centre of mass is at {} m", shape.mass.center);
}

/// Parts weigh what the mesh does, and their centre of mass is where the mesh has it, within `off` (m).
fn weighs_right(name: &str, category: &str, (vertices, triangles): (Vec<[f32; 3]>, Vec<[u32; 3]>), off: f32) -> Shape {
    let folder = tempfile::tempdir().unwrap();
    let shape = build(of_file(obj(folder.path(), "mesh.obj", &vertices, &triangles), category), None);
    check(name, &shape);
    let (volume, center) = enclosed(&vertices, &triangles);
    let (ratio, aside) = (shape.mass.volume / volume, shape.mass.center.distance(center));
    assert!((0.98..1.08).contains(&ratio), "{name}: {} parts hold {ratio}", shape.parts.len());
    assert!(aside < off, "{name}: the centre of mass of {} parts is {aside} m aside", shape.parts.len());
    shape
}

/// A snowman. Cut by planes in three directions, its pieces lack the corners in which these meet inside: its parts held
/// 0.8 of it, with the centre of mass 12 mm aside.
#[test]
fn a_snowman_is_not_hollow() {
    let snowman = between_poles(48, 32, |along, around| {
        let height = -0.13 * along.cos();
        let ball = |middle: f32, radius: f32| (radius * radius - (height - middle).powi(2)).max(0.0).sqrt();
        let out = ball(-0.05, 0.08).max(ball(0.07, 0.06));
        Vec3::new(out * around.cos(), height, out * around.sin())
    });
    weighs_right("snowman", "", snowman, 1.5e-3);
}

/// A shelf whose boards are one mesh: no single cut opens it, and its parts held five times what it does.
#[test]
fn a_shelf_is_cut_along_its_boards() {
    let board = |y: f32| [[-0.38, y, -0.14], [0.38, y + 0.02, 0.15]];
    let side = |x: f32| [[x, 0.0, -0.14], [x + 0.02, 1.8, 0.15]];
    let back = [[-0.4, 0.0, -0.15], [0.4, 1.8, -0.14]];
    let boxes: Vec<[[f32; 3]; 2]> =
        [back, side(-0.4), side(0.38)].into_iter().chain((0..6).map(|i| board(0.05 + 0.34 * i as f32))).collect();
    let shape = weighs_right("shelf", "shelf", blocks(&boxes), 5e-3);
    assert!(shape.parts.len() <= 10, "{} parts", shape.parts.len());
}

/// A chair with six slats in its back, more bars than parts of its category: those that bridge two slats weigh the gap.
#[test]
fn the_gaps_of_a_chair_weigh_nothing() {
    let leg = |x: f32, z: f32| [[x, 0.0, z], [x + 0.04, 0.43, z + 0.04]];
    let seat = [[-0.22, 0.43, -0.22], [0.22, 0.47, 0.22]];
    let slat = |x: f32| [[x, 0.47, -0.22], [x + 0.03, 0.93, -0.19]];
    let rail = [[-0.22, 0.93, -0.22], [0.22, 0.98, -0.19]];
    let legs = [leg(-0.22, -0.22), leg(0.18, -0.22), leg(-0.22, 0.18), leg(0.18, 0.18)];
    let slats = (0..6).map(|i| slat(-0.22 + 0.082 * i as f32));
    let boxes: Vec<[[f32; 3]; 2]> = legs.into_iter().chain([seat, rail]).chain(slats).collect();
    weighs_right("chair", "chair", blocks(&boxes), 0.012);
}

/// A dented pear. Pieces of its surface are merged where that fills no free space, and what they share inside costs
/// too: without that its parts hold half as much again as it does.
#[test]
fn parts_of_something_solid_share_little() {
    let folder = tempfile::tempdir().unwrap();
    let (vertices, triangles) = between_poles(40, 56, |along, around| {
        let dents = 1.0 + 0.12 * (3.0 * around).sin() + 0.09 * (5.0 * around + 4.0 * along).sin();
        let out = 0.1 * along.sin() * (1.0 - 0.35 * (1.0 - along.cos())) * dents;
        Vec3::new(out * around.cos(), -0.1 * along.cos(), out * around.sin())
    });
    let volume = enclosed(&vertices, &triangles).0.abs();
    let shape = build(of_file(obj(folder.path(), "pear.obj", &vertices, &triangles), "fruit"), None);
    check("pear", &shape);
    let of_part = |part: &Part| ConvexPolyhedron::from_convex_hull(&part.vertices).unwrap().mass_properties(1.0).mass();
    let ratio = shape.parts.iter().map(of_part).sum::<f32>() / volume;
    assert!(shape.parts.len() > 1 && ratio < 1.15, "{} parts of {ratio} times its volume", shape.parts.len());
}
