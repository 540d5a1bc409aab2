//! Where light comes from: a sun and a sky, both spread over many directions, each with a map of depths.
//!
//! Shadows of the sun so get soft with distance, which shows what floats, and the many faint ones of the sky darken
//! where things touch.

use super::layout::Light;
use super::{Camera, Stage};
use glam::{Vec3, Vec4};

/// Directions of the sun and of the sky. More would be smoother and slower.
pub const SUNS: u32 = 10;
/// See [`SUNS`].
pub const SKIES: u32 = 24;
/// Side of a map of depths, texels.
pub const SUN_SIDE: u32 = 1024;
/// See [`SUN_SIDE`].
pub const SKY_SIDE: u32 = 320;

/// Half the angle under which the sun is seen, rad: eight times the real one, for soft shadows.
const SUN_SPREAD: f32 = 0.035;
/// The sun stands to the left of the camera, behind it and above: shares along those axes.
const SUN: Vec3 = Vec3::new(-0.62, 1.25, 0.5);
/// Lowest sine of the height of a direction of the sky.
const SKY_LOWEST: f32 = 0.12;
/// Light that falls onto open ground, from each.
const SUN_LIGHT: Vec3 = Vec3::new(0.60, 0.575, 0.535);
const SKY_LIGHT: Vec3 = Vec3::new(0.40, 0.425, 0.465);
/// Light from below.
pub(super) const BOUNCE: Vec3 = Vec3::new(0.24, 0.23, 0.22);
/// Points are looked up so many texels off their surface, where light grazes it, and so many texels nearer.
const OFFSET: f32 = 1.4;
const BIAS: f32 = 0.6;
/// Texels that stay free around what casts shadows.
const BORDER: f32 = 2.0;
const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// Suns first, then skies.
pub fn lights(stage: &Stage, camera: &Camera) -> Vec<Light> {
    let (right, back) = (camera.right.as_vec3(), camera.toward_viewer().as_vec3());
    let sun = (right * SUN.x + Vec3::Y * SUN.y + back * SUN.z).normalize();
    let (across, along) = sun.any_orthonormal_pair();
    let suns = (0..SUNS).map(|i| {
        // A spiral covers the disc evenly.
        let (sin, cos) = (i as f32 * GOLDEN_ANGLE).sin_cos();
        let radius = SUN_SPREAD * ((i as f32 + 0.5) / SUNS as f32).sqrt();
        ((sun + (across * cos + along * sin) * radius).normalize(), SUN_SIDE)
    });
    let skies = (0..SKIES).map(|i| {
        let height = SKY_LOWEST + (1.0 - SKY_LOWEST) * (i as f32 + 0.5) / SKIES as f32;
        let (sin, cos) = (i as f32 * GOLDEN_ANGLE).sin_cos();
        let level = (1.0 - height * height).sqrt();
        (right * (cos * level) + back * (sin * level) + Vec3::Y * height, SKY_SIDE)
    });
    suns.chain(skies).map(|(toward, side)| light(stage, toward, side)).collect()
}

/// Intensities of each light of the sun and of the sky.
pub(super) fn intensities(lights: &[Light]) -> [Vec3; 2] {
    let (suns, skies) = lights.split_at(SUNS as usize);
    [(suns, SUN_LIGHT), (skies, SKY_LIGHT)].map(|(all, light)| light / all.iter().map(|one| one.toward.y).sum::<f32>())
}

/// What light without shadows is made of, see `View::open`. The cosine of an angle, 0 from 90° on, is about
/// 3/32 + cos/2 + 15/32 cos², the first terms of its series in Legendre polynomials.
pub(super) fn open(lights: &[Light]) -> [Vec4; 10] {
    let mut sum = [Vec4::ZERO; 10];
    for (i, light) in lights.iter().enumerate() {
        let which = if i < SUNS as usize { Vec4::X } else { Vec4::Y };
        let d = light.toward;
        let square = 15.0 / 32.0 * d * d;
        let products = 15.0 / 16.0 * d * Vec3::new(d.y, d.z, d.x);
        let factors = [3.0 / 32.0, 0.5 * d.x, 0.5 * d.y, 0.5 * d.z, square.x, square.y, square.z];
        for (sum, factor) in sum.iter_mut().zip(factors.into_iter().chain(products.to_array())) {
            *sum += which * factor;
        }
    }
    sum
}

/// A light whose map just holds what casts shadows.
fn light(stage: &Stage, toward: Vec3, side: u32) -> Light {
    let (across, down) = toward.any_orthonormal_pair();
    let axes = [across, down, -toward];
    let mut bounds = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
    for p in &stage.casters.positions {
        for (bound, axis) in bounds.iter_mut().zip(axes) {
            let along = p.truncate().dot(axis);
            *bound = [bound[0].min(along), bound[1].max(along)];
        }
    }
    if stage.casters.positions.is_empty() {
        bounds = [[-1.0, 1.0]; 3];
    }
    let extents = bounds.map(|[low, high]| (high - low).max(1e-4 * stage.radius).max(1e-6));
    let texel = extents[0].max(extents[1]) / (side as f32 - 2.0 * BORDER);
    let scale = 1.0 - 2.0 * BORDER / side as f32;
    let row = |i: usize, scale: f32, margin: f32| {
        (axes[i] * (scale / extents[i])).extend(margin - bounds[i][0] * scale / extents[i])
    };
    let margin = BORDER / side as f32;
    Light {
        u: row(0, scale, margin),
        v: row(1, scale, margin),
        // Not quite to the ends: a depth of 1 means that nothing is there.
        depth: row(2, 0.98, 0.01),
        toward,
        offset: OFFSET * texel,
        bias: BIAS * texel * 0.98 / extents[2],
        padding: [0.0; 3],
    }
}
