//! What parts cover, follow and keep open, and what the cache gives back.

use crate::fixture::*;
use glam::{Quat, Vec3};
use parry3d::shape::{ConvexPolyhedron, Shape as _};
use rest3d_gpu::shape::{
    Cache, PADDING, Part, Shape, ShapeRequest, ShapeSettings, build_shapes, part_budget, part_obj, read_mesh,
};

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn representative_meshes_are_covered_and_do_not_stick_out() {
    let objects = objects();
    for (name, category) in [
        ("desk", "desk"),
        ("bookcase", "shelf"),
        ("nightstand", "nightstand"),
        ("tv_stand", "cabinet"),
        ("ycb_cracker_box", "box"),
        ("speaker", "speaker"),
        ("laptop", "laptop"),
        ("newspaper", "newspaper"),
    ] {
        let shape = build(request(&objects, name, category), None);
        check(name, &shape);
        let q = &shape.quality;
        // The desk's round edges cost three parts more, and the report says so.
        let told = shape.notes.iter().any(|note| note.contains("follow its surface"));
        let most = part_budget(category) + if told { 3 } else { 0 };
        assert!(q.parts <= most, "{name}: {} parts, {:?}", q.parts, shape.notes);
        // The millimetre that the project asks for, where things rest; the covering of round edges stands out by more.
        assert!(q.uncovered_feet_mm < 0.2 && q.uncovered_top_mm < 0.2 && q.uncovered_p95_mm < 0.1, "{name}: {q:?}");
        assert!(q.outward_p95_mm < 1.6, "{name}: {q:?}");
        assert!(q.volume_ratio < 1.25, "{name}: {q:?}");
    }
}

/// A dome with a flat bottom: 64 vertices within its skin would fall short of it by 3 mm.
#[test]
fn a_round_mesh_is_covered_and_keeps_its_flat_bottom() {
    let folder = tempfile::tempdir().unwrap();
    let (rings, sides) = (16_u32, 48_u32);
    let mut vertices = vec![[0.0, 0.0, 0.0]];
    let mut triangles = Vec::new();
    for k in 0..rings {
        let (up, out) = (std::f32::consts::FRAC_PI_2 * k as f32 / rings as f32).sin_cos();
        for i in 0..sides {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / sides as f32).sin_cos();
            vertices.push([0.12 * out * cos, 0.12 * up, 0.12 * out * sin]);
        }
    }
    vertices.push([0.0, 0.12, 0.0]);
    let at = |k: u32, i: u32| 1 + k * sides + i % sides;
    for i in 0..sides {
        triangles.push([0, at(0, i), at(0, i + 1)]);
        triangles.push([1 + rings * sides, at(rings - 1, i + 1), at(rings - 1, i)]);
        for k in 1..rings {
            triangles.push([at(k - 1, i), at(k, i), at(k, i + 1)]);
            triangles.push([at(k - 1, i), at(k, i + 1), at(k - 1, i + 1)]);
        }
    }
    let shape = build(of_file(obj(folder.path(), "dome.obj", &vertices, &triangles), "vase"), None);
    check("dome", &shape);
    for v in &vertices {
        let outside = clearance(&shape, Vec3::from_array(*v));
        assert!(outside < 0.1e-3, "{v:?} lies {} mm outside the parts", 1e3 * outside);
    }
    let corners = || shape.parts.iter().flat_map(|part| &part.vertices);
    let (low, high) = corners().fold((f32::INFINITY, 0.0_f32), |(l, h), v| (l.min(v.y), h.max(v.y)));
    assert!((low + PADDING).abs() < 1e-5, "it stands at {low} m");
    // Around the pole, on which it can stand, too, what lies within half a millimetre of a facet is drawn out to it.
    assert!((-2e-5..0.5e-3).contains(&(high - 0.12 - PADDING)), "it ends at {high} m");
    let beyond = corners().map(|v| v.length() - 0.12).fold(0.0, f32::max);
    assert!(beyond < 4e-3, "a part stands out by {} mm", 1e3 * beyond);
}

