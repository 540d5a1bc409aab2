//! Numbers out of the buffers of a glTF file.
//!
//! The `gltf` crate parses the document; its own reader of accessors is not used, because it adds and subtracts the
//! file's numbers unchecked and so panics on damaged files. Every access here is checked.

use super::{MAX_ELEMENTS, Source, bytes_of, error};
use crate::shape::MeshError;
use ::gltf::json::accessor::{Accessor, ComponentType, Type};
use ::gltf::json::buffer::View;
use ::gltf::json::validation::Checked;
use ::gltf::json::{Buffer, Index, Root};
use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use glam::{Vec3, Vec4};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The buffers of one file, loaded when first asked for: those that only serve images need not be there.
pub(super) struct Buffers<'a> {
    source: &'a Source<'a>,
    root: &'a Root,
    /// The binary chunk of a GLB.
    chunk: Option<&'a [u8]>,
    loaded: BTreeMap<usize, Cow<'a, [u8]>>,
}

/// How elements lie in a buffer view.
struct Layout {
    view: Index<View>,
    /// Bytes before the first one.
    offset: u64,
    /// Bytes of one.
    size: usize,
    count: usize,
}

impl<'a> Buffers<'a> {
    pub fn new(source: &'a Source<'a>, root: &'a Root, chunk: Option<&'a [u8]>) -> Self {
        Self { source, root, chunk, loaded: BTreeMap::new() }
    }

    /// Positions: three floats each, or quantized integers.
    pub fn positions(&mut self, index: Index<Accessor>) -> Result<Vec<Vec3>, MeshError> {
        let (accessor, kind) = self.accessor(index, Type::Vec3)?;
        self.elements(accessor, MAX_ELEMENTS, 3 * kind.size(), |bytes| {
            let axis = |i: usize| number(&bytes[i * kind.size()..], kind, accessor.normalized);
            Vec3::new(axis(0), axis(1), axis(2))
        })
    }

    /// Vectors of one of the types `wanted`, of floats or normalized integers; components that it lacks are 1.
    pub fn vectors(&mut self, index: Index<Accessor>, wanted: &[Type]) -> Result<Vec<Vec4>, MeshError> {
        let found = self.root.get(index).map(|accessor| accessor.type_);
        let is = |wanted: &&Type| matches!(found, Some(Checked::Valid(found)) if found == **wanted);
        let wanted = *wanted.iter().find(is).unwrap_or(&Type::Vec4);
        let (accessor, kind) = self.accessor(index, wanted)?;
        let count = wanted.multiplicity();
        self.elements(accessor, MAX_ELEMENTS, count * kind.size(), |bytes| {
            let axis = |i: usize| if i < count { number(&bytes[i * kind.size()..], kind, true) } else { 1.0 };
            Vec4::new(axis(0), axis(1), axis(2), axis(3))
        })
    }

    /// All bytes of a buffer view.
    pub fn view(&mut self, index: Index<View>) -> Result<Vec<u8>, MeshError> {
        let view = self.root.get(index).ok_or_else(|| self.source.damaged("a buffer view is missing"))?;
        let count = usize::try_from(view.byte_length.0).unwrap_or(usize::MAX);
        Ok(self.slices(&Layout { view: index, offset: 0, size: count, count: 1 })?.flatten().copied().collect())
    }

    /// What a URI of the file stands for.
    pub fn resource(&self, uri: &str) -> Result<Vec<u8>, MeshError> {
        load(self.source, uri)
    }

    /// Vertex numbers.
    pub fn indices(&mut self, index: Index<Accessor>) -> Result<Vec<u32>, MeshError> {
        let (accessor, kind) = self.accessor(index, Type::Scalar)?;
        if !matches!(kind, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(self.source.damaged("vertex numbers are not unsigned integers"));
        }
        self.elements(accessor, 3 * MAX_ELEMENTS, kind.size(), |bytes| unsigned(bytes, kind))
    }

    /// An accessor and the type of its components.
    fn accessor(&self, index: Index<Accessor>, wanted: Type) -> Result<(&'a Accessor, ComponentType), MeshError> {
        let number = index.value();
        match self.root.get(index).map(|accessor| (accessor, accessor.type_, accessor.component_type)) {
            Some((accessor, Checked::Valid(found), Checked::Valid(kind))) if found == wanted => Ok((accessor, kind.0)),
            Some(_) => Err(self.source.damaged(format!("accessor {number} is not of type {wanted:?}"))),
            None => Err(self.source.damaged(format!("there is no accessor {number}"))),
        }
    }

