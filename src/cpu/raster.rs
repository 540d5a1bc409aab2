//! The painter for machines without a graphics adapter: the twin of `shaders/raster/`, with the same samples a pixel.

use crate::render::{
    BACKGROUND, Batch, Camera, Kind, Light, Painter, Picture, RenderError, Screen, Size, Stage, Vertex, View, SKY_SIDE,
    SUN_SIDE, SUNS, lights, near, project, to_byte, to_linear, unpack_normal, view,
};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec3Swizzles, Vec4, Vec4Swizzles};
use rayon::prelude::*;
use std::ops::Range;

/// Places in a pixel at which it is decided what is seen: those of graphics cards.
const SAMPLES: [DVec2; 4] =
    [DVec2::new(0.375, 0.125), DVec2::new(0.875, 0.375), DVec2::new(0.125, 0.625), DVec2::new(0.625, 0.875)];
/// Rows that one thread draws at once.
const BAND: u32 = 16;
/// No triangle.
const NONE: u32 = u32::MAX;

/// Draws on the processor.
pub struct CpuPainter;

impl Painter for CpuPainter {
    fn describe(&self) -> String {
        "cpu".into()
    }

    fn paint(&self, stage: &Stage, camera: &Camera, size: Size) -> Result<Picture, RenderError> {
        size.check()?;
        let lights = lights(stage, camera);
        let maps = lights.par_iter().enumerate().map(|(i, light)| {
            Map::new(stage, light, if (i as u32) < SUNS { SUN_SIDE } else { SKY_SIDE })
        });
        let maps: Vec<Map> = maps.collect();
        let scene = Shading { stage, view: view(stage, camera, size), lights, maps, camera, size };
        let opaque = stage.batches.iter().filter(|batch| matches!(batch.kind, Kind::Solid | Kind::Ground));
        let opaque = scene.screens(opaque.copied());
        let blended = scene.screens(stage.blended(scene.view.eye).into_iter());
        let count = size.height.div_ceil(BAND);
        let (opaque_bands, blended_bands) = (bands(&opaque, size, count), bands(&blended, size, count));
        let rows = (0..count as usize).into_par_iter().map(|band| {
            let rows = band as u32 * BAND..((band as u32 + 1) * BAND).min(size.height);
            let of = |all: &[(u32, Screen)], here: &[u32]| -> Vec<(u32, Screen)> {
                here.iter().map(|&i| all[i as usize]).collect()
            };
            scene.band(rows, &of(&opaque, &opaque_bands[band]), &of(&blended, &blended_bands[band]))
        });
        Ok(Picture { size, rgb: rows.flatten_iter().collect() })
    }
}

/// Which triangles touch which rows.
fn bands(screens: &[(u32, Screen)], size: Size, count: u32) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); count as usize];
    for (i, (_, screen)) in screens.iter().enumerate() {
        let rows = screen.rows(size.height);
        for band in rows.start / BAND..rows.end.div_ceil(BAND) {
            bands[band as usize].push(i as u32);
        }
    }
    bands
}

/// Distances of what casts shadows from one light.
struct Map {
    side: u32,
    depths: Vec<f32>,
}

impl Map {
    fn new(stage: &Stage, light: &Light, side: u32) -> Self {
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

/// A picture in the making.
struct Shading<'a> {
    stage: &'a Stage,
    view: View,
    lights: Vec<Light>,
    maps: Vec<Map>,
    camera: &'a Camera,
    size: Size,
}

/// A point of a triangle.
struct Fragment {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    color: Vec4,
    detail: f32,
    /// Seen from the side from which the triangle is counter-clockwise.
    front: bool,
}

impl Shading<'_> {
    /// Triangles with their numbers on the raster, in order.
    fn screens(&self, batches: impl Iterator<Item = Batch>) -> Vec<(u32, Screen)> {
        let near = f64::from(near(self.stage));
        let clip = self.camera.clip(self.stage.origin, near);
        let mut screens = Vec::new();
        for number in batches.flat_map(|batch| batch.first..batch.first + batch.count) {
            let corners = self.stage.triangle(number).map(|p| clip * p.as_dvec3().extend(1.0));
            project(corners, near, self.size, |screen| screens.push((number as u32, screen)));
        }
        screens
    }

