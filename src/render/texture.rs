//! Textures with all their reduced sizes, and how they are sampled.

use crate::shape::{Pixels, Wrap};
use glam::{Vec2, Vec4};
use std::sync::{Arc, LazyLock};

/// Longest side that is kept, px: no object of a picture shows more.
const MAX_SIDE: u32 = 1024;

/// An image with its reduced sizes, each half of the one before, down to one pixel.
#[derive(Clone, Debug)]
pub struct Texture {
    /// From large to small, sRGB and opacity.
    pub levels: Vec<Arc<Pixels>>,
    /// How it goes on across and down.
    pub wrap: [Wrap; 2],
}

/// Linear light of each byte.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| to_linear(i as f32 / 255.0)));

impl Texture {
    /// Makes the reduced sizes.
    pub fn new(image: &Arc<Pixels>, wrap: [Wrap; 2]) -> Self {
        let mut first = Arc::clone(image);
        while first.width.max(first.height) > MAX_SIDE {
            first = Arc::new(half(&first));
        }
        let mut levels = vec![first];
        while let Some(last) = levels.last().filter(|last| last.width.max(last.height) > 1) {
            levels.push(Arc::new(half(last)));
        }
        Self { levels, wrap }
    }

    /// Pixels of the largest size.
    pub fn area(&self) -> f32 {
        self.levels[0].width as f32 * self.levels[0].height as f32
    }

    /// Linear colour and opacity at a place, between the reduced sizes around `level`.
    pub fn sample(&self, uv: Vec2, level: f32) -> Vec4 {
        let level = level.clamp(0.0, (self.levels.len() - 1) as f32);
        let lower = level as usize;
        let fine = self.bilinear(&self.levels[lower], uv);
        match self.levels.get(lower + 1).filter(|_| level.fract() > 0.0) {
            Some(coarse) => fine.lerp(self.bilinear(coarse, uv), level.fract()),
            None => fine,
        }
    }

    fn bilinear(&self, image: &Pixels, uv: Vec2) -> Vec4 {
        let at = uv * Vec2::new(image.width as f32, image.height as f32) - 0.5;
        let (corner, share) = (at.floor(), at - at.floor());
        let texel = |dx: f32, dy: f32| {
            let x = wrapped(corner.x + dx, image.width, self.wrap[0]);
            let y = wrapped(corner.y + dy, image.height, self.wrap[1]);
            linear_pixel(image, x, y)
        };
        let upper = texel(0.0, 0.0).lerp(texel(1.0, 0.0), share.x);
        upper.lerp(texel(0.0, 1.0).lerp(texel(1.0, 1.0), share.x), share.y)
    }
}

fn wrapped(place: f32, size: u32, wrap: Wrap) -> u32 {
    let size = size as f32;
    let inside = match wrap {
        Wrap::Repeat => place.rem_euclid(size),
        Wrap::Clamp => place,
        Wrap::Mirror => {
            let twice = place.rem_euclid(2.0 * size);
            if twice < size { twice } else { 2.0 * size - 1.0 - twice }
        }
    };
    inside.clamp(0.0, size - 1.0) as u32
}

fn linear_pixel(image: &Pixels, x: u32, y: u32) -> Vec4 {
    let at = 4 * (y as usize * image.width as usize + x as usize);
    let [r, g, b, a] = [0, 1, 2, 3].map(|i| image.rgba[at + i]);
    Vec4::new(LINEAR[r as usize], LINEAR[g as usize], LINEAR[b as usize], f32::from(a) / 255.0)
}

/// Half as large, averaged in linear light.
fn half(image: &Pixels) -> Pixels {
    let (width, height) = ((image.width / 2).max(1), (image.height / 2).max(1));
    let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let (x1, y1) = ((2 * x + 1).min(image.width - 1), (2 * y + 1).min(image.height - 1));
            let (x0, y0) = ((2 * x).min(x1), (2 * y).min(y1));
            let sum = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| linear_pixel(image, x, y));
            let mean = 0.25 * sum.into_iter().sum::<Vec4>();
            rgba.extend(mean.truncate().to_array().map(to_byte));
            rgba.push((255.0 * mean.w).round() as u8);
        }
    }
    Pixels { width, height, rgba }
}

/// The byte of a linear intensity in sRGB.
pub fn to_byte(linear: f32) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

/// The linear intensity of a byte in sRGB.
pub fn byte_to_linear(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

/// The linear intensity of a value in sRGB.
fn to_linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_go_on_as_asked() {
        for (place, repeat, mirror, clamp) in [(-1.0, 3, 0, 0), (4.0, 0, 3, 3), (5.0, 1, 2, 3), (2.0, 2, 2, 2)] {
            let found = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|wrap| wrapped(place, 4, wrap));
            assert_eq!(found, [repeat, mirror, clamp], "{place}");
        }
    }

    #[test]
    fn reduced_sizes_end_at_one_pixel_of_the_mean() {
        let rgba = [[0, 0, 0, 255], [255, 255, 255, 255]].as_flattened().repeat(3);
        let texture = Texture::new(&Arc::new(Pixels { width: 2, height: 3, rgba }), Default::default());
        let last = &texture.levels[texture.levels.len() - 1];
        assert_eq!((last.width, last.height, last.rgba[0]), (1, 1, to_byte(0.5)));
        assert!((texture.sample(Vec2::new(7.3, -2.0), 9.0).x - 0.5).abs() < 0.01);
    }

    #[test]
    fn bytes_survive_linear_light() {
        assert!((0..=255).all(|byte: u8| to_byte(to_linear(f32::from(byte) / 255.0)) == byte));
    }
}