/// A rod of 1 cm with 24 sides: fewer corners would make facets that stand out and on which it does not lie.
#[test]
fn a_convex_mesh_of_few_corners_is_its_own_part() {
    const SIDES: u32 = 24;
    let folder = tempfile::tempdir().unwrap();
    let rim = |i: u32| (std::f32::consts::TAU * (i / 2) as f32 / SIDES as f32).sin_cos();
    let vertices: Vec<[f32; 3]> =
        (0..2 * SIDES).map(|i| [0.005 * rim(i).0, if i % 2 == 0 { 0.0 } else { 0.15 }, 0.005 * rim(i).1]).collect();
    let mut triangles = Vec::new();
    for i in (0..2 * SIDES).step_by(2) {
        let next = (i + 2) % (2 * SIDES);
        triangles.extend([[i, i + 1, next], [next, i + 1, next + 1]]);
        triangles.extend([[0, i, next], [1, next + 1, i + 1]].into_iter().filter(|[a, b, c]| a != b && a != c));
    }
    let shape = build(of_file(obj(folder.path(), "rod.obj", &vertices, &triangles), "pen"), None);
    check("rod", &shape);
    let part = &shape.parts[0];
    assert_eq!((shape.parts.len(), part.vertices.len()), (1, 2 * SIDES as usize));
    let nearest = |v: &Vec3| vertices.iter().map(|&w| v.distance(Vec3::from_array(w))).fold(f32::INFINITY, f32::min);
    let farthest = part.vertices.iter().map(nearest).fold(0.0, f32::max);
    assert!(farthest < 2.0 * PADDING, "a corner is {farthest} m from where the mesh has one");
}

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

/// A snowman. Cut by planes in three directions, its pieces lack the corners in which these meet inside: its parts held 0.8
/// of it, with the centre of mass 12 mm aside.
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

/// A dented pear. Pieces of its surface are merged where that fills no free space, and what they share inside costs too:
/// without that its parts hold half as much again as it does.
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

/// A round table top of 1.2 m: the 32 sides that 64 vertices make stand out by 3 mm, and the category has no second part.
#[test]
fn what_few_vertices_cannot_follow_costs_more_parts() {
    const SIDES: u32 = 192;
    let folder = tempfile::tempdir().unwrap();
    let rim = |i: u32| (std::f32::consts::TAU * (i / 2) as f32 / SIDES as f32).sin_cos();
    let vertices: Vec<[f32; 3]> =
        (0..2 * SIDES).map(|i| [0.6 * rim(i).1, 0.04 * (i % 2) as f32, 0.6 * rim(i).0]).collect();
    let at = |i: u32| i % (2 * SIDES);
    let side = |i: u32| [[at(i), at(i + 1), at(i + 2)], [at(i + 1), at(i + 3), at(i + 2)]];
    let caps = |i: u32| [[0, at(i), at(i + 2)], [1, at(i + 3), at(i + 1)]];
    let triangles: Vec<[u32; 3]> = (0..SIDES).flat_map(|i| [side(2 * i), caps(2 * i)].concat()).collect();
    let file = obj(folder.path(), "top.obj", &vertices, &triangles);
    let of = |following_parts| {
        let settings = ShapeSettings { max_parts: 1, following_parts, ..ShapeSettings::default() };
        build_with(&settings, of_file(file.clone(), "table"))
    };
    let (one, many) = (of(1), of(32));
    check("top", &many);
    assert!(one.parts.len() == 1 && one.quality.outward_max_mm > 2.0, "{:?}", one.quality);
    assert!((2..=4).contains(&many.parts.len()) && many.quality.outward_max_mm < 1.55, "{:?}", many.quality);
    assert!(many.quality.uncovered_max_mm < 0.1, "{:?}", many.quality);
    assert!(one.notes.is_empty() && many.notes[0].contains("follow its surface"), "{:?} {:?}", one.notes, many.notes);
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn cavities_stay_open() {
    let objects = objects();
    // A point in the middle of the cavity and the radius of a ball that fits there, m.
    for (name, category, points, radius) in [
        ("mug", "mug", vec![Vec3::new(0.0, 0.0, -0.0175)], 0.028),
        ("tray", "tray", vec![Vec3::new(0.0, 0.04, -0.008)], 0.025),
        ("drake_bowl", "bowl", vec![Vec3::new(0.0, 0.015, 0.0)], 0.03),
        ("fruit_bowl", "bowl", vec![Vec3::new(0.572, 0.12, -0.149)], 0.06),
        ("glass", "glass", vec![Vec3::new(0.0, 0.02, 0.0)], 0.02),
        ("tv_stand", "cabinet", vec![Vec3::new(0.0, 0.44, 0.0), Vec3::new(0.0, 0.25, 0.0)], 0.06),
        (
            "bookshelf_worn",
            "shelf",
            vec![Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.3, 0.8, 0.0), Vec3::new(0.0, 1.8, 0.0)],
            0.1,
        ),
    ] {
        let shape = build(request(&objects, name, category), None);
        check(name, &shape);
        for point in points {
            let free = clearance(&shape, point);
            assert!(free >= radius, "{name}: only {:.1} mm free at {point}", 1e3 * free);
        }
    }
}

