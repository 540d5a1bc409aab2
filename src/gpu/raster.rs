//! The painter on a graphics adapter: a pass for every light's map of depths, one at half the resolution for the share
//! of the light that arrives, then one for the picture.
//!
//! Vertices are pulled from storage buffers, so that their layout is checked as that of the kernels' is. Edges are
//! smooth by four samples a pixel. The twin is `cpu::raster`.

use super::adapter::AdapterChoice;
use super::buffer::Download;
use super::device::{Gpu, GpuError};
use super::raster_pipelines::{COLORS, DEPTHS, Pipelines, SAMPLES, SHARES};
use crate::render::{
    BACKGROUND, Batch, Camera, Kind, Light, Painter, Picture, RenderError, SKIES, SKY_SIDE, SUN_SIDE, SUNS, Size,
    Stage, Texture, lights, view,
};
use crate::shape::Wrap;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Triangles drawn from one buffer: a storage buffer of 96 MiB, which every adapter has.
const CHUNK: usize = 1 << 20;
/// Rows are copied to the host in multiples of this, bytes.
const ROW: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

/// Draws on a graphics adapter.
pub struct GpuPainter {
    gpu: Gpu,
    pipelines: Pipelines,
}

impl GpuPainter {
    /// Opens the adapter and compiles the shaders.
    ///
    /// # Errors
    /// If there is no such adapter, or it lacks something.
    pub fn open(choice: &AdapterChoice) -> Result<Self, GpuError> {
        let gpu = Gpu::open(choice)?;
        let pipelines = Pipelines::new(&gpu)?;
        Ok(Self { gpu, pipelines })
    }