    /// The elements of an accessor, the sparse ones put in.
    fn elements<T: Copy + Default>(
        &mut self,
        accessor: &Accessor,
        most: usize,
        size: usize,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, MeshError> {
        let source = self.source;
        let bounded = |count: u64| match usize::try_from(count) {
            Ok(count) if count <= most => Ok(count),
            _ => Err(source.too_large()),
        };
        let count = bounded(accessor.count.0)?;
        let mut values: Vec<T> = match (accessor.buffer_view, &accessor.sparse) {
            (Some(view), _) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                self.slices(&Layout { view, offset, size, count })?.map(&decode).collect()
            }
            (None, Some(_)) => vec![T::default(); count],
            (None, None) => return Err(source.damaged("an accessor has no data")),
        };
        if let Some(sparse) = &accessor.sparse {
            let count = bounded(sparse.count.0)?;
            let Checked::Valid(kind) = sparse.indices.component_type else {
                return Err(source.damaged("sparse indices are of an unknown type"));
            };
            let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset.0);
            let places = Layout { view, offset, size: kind.0.size(), count };
            let places: Vec<u32> = self.slices(&places)?.map(|bytes| unsigned(bytes, kind.0)).collect();
            let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset.0);
            for (place, bytes) in places.into_iter().zip(self.slices(&Layout { view, offset, size, count })?) {
                let value = values.get_mut(place as usize);
                *value.ok_or_else(|| source.damaged("a sparse index is out of range"))? = decode(bytes);
            }
        }
        Ok(values)
    }

    /// The bytes of each element.
    fn slices(&mut self, layout: &Layout) -> Result<impl Iterator<Item = &[u8]>, MeshError> {
        let source = self.source;
        let &Layout { offset, size, count, .. } = layout;
        let view = self.root.get(layout.view).ok_or_else(|| source.damaged("a buffer view is missing"))?;
        let stride = view.byte_stride.map_or(size, |stride| stride.0.max(1));
        let buffer = self.bytes(view.buffer)?;
        let window = || {
            let start = usize::try_from(view.byte_offset.unwrap_or_default().0).ok()?;
            let end = start.checked_add(usize::try_from(view.byte_length.0).ok()?)?;
            let window = buffer.get(start..end)?.get(usize::try_from(offset).ok()?..)?;
            let needed = match count {
                0 => 0,
                _ => stride.checked_mul(count - 1)?.checked_add(size)?,
            };
            (needed <= window.len()).then_some(window)
        };
        let window = window().ok_or_else(|| source.damaged("it breaks off: a buffer is shorter than announced"))?;
        Ok((0..count).map(move |i| &window[i * stride..][..size]))
    }

    fn bytes(&mut self, index: Index<Buffer>) -> Result<&[u8], MeshError> {
        match self.loaded.entry(index.value()) {
            Entry::Occupied(loaded) => Ok(loaded.into_mut()),
            Entry::Vacant(place) => {
                let missing = || self.source.damaged(format!("there is no buffer {}", index.value()));
                let buffer = self.root.get(index).ok_or_else(missing)?;
                Ok(place.insert(match (&buffer.uri, self.chunk) {
                    (Some(uri), _) => load(self.source, uri)?.into(),
                    (None, Some(chunk)) if index.value() == 0 => chunk.into(),
                    (None, _) => return Err(missing()),
                }))
            }
        }
    }
}

/// The content of a buffer that is not in the file's own binary chunk.
fn load(source: &Source<'_>, uri: &str) -> Result<Vec<u8>, MeshError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, data) = data.split_once(',').ok_or_else(|| source.damaged("a data URI has no data"))?;
        if !kind.ends_with(";base64") {
            return Ok(percent_encoding::percent_decode_str(data).collect());
        }
        return BASE64.decode(data).map_err(|e| source.damaged(format!("a data URI is not base64: {e}")));
    }
    if uri.contains("://") {
        let remedy = "put the buffer beside the file, or export as GLB";
        return Err(source.error(format!("the buffer \"{uri}\" is not a local file"), remedy));
    }
    let name = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let path = source.path.parent().unwrap_or(Path::new("")).join(name.as_ref());
    bytes_of(&path).map_err(|e| {
        let remedy = "put the buffer beside the glTF file, or export as GLB";
        error(source.path, format!("its buffer {}: {}", path.display(), e.problem), remedy)
    })
}

fn unsigned(bytes: &[u8], kind: ComponentType) -> u32 {
    match (kind, bytes) {
        (ComponentType::U8, &[a, ..]) => a.into(),
        (ComponentType::U16, &[a, b, ..]) => u16::from_le_bytes([a, b]).into(),
        (_, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]),
        _ => u32::MAX,
    }
}

/// A component of a position; `normalized` integers stand for [0, 1] or [−1, 1].
fn number(bytes: &[u8], kind: ComponentType, normalized: bool) -> f32 {
    let scaled = |value: f32, largest: f32| if normalized { (value / largest).max(-1.0) } else { value };
    match (kind, bytes) {
        (ComponentType::I8, &[a, ..]) => scaled(f32::from(a as i8), 127.0),
        (ComponentType::U8, &[a, ..]) => scaled(f32::from(a), 255.0),
        (ComponentType::I16, &[a, b, ..]) => scaled(f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (ComponentType::U16, &[a, b, ..]) => scaled(f32::from(u16::from_le_bytes([a, b])), 65535.0),
        (ComponentType::F32, &[a, b, c, d, ..]) => f32::from_le_bytes([a, b, c, d]),
        (ComponentType::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]) as f32,
        _ => f32::NAN,
    }
}
