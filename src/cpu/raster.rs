//! The painter for machines without a graphics adapter: the twin of `shaders/raster/`, with the same samples a pixel.

use crate::render::{
    BACKGROUND, Batch, Camera, Kind, Light, Painter, Picture, RenderError, SKY_SIDE, SUN_SIDE, SUNS, Screen, Size,
    Stage, Vertex, View, byte_to_linear, lights, near, project, to_byte, unpack_normal, view,
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
        let maps = lights
            .par_iter()
            .enumerate()
            .map(|(i, light)| Map::new(stage, light, if (i as u32) < SUNS { SUN_SIDE } else { SKY_SIDE }));
        let maps: Vec<Map> = maps.collect();
        let view = view(stage, camera, size, &lights);
        let mut scene = Shading { stage, view, lights, maps, camera, size, shares: Vec::new(), wall: Vec::new() };
        scene.shares = scene.shares();
        scene.wall = scene.wall_shares();
        let opaque = scene.screens(stage.opaque());
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
    /// At half the resolution.
    shares: Vec<Arriving>,
    /// Shares of the sun's and the sky's light at the corners of all walls, from the first wall's on.
    wall: Vec<Vec2>,
}

/// What arrives at a place.
#[derive(Clone, Copy, Default)]
struct Arriving {
    /// Of the sun's and of the sky's light.
    shares: Vec2,
    /// Distance to the eye; 0 where nothing is.
    away: f32,
    normal: Vec3,
}

/// What a triangle covers of a pixel.
struct Hit {
    x: u32,
    y: u32,
    /// At each sample; 0 at those that are not covered.
    depths: [f32; 4],
}

impl Hit {
    fn middle(&self) -> DVec2 {
        middle(self.x, self.y, self.depths.map(|depth| depth > 0.0))
    }
}

/// The middle of the covered samples of a pixel, px.
fn middle(x: u32, y: u32, covered: [bool; 4]) -> DVec2 {
    let count = covered.iter().filter(|covered| **covered).count();
    let sum: DVec2 = SAMPLES.iter().zip(covered).filter(|(_, covered)| *covered).map(|(sample, _)| *sample).sum();
    DVec2::new(x.into(), y.into()) + sum / count.max(1) as f64
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
    /// Place in the picture, px.
    at: Vec2,
}

impl Fragment {
    /// Unit normal on the side that is seen.
    fn facing(&self) -> Vec3 {
        self.normal.normalize_or(Vec3::Y) * if self.front { 1.0 } else { -1.0 }
    }
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

    /// See `shares`.
    fn shares(&self) -> Vec<Arriving> {
        let [width, height] = [self.size.width, self.size.height].map(|side| side.div_ceil(2));
        let (mut depths, mut owners) =
            (vec![0.0_f32; (width * height) as usize], vec![NONE; (width * height) as usize]);
        let at = |x: u32, y: u32| 2.0 * (DVec2::new(x.into(), y.into()) + 0.5);
        for (number, Screen(corners)) in self.screens(self.stage.opaque()) {
            let screen = Screen(corners.map(|p| p * DVec3::new(0.5, 0.5, 1.0)));
            let holes = self.holes(number);
            screen.scan(screen.rows(height), width, &[DVec2::splat(0.5)], |x, y, _, depth| {
                let place = (y * width + x) as usize;
                if depth > depths[place] && !holes.is_some_and(|cutoff| self.is_hole(number, at(x, y), cutoff)) {
                    (depths[place], owners[place]) = (depth, number);
                }
            });
        }
        let share = |(place, number): (usize, u32)| {
            if number == NONE {
                return Arriving::default();
            }
            let it = self.fragment(number, at(place as u32 % width, place as u32 / width));
            let (normal, away) = (it.facing(), it.position.distance(self.view.eye));
            Arriving { shares: self.share(it.position, normal, 1), away, normal }
        };
        owners.into_par_iter().enumerate().map(share).collect()
    }

    /// See `wall`.
    fn wall_shares(&self) -> Vec<Vec2> {
        let first = 3 * self.first_wall();
        let corners = self.stage.vertices[first..].par_iter();
        corners.map(|corner| self.share(corner.position, unpack_normal(corner.normal), 1)).collect()
    }

    /// First triangle of the walls, which are the last.
    fn first_wall(&self) -> usize {
        let first = self.stage.batches.iter().find(|batch| batch.kind == Kind::Wall).map(|batch| batch.first);
        first.unwrap_or(self.stage.vertices.len() / 3)
    }

