//! How a mesh looks: normals, colours and textures as its file gives them. Only pictures need it.

use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;

/// How the triangles of a [`Mesh`](super::Mesh) look, in their order.
#[derive(Clone, Debug, Default)]
pub struct Look {
    /// The three corners of every triangle.
    pub corners: Vec<[Corner; 3]>,
    /// Index into `skins` of every triangle.
    pub skin: Vec<u32>,
    /// What the triangles are covered with.
    pub skins: Vec<Skin>,
    /// What could not be read and how it is drawn instead, in whole sentences.
    pub notes: Vec<String>,
}

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Unit normal in the mesh's frame; zero if the file gives none.
    pub normal: Vec3,
    /// Place in the texture; (0, 0) is its upper left.
    pub uv: Vec2,
    /// Linear red, green, blue and opacity; white if the file gives none.
    pub color: Vec4,
}

impl Default for Corner {
    fn default() -> Self {
        Self { normal: Vec3::ZERO, uv: Vec2::ZERO, color: Vec4::ONE }
    }
}

/// What a part of a mesh is covered with. The product of all that is given is seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Linear red, green, blue and opacity.
    pub color: Option<Vec4>,
    /// True if the corners have colours.
    pub tinted: bool,
    /// The image, with how it goes on beyond its edges across and down.
    pub texture: Option<(Arc<Pixels>, [Wrap; 2])>,
    /// Where the texture is less opaque than this, there is a hole.
    pub cutoff: f32,
}

impl Skin {
    /// True if the file says nothing of its colour.
    pub fn is_bare(&self) -> bool {
        self.color.is_none() && !self.tinted && self.texture.is_none()
    }
}

/// A decoded image: sRGB colours and opacity, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Columns, above 0.
    pub width: u32,
    /// Rows, above 0.
    pub height: u32,
    /// `width · height` of red, green, blue, opacity.
    pub rgba: Vec<u8>,
}

/// How a texture goes on beyond its edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Wrap {
    /// From the other edge on.
    #[default]
    Repeat,
    /// Backwards.
    Mirror,
    /// With the colour of the edge.
    Clamp,
}

impl Look {
    /// Adds a triangle.
    pub(super) fn push(&mut self, corners: [Corner; 3], skin: u32) {
        self.corners.push(corners);
        self.skin.push(skin);
    }

    /// Makes it cover `triangles`: formats that know no looks leave it empty.
    pub(super) fn complete(&mut self, triangles: usize) {
        if self.skins.is_empty() {
            self.skins.push(Skin::default());
        }
        self.corners.resize(triangles, Default::default());
        self.skin.resize(triangles, 0);
    }
}
