//! Choosing an adapter, and what happens when a request cannot be met.

use super::Test;
use super::fixture::Device;
use libtest_mimic::Failed;
use rest3d_gpu::gpu::{AdapterChoice, Buffer, Gpu, GpuError};

pub const TESTS: &[Test] = &[
    ("device::is_found_by_number_kind_and_name", is_found_by_number_kind_and_name),
    ("device::unknown_adapters_are_named", unknown_adapters_are_named),
    ("device::too_large_a_buffer_is_an_error", too_large_a_buffer_is_an_error),
    ("device::a_fault_is_kept_and_told", a_fault_is_kept_and_told),
    ("device::empty_buffers_are_allowed", empty_buffers_are_allowed),
];

fn is_found_by_number_kind_and_name(device: &Device) -> Result<(), Failed> {
    let report = device.gpu.report();
    for text in [report.index.to_string(), report.kind.to_string(), report.name.to_uppercase()] {
        let choice: AdapterChoice = text.parse()?;
        let found = Gpu::open(&choice)?;
        if found.report().kind != report.kind {
            return Err(format!("{text} opens {}", found.report().name).into());
        }
    }
    Ok(())
}

fn unknown_adapters_are_named(device: &Device) -> Result<(), Failed> {
    match Gpu::open(&"no such card".parse()?) {
        Err(GpuError::NoAdapter(message)) if message.contains(&device.gpu.report().name) => Ok(()),
        Err(error) => Err(format!("does not say what there is: {error}").into()),
        Ok(found) => Err(format!("opens {}", found.report().name).into()),
    }
}

fn too_large_a_buffer_is_an_error(device: &Device) -> Result<(), Failed> {
    let len = device.gpu.report().max_binding_bytes as usize / 4 + 1;
    match Buffer::<u32>::new(&device.gpu, "huge", len) {
        Err(GpuError::Capacity(message)) if message.contains("huge") => Ok(()),
        other => Err(format!("{:?}", other.err()).into()),
    }
}

fn a_fault_is_kept_and_told(device: &Device) -> Result<(), Failed> {
    // A device of its own: after a fault it is no good for other tests.
    let gpu = Gpu::open(&AdapterChoice::Index(device.gpu.report().index))?;
    gpu.check()?;
    Buffer::<u32>::new(&gpu, "short", 1)?.upload(&gpu, &[1, 2]);
    match (gpu.check(), gpu.wait()) {
        (Err(GpuError::Device(_)), Err(GpuError::Device(_))) => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

fn empty_buffers_are_allowed(device: &Device) -> Result<(), Failed> {
    let buffer = Buffer::<u32>::from_slice(&device.gpu, "empty", &[])?;
    if device.fetch(&buffer)?.is_empty() { Ok(()) } else { Err("something came out".into()) }
}
