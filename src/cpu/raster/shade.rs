//! What colour a point of a triangle has.

use super::{Shading, middle};
use crate::render::shading::{
    BACK, BACK_OPACITY, FADE_FROM, FADE_TO, FLATTEST_VIEW, LEAST_AWAY, LINE, LINE_EDGE, LINE_SHADE, WALL_BLUE,
    WALL_GREEN, WALL_OPACITY, WALL_RED, WALL_SHADE,
};
use crate::render::{Kind, Vertex, View, byte_to_linear, unpack_normal};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec3Swizzles, Vec4, Vec4Swizzles};

/// A point of a triangle.
pub(super) struct Fragment {
    pub position: Vec3,
    pub normal: Vec3,
    pub uv: Vec2,
    pub color: Vec4,
    pub detail: f32,
    /// Seen from the side from which the triangle is counter-clockwise.
    pub front: bool,
    /// Place in the picture, px.
    pub at: Vec2,
}

impl Fragment {
    /// Unit normal on the side that is seen.
    pub fn facing(&self) -> Vec3 {
        self.normal.normalize_or(Vec3::Y) * if self.front { 1.0 } else { -1.0 }
    }
}

impl Shading<'_> {
    pub fn is_hole(&self, number: u32, at: DVec2, cutoff: f32) -> bool {
        let fragment = self.fragment(number, at);
        self.texel(number, &fragment).w * fragment.color.w < cutoff
    }

    /// Linear colour and opacity of a triangle in a pixel, at the middle of what it covers.
    pub fn shade(&self, number: u32, x: u32, y: u32, covered: [bool; 4]) -> Vec4 {
        let it = self.fragment(number, middle(x, y, covered));
        match self.batch(number).kind {
            Kind::Solid | Kind::Glass => self.shaded(number, &it),
            Kind::Ground => self.ground(&it),
            Kind::Wall => self.wall(&it),
        }
    }

    /// Where the ray through a place of the picture meets the triangle's plane.
    pub fn fragment(&self, number: u32, at: DVec2) -> Fragment {
        let camera = self.camera;
        let across = (2.0 * at.x / f64::from(self.size.width) - 1.0) * camera.slope * camera.aspect;
        let upward = (1.0 - 2.0 * at.y / f64::from(self.size.height)) * camera.slope;
        let ray = camera.forward + camera.right * across + camera.up * upward;
        let corners: &[Vertex] = &self.stage.vertices[3 * number as usize..][..3];
        let [a, b, c] = [0, 1, 2].map(|i| corners[i].position.as_dvec3());
        let face = (b - a).cross(c - a);
        let eye = camera.eye - self.stage.origin;
        let p = eye + ray * (face.dot(a - eye) / face.dot(ray));
        let share = |q: DVec3, r: DVec3| ((q - p).cross(r - p).dot(face) / face.length_squared()) as f32;
        let shares = [share(b, c), share(c, a), share(a, b)];
        let mix = |of: &dyn Fn(&Vertex) -> Vec4| -> Vec4 {
            corners.iter().zip(shares).map(|(corner, share)| of(corner) * share).sum()
        };
        let first_wall = self.first_wall();
        let color = if number as usize >= first_wall {
            let lit = &self.wall[3 * (number as usize - first_wall)..][..3];
            lit.iter().zip(shares).map(|(lit, share)| lit.extend(0.0).extend(1.0) * share).sum()
        } else {
            mix(&|v| unpack_color(v.color))
        };
        Fragment {
            position: p.as_vec3(),
            normal: mix(&|v| unpack_normal(v.normal).extend(0.0)).xyz(),
            uv: mix(&|v| v.uv.extend(0.0).extend(0.0)).xy(),
            color,
            detail: corners[0].detail,
            front: face.dot(ray) < 0.0,
            at: at.as_vec2().floor() + 0.5,
        }
    }

    fn texel(&self, number: u32, it: &Fragment) -> Vec4 {
        let Some(texture) = self.batch(number).texture else { return Vec4::ONE };
        let level = (it.detail * self.view.pixel * it.position.distance(self.view.eye)).max(1.0).log2();
        self.stage.textures[texture].0.sample(it.uv, level)
    }

    fn shaded(&self, number: u32, it: &Fragment) -> Vec4 {
        let normal = it.facing();
        let light = self.light(normal, self.arriving(it, normal));
        let color = (-self.view.exposure * it.color.xyz() * self.texel(number, it).xyz() * light).exp();
        (1.0 - color).extend(it.color.w)
    }

    fn ground(&self, it: &Fragment) -> Vec4 {
        let View { eye, pixel, background, grid, center, radius, grid_at, .. } = self.view;
        let p = it.position;
        let away = p.distance(eye);
        let fade = smoothstep(FADE_FROM, FADE_TO, p.xz().distance(center.xz()) / radius);
        let mut share = Vec3::ONE;
        if fade < 1.0 {
            let steep = ((eye.y - p.y).abs() / away.max(LEAST_AWAY)).max(FLATTEST_VIEW);
            let soft = LINE_EDGE * pixel * away / steep;
            let at = (p.xz() - grid_at) / grid;
            let off = (at - at.round()).abs() * grid;
            let half = LINE * radius;
            let line = ((half + soft - off.min_element()) / (2.0 * soft)).clamp(0.0, 1.0) * (half / soft).min(1.0);
            let light = self.light(Vec3::Y, self.arriving(it, Vec3::Y));
            share = light / self.light(Vec3::Y, Vec2::ONE) * (1.0 - LINE_SHADE * line);
        }
        (background * share.lerp(Vec3::ONE, fade)).extend(1.0)
    }

    fn wall(&self, it: &Fragment) -> Vec4 {
        if !it.front {
            return (BACK * self.view.background).extend(BACK_OPACITY);
        }
        let normal = it.normal.normalize_or(Vec3::Y);
        let share = self.light(normal, it.color.xy()) / self.light(normal, Vec2::ONE);
        (Vec3::new(WALL_RED, WALL_GREEN, WALL_BLUE) * Vec3::ONE.lerp(share, WALL_SHADE)).extend(WALL_OPACITY)
    }
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn unpack_color(packed: u32) -> Vec4 {
    let [r, g, b, a] = packed.to_le_bytes();
    Vec3::from_array([r, g, b].map(byte_to_linear)).extend(f32::from(a) / 255.0)
}