    /// Bytes of some rows.
    fn band(&self, rows: Range<u32>, opaque: &[(u32, Screen)], blended: &[(u32, Screen)]) -> Vec<u8> {
        let width = self.size.width;
        let inside = |screen: &Screen| {
            let touched = screen.rows(self.size.height);
            touched.start.max(rows.start)..touched.end.min(rows.end)
        };
        let pixels = ((rows.end - rows.start) * width) as usize;
        let at = |x: u32, y: u32| ((y - rows.start) * width + x) as usize;
        let mut depths = vec![[0.0_f32; 4]; pixels];
        let mut owners = vec![[NONE; 4]; pixels];
        for &(number, screen) in opaque {
            let holes = self.holes(number);
            screen.scan(inside(&screen), width, &SAMPLES, |x, y, sample, depth| {
                let place = at(x, y);
                if depth > depths[place][sample] && !holes.is_some_and(|cutoff| self.is_hole(number, x, y, sample, cutoff)) {
                    (depths[place][sample], owners[place][sample]) = (depth, number);
                }
            });
        }
        let mut colors = vec![[BACKGROUND; 4]; pixels];
        for y in rows.clone() {
            for x in 0..width {
                let (owners, colors) = (&owners[at(x, y)], &mut colors[at(x, y)]);
                for (sample, &number) in owners.iter().enumerate() {
                    // Once a triangle, for all of its samples.
                    if number == NONE || owners[..sample].contains(&number) {
                        continue;
                    }
                    let covered = [0, 1, 2, 3].map(|sample| owners[sample] == number);
                    let color = self.shade(number, x, y, covered).xyz();
                    for (into, _) in colors.iter_mut().zip(covered).filter(|(_, covered)| *covered) {
                        *into = color;
                    }
                }
            }
        }
        let mut hits: Vec<(u32, u32, [bool; 4])> = Vec::new();
        for &(number, screen) in blended {
            hits.clear();
            screen.scan(inside(&screen), width, &SAMPLES, |x, y, sample, depth| {
                if depth > depths[at(x, y)][sample] {
                    match hits.last_mut().filter(|hit| (hit.0, hit.1) == (x, y)) {
                        Some(hit) => hit.2[sample] = true,
                        None => hits.push((x, y, [0, 1, 2, 3].map(|i| i == sample))),
                    }
                }
            });
            for &(x, y, covered) in &hits {
                let color = self.shade(number, x, y, covered);
                for (into, _) in colors[at(x, y)].iter_mut().zip(covered).filter(|(_, covered)| *covered) {
                    *into = into.lerp(color.xyz(), color.w);
                }
            }
        }
        colors.iter().flat_map(|samples| (0.25 * samples.iter().sum::<Vec3>()).to_array().map(to_byte)).collect()
    }

    /// The batch of a triangle.
    fn batch(&self, number: u32) -> &Batch {
        let after = self.stage.batches.partition_point(|batch| batch.first <= number as usize);
        &self.stage.batches[after - 1]
    }

    /// The opacity below which the triangle's texture has holes, if it has any.
    fn holes(&self, number: u32) -> Option<f32> {
        let batch = self.batch(number);
        batch.texture.map(|texture| self.stage.textures[texture].1).filter(|cutoff| *cutoff > 0.0)
    }

    fn is_hole(&self, number: u32, x: u32, y: u32, sample: usize, cutoff: f32) -> bool {
        let fragment = self.fragment(number, DVec2::new(x.into(), y.into()) + SAMPLES[sample]);
        self.texel(number, &fragment).w * fragment.color.w < cutoff
    }

