//! The pictures that `optimize` leaves. They are a help to the eye: without them the result is no worse.

use super::{Failure, painter, say};
use rest3d_gpu::cpu::CpuPainter;
use rest3d_gpu::gpu::AdapterChoice;
use rest3d_gpu::render::{Models, Painter, Picture, RenderError, Size, Viewpoint, camera, share_a_view, stage};
use rest3d_gpu::scene::Scene;
use std::time::Instant;

/// Smaller than that of `render`, because nobody asked for them by name.
const SIZE: Size = Size { width: 1200, height: 900 };

/// The scene before and after as PNG files, from the same camera, which shows all of both: drawn on the adapter that
/// simulated, else by the processor, which needs no driver. What goes wrong is told, and there are none.
pub fn before_and_after(before: &Scene, after: &Scene, adapter: Option<&AdapterChoice>) -> Option<[Vec<u8>; 2]> {
    match drawn(before, after, adapter) {
        Ok(pictures) => Some(pictures),
        Err(failure) => {
            say(format_args!("warning: no before.png and after.png: {failure}"));
            None
        }
    }
}

fn drawn(before: &Scene, after: &Scene, adapter: Option<&AdapterChoice>) -> Result<[Vec<u8>; 2], Failure> {
    let clock = Instant::now();
    let mut models = Models::default();
    let first = stage(before, &mut models)?;
    for note in &first.notes {
        say(format_args!("warning: {note}"));
    }
    let second = stage(after, &mut models)?;
    // What has rolled far away is no reason to show the room from afar.
    let stages = [&first, &second];
    let framed = if share_a_view(&stages) { &stages[..] } else { &stages[..1] };
    let camera = camera(Viewpoint::Auto, before, framed, SIZE);
    let both = |painter: &dyn Painter| -> Result<[Picture; 2], RenderError> {
        Ok([painter.paint(&first, &camera, SIZE)?, painter.paint(&second, &camera, SIZE)?])
    };
    let mut painter = adapter.map_or_else(|| Box::new(CpuPainter) as Box<dyn Painter>, painter::any);
    let pictures = both(painter.as_ref()).or_else(|error| {
        say(format_args!("drawn by the cpu, not by {}: {error}", painter.describe()));
        painter = Box::new(CpuPainter);
        both(painter.as_ref())
    });
    let [before, after] = pictures?;
    let pictures = [before.png()?, after.png()?];
    say(format_args!("pictures: drawn by {}, {:.1} s", painter.describe(), clock.elapsed().as_secs_f64()));
    Ok(pictures)
}