    /// Shares of the sun's and the sky's light that arrive at a pixel: those of the four places around it at half the
    /// resolution, as far as they lie in its plane and face as it does.
    fn arriving(&self, it: &Fragment, normal: Vec3) -> Vec2 {
        let View { eye, pixel, forward, across, upward, width, height, .. } = self.view;
        let size = Vec2::new(width, height);
        let half = (0.5 * size).ceil();
        let at = 0.5 * it.at - 0.5;
        let (corner, part) = (at.floor(), at - at.floor());
        let tolerance = 0.7 * pixel * it.position.distance(eye);
        let mut sum = Vec3::ZERO;
        for step in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE] {
            let cell = (corner + step).clamp(Vec2::ZERO, half - 1.0);
            let there = self.shares[(cell.y * half.x + cell.x) as usize];
            let place = (4.0 * cell + 2.0) / size - 1.0;
            let ray = (forward + across * place.x - upward * place.y).normalize();
            let off = (eye + ray * there.away - it.position).dot(normal) / tolerance;
            let near = (1.0 - part) * (1.0 - step) + part * step;
            let alike = normal.dot(there.normal).max(0.0).powi(8);
            let known = if there.away > 0.0 { 1.0 } else { 0.0 };
            let weight = known * near.element_product() * alike / (1.0 + off.powi(4));
            sum += weight * there.shares.extend(1.0);
        }
        // On edges and thin things nothing was found out; a quarter of the lights is enough for them.
        if sum.z < 0.15 { self.share(it.position, normal, 4) } else { sum.xy() / sum.z }
    }

    /// Light that falls onto a surface, given the shares of the sun's and the sky's that arrive.
    fn light(&self, n: Vec3, shares: Vec2) -> Vec3 {
        let terms = [1.0, n.x, n.y, n.z, n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.y * n.z, n.z * n.x];
        let open = self.view.open.iter().zip(terms).map(|(factor, term)| *factor * term).sum::<Vec4>();
        let from = shares * open.xy();
        self.view.sun * from.x + self.view.sky * from.y + self.view.bounce * (0.5 - 0.5 * n.y)
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
        let mut hits: Vec<Hit> = Vec::new();
        for &(number, screen) in opaque {
            self.hits(screen, inside(&screen), &mut hits);
            let holes = self.holes(number);
            for hit in &hits {
                let place = at(hit.x, hit.y);
                // As on a graphics card, a pixel of a triangle is a hole or is none, whatever it covers of it.
                if holes.is_some_and(|cutoff| self.is_hole(number, hit.middle(), cutoff)) {
                    continue;
                }
                for sample in 0..4 {
                    if hit.depths[sample] > depths[place][sample] {
                        (depths[place][sample], owners[place][sample]) = (hit.depths[sample], number);
                    }
                }
            }
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
        for &(number, screen) in blended {
            self.hits(screen, inside(&screen), &mut hits);
            for hit in &hits {
                let place = at(hit.x, hit.y);
                let covered = [0, 1, 2, 3].map(|sample| hit.depths[sample] > depths[place][sample]);
                if covered.contains(&true) {
                    let color = self.shade(number, hit.x, hit.y, covered);
                    for (into, _) in colors[place].iter_mut().zip(covered).filter(|(_, covered)| *covered) {
                        *into = into.lerp(color.xyz(), color.w);
                    }
                }
            }
        }
        colors.iter().flat_map(|samples| (0.25 * samples.iter().sum::<Vec3>()).to_array().map(to_byte)).collect()
    }

    /// The pixels that a triangle covers in some rows.
    fn hits(&self, screen: Screen, rows: Range<u32>, hits: &mut Vec<Hit>) {
        hits.clear();
        screen.scan(rows, self.size.width, &SAMPLES, |x, y, sample, depth| {
            match hits.last_mut().filter(|hit| (hit.x, hit.y) == (x, y)) {
                Some(hit) => hit.depths[sample] = depth,
                None => hits.push(Hit { x, y, depths: [0, 1, 2, 3].map(|i| if i == sample { depth } else { 0.0 }) }),
            }
        });
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

    fn is_hole(&self, number: u32, at: DVec2, cutoff: f32) -> bool {
        let fragment = self.fragment(number, at);
        self.texel(number, &fragment).w * fragment.color.w < cutoff
    }

    /// Linear colour and opacity of a triangle in a pixel, at the middle of what it covers.
    fn shade(&self, number: u32, x: u32, y: u32, covered: [bool; 4]) -> Vec4 {
        let it = self.fragment(number, middle(x, y, covered));
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
        let fade = smoothstep(1.5, 3.2, p.xz().distance(center.xz()) / radius);
        let mut share = Vec3::ONE;
        if fade < 1.0 {
            let steep = ((eye.y - p.y).abs() / away.max(1e-6)).max(0.02);
            let soft = 0.75 * pixel * away / steep;
            let at = (p.xz() - grid_at) / grid;
            let off = (at - at.round()).abs() * grid;
            let half = 0.0015 * radius;
            let line = ((half + soft - off.min_element()) / (2.0 * soft)).clamp(0.0, 1.0) * (half / soft).min(1.0);
            let light = self.light(Vec3::Y, self.arriving(it, Vec3::Y));
            share = light / self.light(Vec3::Y, Vec2::ONE) * (1.0 - 0.16 * line);
        }
        (background * share.lerp(Vec3::ONE, fade)).extend(1.0)
    }

    fn wall(&self, it: &Fragment) -> Vec4 {
        if !it.front {
            return (0.5 * self.view.background).extend(0.06);
        }
        let normal = it.normal.normalize_or(Vec3::Y);
        let share = self.light(normal, it.color.xy()) / self.light(normal, Vec2::ONE);
        (Vec3::new(0.86, 0.85, 0.83) * Vec3::ONE.lerp(share, 0.7)).extend(0.6)
    }

    /// Shares of the sun's and the sky's light that arrive at a point of a surface, by every n-th light.
    fn share(&self, p: Vec3, normal: Vec3, every: usize) -> Vec2 {
        // A little more than nothing, for surfaces that face no light.
        let [mut all, mut lit] = [Vec2::splat(1e-6); 2];
        let suns = (0..SUNS as usize).step_by(every);
        for i in suns.chain((SUNS as usize..self.lights.len()).step_by(every)) {
            let (light, map) = (&self.lights[i], &self.maps[i]);
            let facing = normal.dot(light.toward);
            if facing > 0.0 {
                let at = place(light, p + normal * (light.offset * (1.15 - facing)));
                let free = map.lit(at.xy(), (at.z - light.bias).min(1.0));
                let which = if i < SUNS as usize { Vec2::X } else { Vec2::Y };
                all += which * facing;
                lit += which * (facing * free);
            }
        }
        lit / all
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