/// A table top that sags by 8 mm in its middle: one part for a table that bears nothing, and parts that follow the top, with
/// nothing of it uncovered, for one that does.
#[test]
fn what_bears_follows_its_top() {
    const COLUMNS: u32 = 24;
    let directory = tempfile::tempdir().unwrap();
    let top = |x: f32, z: f32| 0.05 - 0.008 * (1.0 - x * x) * (1.0 - z * z);
    let at = |i: u32| 2.0 * i as f32 / COLUMNS as f32 - 1.0;
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let across = COLUMNS + 1;
    for under in [false, true] {
        for (i, j) in (0..across).flat_map(|i| (0..across).map(move |j| (i, j))) {
            let (x, z) = (at(i), at(j));
            vertices.push([0.8 * x, if under { 0.0 } else { top(x, z) }, 0.4 * z]);
        }
        for (i, j) in (0..COLUMNS).flat_map(|i| (0..COLUMNS).map(move |j| (i, j))) {
            let first = across * across * u32::from(under) + i * across + j;
            let [a, b, c, d] = [first, first + 1, first + across + 1, first + across];
            match under {
                false => triangles.extend([[a, b, c], [a, c, d]]),
                true => triangles.extend([[a, c, b], [a, d, c]]),
            }
        }
    }
    for i in 0..COLUMNS {
        let sides = [
            [i, i + 1],
            [(COLUMNS * across) + i + 1, (COLUMNS * across) + i],
            [(i + 1) * across, i * across],
            [i * across + COLUMNS, (i + 1) * across + COLUMNS],
        ];
        for [a, b] in sides {
            let [under_a, under_b] = [a + across * across, b + across * across];
            triangles.extend([[a, under_a, under_b], [a, under_b, b]]);
        }
    }
    let file = obj(directory.path(), "sagging.obj", &vertices, &triangles);
    // How far the parts reach above the top at most, 5 cm or more from its edge.
    let above = |shape: &Shape| {
        let inner = (3..COLUMNS - 2).flat_map(|i| (3..COLUMNS - 2).map(move |j| (at(i), at(j))));
        let depth = |(x, z): (f32, f32)| {
            let reached = |h: &u32| clearance(shape, Vec3::new(0.8 * x, top(x, z) + 5e-4 * *h as f32, 0.4 * z)) > 0.0;
            5e-4 * (0..20).find(reached).unwrap_or(20) as f32
        };
        inner.map(depth).fold(0.0, f32::max)
    };
    let bare = build(of_file(file.clone(), "table"), None);
    let bearing = build(ShapeRequest { bears: true, ..of_file(file, "table") }, None);
    check("bearing", &bearing);
    assert!(above(&bare) > 5e-3, "the part follows the top by itself: {}", above(&bare));
    assert!(above(&bearing) <= 2e-3, "{} m above the top, {} parts", above(&bearing), bearing.parts.len());
    assert!(bearing.parts.len() <= ShapeSettings::default().following_parts);
    assert!(bearing.quality.uncovered_max_mm < 0.5, "{:?}", bearing.quality);
}

#[test]
fn convex_mesh_is_its_own_hull() {
    let directory = tempfile::tempdir().unwrap();
    let (vertices, triangles) = cuboid([0.1, 0.2, 0.3], [0.5, 0.4, 1.1]);
    let mut request = of_file(obj(directory.path(), "box.obj", &vertices, &triangles), "gadget");
    request.scale = Vec3::new(1.0, 2.0, 0.5);
    let shape = build(request, None);
    check("box", &shape);
    assert_eq!((shape.parts.len(), shape.parts[0].vertices.len()), (1, 8));
    let expected = [Vec3::new(0.1, 0.4, 0.15), Vec3::new(0.5, 0.8, 0.55)];
    // f32 rounding.
    assert!(shape.bounds[0].distance(expected[0]) < 1e-6 && shape.bounds[1].distance(expected[1]) < 1e-6);
    assert!(shape.mass.center.distance(0.5 * (expected[0] + expected[1])) < 1e-5, "{:?}", shape.mass);
    assert_eq!(shape.mass.axes, Quat::IDENTITY);
    let beyond = |v: &Vec3| (*v - 0.5 * (expected[0] + expected[1])).abs() - Vec3::splat(0.2);
    let padded = |v: &Vec3| (beyond(v) - PADDING).abs().max_element() < 1e-6;
    assert!(shape.parts[0].vertices.iter().all(padded), "{:?}", shape.parts);
    // 250 kg/m³ × 0.4³ m³.
    assert!((shape.mass.mass - 16.0).abs() < 1e-3, "{:?}", shape.mass);
}

