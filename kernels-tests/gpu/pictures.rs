//! Pictures: the adapter draws what the processor does.

use super::Test;
use super::fixture::Device;
use crate::render::{Case, agree, everything, shot};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::CpuPainter;
use rest3d_gpu::gpu::{AdapterChoice, GpuPainter};
use rest3d_gpu::scene::Scene;
use std::path::Path;

pub const TESTS: &[Test] = &[
    ("pictures::both_painters_draw_the_same", both_painters_draw_the_same),
    ("pictures::the_same_scene_gives_the_same_picture", the_same_scene_gives_the_same_picture),
    ("pictures::the_shipped_scene_looks_the_same_from_both_painters", the_shipped_scene_looks_the_same),
];

fn painter(device: &Device) -> Result<GpuPainter, Failed> {
    Ok(GpuPainter::open(&AdapterChoice::Index(device.gpu.report().index))?)
}

fn both_agree(device: &Device, scene: &Scene) -> Result<(), Failed> {
    if agree(&shot(scene, &painter(device)?), &shot(scene, &CpuPainter)) { Ok(()) } else { Err("they differ".into()) }
}

fn both_painters_draw_the_same(device: &Device) -> Result<(), Failed> {
    both_agree(device, &everything(&Case::new()))
}

fn the_same_scene_gives_the_same_picture(device: &Device) -> Result<(), Failed> {
    let case = Case::new();
    let (scene, painter) = (everything(&case), painter(device)?);
    if shot(&scene, &painter) == shot(&scene, &painter) { Ok(()) } else { Err("two pictures differ".into()) }
}

fn the_shipped_scene_looks_the_same(device: &Device) -> Result<(), Failed> {
    both_agree(device, &Scene::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/study"))?)
}
