//! What the kernel tests share: the device, poison, comparison and canary.

use crate::common::hulls::cuboid;
use crate::common::scenario::Scenario;
use bytemuck::Pod;
use glam::{Quat, Vec3};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::sample::{normals, philox};
use rest3d_gpu::gpu::{
    AdapterChoice, AdapterKind, Buffer, Download, Gpu, GpuBackend, GpuError, Kernels, Recorder, Step,
};
use rest3d_gpu::world::{Body, BodyDef, Energy, Pose, STATIC, Winner, World, angle_between};
use std::sync::OnceLock;

/// Batch sizes: one, few, and no multiples of a workgroup.
pub const SIZES: [u32; 4] = [1, 7, 65, 1234];

/// The adapter under test.
pub struct Device {
    pub gpu: Gpu,
    kernels: Result<Kernels, GpuError>,
    choice: AdapterChoice,
    backend: OnceLock<Result<GpuBackend, GpuError>>,
}

impl Device {
    pub fn open(choice: AdapterChoice) -> Result<Self, GpuError> {
        let gpu = Gpu::open(&choice)?;
        let kernels = Kernels::compile(&gpu);
        Ok(Self { gpu, kernels, choice, backend: OnceLock::new() })
    }

    /// The same adapter as the optimizer sees it, opened when a test first wants it.
    pub fn backend(&self) -> Result<&GpuBackend, Failed> {
        let opened = self.backend.get_or_init(|| GpuBackend::open(&self.choice));
        opened.as_ref().map_err(|error| error.to_string().into())
    }

    pub fn kernels(&self) -> Result<&Kernels, Failed> {
        self.kernels.as_ref().map_err(|error| error.to_string().into())
    }

    pub fn input<T: Pod>(&self, data: &[T]) -> Result<Buffer<T>, Failed> {
        Ok(Buffer::from_slice(&self.gpu, "input", data)?)
    }

    /// A buffer of values that no kernel writes.
    pub fn poisoned<T: Pod>(&self, len: usize) -> Result<Buffer<T>, Failed> {
        let buffer = Buffer::new(&self.gpu, "poisoned", len)?;
        self.poison(&buffer);
        Ok(buffer)
    }

    /// Fills a buffer with values that no kernel writes.
    pub fn poison<T: Pod>(&self, buffer: &Buffer<T>) {
        const POISON: u32 = 0x7fc0_dead;
        let words = vec![POISON; buffer.len() * size_of::<T>() / 4];
        buffer.upload(&self.gpu, &bytemuck::pod_collect_to_vec::<u32, T>(&words));
    }

    /// How far a kernel that gives its twin's bits on a software adapter may be off: cards round as they like.
    pub fn rounding(&self, on_cards: f32) -> f32 {
        if self.gpu.report().kind == AdapterKind::Software { 0.0 } else { on_cards }
    }

    pub fn run(&self, step: &Step) {
        let mut recorder = Recorder::new(&self.gpu);
        recorder.run([step]);
        recorder.submit();
    }

    pub fn fetch<T: Pod>(&self, buffer: &Buffer<T>) -> Result<Vec<T>, Failed> {
        let download = Download::new(&self.gpu, "fetched", buffer.len());
        let mut recorder = Recorder::new(&self.gpu);
        recorder.fetch(buffer, &download);
        recorder.submit();
        Ok(download.take(&self.gpu)?)
    }

    /// The buffer holds what is expected, and would not if any element were off by a little: the canary spoils the
    /// first, a middle and the last element on the device, and the comparison must see it.
    pub fn expect<T: Value>(
        &self,
        what: &str,
        buffer: &Buffer<T>,
        expected: &[T],
        tolerance: f32,
    ) -> Result<(), Failed> {
        let found = self.fetch(buffer)?;
        alike(&found, expected, tolerance).map_err(|error| format!("{what}: {error}"))?;
        for at in [0, found.len() / 2, found.len().saturating_sub(1)] {
            let mut spoiled = found.clone();
            let Some(value) = spoiled.get_mut(at) else { continue };
            value.spoil(3.0 * tolerance);
            buffer.upload(&self.gpu, &spoiled);
            if alike(&self.fetch(buffer)?, expected, tolerance).is_ok() {
                return Err(format!("{what}: the comparison does not see that element {at} is off").into());
            }
        }
        buffer.upload(&self.gpu, &found);
        Ok(())
    }
}

/// Something that kernels write, and how far two of it are apart.
pub trait Value: Pod + std::fmt::Debug {
    /// 0 if they are the same; differences of numbers above 1 count relative to them; NaN if they cannot be compared.
    fn distance(&self, other: &Self) -> f32;
    /// Moves it by so much, or by the least that there is.
    fn spoil(&mut self, by: f32);
}