    /// Linear colour and opacity of a triangle in a pixel, at the middle of what it covers.
    fn shade(&self, number: u32, x: u32, y: u32, covered: [bool; 4]) -> Vec4 {
        let corner = DVec2::new(x.into(), y.into());
        let count = covered.iter().filter(|covered| **covered).count();
        let sum: DVec2 = SAMPLES.iter().zip(covered).filter(|(_, covered)| *covered).map(|(sample, _)| *sample).sum();
        let it = self.fragment(number, corner + sum / count.max(1) as f64);
        match self.batch(number).kind {
            Kind::Solid | Kind::Glass => self.shaded(number, &it),
            Kind::Ground => self.ground(&it),
            Kind::Wall => self.wall(&it),
        }
    }

    /// Where the ray through a place of the picture meets the triangle's plane.
    fn fragment(&self, number: u32, at: DVec2) -> Fragment {
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
        Fragment {
            position: p.as_vec3(),
            normal: mix(&|v| unpack_normal(v.normal).extend(0.0)).xyz(),
            uv: mix(&|v| v.uv.extend(0.0).extend(0.0)).xy(),
            color: mix(&|v| unpack_color(v.color)),
            detail: corners[0].detail,
            front: face.dot(ray) < 0.0,
        }
    }

    fn texel(&self, number: u32, it: &Fragment) -> Vec4 {
        let Some(texture) = self.batch(number).texture else { return Vec4::ONE };
        let level = (it.detail * self.view.pixel * it.position.distance(self.view.eye)).max(1.0).log2();
        self.stage.textures[texture].0.sample(it.uv, level)
    }

    fn shaded(&self, number: u32, it: &Fragment) -> Vec4 {
        let normal = it.normal.normalize_or(Vec3::Y) * if it.front { 1.0 } else { -1.0 };
        let texel = self.texel(number, it);
        let [lit, _] = self.illumination(it.position, normal);
        let color = (-self.view.exposure * it.color.xyz() * texel.xyz() * lit).exp();
        (1.0 - color).extend(it.color.w)
    }

    fn ground(&self, it: &Fragment) -> Vec4 {
        let View { eye, pixel, background, grid, center, radius, grid_at, .. } = self.view;
        let p = it.position;
        let away = p.distance(eye);
        let fade = smoothstep(1.5, 3.2, p.xz().distance(center.xz()) / radius);
        let mut share = Vec3::ONE;
        if fade < 1.0 {
            let [lit, open] = self.illumination(p, Vec3::Y);
            let steep = ((eye.y - p.y).abs() / away.max(1e-6)).max(0.02);
            let soft = 0.75 * pixel * away / steep;
            let at = (p.xz() - grid_at) / grid;
            let off = (at - at.round()).abs() * grid;
            let half = 0.0015 * radius;
            let line = ((half + soft - off.min_element()) / (2.0 * soft)).clamp(0.0, 1.0) * (half / soft).min(1.0);
            share = lit / open * (1.0 - 0.16 * line);
        }
        (background * share.lerp(Vec3::ONE, fade)).extend(1.0)
    }

    fn wall(&self, it: &Fragment) -> Vec4 {
        if !it.front {
            return (0.5 * self.view.background).extend(0.06);
        }
        let [lit, open] = self.illumination(it.position, it.normal.normalize_or(Vec3::Y));
        (Vec3::new(0.86, 0.85, 0.83) * lit / open).extend(0.6)
    }

    /// With and without shadows.
    fn illumination(&self, p: Vec3, normal: Vec3) -> [Vec3; 2] {
        let below = self.view.bounce * (0.5 - 0.5 * normal.y);
        let [mut lit, mut open] = [below; 2];
        for (light, map) in self.lights.iter().zip(&self.maps) {
            let facing = normal.dot(light.toward);
            if facing > 0.0 {
                let at = place(light, p + normal * light.offset);
                let depth = (at.z - light.bias).min(1.0);
                open += facing * light.color;
                lit += facing * map.lit(at.xy(), depth) * light.color;
            }
        }
        [lit, open]
    }
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn unpack_color(packed: u32) -> Vec4 {
    let [r, g, b, a] = packed.to_le_bytes().map(|byte| f32::from(byte) / 255.0);
    Vec3::new(r, g, b).map(to_linear).extend(a)
}
