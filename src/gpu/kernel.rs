//! Compiled kernels and what is done with them: bound to buffers once, then recorded and submitted again and again.

use super::buffer::{Buffer, Download};
use super::device::{Gpu, GpuError};
use super::timer::Timer;
use bytemuck::Pod;
use rayon::prelude::*;

/// What the build read off a shader.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// Name of its file without the ending.
    pub name: &'static str,
    /// WGSL without imports.
    pub source: &'static str,
    /// Invocations of a workgroup.
    pub workgroup: [u32; 3],
    /// Bytes of workgroup memory.
    pub workgroup_bytes: u32,
    /// Its buffers, by binding number.
    pub slots: &'static [Slot],
}

/// One buffer of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Name of the variable.
    pub name: &'static str,
    /// How it is used.
    pub access: Access,
    /// Bytes of an element.
    pub bytes: u32,
}

/// How a kernel uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// `var<uniform>`
    Uniform,
    /// `var<storage, read>`
    Read,
    /// `var<storage, read_write>`
    Write,
}

impl Access {
    fn binding(self) -> wgpu::BufferBindingType {
        match self {
            Self::Uniform => wgpu::BufferBindingType::Uniform,
            Self::Read => wgpu::BufferBindingType::Storage { read_only: true },
            Self::Write => wgpu::BufferBindingType::Storage { read_only: false },
        }
    }
}

/// The kernel that adapters without `Gpu::has_waves` refuse and never run.
const WAVES: &str = "solve_waves";

/// A compiled shader.
pub struct Kernel {
    shader: &'static Shader,
    /// None if it is `WAVES` and the adapter refuses it.
    pipeline: Option<wgpu::ComputePipeline>,
    layout: wgpu::BindGroupLayout,
}

/// A kernel with its buffers and the size of its grid.
pub struct Step {
    /// Name of the kernel.
    pub name: &'static str,
    pipeline: Option<wgpu::ComputePipeline>,
    buffers: wgpu::BindGroup,
    workgroups: [u32; 2],
}

/// Compiles shaders in parallel, in their order.
///
/// # Errors
/// With the driver's message for the first shader that it refuses.
pub fn compile_all<const N: usize>(gpu: &Gpu, shaders: [&'static Shader; N]) -> Result<[Kernel; N], GpuError> {
    let kernels: Vec<Kernel> =
        shaders.into_par_iter().map(|shader| Kernel::compile(gpu, shader)).collect::<Result<_, _>>()?;
    kernels.try_into().map_err(|_| GpuError::Device("a kernel was lost".into()))
}

impl Kernel {
    fn compile(gpu: &Gpu, shader: &'static Shader) -> Result<Self, GpuError> {
        let label = Some(shader.name);
        let errors = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let entries: Vec<_> = (shader.slots.iter().enumerate())
            .map(|(binding, slot)| wgpu::BindGroupLayoutEntry {
                binding: binding as u32,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: slot.access.binding(),
                    has_dynamic_offset: false,
                    min_binding_size: std::num::NonZeroU64::new(slot.bytes.into()),
                },
                count: None,
            })
            .collect();
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let compile = || {
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label,
                layout: Some(&pipeline_layout),
                module: &module(gpu, shader),
                entry_point: Some("main"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..Default::default()
                },
                cache: gpu.pipelines.as_ref().map(|pipelines| &pipelines.cache),
            })
        };
        let pipeline = (gpu.has_waves() || shader.name != WAVES).then(compile);
        match pollster::block_on(errors.pop()) {
            Some(error) => Err(GpuError::Device(format!("kernel `{}`: {error}", shader.name))),
            None => Ok(Self { shader, pipeline, layout }),
        }
    }

    /// Binds `buffers`, one a slot, for a grid of at least `invocations`: rows of as many workgroups as the adapter
    /// allows, because it allows fewer in a row than a large batch has.
    pub(super) fn step(&self, gpu: &Gpu, buffers: &[&wgpu::Buffer], invocations: u32) -> Step {
        let entries: Vec<_> = (buffers.iter().enumerate())
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding: binding as u32,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let descriptor =
            wgpu::BindGroupDescriptor { label: Some(self.shader.name), layout: &self.layout, entries: &entries };
        let workgroups = invocations.div_ceil(self.shader.workgroup.iter().product());
        let row = workgroups.min(gpu.limits.max_compute_workgroups_per_dimension);
        Step {
            name: self.shader.name,
            pipeline: self.pipeline.clone(),
            buffers: gpu.device.create_bind_group(&descriptor),
            workgroups: [row, workgroups.div_ceil(row.max(1))],
        }
    }
}