impl Value for f32 {
    fn distance(&self, other: &Self) -> f32 {
        if self == other { 0.0 } else { (self - other).abs() / other.abs().max(1.0) }
    }
    fn spoil(&mut self, by: f32) {
        *self = if by == 0.0 { self.next_up() } else { *self + by * self.abs().max(1.0) };
        if !self.is_finite() {
            *self = 0.0;
        }
    }
}

impl Value for u32 {
    fn distance(&self, other: &Self) -> f32 {
        if self == other { 0.0 } else { f32::NAN }
    }
    fn spoil(&mut self, _: f32) {
        *self ^= 1;
    }
}

impl Value for Pose {
    fn distance(&self, other: &Self) -> f32 {
        if (self.rotation, self.translation) == (other.rotation, other.translation) {
            return 0.0;
        }
        let [turn, length] = [angle_between(self.rotation, other.rotation), self.rotation.length() - 1.0];
        let shift = self.translation.distance(other.translation) / other.translation.length().max(1.0);
        shift + turn + length.abs()
    }
    fn spoil(&mut self, by: f32) {
        if by == 0.0 {
            self.translation.x.spoil(by);
        }
        self.rotation = Quat::from_rotation_y(2.0 * by) * self.rotation;
    }
}

impl Value for Energy {
    fn distance(&self, other: &Self) -> f32 {
        let terms = |e: &Self| [e.total, e.stability, e.velocity, e.penetration, e.layout];
        terms(self).iter().zip(terms(other)).map(|(a, b)| a.distance(&b)).sum()
    }
    fn spoil(&mut self, by: f32) {
        self.total.spoil(by);
    }
}

impl Value for Winner {
    fn distance(&self, other: &Self) -> f32 {
        self.energy.distance(&other.energy)
            + self.iteration.distance(&other.iteration)
            + self.candidate.distance(&other.candidate)
    }
    fn spoil(&mut self, by: f32) {
        self.candidate.spoil(by);
    }
}

/// Fails with the first element that is too far off, or NaN; and if it would not see that one is.
pub fn compare<T: Value>(found: &[T], expected: &[T], tolerance: f32) -> Result<(), String> {
    alike(found, expected, tolerance)?;
    for at in [0, found.len() / 2, found.len().saturating_sub(1)] {
        let mut spoiled = found.to_vec();
        let Some(value) = spoiled.get_mut(at) else { continue };
        value.spoil(3.0 * tolerance);
        if alike(&spoiled, expected, tolerance).is_ok() {
            return Err(format!("the comparison does not see that element {at} is off"));
        }
    }
    Ok(())
}

/// Fails with the first element that is too far off, or NaN.
fn alike<T: Value>(found: &[T], expected: &[T], tolerance: f32) -> Result<(), String> {
    if found.len() != expected.len() {
        return Err(format!("{} elements instead of {}", found.len(), expected.len()));
    }
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        let distance = a.distance(b);
        if distance.is_nan() || distance > tolerance {
            return Err(format!("element {i} is {a:?} instead of {b:?}, {distance:e} apart"));
        }
    }
    Ok(())
}

/// Numbers in about [−5, 5] that depend on nothing but their place.
pub fn noise(seed: u32, len: usize) -> Vec<f32> {
    (0..len.div_ceil(4) as u32).flat_map(|i| normals(philox([seed, i, 0, 0], [7, 8]))).take(len).collect()
}

/// Poses all over the place.
pub fn noisy_poses(seed: u32, len: usize) -> Vec<Pose> {
    noise(seed, 6 * len)
        .chunks_exact(6)
        .map(|x| Pose::new(Quat::from_scaled_axis(Vec3::new(x[3], x[4], x[5])), Vec3::new(x[0], x[1], x[2])))
        .collect()
}

/// Boxes: a fixed one first, then units of one and of two bodies.
pub fn world() -> World {
    let parts = vec![cuboid(Vec3::splat(0.05))];
    let units = [STATIC, 0, 1, 1, 2, STATIC, 2];
    let defs: Vec<BodyDef> = noisy_poses(3, units.len())
        .into_iter()
        .zip(noisy_poses(4, units.len()))
        .zip(units)
        .map(|((start, reference), unit)| BodyDef {
            parts: parts.clone(),
            mass: 1.0,
            inertia: Vec3::ONE,
            unit,
            start,
            reference,
        })
        .collect();
    let world = World::new(&defs, &[1, 2, 4]);
    assert!(world.bodies.iter().any(Body::is_static));
    world
}

/// A stack of three boxes, and one that falls.
pub fn boxes_world() -> World {
    let mut scenario = Scenario::default();
    for level in 0..3 {
        scenario.cuboid(Vec3::splat(0.1), 1.0, Vec3::Y * (0.1 + 0.2 * level as f32), Quat::IDENTITY);
    }
    scenario.cuboid(Vec3::splat(0.1), 1.0, Vec3::new(1.0, 0.3, 0.0), Quat::IDENTITY);
    scenario.world()
}
