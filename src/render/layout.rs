//! Structs that shaders and host share; the build compares their layouts.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// A corner of a triangle; lengths in m from the stage's origin.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Place.
    pub position: Vec3,
    /// Unit normal, octahedral, two signed 16-bit shares.
    pub normal: u32,
    /// Place in the texture.
    pub uv: Vec2,
    /// sRGB and opacity, a byte each, red lowest.
    pub color: u32,
    /// Pixels of the texture per m of surface.
    pub detail: f32,
}

/// A direction that light comes from, with its map of depths.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// `u.xyz · p + u.w`: place across the map, 0 to 1.
    pub u: Vec4,
    /// Place down the map, 0 to 1.
    pub v: Vec4,
    /// Depth in the map, growing away from the light, 0 to 1 where something casts a shadow.
    pub depth: Vec4,
    /// Unit vector to the light.
    pub toward: Vec3,
    /// How far off its surface a point is looked up where light grazes it, m.
    pub offset: f32,
    /// How much nearer to the light it is taken for, share of the depth.
    pub bias: f32,
    /// Not used; fills up.
    pub padding: [f32; 3],
}

/// All that is the same for a whole picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct View {
    /// From the stage to clip space, see `Camera::clip`.
    pub clip: Mat4,
    /// The eye, m from the stage's origin.
    pub eye: Vec3,
    /// Width of a pixel at distance 1.
    pub pixel: f32,
    /// Linear colour of what is not covered.
    pub background: Vec3,
    /// Factor from light to brightness.
    pub exposure: f32,
    /// Light from below.
    pub bounce: Vec3,
    /// Distance of the lines on the ground, m.
    pub grid: f32,
    /// Middle of the scene.
    pub center: Vec3,
    /// Its half extent, m.
    pub radius: f32,
    /// Lights of the sun, the first in the list.
    pub suns: u32,
    /// Lights of the sky, after them.
    pub skies: u32,
    /// Where a line of the grid is, x and z, m.
    pub grid_at: Vec2,
    /// Unit vector into the picture.
    pub forward: Vec3,
    /// Columns of the picture.
    pub width: f32,
    /// From its middle to its right edge, at distance 1.
    pub across: Vec3,
    /// Rows of the picture.
    pub height: f32,
    /// From its middle to its upper edge, at distance 1.
    pub upward: Vec3,
    /// Not used; aligns what follows.
    pub padding: f32,
    /// Linear intensity of each light of the sun.
    pub sun: Vec3,
    /// Not used; aligns what follows.
    pub padding_2: f32,
    /// Linear intensity of each light of the sky.
    pub sky: Vec3,
    /// Not used; aligns what follows.
    pub padding_3: f32,
    /// Sum of the cosines of the lights that a surface with a normal sees, of the sun in x and of the sky in y: factors
    /// of 1, x, y, z, xx, yy, zz, xy, yz and zx of the normal.
    pub open: [Vec4; 10],
}

/// A unit vector in two numbers from −1 to 1 (Cigolle and others, "A survey of efficient representations for
/// independent unit vectors", 2014).
pub fn pack_normal(n: Vec3) -> u32 {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs()).max(f32::MIN_POSITIVE);
    let folded = |a: f32, b: f32| (1.0 - b.abs()).copysign(a);
    let flat = if n.y >= 0.0 { Vec2::new(n.x, n.z) } else { Vec2::new(folded(n.x, n.z), folded(n.z, n.x)) };
    let [x, y] =
        (flat.clamp(Vec2::NEG_ONE, Vec2::ONE) * 32767.0).round().to_array().map(|x| u32::from(x as i16 as u16));
    x | y << 16
}

/// The vector of [`pack_normal`].
pub fn unpack_normal(packed: u32) -> Vec3 {
    let share = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let flat = Vec2::new(share(packed), share(packed >> 16));
    let y = 1.0 - flat.x.abs() - flat.y.abs();
    let fold = (-y).max(0.0);
    Vec3::new(flat.x - fold.copysign(flat.x), y, flat.y - fold.copysign(flat.y)).normalize_or(Vec3::Y)
}

#[cfg(test)]
mod tests {
    use super::{pack_normal, unpack_normal};
    use glam::Vec3;

    #[test]
    fn normals_survive_packing() {
        for i in 0..1234 {
            let t = i as f32;
            let n = Vec3::new((t * 1.7).sin(), (t * 0.31).cos(), (t * 2.3).cos()).normalize_or(Vec3::NEG_Y);
            assert!(unpack_normal(pack_normal(n)).distance(n) < 1e-4, "{n}");
        }
        for n in Vec3::AXES.into_iter().flat_map(|n| [n, -n]) {
            assert!(unpack_normal(pack_normal(n)).distance(n) < 1e-4, "{n}");
        }
    }
}
