//! A colour for every object that has none: the same one in every picture of the same names.

use glam::{Vec3, Vec4};

/// Hues, degrees in Oklch, with lightness and chroma: calm, apart from each other, none as light as the ground.
const COLORS: [[f32; 3]; 20] = [
    [30.0, 0.66, 0.13],
    [250.0, 0.62, 0.11],
    [145.0, 0.66, 0.11],
    [85.0, 0.78, 0.12],
    [310.0, 0.62, 0.12],
    [195.0, 0.68, 0.09],
    [55.0, 0.70, 0.13],
    [275.0, 0.62, 0.12],
    [120.0, 0.74, 0.11],
    [0.0, 0.68, 0.12],
    [220.0, 0.72, 0.09],
    [70.0, 0.64, 0.09],
    [165.0, 0.66, 0.10],
    [335.0, 0.60, 0.13],
    [100.0, 0.82, 0.11],
    [235.0, 0.60, 0.10],
    [15.0, 0.78, 0.09],
    [180.0, 0.76, 0.08],
    [45.0, 0.64, 0.11],
    [290.0, 0.72, 0.10],
];

/// Linear colours for objects of these names. Each name has a colour of its own choice; of two that choose the same,
/// the later in the alphabet takes the next free one, so that neither the order of the objects nor their places matter.
pub fn colors(names: &[&str]) -> Vec<Vec4> {
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_key(|&i| names[i]);
    let mut taken = [0_usize; COLORS.len()];
    let mut colors = vec![Vec4::ONE; names.len()];
    for i in order {
        let hash = blake3::hash(names[i].as_bytes());
        let first = usize::from(hash.as_bytes()[0]) * 256 + usize::from(hash.as_bytes()[1]);
        let least = taken.iter().copied().min().unwrap_or(0);
        let slot = (first..).map(|slot| slot % COLORS.len()).find(|&slot| taken[slot] == least).unwrap_or(0);
        taken[slot] += 1;
        colors[i] = linear(COLORS[slot]).extend(1.0);
    }
    colors
}

/// Oklch (hue in degrees, lightness, chroma) to linear sRGB, after Ottosson, "A perceptual color space for image
/// processing", 2020.
fn linear([hue, lightness, chroma]: [f32; 3]) -> Vec3 {
    let (sin, cos) = hue.to_radians().sin_cos();
    let (a, b) = (chroma * cos, chroma * sin);
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    let rgb = Vec3::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_93 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    );
    rgb.clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::colors;

    #[test]
    fn colors_belong_to_names() {
        let names = ["desk", "lamp", "mug", "book", "sofa", "chair"];
        let all = colors(&names);
        let turned: Vec<&str> = names.iter().rev().copied().collect();
        let again: Vec<_> = colors(&turned).into_iter().rev().collect();
        assert_eq!(all, again);
        for (i, color) in all.iter().enumerate() {
            assert!(!all[..i].contains(color), "{}", names[i]);
        }
        let many: Vec<String> = (0..50).map(|i| i.to_string()).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert_eq!(colors(&many).len(), 50);
    }
}
