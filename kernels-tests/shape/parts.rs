//! What parts cover, follow and keep open.

use crate::fixture::*;
use glam::{Quat, Vec3};
use rest3d_gpu::shape::{PADDING, Quality, Shape, ShapeRequest, ShapeSettings, part_budget};

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

/// A round table top of 1.2 m: the 32 sides that 64 vertices make stand out by 3 mm, and the category has no second
/// part.
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

/// A table top that sags by 8 mm in its middle: one part for a table that bears nothing, and parts that follow the top,
/// with nothing of it uncovered, for one that does.
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

/// A workbench of thirteen boards with open slots for three drawers. Merged down to the eight parts of a table its sides
/// close these, and no cutting afterwards opens them again.
#[test]
fn slots_between_more_boards_than_the_budget_stay_open() {
    let folder = tempfile::tempdir().unwrap();
    let side = |x: f32| [[x - 0.01, 0.35, -0.25], [x + 0.01, 0.85, 0.25]];
    let leg = |x: f32, z: f32| [[x - 0.04, 0.0, z - 0.04], [x + 0.04, 0.85, z + 0.04]];
    let board = |y: f32| [[-0.25, y - 0.01, -0.25], [0.25, y + 0.01, 0.25]];
    let rail = |z: f32| [[-0.75, 0.17, z - 0.02], [0.75, 0.23, z + 0.02]];
    let boards = [
        [[-0.8, 0.85, -0.3], [0.8, 0.9, 0.3]],
        leg(-0.75, -0.25),
        leg(-0.75, 0.25),
        leg(0.75, -0.25),
        leg(0.75, 0.25),
        side(-0.26),
        side(0.26),
        board(0.36),
        board(0.52),
        board(0.68),
        [[-0.25, 0.35, -0.25], [0.25, 0.85, -0.23]],
        rail(-0.25),
        rail(0.25),
    ];
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for [low, high] in boards {
        let (corners, faces) = cuboid(low, high);
        triangles.extend(faces.into_iter().map(|face| face.map(|corner| corner + vertices.len() as u32)));
        vertices.extend(corners);
    }
    let mut request = of_file(obj(folder.path(), "bench.obj", &vertices, &triangles), "table");
    request.bears = true;
    let shape = build(request, None);
    check("bench", &shape);
    let Quality { parts, bulge_max_mm, volume_ratio, .. } = shape.quality;
    assert!(parts <= boards.len() && bulge_max_mm < 5.0 && volume_ratio < 1.05, "{:?}", shape.quality);
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
    // 64 litres, between 2 (3 kg) and 200 (7 kg) on a logarithmic scale.
    assert!((shape.mass.mass - 5.676).abs() < 1e-3, "{:?}", shape.mass);
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
