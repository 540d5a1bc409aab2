//! The pipelines of the painter.

use super::device::{Gpu, GpuError};
use crate::render::{Light, Vertex, View};

#[allow(missing_docs)]
mod shaders {
    use super::{Light, Vertex, View};
    include!(concat!(env!("OUT_DIR"), "/raster.rs"));
}

use shaders::{depths, picture};

/// sRGB, so that samples are blended and averaged in linear light.
pub const COLORS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Shares of light, with a distance that has to be exact.
pub const SHARES: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
pub const DEPTHS: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples of a pixel of the picture.
pub const SAMPLES: u32 = 4;

/// All pipelines.
pub struct Pipelines {
    /// Depths as a light sees them.
    pub depths: wgpu::RenderPipeline,
    /// Shares of light at half the resolution.
    pub shadow: wgpu::RenderPipeline,
    pub holed_shadow: wgpu::RenderPipeline,
    pub solid: wgpu::RenderPipeline,
    pub holed: wgpu::RenderPipeline,
    pub glass: wgpu::RenderPipeline,
    pub ground: wgpu::RenderPipeline,
    pub wall: wgpu::RenderPipeline,
    /// What is the same for a whole picture.
    pub frame: wgpu::BindGroupLayout,
    /// A texture.
    pub cover: wgpu::BindGroupLayout,
    /// The shares of light.
    pub shares: wgpu::BindGroupLayout,
}

impl Pipelines {
    /// Compiles all.
    ///
    /// # Errors
    /// With the driver's message if it refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let errors = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let (frame, cover, shares) = (frame_layout(gpu), cover_layout(gpu), shares_layout(gpu));
        let module = module(gpu, "picture", picture::SOURCE);
        let half = pipeline_layout(gpu, &[Some(&frame), Some(&cover)]);
        let whole = pipeline_layout(gpu, &[Some(&frame), Some(&cover), Some(&shares)]);
        let shadow = |stage| pipeline(gpu, &half, &module, picture::VERTEX, Output::Shares(stage));
        let picture =
            |stage, blended| pipeline(gpu, &whole, &module, picture::VERTEX, Output::Picture { stage, blended });
        let wall = Output::Picture { stage: picture::WALL, blended: true };
        let pipelines = Self {
            depths: depths_pipeline(gpu),
            shadow: shadow(picture::SHADOW),
            holed_shadow: shadow(picture::HOLED_SHADOW),
            solid: picture(picture::SOLID, false),
            holed: picture(picture::HOLED, false),
            glass: picture(picture::SOLID, true),
            ground: picture(picture::GROUND, false),
            wall: pipeline(gpu, &whole, &module, picture::WALL_VERTEX, wall),
            frame,
            cover,
            shares,
        };
        match pollster::block_on(errors.pop()) {
            Some(error) => Err(GpuError::Device(format!("picture: {error}"))),
            None => Ok(pipelines),
        }
    }
}

fn depths_pipeline(gpu: &Gpu) -> wgpu::RenderPipeline {
    let entries = [uniform(0, wgpu::ShaderStages::VERTEX), storage(1, wgpu::ShaderStages::VERTEX)];
    let layout = pipeline_layout(gpu, &[Some(&group_layout(gpu, "depths", &entries))]);
    pipeline(gpu, &layout, &module(gpu, "depths", depths::SOURCE), depths::VERTEX, Output::Depths)
}

/// What a pipeline draws.
#[derive(Clone, Copy)]
enum Output<'a> {
    /// Depths only, as a light sees them: near is small.
    Depths,
    /// Shares of light at half the resolution. Near is large, here and in the picture.
    Shares(&'a str),
    /// The picture.
    Picture { stage: &'a str, blended: bool },
}

/// A pipeline of triangles seen from both sides.
fn pipeline(
    gpu: &Gpu,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    vertex: &str,
    output: Output<'_>,
) -> wgpu::RenderPipeline {
    let (fragment, format, blended, count) = match output {
        Output::Depths => (None, COLORS, false, 1),
        Output::Shares(stage) => (Some(stage), SHARES, false, 1),
        Output::Picture { stage, blended } => (Some(stage), COLORS, blended, SAMPLES),
    };
    let nearer = if fragment.is_some() { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Less };
    let blend = blended.then_some(wgpu::BlendState::ALPHA_BLENDING);
    let targets = [Some(wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL })];
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: fragment.or(Some("depths")),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTHS,
            depth_write_enabled: Some(!blended),
            depth_compare: Some(nearer),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count, ..Default::default() },
        fragment: fragment.map(|stage| wgpu::FragmentState {
            module,
            entry_point: Some(stage),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn module(gpu: &Gpu, name: &str, source: &'static str) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(source.into());
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
}

fn frame_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
    let depths = |binding: u32| {
        let kind = (wgpu::TextureSampleType::Depth, wgpu::TextureViewDimension::D2Array);
        entry(binding, both, image(kind))
    };
    let entries = [
        uniform(0, both),
        storage(1, both),
        depths(2),
        depths(3),
        entry(4, both, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
        storage(5, wgpu::ShaderStages::VERTEX),
    ];
    group_layout(gpu, "frame", &entries)
}

fn cover_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let fragment = wgpu::ShaderStages::FRAGMENT;
    let kind = (wgpu::TextureSampleType::Float { filterable: true }, wgpu::TextureViewDimension::D2);
    let entries = [
        entry(0, fragment, image(kind)),
        entry(1, fragment, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
        uniform(2, fragment),
    ];
    group_layout(gpu, "cover", &entries)
}

fn shares_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let kind = (wgpu::TextureSampleType::Float { filterable: false }, wgpu::TextureViewDimension::D2);
    group_layout(gpu, "shares", &[entry(0, wgpu::ShaderStages::FRAGMENT, image(kind))])
}

fn pipeline_layout(gpu: &Gpu, bind_group_layouts: &[Option<&wgpu::BindGroupLayout>]) -> wgpu::PipelineLayout {
    let descriptor = wgpu::PipelineLayoutDescriptor { label: None, bind_group_layouts, ..Default::default() };
    gpu.device.create_pipeline_layout(&descriptor)
}

fn group_layout(gpu: &Gpu, name: &str, entries: &[wgpu::BindGroupLayoutEntry]) -> wgpu::BindGroupLayout {
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries })
}

fn entry(binding: u32, visibility: wgpu::ShaderStages, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

fn uniform(binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    entry(binding, visibility, buffer(wgpu::BufferBindingType::Uniform))
}

fn storage(binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    entry(binding, visibility, buffer(wgpu::BufferBindingType::Storage { read_only: true }))
}

fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

fn image((sample_type, view_dimension): (wgpu::TextureSampleType, wgpu::TextureViewDimension)) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}