impl Step {
    /// Runs it in a pass.
    pub(super) fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>) {
        let ([x, y], Some(pipeline)) = (self.workgroups, &self.pipeline) else { return };
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.buffers, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }
}

/// Without the guard against endless loops, which costs much on some drivers; all other checks stay.
#[allow(unsafe_code)]
fn module(gpu: &Gpu, shader: &Shader) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(shader.name),
        source: wgpu::ShaderSource::Wgsl(shader.source.into()),
    };
    let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..wgpu::ShaderRuntimeChecks::checked() };
    // SAFETY: every loop in `shaders/` counts towards a bound. The build refuses what has no condition, or one that its
    // counter does not reach; that it counts the right way is for the author to see.
    unsafe { gpu.device.create_shader_module_trusted(descriptor, checks) }
}

/// Work that is submitted together. Each step sees what the steps before it wrote.
pub struct Recorder<'a> {
    gpu: &'a Gpu,
    encoder: wgpu::CommandEncoder,
    timer: Option<&'a Timer>,
    /// How many units of work the present one stands for in the timer's sums; 0 if it is not timed.
    weight: u32,
}

impl<'a> Recorder<'a> {
    /// Nothing to do yet.
    pub fn new(gpu: &'a Gpu) -> Self {
        Self::timed(gpu, None)
    }

    /// The same, and `timer` is told of every step.
    pub fn timed(gpu: &'a Gpu, timer: Option<&'a Timer>) -> Self {
        let encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        Self { gpu, encoder, timer, weight: 1 }
    }

    /// What is recorded from now on is one of many alike, of which the timer need not see all.
    pub(super) fn begin_unit(&mut self) {
        self.weight = self.timer.map_or(0, Timer::next_unit);
    }

    /// What is recorded from now on is done once.
    pub(super) fn end_units(&mut self) {
        self.weight = 1;
    }

    /// Fetches the timer's timestamps; `Timer::collect` reads them once this is submitted.
    pub fn fetch_times(&mut self) {
        if let Some(timer) = self.timer {
            timer.fetch(&mut self.encoder);
        }
    }

    /// Runs the steps one after the other.
    pub fn run<'s>(&mut self, steps: impl IntoIterator<Item = &'s Step>) {
        if let Some(timer) = self.timer.filter(|_| self.weight > 0) {
            return timer.run(&mut self.encoder, self.weight, steps);
        }
        let mut pass = self.encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        steps.into_iter().for_each(|step| step.dispatch(&mut pass));
    }

    /// Runs what is done once, in whatever unit.
    pub(super) fn run_once<'s>(&mut self, steps: impl IntoIterator<Item = &'s Step>) {
        let weight = self.weight;
        self.weight = 1;
        self.run(steps);
        self.weight = weight;
    }

    /// Copies all elements of a buffer to another of the same size.
    pub fn copy<T: Pod>(&mut self, from: &Buffer<T>, to: &Buffer<T>) {
        self.encoder.copy_buffer_to_buffer(&from.raw, 0, &to.raw, 0, from.raw.size());
    }

    /// Copies `len` elements.
    pub fn copy_range<T: Pod>(&mut self, from: (&Buffer<T>, usize), to: (&Buffer<T>, usize), len: usize) {
        let bytes = |elements: usize| (elements * size_of::<T>()) as u64;
        self.encoder.copy_buffer_to_buffer(&from.0.raw, bytes(from.1), &to.0.raw, bytes(to.1), bytes(len));
    }

    /// Fills a buffer with zeros.
    pub fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) {
        self.encoder.clear_buffer(&buffer.raw, 0, None);
    }

    /// Copies the first elements of a buffer to the host.
    pub fn fetch<T: Pod>(&mut self, from: &Buffer<T>, to: &Download<T>) {
        self.encoder.copy_buffer_to_buffer(&from.raw, 0, &to.raw, 0, to.raw.size().min(from.raw.size()));
    }

    /// Copies as many elements as there is room for to the host, from element `first` on.
    pub fn fetch_range<T: Pod>(&mut self, from: &Buffer<T>, first: usize, to: &Download<T>) {
        let bytes = |elements: usize| (elements * size_of::<T>()) as u64;
        self.encoder.copy_buffer_to_buffer(&from.raw, bytes(first), &to.raw, 0, bytes(to.len));
    }

    /// Hands everything to the device, without waiting.
    pub fn submit(self) {
        self.gpu.queue.submit([self.encoder.finish()]);
    }

    /// The same, and what comes next is recorded with the same timer.
    #[must_use]
    pub fn next(self) -> Self {
        let next = Self::timed(self.gpu, self.timer);
        self.submit();
        next
    }
}