#[test]
fn flat_and_tiny_meshes_get_volume() {
    let directory = tempfile::tempdir().unwrap();
    let quad = [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.3, 0.2, 0.0], [0.0, 0.2, 0.0]];
    let line = [[0.0, 0.0, 0.0], [0.1, 0.1, 0.1], [0.2, 0.2, 0.2]];
    let speck = [[0.0, 0.0, 0.0], [1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]];
    for (name, vertices, triangles) in [
        ("picture", &quad[..], &[[0, 1, 2], [0, 2, 3]][..]),
        ("triangle", &quad[..3], &[[0, 1, 2]]),
        ("line", &line, &[[0, 1, 2]]),
        ("speck", &speck, &[[0, 1, 2]]),
        ("point", &[[0.5; 3]; 3], &[[0, 1, 2]]),
    ] {
        let shape = build(of_file(obj(directory.path(), "flat.obj", vertices, triangles), ""), None);
        check(name, &shape);
        assert_eq!(shape.parts.len(), 1, "{name}");
        assert!(shape.notes.iter().any(|n| n.starts_with("flat")), "{name}: {:?}", shape.notes);
        // Half of the thickness on either side, in up to three directions.
        assert!(shape.quality.outward_max_mm < 1.7, "{name}: {:?}", shape.quality);
        if name == "picture" {
            assert!(shape.quality.outward_max_mm < 1.0, "{:?}", shape.quality);
        }
    }
}

#[test]
fn ready_made_parts_are_used() {
    let directory = tempfile::tempdir().unwrap();
    let (vertices, triangles) = cuboid([0.0; 3], [1.0; 3]);
    let mesh = obj(directory.path(), "mesh.obj", &vertices, &triangles);
    let (low, _) = cuboid([0.0; 3], [1.0, 0.5, 1.0]);
    let mut ball = Vec::new();
    for i in 0..200 {
        let (y, a) = (1.0 - (i as f32 + 0.5) / 100.0, 2.4 * i as f32);
        let r = (1.0 - y * y).sqrt();
        ball.push([0.5 + 0.5 * r * a.cos(), 0.5 + 0.5 * y, 0.5 + 0.5 * r * a.sin()]);
    }
    // The hull is what counts: any triangles that name all points will do.
    let fan: Vec<[u32; 3]> = (2..200).map(|i| [0, i - 1, i]).collect();
    let mut request = of_file(mesh, "box");
    request.convex_parts =
        vec![obj(directory.path(), "a.obj", &low, &triangles), obj(directory.path(), "b.obj", &ball, &fan)];
    let shape = build(request.clone(), None);
    check("ready-made", &shape);
    assert!(shape.parts.iter().any(|p| p.vertices.len() == 8));
    assert!(shape.parts.iter().all(|p| p.vertices.len() <= 64));
    // What has too many corners is cut up, not cut down.
    let kept = |corner: &[f32; 3]| {
        shape.parts.iter().flat_map(|p| &p.vertices).any(|v| v.distance(Vec3::from(*corner) * request.scale) < 1e-5)
    };
    assert!(ball.iter().all(kept));
    assert!(shape.notes.iter().any(|n| n.contains("convex_parts[1]") && n.contains("200")), "{:?}", shape.notes);

    request.convex_parts.push(directory.path().join("missing.obj"));
    let error = build_shapes(&[request], &ShapeSettings::default(), None, &|_, _, _| ()).unwrap_err().to_string();
    assert!(error.contains("thing") && error.contains("convex_parts") && error.contains("missing.obj"), "{error}");
}

