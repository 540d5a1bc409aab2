//! Images for textures: PNG and JPEG, by the `image` crate.

use crate::shape::Pixels;
use image::{ImageReader, Limits};
use std::io::Cursor;

/// Most columns or rows; textures of 16384 exist, larger ones are a mistake.
const MAX_SIDE: u32 = 1 << 14;
/// Most memory that decoding may take, bytes.
const MAX_MEMORY: u64 = 1 << 30;

/// Decodes an image; what it is tells its content, not its name. The error is one line.
pub(super) fn decode(bytes: &[u8]) -> Result<Pixels, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_MEMORY);
    reader.limits(limits);
    if reader.format().is_none() {
        return Err("it is neither PNG nor JPEG".into());
    }
    let image = reader.decode().map_err(|e| e.to_string().split_whitespace().collect::<Vec<_>>().join(" "))?;
    let image = image.into_rgba8();
    match image.dimensions() {
        (0, _) | (_, 0) => Err("it is empty".into()),
        (width, height) => Ok(Pixels { width, height, rgba: image.into_raw() }),
    }
}
