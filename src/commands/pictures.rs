//! The pictures that `optimize` leaves. They are a help to the eye: without them the result is no worse.

use super::backend::BackendArgs;
use super::{Failure, say};
use rest3d_gpu::render::{Models, Size, Viewpoint, camera, stage};
use rest3d_gpu::scene::Scene;
use std::time::Instant;

/// Smaller than that of `render`, because nobody asked for them by name.
const SIZE: Size = Size { width: 1200, height: 900 };

/// The scene before and after as PNG files, from the same camera. What goes wrong is told, and there are none.
pub fn before_and_after(before: &Scene, after: &Scene, backend: &BackendArgs) -> Option<[Vec<u8>; 2]> {
    match drawn(before, after, backend) {
        Ok(pictures) => Some(pictures),
        Err(failure) => {
            say(format_args!("warning: no before.png and after.png: {failure}"));
            None
        }
    }
}

fn drawn(before: &Scene, after: &Scene, backend: &BackendArgs) -> Result<[Vec<u8>; 2], Failure> {
    let clock = Instant::now();
    let mut models = Models::default();
    let first = stage(before, &mut models)?;
    for note in &first.notes {
        say(format_args!("warning: {note}"));
    }
    let second = stage(after, &mut models)?;
    let painter = backend.painter();
    let camera = camera(Viewpoint::Auto, before, &[&first], SIZE);
    let paint = |stage| Ok::<_, Failure>(painter.paint(stage, &camera, SIZE)?.png()?);
    let pictures = [paint(&first)?, paint(&second)?];
    say(format_args!("pictures: drawn by {}, {:.1} s", painter.describe(), clock.elapsed().as_secs_f64()));
    Ok(pictures)
}
