//! Contact sheets: rows of pictures under one heading each.

use super::text::{LINE, write};
use super::{Picture, RenderError, Size};

/// Free space around and between the pictures, px.
const GAP: u32 = 16;
const PAPER: [u8; 3] = [250, 250, 249];
const EMPTY: [u8; 3] = [238, 238, 237];
const INK: [u8; 3] = [38, 40, 43];
const FAINT: [u8; 3] = [128, 130, 134];

/// A picture with what stands under it.
pub struct Cell {
    /// What it shows; it is cut off where it is wider than the picture.
    pub label: String,
    /// `None` leaves the place empty.
    pub picture: Option<Picture>,
}

/// What a sheet shows.
pub struct Sheet {
    /// Heading and pictures of each row.
    pub rows: Vec<(String, Vec<Cell>)>,
    /// Size of each picture.
    pub cell: Size,
}

/// Puts the pictures side by side.
///
/// # Errors
/// More pictures than one picture can hold; the message says what to do.
pub fn sheet(sheet: &Sheet) -> Result<Picture, RenderError> {
    let size = size(sheet.rows.len(), sheet.rows.iter().map(|(_, cells)| cells.len()).max().unwrap_or(0), sheet.cell)?;
    let mut paper = Picture::filled(size, PAPER);
    let Size { width, height } = sheet.cell;
    for (row, (heading, cells)) in sheet.rows.iter().enumerate() {
        let top = GAP + row as u32 * row_height(height);
        write(&mut paper, GAP, top, size.width - 2 * GAP, heading, INK);
        for (column, cell) in cells.iter().enumerate() {
            let (x, y) = (GAP + column as u32 * (width + GAP), top + LINE + GAP / 2);
            match &cell.picture {
                Some(picture) => put(&mut paper, x, y, picture),
                None => put(&mut paper, x, y, &Picture::filled(sheet.cell, EMPTY)),
            }
            let ink = if cell.picture.is_some() { INK } else { FAINT };
            write(&mut paper, x, y + height + GAP / 4, width, &cell.label, ink);
        }
    }
    Ok(paper)
}

/// Size of a sheet of so many rows and columns.
///
/// # Errors
/// A side beyond 32768 pixels, which many viewers cannot show.
pub fn size(rows: usize, columns: usize, cell: Size) -> Result<Size, RenderError> {
    const MOST: u64 = 1 << 15;
    let width = u64::from(GAP) + columns as u64 * u64::from(cell.width + GAP);
    let height = u64::from(GAP) + rows as u64 * u64::from(row_height(cell.height));
    if width.max(height) > MOST {
        return Err(RenderError::Input(format!(
            "{rows} rows of {columns} pictures make a sheet of {width}x{height}, more than {MOST} pixels; make the \
             pictures smaller with --size, or take fewer"
        )));
    }
    Ok(Size { width: width as u32, height: height as u32 })
}

fn row_height(cell: u32) -> u32 {
    cell + 2 * LINE + 2 * GAP
}

fn put(paper: &mut Picture, x: u32, y: u32, picture: &Picture) {
    let (from, to) = (3 * picture.size.width as usize, 3 * paper.size.width as usize);
    for (row, line) in picture.rgb.chunks_exact(from).enumerate() {
        let start = (y as usize + row) * to + 3 * x as usize;
        paper.rgb[start..start + from].copy_from_slice(line);
    }
}
