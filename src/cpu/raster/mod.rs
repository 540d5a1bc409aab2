//! The painter for machines without a graphics adapter: the twin of `shaders/raster/`, with the same samples a pixel.

mod light;
mod shade;

use crate::render::{
    BACKGROUND, Batch, Camera, Kind, Light, Painter, Picture, RenderError, SKY_SIDE, SUN_SIDE, SUNS, Screen, Size,
    Stage, View, lights, near, project, to_byte, view,
};
use glam::{DVec2, DVec3, Vec2, Vec3, Vec4Swizzles};
use light::{Arriving, Map};
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

    /// First triangle of the walls, which are the last.
    fn first_wall(&self) -> usize {
        let first = self.stage.batches.iter().find(|batch| batch.kind == Kind::Wall).map(|batch| batch.first);
        first.unwrap_or(self.stage.vertices.len() / 3)
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
}
