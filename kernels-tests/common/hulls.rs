//! Corners of convex parts.

use glam::Vec3;
pub use rest3d_gpu::shape::box_corners as cuboid;

/// Points moved by a vector.
pub fn shifted(points: &[Vec3], by: Vec3) -> Vec<Vec3> {
    points.iter().map(|&p| p + by).collect()
}

/// A prism with `sides` corners in the xz plane.
pub fn prism(radius: f32, half_height: f32, sides: usize) -> Vec<Vec3> {
    (0..sides)
        .flat_map(|i| {
            let angle = std::f32::consts::TAU * (i as f32 + 0.5) / sides as f32;
            [-1.0, 1.0].map(|s| Vec3::new(radius * angle.cos(), s * half_height, radius * angle.sin()))
        })
        .collect()
}

/// A cube with its corners cut off: six octagons and eight triangles.
pub fn truncated_cube(half: f32) -> Vec<Vec3> {
    let short = std::f32::consts::SQRT_2 - 1.0;
    let axes = [Vec3::new(short, 1.0, 1.0), Vec3::new(1.0, short, 1.0), Vec3::new(1.0, 1.0, short)];
    axes.into_iter().flat_map(|corner| cuboid(half * corner)).collect()
}

/// A ring of `count` wedges about the y axis: inner and outer radius at the lower and at the upper height.
pub fn ring(low: [f32; 2], high: [f32; 2], heights: [f32; 2], count: usize) -> Vec<Vec<Vec3>> {
    let angle = |i: usize| std::f32::consts::TAU * i as f32 / count as f32;
    (0..count)
        .map(|i| {
            let mut wedge = Vec::new();
            for (sin, cos) in [angle(i), angle(i + 1)].map(f32::sin_cos) {
                for (radii, y) in [low, high].into_iter().zip(heights) {
                    wedge.extend(radii.map(|r| Vec3::new(r * cos, y, r * sin)));
                }
            }
            wedge
        })
        .collect()
}

/// A ball cut into slices about the z axis, `slices · steps` corners around its equator.
pub fn sliced_ball(radius: f32, slices: usize, steps: usize) -> Vec<Vec<Vec3>> {
    const RINGS: usize = 8;
    let around = |i: usize| std::f32::consts::TAU * i as f32 / (slices * steps) as f32;
    (0..slices)
        .map(|slice| {
            let mut points = vec![Vec3::Z * radius, Vec3::NEG_Z * radius];
            for ring in 1..RINGS {
                let (out, along) = (std::f32::consts::PI * ring as f32 / RINGS as f32).sin_cos();
                points.extend((slice * steps..=(slice + 1) * steps).map(|i| {
                    let (sin, cos) = around(i).sin_cos();
                    radius * Vec3::new(out * cos, out * sin, along)
                }));
            }
            points
        })
        .collect()
}
