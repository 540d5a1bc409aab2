//! Translates checked shaders for every platform that wgpu reaches, so that none is broken unseen by those who build on
//! another: Metal, DirectX 12, Vulkan, WebGPU.

use crate::check::{parse, report};
use crate::compose::Composed;
use naga::Module;
use naga::back::{hlsl, msl, spv, wgsl};
use naga::valid::ModuleInfo;

/// What each platform has against the shader.
pub fn translate(shader: &Composed, module: &Module, info: &ModuleInfo) -> Vec<String> {
    let results = [
        ("Metal", metal(module, info)),
        ("DirectX 12", directx(module, info)),
        ("Vulkan", vulkan(module, info)),
        ("WebGPU", webgpu(shader, module, info)),
    ];
    let failed = results.into_iter().filter_map(|(platform, result)| Some((platform, result.err()?)));
    failed.map(|(platform, error)| report(shader, &format!("{platform}: {error}"), [])).collect()
}

fn metal(module: &Module, info: &ModuleInfo) -> Result<(), String> {
    let options = msl::Options { lang_version: (2, 4), ..Default::default() };
    let (_, found) = msl::write_string(module, info, &options, &Default::default()).map_err(|e| e.to_string())?;
    found.entry_point_names.into_iter().try_for_each(|entry| entry.map(drop)).map_err(|e| e.to_string())
}

fn directx(module: &Module, info: &ModuleInfo) -> Result<(), String> {
    let (options, pipeline) = (hlsl::Options::default(), hlsl::PipelineOptions::default());
    let mut text = String::new();
    let found =
        hlsl::Writer::new(&mut text, &options, &pipeline).write(module, info, None).map_err(|e| e.to_string())?;
    found.entry_point_names.into_iter().try_for_each(|entry| entry.map(drop)).map_err(|e| e.to_string())
}

fn vulkan(module: &Module, info: &ModuleInfo) -> Result<(), String> {
    module.entry_points.iter().try_for_each(|entry| {
        let pipeline = spv::PipelineOptions { shader_stage: entry.stage, entry_point: entry.name.clone() };
        spv::write_vec(module, info, &spv::Options::default(), Some(&pipeline)).map(drop).map_err(|e| e.to_string())
    })
}

/// Written out and read again, as a browser would.
fn webgpu(shader: &Composed, module: &Module, info: &ModuleInfo) -> Result<(), String> {
    let source = wgsl::write_string(module, info, wgsl::WriterFlags::EXPLICIT_TYPES).map_err(|e| e.to_string())?;
    parse(&Composed { source, origins: Vec::new(), ..shader.clone() }).map(drop)
}
