//! What glTF says of the look of its triangles: normals, colours of vertices, base colour and its texture.

use super::accessor::Buffers;
use super::image::decode;
use crate::shape::{Corner, Look, MeshError, Pixels, Skin, Wrap};
use ::gltf::json::accessor::{Accessor, Type};
use ::gltf::json::material::{AlphaMode, PbrBaseColorFactor};
use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::texture::{Info, WrappingMode};
use ::gltf::json::validation::Checked;
use ::gltf::json::{Index, Root};
use glam::{DMat3, DMat4, Vec2, Vec3, Vec4};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Transparent parts of a texture that is to be blended are holes, as far as they cannot be seen at all.
const INVISIBLE: f32 = 0.05;

/// Fills a [`Look`], primitive by primitive.
pub(super) struct LookReader<'a> {
    look: &'a mut Look,
    /// Decoded images; `None` for those that are damaged, so that each is told of once.
    images: BTreeMap<usize, Option<Arc<Pixels>>>,
}

impl<'a> LookReader<'a> {
    pub fn new(look: &'a mut Look) -> Self {
        Self { look, images: BTreeMap::new() }
    }

    /// The look of one primitive, given its triangles as vertex numbers of its own. `transform` takes it to the mesh.
    pub fn read_primitive(
        &mut self,
        root: &Root,
        buffers: &mut Buffers<'_>,
        primitive: &Primitive,
        transform: DMat4,
        triangles: impl Iterator<Item = [u32; 3]>,
    ) {
        let material = primitive.material.and_then(|index| root.get(index));
        let base = material.map(|material| &material.pbr_metallic_roughness);
        let texture = base.and_then(|base| base.base_color_texture.as_ref());
        let mut attribute = |semantic: Semantic, kinds: &[Type]| -> Vec<Vec4> {
            let Some(&index) = primitive.attributes.get(&Checked::Valid(semantic.clone())) else { return Vec::new() };
            self.vectors(buffers, index, kinds, &semantic)
        };
        let normals = attribute(Semantic::Normals, &[Type::Vec3]);
        let colors = attribute(Semantic::Colors(0), &[Type::Vec3, Type::Vec4]);
        let uvs =
            texture.map_or_else(Vec::new, |texture| attribute(Semantic::TexCoords(texture.tex_coord), &[Type::Vec2]));
        let cutoff = material.map_or(0.0, |material| match material.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => material.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0),
            Checked::Valid(AlphaMode::Blend) => INVISIBLE,
            _ => 0.0,
        });
        let color = base.map(|base| base.base_color_factor).filter(|color| color.0 != PbrBaseColorFactor::default().0);
        let texture = texture.filter(|_| !uvs.is_empty()).and_then(|texture| self.texture(root, buffers, texture));
        let color = color.map(|color| Vec4::from_array(color.0)).filter(|color| color.is_finite());
        self.look.skins.push(Skin { color, tinted: !colors.is_empty(), texture, cutoff });
        let skin = self.look.skins.len() as u32 - 1;
        // Normals keep at a right angle to a surface that is stretched.
        let turn = DMat3::from_mat4(transform).inverse().transpose();
        let corner = |i: u32| {
            let i = i as usize;
            let normal = normals.get(i).map_or(Vec3::ZERO, |n| (turn * n.truncate().as_dvec3()).as_vec3());
            let uv = uvs.get(i).map(|uv| Vec2::new(uv.x, uv.y)).filter(|uv| uv.is_finite());
            let color = colors.get(i).copied().filter(|color| color.is_finite());
            Corner {
                normal: normal.try_normalize().unwrap_or(Vec3::ZERO),
                uv: uv.unwrap_or_default(),
                color: color.unwrap_or(Vec4::ONE).clamp(Vec4::ZERO, Vec4::ONE),
            }
        };
        for triangle in triangles {
            self.look.push(triangle.map(corner), skin);
        }
    }

    /// The elements of an attribute; none, and a note, if they cannot be read.
    fn vectors(
        &mut self,
        buffers: &mut Buffers<'_>,
        index: Index<Accessor>,
        kinds: &[Type],
        semantic: &Semantic,
    ) -> Vec<Vec4> {
        buffers.vectors(index, kinds).unwrap_or_else(|error| {
            self.note(&format!("{semantic:?}"), &error.problem, "drawn without");
            Vec::new()
        })
    }

    fn texture(&mut self, root: &Root, buffers: &mut Buffers<'_>, info: &Info) -> Option<(Arc<Pixels>, [Wrap; 2])> {
        let texture = root.get(info.index)?;
        let wrap = texture.sampler.and_then(|sampler| root.get(sampler)).map_or_else(Default::default, |sampler| {
            [&sampler.wrap_s, &sampler.wrap_t].map(|wrap| match wrap {
                Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
                Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
                _ => Wrap::Repeat,
            })
        });
        let index = texture.source.value();
        if !self.images.contains_key(&index) {
            let image = root.get(texture.source).ok_or_else(|| "it is missing".to_owned()).and_then(|image| {
                let told = |error: MeshError| error.problem;
                let bytes = match (image.buffer_view, &image.uri) {
                    (Some(view), _) => buffers.view(view).map_err(told)?,
                    (None, Some(uri)) => buffers.resource(uri).map_err(told)?,
                    (None, None) => return Err("it has no content".into()),
                };
                decode(&bytes)
            });
            let image =
                image.map_err(|problem| self.note(&format!("image {index}"), &problem, "drawn in plain colour"));
            self.images.insert(index, image.ok().map(Arc::new));
        }
        Some((self.images.get(&index)?.clone()?, wrap))
    }

    fn note(&mut self, what: &str, problem: &str, instead: &str) {
        let note = format!("{what}: {problem}; {instead}");
        if !self.look.notes.contains(&note) {
            self.look.notes.push(note);
        }
    }
}
