//! The test rooms, tilted, against their truth.

use glam::{DMat3, DQuat, DVec3};
use rest3d_gpu::canonicalize::canonicalize;
use rest3d_gpu::optimize::shape_requests;
use rest3d_gpu::scene::Scene;
use rest3d_gpu::shape::{Mesh, scaled_mesh};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A scene with the middles of its objects' boxes in the world.
fn shared(file: &Path) -> (Scene, Vec<Mesh>) {
    let scene = Scene::read(file).unwrap();
    let meshes = shape_requests(&scene).iter().map(|request| scaled_mesh(request).unwrap()).collect();
    (scene, meshes)
}

fn middles(scene: &Scene, meshes: &[Mesh]) -> Vec<DVec3> {
    let middle = |mesh: &Mesh| {
        let points = || mesh.vertices.iter().map(|v| v.as_dvec3());
        0.5 * (points().fold(DVec3::INFINITY, DVec3::min) + points().fold(DVec3::NEG_INFINITY, DVec3::max))
    };
    (scene.objects.iter().zip(meshes))
        .map(|(object, mesh)| object.pose.translation + object.pose.rotation * middle(mesh))
        .collect()
}

/// Mean distance of two layouts after the rigid motion that fits them best, as the judge measures it.
fn distance(from: &[DVec3], to: &[DVec3]) -> f64 {
    let centred = |points: &[DVec3]| -> Vec<DVec3> {
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        points.iter().map(|p| *p - mean).collect()
    };
    let (mut from, to) = (centred(from), centred(to));
    // Gauss and Newton: the layouts are a few degrees apart.
    for _ in 0..20 {
        let (mut normal, mut moment) = (DMat3::ZERO, DVec3::ZERO);
        for (p, q) in from.iter().zip(&to) {
            normal +=
                DMat3::from_diagonal(DVec3::splat(p.length_squared())) - DMat3::from_cols(*p * p.x, *p * p.y, *p * p.z);
            moment += p.cross(*q);
        }
        let turn = DQuat::from_scaled_axis(normal.inverse() * moment);
        from.iter_mut().for_each(|p| *p = turn * *p);
    }
    from.iter().zip(&to).map(|(p, q)| p.distance(*q)).sum::<f64>() / from.len() as f64
}

/// `limit`: degrees that the vertical may be off, and the distance from the truth over that of `scene.json`.
fn restores_a_shared_room(name: &str, limit: [f64; 2]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes").join(name);
    let corruption: Value = serde_json::from_slice(&fs::read(folder.join("corruption.json")).unwrap()).unwrap();
    let known = |key: &str| corruption["raw_transform"][key].clone();
    let axis: [f64; 2] = serde_json::from_value(known("tilt_axis_xz")).unwrap();
    let axis = DVec3::new(axis[0], 0.0, axis[1]).normalize();
    let tilt = DQuat::from_axis_angle(axis, known("tilt_deg").as_f64().unwrap().to_radians());

    let (mut scene, meshes) = shared(&folder.join("raw.json"));
    let report = canonicalize(&mut scene, &meshes);
    let found = DQuat::from_axis_angle(DVec3::from(report.rotation.axis), report.rotation.degrees.to_radians());
    let error = (found * tilt * DVec3::Y).angle_between(DVec3::Y).to_degrees();

    // The known layout is canonical: pots and crumpled boxes stand on their bases a little better.
    let (truth, truth_meshes) = shared(&folder.join("truth.json"));
    let changes = canonicalize(&mut truth.clone(), &truth_meshes);
    assert_eq!(changes.rotation.degrees, 0.0);
    // A banana has several ways to lie, 11° apart.
    for object in changes.objects.iter().filter(|object| object.name != "banana") {
        assert!(object.turned_degrees < 1.0 && object.raised.abs() < 3e-3, "{object:?}");
    }
    let (corrupted, corrupted_meshes) = shared(&folder.join("scene.json"));
    let truth = middles(&truth, &truth_meshes);
    let own = distance(&middles(&corrupted, &corrupted_meshes), &truth);
    // The raw scene has a scale of its own, which canonicalization leaves alone.
    let scale = known("g").as_f64().unwrap();
    let result: Vec<DVec3> = middles(&scene, &meshes).into_iter().map(|p| p / scale).collect();
    let ratio = distance(&result, &truth) / own;
    eprintln!("{name}: vertical off by {error:.2}°, {ratio:.2} times the distance of scene.json ({:.1} mm)", 1e3 * own);
    assert!(error < limit[0] && ratio < limit[1], "{name}: {error}°, {ratio}");
}

macro_rules! shared_rooms {
    ($($name:ident: $limit:expr;)*) => {$(
        #[test]
        #[cfg_attr(not(shared_files), ignore = "needs ../shared")]
        fn $name() {
            restores_a_shared_room(stringify!($name), $limit);
        }
    )*};
}

shared_rooms! {
    bedroom: [1.5, 1.15];
    deep_interpenetration: [1.5, 1.15];
    dining_room: [1.5, 1.15];
    living_room: [1.5, 1.15];
    // Four objects, of which the table and the mug are turned the same way by 3° and 5°: no vote can tell.
    minimal: [1.8, 1.3];
    office: [1.5, 1.15];
    study: [1.5, 1.15];
    tabletop_desk: [1.5, 1.15];
    wall_ceiling: [1.5, 1.15];
}
