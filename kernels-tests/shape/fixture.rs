//! Shared meshes, and small ones made here.

use glam::Vec3;
use parry3d::query::PointQuery as _;
use parry3d::shape::ConvexPolyhedron;
use rest3d_gpu::shape::{Cache, Shape, ShapeRequest, ShapeSettings, build_shapes};
use std::path::{Path, PathBuf};

pub fn objects() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/objects")
}

pub fn request(objects: &Path, name: &str, category: &str) -> ShapeRequest {
    ShapeRequest {
        name: name.into(),
        category: category.into(),
        mesh: objects.join(format!("{name}.glb")),
        scale: Vec3::ONE,
        mass: None,
        convex_parts: Vec::new(),
        up: Vec3::Y,
        bears: false,
    }
}

pub fn build(request: ShapeRequest, cache: Option<&Cache>) -> Shape {
    build_shapes(&[request], &ShapeSettings::default(), cache, &|_, _, _| ()).unwrap().remove(0)
}

/// The same with other settings.
pub fn build_with(settings: &ShapeSettings, request: ShapeRequest) -> Shape {
    build_shapes(&[request], settings, None, &|_, _, _| ()).unwrap().remove(0)
}

/// Distance from a point to the nearest part, m; zero inside.
pub fn clearance(shape: &Shape, point: Vec3) -> f32 {
    shape
        .parts
        .iter()
        .map(|p| ConvexPolyhedron::from_convex_hull(&p.vertices).unwrap().distance_to_local_point(point, true))
        .fold(f32::INFINITY, f32::min)
}

/// An OBJ file of triangles.
pub fn obj(directory: &Path, name: &str, vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> PathBuf {
    let mut text = String::new();
    for [x, y, z] in vertices {
        text += &format!("v {x} {y} {z}\n");
    }
    for [a, b, c] in triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    let file = directory.join(name);
    std::fs::write(&file, text).unwrap();
    file
}

/// A box with outward triangles.
pub fn cuboid(low: [f32; 3], high: [f32; 3]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let corners = (0..8).map(|i| std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    (corners, quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect())
}

/// The closed surface of boxes, given by their lowest and highest corners, as one: faces that two of them share are
/// left out. They have to meet in whole faces of the grid that all their sides make.
pub fn blocks(boxes: &[[[f32; 3]; 2]]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let lines: [Vec<f32>; 3] = std::array::from_fn(|axis| {
        let mut lines: Vec<f32> = boxes.iter().flatten().map(|corner| corner[axis]).collect();
        lines.sort_by(f32::total_cmp);
        lines.dedup();
        lines
    });
    let count: [usize; 3] = std::array::from_fn(|axis| lines[axis].len() - 1);
    let filled = |cell: [usize; 3]| {
        let middle: [f32; 3] =
            std::array::from_fn(|axis| 0.5 * (lines[axis][cell[axis]] + lines[axis][cell[axis] + 1]));
        boxes.iter().any(|[low, high]| (0..3).all(|axis| low[axis] < middle[axis] && middle[axis] < high[axis]))
    };
    let number = |corner: [usize; 3]| ((corner[2] * (count[1] + 1) + corner[1]) * (count[0] + 1) + corner[0]) as u32;
    let mut triangles = Vec::new();
    for index in 0..count.iter().product() {
        let cell = [index % count[0], index / count[0] % count[1], index / count[0] / count[1]];
        for (axis, far) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let mut beyond = cell;
            beyond[axis] = if far { cell[axis] + 1 } else { cell[axis].wrapping_sub(1) };
            if !filled(cell) || (beyond[axis] < count[axis] && filled(beyond)) {
                continue;
            }
            let corner = |u: usize, v: usize| {
                let mut corner = cell;
                corner[axis] += usize::from(far);
                corner[(axis + 1) % 3] += u;
                corner[(axis + 2) % 3] += v;
                number(corner)
            };
            let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            triangles.extend(if far { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    let mut vertices = Vec::new();
    for &z in &lines[2] {
        for &y in &lines[1] {
            vertices.extend(lines[0].iter().map(|&x| [x, y, z]));
        }
    }
    (vertices, triangles)
}

/// Volume that a closed surface encloses, m³, and its middle, m.
pub fn enclosed(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> (f32, Vec3) {
    let corner = |i: u32| Vec3::from_array(vertices[i as usize]);
    let cones = triangles.iter().map(|&[a, b, c]| {
        let (a, b, c) = (corner(a), corner(b), corner(c));
        let volume = a.dot(b.cross(c)) / 6.0;
        (volume, 0.25 * volume * (a + b + c))
    });
    let (volume, moment) = cones.fold((0.0, Vec3::ZERO), |sum, cone| (sum.0 + cone.0, sum.1 + cone.1));
    (volume, moment / volume)
}

/// A closed surface of rings of corners between two poles. `point`: where it is at an angle along it from pole to pole
/// and one around it.
pub fn between_poles(rings: u32, sides: u32, point: impl Fn(f32, f32) -> Vec3) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    use std::f32::consts::{PI, TAU};
    let ring = |k: u32| {
        let along = PI * k as f32 / rings as f32;
        (0..sides).map(move |i| (along, TAU * i as f32 / sides as f32))
    };
    let places = [(0.0, 0.0)].into_iter().chain((1..rings).flat_map(ring)).chain([(PI, 0.0)]);
    let vertices: Vec<[f32; 3]> = places.map(|(along, around)| point(along, around).to_array()).collect();
    let at = |k: u32, i: u32| 1 + (k - 1) * sides + i % sides;
    let last = vertices.len() as u32 - 1;
    let mut triangles = Vec::new();
    for i in 0..sides {
        triangles.extend([[0, at(1, i), at(1, i + 1)], [last, at(rings - 1, i + 1), at(rings - 1, i)]]);
        for k in 2..rings {
            triangles.push([at(k - 1, i), at(k, i), at(k, i + 1)]);
            triangles.push([at(k - 1, i), at(k, i + 1), at(k - 1, i + 1)]);
        }
    }
    (vertices, triangles)
}

pub fn of_file(mesh: PathBuf, category: &str) -> ShapeRequest {
    ShapeRequest { mesh, ..request(Path::new(""), "thing", category) }
}

/// What a shape promises, whatever the mesh.
pub fn check(name: &str, shape: &Shape) {
    for part in &shape.parts {
        assert!((4..=64).contains(&part.vertices.len()), "{name}: {} vertices", part.vertices.len());
        assert!(ConvexPolyhedron::from_convex_hull(&part.vertices).is_some(), "{name}: a part without volume");
    }
    let mass = &shape.mass;
    assert!(mass.mass > 0.0 && mass.inertia.min_element() > 0.0 && mass.inertia.is_finite(), "{name}: {mass:?}");
    // Principal moments of a body obey the triangle inequality; the slack is that of sampled overlaps.
    let [x, y, z] = mass.inertia.to_array();
    assert!(x <= 1.01 * (y + z) && y <= 1.01 * (x + z) && z <= 1.01 * (x + y), "{name}: {mass:?}");
    assert!(mass.axes.is_normalized(), "{name}: {mass:?}");
}