    fn draw(&self, stage: &Stage, camera: &Camera, size: Size) -> Result<Picture, GpuError> {
        let device = &self.gpu.device;
        let most = self.gpu.limits.max_texture_dimension_2d;
        if size.width.max(size.height) > most {
            let name = &self.gpu.report().name;
            let message = format!("{name} draws at most {most} pixels a side; take a smaller --size or --backend cpu");
            return Err(GpuError::Capacity(message));
        }
        let lights = lights(stage, camera);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let maps = [("suns", SUN_SIDE, SUNS), ("skies", SKY_SIDE, SKIES)].map(|(name, side, layers)| {
            let extent = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers };
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
            self.texture(name, extent, DEPTHS, usage, 1, 1)
        });
        self.draw_depths(&mut encoder, stage, &lights, &maps);
        let frame = self.frame(stage, camera, size, &lights, &maps);
        let textures = self.textures(stage);
        let shares = self.draw_shares(&mut encoder, stage, size, &frame, &textures);
        let extent = wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let samples = self.texture("samples", extent, COLORS, attachment, 1, SAMPLES);
        let depths = self.texture("depths", extent, DEPTHS, attachment, 1, SAMPLES);
        let resolved = self.texture("picture", extent, COLORS, attachment | wgpu::TextureUsages::COPY_SRC, 1, 1);
        let [r, g, b] = BACKGROUND.as_dvec3().to_array();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &whole(&samples),
                depth_slice: None,
                resolve_target: Some(&whole(&resolved)),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&whole(&depths), 0.0)),
            ..Default::default()
        });
        let shares = self.bind(&self.pipelines.shares, &[wgpu::BindingResource::TextureView(&whole(&shares))]);
        pass.set_bind_group(2, &shares, &[]);
        let eye = (camera.eye - stage.origin).as_vec3();
        for batch in stage.opaque().chain(stage.blended(eye)) {
            let holed = cutoff(stage, &batch) > 0.0;
            pass.set_pipeline(match batch.kind {
                Kind::Solid if holed => &self.pipelines.holed,
                Kind::Solid => &self.pipelines.solid,
                Kind::Ground => &self.pipelines.ground,
                Kind::Glass => &self.pipelines.glass,
                Kind::Wall => &self.pipelines.wall,
            });
            draw_batch(&mut pass, &batch, &frame, &textures);
        }
        drop(pass);
        self.fetch(encoder, &resolved, size)
    }

    /// The depths of what casts shadows, from every light.
    fn draw_depths(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &Stage,
        lights: &[Light],
        [suns, skies]: &[wgpu::Texture; 2],
    ) {
        let positions = self.storage("positions", bytemuck::cast_slice(&stage.casters.positions));
        let corners: &[u8] = bytemuck::cast_slice(&stage.casters.triangles);
        let corners = (!corners.is_empty()).then(|| self.buffer("corners", corners, wgpu::BufferUsages::INDEX));
        for (number, light) in lights.iter().enumerate() {
            let number = number as u32;
            let (map, layer) = if number < SUNS { (suns, number) } else { (skies, number - SUNS) };
            let map = map.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            let light = self.buffer("light", bytemuck::bytes_of(light), wgpu::BufferUsages::UNIFORM);
            let group =
                self.group(&self.pipelines.depths, 0, &[light.as_entire_binding(), positions.as_entire_binding()]);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("depths"),
                depth_stencil_attachment: Some(depth_attachment(&map, 1.0)),
                ..Default::default()
            });
            if let Some(corners) = &corners {
                pass.set_pipeline(&self.pipelines.depths);
                pass.set_bind_group(0, &group, &[]);
                pass.set_index_buffer(corners.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..3 * stage.casters.triangles.len() as u32, 0, 0..1);
            }
        }
    }

    /// The share of the light that arrives where something solid is seen, at half the resolution.
    fn draw_shares(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        stage: &Stage,
        size: Size,
        frame: &[wgpu::BindGroup],
        textures: &[wgpu::BindGroup],
    ) -> wgpu::Texture {
        let [width, height] = [size.width, size.height].map(|side| side.div_ceil(2));
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let shares = self.texture("shares", extent, SHARES, attachment | wgpu::TextureUsages::TEXTURE_BINDING, 1, 1);
        let depths = self.texture("half depths", extent, DEPTHS, attachment, 1, 1);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shares"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &whole(&shares),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&whole(&depths), 0.0)),
            ..Default::default()
        });
        // As far as they count in the picture: an odd side is half a pixel longer.
        pass.set_viewport(0.0, 0.0, 0.5 * size.width as f32, 0.5 * size.height as f32, 0.0, 1.0);
        for batch in stage.opaque() {
            let holed = cutoff(stage, &batch) > 0.0;
            pass.set_pipeline(if holed { &self.pipelines.holed_shadow } else { &self.pipelines.shadow });
            draw_batch(&mut pass, &batch, frame, textures);
        }
        drop(pass);
        shares
    }

    /// What the picture's shader is given, for each chunk of the vertices.
    fn frame(
        &self,
        stage: &Stage,
        camera: &Camera,
        size: Size,
        lights: &[Light],
        maps: &[wgpu::Texture; 2],
    ) -> Vec<wgpu::BindGroup> {
        let view = view(stage, camera, size, lights);
        let view = self.buffer("view", bytemuck::bytes_of(&view), wgpu::BufferUsages::UNIFORM);
        let lights = self.storage("lights", bytemuck::cast_slice(lights));
        let [suns, skies] = [0, 1].map(|i| {
            let dimension = Some(wgpu::TextureViewDimension::D2Array);
            maps[i].create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
        });
        let nearer = self.gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(wgpu::CompareFunction::LessEqual),
            ..Default::default()
        });
        let chunks = stage.vertices.chunks(3 * CHUNK);
        let group = |vertices: &[_]| {
            let vertices = self.storage("vertices", bytemuck::cast_slice::<crate::render::Vertex, u8>(vertices));
            let resources = [
                view.as_entire_binding(),
                lights.as_entire_binding(),
                wgpu::BindingResource::TextureView(&suns),
                wgpu::BindingResource::TextureView(&skies),
                wgpu::BindingResource::Sampler(&nearer),
                vertices.as_entire_binding(),
            ];
            self.bind(&self.pipelines.frame, &resources)
        };
        chunks.map(group).collect()
    }

    /// A white texture for what has none, then those of the stage.
    fn textures(&self, stage: &Stage) -> Vec<wgpu::BindGroup> {
        let white = crate::shape::Pixels { width: 1, height: 1, rgba: vec![255; 4] };
        let white = Texture::new(&white.into(), Default::default());
        let all = [(&white, 0.0)]
            .into_iter()
            .chain(stage.textures.iter().map(|(texture, cutoff)| (texture.as_ref(), *cutoff)));
        all.map(|(texture, cutoff)| {
            let image = self.upload(texture).create_view(&wgpu::TextureViewDescriptor::default());
            let [across, down] = texture.wrap.map(|wrap| match wrap {
                Wrap::Repeat => wgpu::AddressMode::Repeat,
                Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
                Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
            });
            let between = self.gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                address_mode_u: across,
                address_mode_v: down,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            });
            let cutoff = self.buffer("cutoff", bytemuck::bytes_of(&cutoff), wgpu::BufferUsages::UNIFORM);
            let resources = [
                wgpu::BindingResource::TextureView(&image),
                wgpu::BindingResource::Sampler(&between),
                cutoff.as_entire_binding(),
            ];
            self.bind(&self.pipelines.cover, &resources)
        })
        .collect()
    }

    fn upload(&self, texture: &Texture) -> wgpu::Texture {
        let first = &texture.levels[0];
        let extent = wgpu::Extent3d { width: first.width, height: first.height, depth_or_array_layers: 1 };
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let target = self.texture("image", extent, COLORS, usage, texture.levels.len() as u32, 1);
        for (level, image) in texture.levels.iter().enumerate() {
            self.gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &target,
                    mip_level: level as u32,
                    origin: wgpu::Origin3d::ZERO,
                    aspect: wgpu::TextureAspect::All,
                },
                &image.rgba,
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * image.width), rows_per_image: None },
                wgpu::Extent3d { width: image.width, height: image.height, depth_or_array_layers: 1 },
            );
        }
        target
    }

    /// Submits everything and reads the picture.
    fn fetch(
        &self,
        mut encoder: wgpu::CommandEncoder,
        picture: &wgpu::Texture,
        size: Size,
    ) -> Result<Picture, GpuError> {
        let row = (4 * size.width).next_multiple_of(ROW);
        let fetched = Download::<u8>::new(&self.gpu, "fetched", row as usize * size.height as usize);
        encoder.copy_texture_to_buffer(
            picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &fetched.raw,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
            },
            picture.size(),
        );
        self.gpu.queue.submit([encoder.finish()]);
        let bytes = fetched.take(&self.gpu)?;
        let rows = bytes.chunks_exact(row as usize);
        let rgb = rows.flat_map(|row| row[..4 * size.width as usize].chunks_exact(4).flat_map(|pixel| &pixel[..3]));
        Ok(Picture { size, rgb: rgb.copied().collect() })
    }

    fn texture(
        &self,
        name: &str,
        size: wgpu::Extent3d,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
        mip_level_count: u32,
        sample_count: u32,
    ) -> wgpu::Texture {
        self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(name),
            size,
            mip_level_count,
            sample_count,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    }

    /// A storage buffer; an empty one gets zeros, because devices know no empty ones.
    fn storage(&self, name: &str, contents: &[u8]) -> wgpu::Buffer {
        let contents = if contents.is_empty() { &[0; 64] } else { contents };
        self.buffer(name, contents, wgpu::BufferUsages::STORAGE)
    }

    fn buffer(&self, name: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.gpu.device.create_buffer_init(&BufferInitDescriptor { label: Some(name), contents, usage })
    }

    fn group(
        &self,
        pipeline: &wgpu::RenderPipeline,
        index: u32,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        self.bind(&pipeline.get_bind_group_layout(index), resources)
    }

    fn bind(&self, layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource<'_>]) -> wgpu::BindGroup {
        let entries: Vec<_> = (resources.iter().cloned().enumerate())
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource })
            .collect();
        self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }
}

