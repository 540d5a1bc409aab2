//! Typed buffers: they are made once, before the search begins.

use super::device::{Gpu, GpuError};
use bytemuck::Pod;
use std::marker::PhantomData;
use std::sync::atomic::Ordering;
use std::sync::mpsc;

/// `len` elements of `T` on the device.
pub struct Buffer<T> {
    pub(super) raw: wgpu::Buffer,
    len: usize,
    element: PhantomData<T>,
}

/// A buffer as a kernel's `var<uniform>`.
#[derive(Clone, Copy)]
pub struct Uniform<'a, T>(pub(super) &'a wgpu::Buffer, PhantomData<T>);

/// A buffer as a kernel's `var<storage, read>`.
#[derive(Clone, Copy)]
pub struct Read<'a, T>(pub(super) &'a wgpu::Buffer, PhantomData<T>);

/// A buffer as a kernel's `var<storage, read_write>`.
#[derive(Clone, Copy)]
pub struct Write<'a, T>(pub(super) &'a wgpu::Buffer, PhantomData<T>);

impl<T: Pod> Buffer<T> {
    /// Zeroed memory for `len` elements; an empty buffer holds one, because devices know no empty ones.
    ///
    /// # Errors
    /// If that is more than the adapter allows in one buffer.
    pub fn new(gpu: &Gpu, name: &str, len: usize) -> Result<Self, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::UNIFORM
            | wgpu::BufferUsages::COPY_SRC
            | wgpu::BufferUsages::COPY_DST;
        let bytes = (len.max(1) * size_of::<T>()) as u64;
        let most = gpu.report().max_binding_bytes;
        if bytes > most {
            return Err(GpuError::Capacity(format!(
                "{name}: {} KiB, but a buffer of {} holds at most {} KiB; use fewer candidates, fewer or simpler \
                 objects, or --backend cpu",
                bytes.div_ceil(1024),
                gpu.report().name,
                most >> 10
            )));
        }
        gpu.made.fetch_add(bytes, Ordering::Relaxed);
        let descriptor = wgpu::BufferDescriptor { label: Some(name), size: bytes, usage, mapped_at_creation: false };
        Ok(Self { raw: gpu.device.create_buffer(&descriptor), len, element: PhantomData })
    }

    /// A copy of `data`.
    ///
    /// # Errors
    /// As `new`.
    pub fn from_slice(gpu: &Gpu, name: &str, data: &[T]) -> Result<Self, GpuError> {
        let buffer = Self::new(gpu, name, data.len())?;
        buffer.upload(gpu, data);
        Ok(buffer)
    }

    /// Overwrites the first elements, before anything that is submitted later.
    pub fn upload(&self, gpu: &Gpu, data: &[T]) {
        gpu.queue.write_buffer(&self.raw, 0, bytemuck::cast_slice(data));
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// True if it was made for no element.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// To be bound as `var<uniform>`.
    pub fn uniform(&self) -> Uniform<'_, T> {
        Uniform(&self.raw, PhantomData)
    }

    /// To be bound as `var<storage, read>`.
    pub fn read(&self) -> Read<'_, T> {
        Read(&self.raw, PhantomData)
    }

    /// To be bound as `var<storage, read_write>`.
    pub fn write(&self) -> Write<'_, T> {
        Write(&self.raw, PhantomData)
    }
}

/// Memory of the host's side into which buffers of `len` elements, or a picture, are fetched.
pub struct Download<T> {
    pub(super) raw: wgpu::Buffer,
    pub(super) len: usize,
    element: PhantomData<T>,
}

impl<T: Pod> Download<T> {
    /// Room for `len` elements.
    pub fn new(gpu: &Gpu, name: &str, len: usize) -> Self {
        let raw = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size: (len.max(1) * size_of::<T>()) as u64,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self { raw, len, element: PhantomData }
    }

    /// Waits for the device, and hands out what was fetched.
    ///
    /// # Errors
    /// If the device failed.
    pub fn take(&self, gpu: &Gpu) -> Result<Vec<T>, GpuError> {
        let (sender, mapped) = mpsc::channel();
        self.raw.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            let _ = sender.send(result);
        });
        gpu.wait()?;
        let failed = |error: &dyn std::fmt::Display| GpuError::Device(format!("cannot be read: {error}"));
        mapped.recv().map_err(|error| failed(&error))?.map_err(|error| failed(&error))?;
        let range = self.raw.slice(..).get_mapped_range().map_err(|error| failed(&error))?;
        let mut data = bytemuck::pod_collect_to_vec(&range);
        data.truncate(self.len);
        drop(range);
        self.raw.unmap();
        Ok(data)
    }
}
