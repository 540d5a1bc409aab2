//! Writing in pictures, with the pre-drawn letters of Noto Sans Mono.

use super::Picture;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width};

/// Height of a line, px.
pub const LINE: u32 = RasterHeight::Size24.val() as u32;
/// Stands for letters that there is no picture of.
const UNKNOWN: char = '?';

/// Width of a letter, px.
pub fn letter() -> u32 {
    get_raster_width(FontWeight::Regular, RasterHeight::Size24) as u32
}

/// Writes a line, its upper left at (x, y), no wider than `room`: what does not fit is cut off, with dots.
pub fn write(picture: &mut Picture, x: u32, y: u32, room: u32, text: &str, ink: [u8; 3]) {
    let fits = (room / letter()) as usize;
    let count = text.chars().count();
    let shown = if count <= fits { count } else { fits.saturating_sub(2) };
    let dots = if count <= fits { "" } else { ".." };
    for (place, c) in text.chars().take(shown).chain(dots.chars()).take(fits).enumerate() {
        let drawn: Option<RasterizedChar> =
            [c, UNKNOWN].into_iter().find_map(|c| get_raster(c, FontWeight::Regular, RasterHeight::Size24));
        let Some(drawn) = drawn else { continue };
        for (row, line) in drawn.rows().enumerate() {
            for (column, &cover) in line.iter().enumerate() {
                let (px, py) = (x + place as u32 * letter() + column as u32, y + row as u32);
                blend(picture, px, py, ink, cover);
            }
        }
    }
}

fn blend(picture: &mut Picture, x: u32, y: u32, ink: [u8; 3], cover: u8) {
    if x >= picture.size.width || y >= picture.size.height {
        return;
    }
    let at = 3 * (y as usize * picture.size.width as usize + x as usize);
    for (there, ink) in picture.rgb[at..at + 3].iter_mut().zip(ink) {
        let mixed = (u32::from(*there) * (255 - u32::from(cover)) + u32::from(ink) * u32::from(cover) + 127) / 255;
        *there = mixed as u8;
    }
}