impl Painter for GpuPainter {
    fn describe(&self) -> String {
        let report = self.gpu.report();
        format!("{} ({})", report.name, report.kind)
    }

    fn paint(&self, stage: &Stage, camera: &Camera, size: Size) -> Result<Picture, RenderError> {
        size.check()?;
        self.draw(stage, camera, size).map_err(|error| match error {
            GpuError::Capacity(message) => RenderError::Input(message),
            error => RenderError::Failed(error.to_string()),
        })
    }
}

/// Opacity below which a batch has holes.
fn cutoff(stage: &Stage, batch: &Batch) -> f32 {
    batch.texture.map_or(0.0, |texture| stage.textures[texture].1)
}

/// Draws a batch from the chunks of vertices that it lies in.
fn draw_batch(pass: &mut wgpu::RenderPass<'_>, batch: &Batch, frame: &[wgpu::BindGroup], textures: &[wgpu::BindGroup]) {
    pass.set_bind_group(1, &textures[batch.texture.map_or(0, |texture| texture + 1)], &[]);
    for (chunk, group) in frame.iter().enumerate() {
        let (from, to) = (batch.first.max(chunk * CHUNK), (batch.first + batch.count).min((chunk + 1) * CHUNK));
        if from < to {
            pass.set_bind_group(0, group, &[]);
            let corner = |triangle: usize| 3 * (triangle - chunk * CHUNK) as u32;
            pass.draw(corner(from)..corner(to), 0..1);
        }
    }
}

fn whole(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn depth_attachment(view: &wgpu::TextureView, clear: f32) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store }),
        stencil_ops: None,
    }
}
