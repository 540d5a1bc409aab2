//! How much of the sun's and the sky's light arrives where.

use super::{Shading, shade::Fragment};
use crate::render::shading::{ALIKE, GRAZING, LEAST_KNOWN, NO_LIGHT, OFF_PLANE, SPARSE};
use crate::render::{Light, SUNS, Screen, Stage, View, unpack_normal};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec3Swizzles, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// Distances of what casts shadows from one light.
pub(super) struct Map {
    side: u32,
    depths: Vec<f32>,
}

impl Map {
    pub fn new(stage: &Stage, light: &Light, side: u32) -> Self {
        let casters = &stage.casters;
        let places: Vec<DVec3> = casters.positions.iter().map(|p| place(light, p.xyz()).as_dvec3()).collect();
        let mut depths = vec![1.0_f32; (side * side) as usize];
        let scale = DVec3::new(side.into(), side.into(), 1.0);
        for triangle in &casters.triangles {
            let screen = Screen(triangle.map(|i| places[i as usize] * scale));
            screen.scan(screen.rows(side), side, &[DVec2::splat(0.5)], |x, y, _, depth| {
                let there = &mut depths[(y * side + x) as usize];
                *there = there.min(depth);
            });
        }
        Self { side, depths }
    }

    /// Share of the four texels around a place that are not nearer to the light than `depth`, weighed by distance.
    fn lit(&self, at: Vec2, depth: f32) -> f32 {
        let at = at * self.side as f32 - 0.5;
        let (corner, share) = (at.floor(), at - at.floor());
        let texel = |dx: f32, dy: f32| {
            let last = (self.side - 1) as f32;
            let x = (corner.x + dx).clamp(0.0, last) as usize;
            let y = (corner.y + dy).clamp(0.0, last) as usize;
            f32::from(depth <= self.depths[y * self.side as usize + x])
        };
        let between = |a: f32, b: f32, share: f32| a + (b - a) * share;
        let upper = between(texel(0.0, 0.0), texel(1.0, 0.0), share.x);
        between(upper, between(texel(0.0, 1.0), texel(1.0, 1.0), share.x), share.y)
    }
}

fn place(light: &Light, p: Vec3) -> Vec3 {
    let q = p.extend(1.0);
    Vec3::new(light.u.dot(q), light.v.dot(q), light.depth.dot(q))
}

/// What arrives at a place.
#[derive(Clone, Copy, Default)]
pub(super) struct Arriving {
    /// Of the sun's and of the sky's light.
    pub shares: Vec2,
    /// Distance to the eye; 0 where nothing is.
    pub away: f32,
    pub normal: Vec3,
}

impl Shading<'_> {
    /// See `wall`.
    pub fn wall_shares(&self) -> Vec<Vec2> {
        let first = 3 * self.first_wall();
        let corners = self.stage.vertices[first..].par_iter();
        corners.map(|corner| self.share(corner.position, unpack_normal(corner.normal), 1)).collect()
    }

    /// Shares of the sun's and the sky's light that arrive at a pixel: those of the four places around it at half the
    /// resolution, as far as they lie in its plane and face as it does.
    pub fn arriving(&self, it: &Fragment, normal: Vec3) -> Vec2 {
        let View { eye, pixel, forward, across, upward, width, height, .. } = self.view;
        let size = Vec2::new(width, height);
        let half = (0.5 * size).ceil();
        let at = 0.5 * it.at - 0.5;
        let (corner, part) = (at.floor(), at - at.floor());
        let tolerance = OFF_PLANE * pixel * it.position.distance(eye);
        let mut sum = Vec3::ZERO;
        for step in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE] {
            let cell = (corner + step).clamp(Vec2::ZERO, half - 1.0);
            let there = self.shares[(cell.y * half.x + cell.x) as usize];
            let place = (4.0 * cell + 2.0) / size - 1.0;
            let ray = (forward + across * place.x - upward * place.y).normalize();
            let off = (eye + ray * there.away - it.position).dot(normal) / tolerance;
            let near = (1.0 - part) * (1.0 - step) + part * step;
            let alike = normal.dot(there.normal).max(0.0).powi(ALIKE);
            let known = if there.away > 0.0 { 1.0 } else { 0.0 };
            let weight = known * near.element_product() * alike / (1.0 + off.powi(4));
            sum += weight * there.shares.extend(1.0);
        }
        if sum.z < LEAST_KNOWN { self.share(it.position, normal, SPARSE) } else { sum.xy() / sum.z }
    }

    /// Light that falls onto a surface, given the shares of the sun's and the sky's that arrive.
    pub fn light(&self, n: Vec3, shares: Vec2) -> Vec3 {
        let terms = [1.0, n.x, n.y, n.z, n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.y * n.z, n.z * n.x];
        let open = self.view.open.iter().zip(terms).map(|(factor, term)| *factor * term).sum::<Vec4>();
        let from = shares * open.xy();
        self.view.sun * from.x + self.view.sky * from.y + self.view.bounce * (0.5 - 0.5 * n.y)
    }

    /// Shares of the sun's and the sky's light that arrive at a point of a surface, by every n-th light.
    pub fn share(&self, p: Vec3, normal: Vec3, every: usize) -> Vec2 {
        let [mut all, mut lit] = [Vec2::splat(NO_LIGHT); 2];
        let suns = (0..SUNS as usize).step_by(every);
        for i in suns.chain((SUNS as usize..self.lights.len()).step_by(every)) {
            let (light, map) = (&self.lights[i], &self.maps[i]);
            let facing = normal.dot(light.toward);
            if facing > 0.0 {
                let at = place(light, p + normal * (light.offset * (GRAZING - facing)));
                let free = map.lit(at.xy(), (at.z - light.bias).min(1.0));
                let which = if i < SUNS as usize { Vec2::X } else { Vec2::Y };
                all += which * facing;
                lit += which * (facing * free);
            }
        }
        lit / all
    }
}
