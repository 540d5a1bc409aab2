//! Compiled kernels on disk, for drivers that keep none themselves.
//!
//! One file an adapter, beside the cached shapes. It begins with the hash of everything that decides its content and of
//! the content: what another driver, another version or a half-written file left is as good as none, and is replaced.

use super::device::GpuError;
use super::kernels::SHADERS;
use crate::files::write_whole;
use std::fs;
use std::path::{Path, PathBuf};

/// The pipeline cache of an opened adapter.
pub(super) struct Pipelines {
    pub cache: wgpu::PipelineCache,
    file: PathBuf,
    key: blake3::Hash,
    /// What the file holds; none if it was of no use.
    stored: Option<blake3::Hash>,
}

impl Pipelines {
    /// Reads what is in `directory` for the adapter; none where it keeps no pipelines.
    pub fn open(device: &wgpu::Device, info: &wgpu::AdapterInfo, directory: &Path) -> Option<Self> {
        if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
            return None;
        }
        let name = wgpu::util::pipeline_cache_key(info)?;
        let file = directory.join(format!("{name}.pipelines"));
        let key = identity(&[&info.name, &info.driver, &info.driver_info, &format!("{:?}", info.backend)]);
        let known = fs::read(&file).ok().and_then(|bytes| content(&bytes, &key).map(<[u8]>::to_vec));
        let cache = create(device, known.as_deref());
        Some(Self { cache, file, key, stored: known.map(|content| blake3::hash(&content)) })
    }

    /// Writes what was compiled, if that is news. A directory that cannot be written costs time at the next start,
    /// never the run.
    ///
    /// # Errors
    /// What keeps it from being written.
    pub fn store(&self) -> Result<(), GpuError> {
        let Some(content) = self.cache.get_data() else { return Ok(()) };
        let sum = blake3::hash(&content);
        if self.stored == Some(sum) {
            return Ok(());
        }
        let bytes = [seal(&self.key, &content).as_bytes().as_slice(), &content].concat();
        write_whole(&self.file, &bytes)
            .map_err(|error| GpuError::Device(format!("{}: cannot be written: {error}", self.file.display())))
    }
}

/// Hash of what an adapter says of itself, of this version, and of all kernels.
pub fn identity(adapter: &[&str]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    let sources = SHADERS.iter().map(|shader| shader.source);
    for text in adapter.iter().copied().chain([env!("CARGO_PKG_VERSION")]).chain(sources) {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    }
    hasher.finalize()
}

/// What a file starts with.
fn seal(key: &blake3::Hash, content: &[u8]) -> blake3::Hash {
    blake3::keyed_hash(key.as_bytes(), content)
}

/// What a file holds, if it is whole and of this key.
fn content<'a>(bytes: &'a [u8], key: &blake3::Hash) -> Option<&'a [u8]> {
    let (sealed, content) = bytes.split_at_checked(blake3::OUT_LEN)?;
    (seal(key, content).as_bytes() == sealed).then_some(content)
}

#[allow(unsafe_code)]
fn create(device: &wgpu::Device, data: Option<&[u8]>) -> wgpu::PipelineCache {
    let descriptor = wgpu::PipelineCacheDescriptor { label: Some("kernels"), data, fallback: true };
    // SAFETY: `data` is what `PipelineCache::get_data` gave for an adapter and a driver that call themselves the same:
    // its keyed hash has just been checked.
    unsafe { device.create_pipeline_cache(&descriptor) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_whole_and_of_the_same_key_is_used() {
        let [key, other] = ["a card", "another"].map(|name| identity(&[name]));
        let bytes = [seal(&key, b"code").as_bytes().as_slice(), b"code"].concat();
        assert_eq!(content(&bytes, &key), Some(b"code".as_slice()));
        assert_eq!(content(&bytes, &other), None);
        assert_eq!(content(&bytes[..bytes.len() - 1], &key), None);
        assert_eq!(content(&bytes[..7], &key), None);
        let mut damaged = bytes;
        damaged[blake3::OUT_LEN] ^= 1;
        assert_eq!(content(&damaged, &key), None);
    }
}
