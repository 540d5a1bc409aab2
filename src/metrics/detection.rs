//! How well instance masks match true ones.

use super::{FOUND, mean};
use image::ImageReader;
use rayon::prelude::*;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};

/// A pixel belongs to a mask from this brightness on, of 255.
const SET: u8 = 128;

/// Detection of objects by masks (paper: Recall@0.5, mIoU, miss rate). Every true mask is matched with the mask of the
/// highest intersection over union, if any shares a pixel with it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Detection {
    /// True masks.
    pub true_masks: usize,
    /// Masks to compare with them.
    pub masks: usize,
    /// Share of the true masks whose match has an intersection over union of at least [`FOUND`], 0 to 1.
    pub recall_at_50: f64,
    /// Mean intersection over union of the matches, 0 to 1.
    pub mean_iou: f64,
    /// Share of the true masks without a match, 0 to 1.
    pub miss_rate: f64,
}

/// Masks that cannot be compared: file, what is wrong, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}; {remedy}", file.display())]
pub struct DetectionError {
    file: PathBuf,
    problem: String,
    remedy: &'static str,
}

/// One instance: the pixels that are bright.
struct Mask {
    file: PathBuf,
    size: (u32, u32),
    pixels: Vec<bool>,
}

/// Compares two folders of PNG masks of one picture, one instance a file.
///
/// # Errors
/// A folder that cannot be read or has no PNG, a damaged file, masks of different sizes.
pub fn detection(masks: &Path, true_masks: &Path) -> Result<Detection, DetectionError> {
    let (masks, truth) = (read(masks)?, read(true_masks)?);
    if let Some(odd) = masks.iter().chain(&truth).find(|mask| mask.size != truth[0].size) {
        let [(w, h), (w0, h0)] = [odd.size, truth[0].size];
        return Err(DetectionError {
            file: odd.file.clone(),
            problem: format!("it has {w} × {h} pixels, but {} has {w0} × {h0}", truth[0].file.display()),
            remedy: "give masks of one picture in one size",
        });
    }
    let best = |truth: &Mask| masks.iter().map(|mask| iou(mask, truth)).fold(0.0, f64::max);
    let best: Vec<f64> = truth.par_iter().map(best).collect();
    let share = |which: fn(f64) -> bool| best.iter().filter(|iou| which(**iou)).count() as f64 / best.len() as f64;
    Ok(Detection {
        true_masks: truth.len(),
        masks: masks.len(),
        recall_at_50: share(|iou| iou >= FOUND),
        mean_iou: mean(best.iter().copied().filter(|iou| *iou > 0.0)),
        miss_rate: share(|iou| iou == 0.0),
    })
}

/// All PNG files of a folder, by name; at least one.
fn read(folder: &Path) -> Result<Vec<Mask>, DetectionError> {
    let wrong = |file: &Path, problem: String, remedy| DetectionError { file: file.to_owned(), problem, remedy };
    let entries = fs::read_dir(folder)
        .map_err(|error| wrong(folder, format!("cannot be read: {error}"), "name a folder of PNG masks"))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")));
    files.sort();
    if files.is_empty() {
        return Err(wrong(
            folder,
            "no PNG file is in it".into(),
            "put one mask a file there, bright where the object is",
        ));
    }
    let load = |file: &PathBuf| {
        let image = ImageReader::open(file).map_err(|error| error.to_string()).and_then(|reader| {
            reader.with_guessed_format().map_err(|e| e.to_string())?.decode().map_err(|e| e.to_string())
        });
        let image =
            image.map_err(|problem| wrong(file, format!("cannot be decoded: {problem}"), "save it again as a PNG"))?;
        let gray = image.into_luma8();
        let pixels = gray.as_raw().iter().map(|value| *value >= SET).collect();
        Ok(Mask { file: file.clone(), size: gray.dimensions(), pixels })
    };
    files.par_iter().map(load).collect()
}

/// Intersection over union, 0 to 1.
fn iou(a: &Mask, b: &Mask) -> f64 {
    let count =
        |both: fn(bool, bool) -> bool| a.pixels.iter().zip(&b.pixels).filter(|(a, b)| both(**a, **b)).count() as f64;
    let union = count(|a, b| a || b);
    if union > 0.0 { count(|a, b| a && b) / union } else { 0.0 }
}