#[test]
fn cache_gives_the_same_and_survives_damage() {
    let directory = tempfile::tempdir().unwrap();
    let (mut vertices, mut triangles) = cuboid([0.0; 3], [0.4, 0.05, 0.4]);
    let (back, more) = cuboid([0.0, 0.05, 0.0], [0.05, 0.4, 0.4]);
    vertices.extend(back);
    triangles.extend(more.iter().map(|t| t.map(|i| i + 8)));
    let request = of_file(obj(directory.path(), "seat.obj", &vertices, &triangles), "chair");
    let cache = Cache::new(directory.path().join("cache"));
    let first = build(request.clone(), Some(&cache));
    assert_eq!(first.parts.len(), 2);
    assert_eq!(build(request.clone(), None), first, "not deterministic");
    assert_eq!(build(request.clone(), Some(&cache)), first);
    let entries = std::fs::read_dir(cache.directory()).unwrap().map(|entry| entry.unwrap().path());
    let entries: Vec<_> = entries.collect();
    assert_eq!(entries.len(), 2);
    for entry in entries {
        let whole = std::fs::read(&entry).unwrap();
        // A canary: what is in the entry is what comes out.
        let mut other = whole.clone();
        let digit = other.iter().rposition(|b| *b == b'8').unwrap();
        other[digit] = b'7';
        for damaged in [&whole[..whole.len() / 2], &whole[..10], &[], &other] {
            std::fs::write(&entry, damaged).unwrap();
            assert_eq!(build(request.clone(), Some(&cache)), first);
            assert_eq!(std::fs::read(&entry).unwrap(), whole, "not repaired");
        }
    }
    // A file where the directory should be: a note, and the same shape.
    let blocked = Cache::new(request.mesh.clone());
    let shape = build(request.clone(), Some(&blocked));
    assert_eq!(shape.parts, first.parts);
    assert!(shape.notes.iter().any(|n| n.contains("cache")), "{:?}", shape.notes);
    // The mass is no part of the entry.
    let heavy = build(ShapeRequest { mass: Some(7.0), ..request }, Some(&cache));
    assert_eq!((heavy.mass.mass, &heavy.parts), (7.0, &first.parts));
}

#[test]
fn what_wants_no_second_opinions_has_the_same_parts() {
    let directory = tempfile::tempdir().unwrap();
    let (vertices, triangles) = cuboid([0.0; 3], [0.4, 0.05, 0.4]);
    let request = of_file(obj(directory.path(), "seat.obj", &vertices, &triangles), "chair");
    let cache = Cache::new(directory.path().join("cache"));
    let entries = || std::fs::read_dir(cache.directory()).unwrap().count();
    let without = ShapeSettings { alternatives: false, ..Default::default() };
    let plain =
        || build_shapes(std::slice::from_ref(&request), &without, Some(&cache), &|_, _, _| ()).unwrap().remove(0);
    let first = plain();
    assert_eq!((first.alternatives.len(), entries()), (0, 1));
    let full = build(request.clone(), Some(&cache));
    assert_eq!((full.alternatives.len(), entries()), (2, 2), "the parts are those that were there");
    assert!(full.alternatives.iter().all(|other| !other.parts.is_empty()));
    assert_eq!(Shape { alternatives: Vec::new(), ..full }, first);
    assert_eq!(plain(), first);
    // Alternatives are those of the mesh, whatever its own parts are.
    build(ShapeRequest { category: "plant".into(), ..request.clone() }, Some(&cache));
    assert_eq!(entries(), 3);
}

#[test]
fn parts_are_written_in_the_mesh_frame() {
    let directory = tempfile::tempdir().unwrap();
    let (vertices, triangles) = cuboid([1.0; 3], [2.0, 3.0, 4.0]);
    let mut request = of_file(obj(directory.path(), "box.obj", &vertices, &triangles), "");
    request.scale = Vec3::new(0.1, 0.2, 0.3);
    let shape = build(request.clone(), None);
    let file = directory.path().join("part.obj");
    std::fs::write(&file, part_obj(&shape.parts[0], request.scale)).unwrap();
    let read = read_mesh(&file).unwrap();
    let padded = |c: &[f32; 3]| {
        let corner = Vec3::from_array(*c);
        corner + (corner - Vec3::new(1.5, 2.0, 2.5)).signum() * PADDING / request.scale
    };
    let found = |c: &[f32; 3]| read.vertices.iter().any(|v| v.distance(padded(c)) < 1e-5);
    assert!(read.vertices.len() == 8 && vertices.iter().all(found), "{read:?}");
    let volume: f32 = read
        .triangles
        .iter()
        .map(|t| t.map(|i| read.vertices[i as usize]))
        .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
        .sum();
    let whole: f32 = (Vec3::new(1.0, 2.0, 3.0) + 2.0 * PADDING / request.scale).to_array().iter().product();
    assert!((volume - whole).abs() < 1e-4, "outward triangles: {volume}");
    // Back again as ready-made parts: the same shape.
    request.convex_parts = vec![file];
    let again = build(request, None);
    let found = |v: &Vec3| shape.parts[0].vertices.iter().any(|w| v.distance(*w) < 1e-6);
    assert!(again.parts.len() == 1 && again.parts[0].vertices.iter().all(found));
}
