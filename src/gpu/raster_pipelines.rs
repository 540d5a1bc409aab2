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
pub const DEPTHS: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples of a pixel of the picture.
pub const SAMPLES: u32 = 4;

/// All pipelines.
pub struct Pipelines {
    /// Depths as a light sees them.
    pub depths: wgpu::RenderPipeline,
    pub solid: wgpu::RenderPipeline,
    pub holed: wgpu::RenderPipeline,
    pub glass: wgpu::RenderPipeline,
    pub ground: wgpu::RenderPipeline,
    pub wall: wgpu::RenderPipeline,
    /// What is the same for a whole picture.
    pub frame: wgpu::BindGroupLayout,
    /// A texture.
    pub cover: wgpu::BindGroupLayout,
}

impl Pipelines {
    /// Compiles all.
    ///
    /// # Errors
    /// With the driver's message if it refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let errors = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let (frame, cover) = (frame_layout(gpu), cover_layout(gpu));
        let module = module(gpu, "picture", picture::SOURCE);
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("picture"),
            bind_group_layouts: &[Some(&frame), Some(&cover)],
            ..Default::default()
        });
        let through = Some(wgpu::BlendState::ALPHA_BLENDING);
        let picture = |stage: &'static str, blend: Option<wgpu::BlendState>| {
            pipeline(gpu, &layout, &module, picture::VERTEX, Some((stage, blend)))
        };
        let pipelines = Self {
            depths: depths_pipeline(gpu),
            solid: picture(picture::SOLID, None),
            holed: picture(picture::HOLED, None),
            glass: picture(picture::SOLID, through),
            ground: picture(picture::GROUND, None),
            wall: picture(picture::WALL, through),
            frame,
            cover,
        };
        match pollster::block_on(errors.pop()) {
            Some(error) => Err(GpuError::Device(format!("picture: {error}"))),
            None => Ok(pipelines),
        }
    }
}

fn depths_pipeline(gpu: &Gpu) -> wgpu::RenderPipeline {
    let entries = [uniform(0, wgpu::ShaderStages::VERTEX), storage(1, wgpu::ShaderStages::VERTEX)];
    let lit = group_layout(gpu, "depths", &entries);
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("depths"),
        bind_group_layouts: &[Some(&lit)],
        ..Default::default()
    });
    pipeline(gpu, &layout, &module(gpu, "depths", depths::SOURCE), depths::VERTEX, None)
}

/// A pipeline of triangles seen from both sides. With a fragment stage it draws the picture, where near is large;
/// without, only depths, where near is small.
fn pipeline(
    gpu: &Gpu,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    vertex: &str,
    fragment: Option<(&str, Option<wgpu::BlendState>)>,
) -> wgpu::RenderPipeline {
    let blended = fragment.is_some_and(|(_, blend)| blend.is_some());
    let nearer = if fragment.is_some() { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Less };
    let count = if fragment.is_some() { SAMPLES } else { 1 };
    let blend = fragment.and_then(|(_, blend)| blend);
    let targets = [Some(wgpu::ColorTargetState { format: COLORS, blend, write_mask: wgpu::ColorWrites::ALL })];
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: fragment.map(|(stage, _)| stage).or(Some("depths")),
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
        fragment: fragment.map(|(stage, _)| wgpu::FragmentState {
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
    let fragment = wgpu::ShaderStages::FRAGMENT;
    let depths = |binding: u32| {
        let kind = (wgpu::TextureSampleType::Depth, wgpu::TextureViewDimension::D2Array);
        entry(binding, fragment, image(kind))
    };
    let entries = [
        uniform(0, both),
        storage(1, fragment),
        depths(2),
        depths(3),
        entry(4, fragment, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
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
