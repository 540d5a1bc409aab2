//! Meshes with their look, read once for all pictures of a run.

use super::normals::{area, smooth};
use super::texture::Texture;
use crate::scene::{Object, Scene};
use crate::shape::{Corner, Mesh, MeshError, Skin, read_look};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh ready to be drawn, in its own frame and unit.
pub struct Model {
    /// Corners as the file has them.
    pub mesh: Mesh,
    /// Of every triangle; their normals are unit vectors, on the side from which the triangle is counter-clockwise.
    pub corners: Vec<[Corner; 3]>,
    /// Skin of every triangle.
    pub skin: Vec<u32>,
    /// Skins, without their textures.
    pub skins: Vec<Skin>,
    /// Texture of each skin.
    pub textures: Vec<Option<Arc<Texture>>>,
}

/// The models of all meshes that were asked for, by file.
#[derive(Default)]
pub struct Models {
    loaded: BTreeMap<PathBuf, Arc<Model>>,
}

impl Models {
    /// Reads the meshes of a scene that are not there yet, in parallel. Returns what the user should know of their
    /// look.
    ///
    /// # Errors
    /// The first object, in the scene's order, whose mesh cannot be read, with its name.
    pub fn load(&mut self, scene: &Scene) -> Result<Vec<String>, (String, MeshError)> {
        let mut seen = BTreeSet::new();
        let new: Vec<&Object> = (scene.objects.iter())
            .filter(|object| !self.loaded.contains_key(&object.mesh) && seen.insert(&object.mesh))
            .collect();
        let read: Vec<_> = new.par_iter().map(|object| Model::read(&object.mesh)).collect();
        let mut notes = Vec::new();
        for (object, model) in new.into_iter().zip(read) {
            let (model, told) = model.map_err(|error| (object.name.clone(), error))?;
            notes.extend(told.into_iter().map(|note| format!("{}: {note}", object.mesh.display())));
            self.loaded.insert(object.mesh.clone(), Arc::new(model));
        }
        Ok(notes)
    }

    /// The model of a mesh that was loaded.
    pub fn get(&self, mesh: &Path) -> Option<&Arc<Model>> {
        self.loaded.get(mesh)
    }
}

impl Model {
    fn read(path: &Path) -> Result<(Self, Vec<String>), MeshError> {
        let (mesh, look) = read_look(path)?;
        let mut corners = look.corners;
        if corners.iter().flatten().any(|corner| corner.normal == Vec3::ZERO) {
            for (corners, normals) in corners.iter_mut().zip(smooth(&mesh.vertices, &mesh.triangles)) {
                for (corner, normal) in corners.iter_mut().zip(normals) {
                    if corner.normal == Vec3::ZERO {
                        corner.normal = normal;
                    }
                }
            }
        }
        // Normals of files and the order of corners do not always agree; what is seen from where must.
        for (corners, triangle) in corners.iter_mut().zip(&mesh.triangles) {
            let face = area(triangle.map(|i| mesh.vertices[i as usize]));
            for corner in corners {
                if corner.normal.dot(face) < 0.0 {
                    corner.normal = -corner.normal;
                }
            }
        }
        let texture = |skin: &mut Skin| skin.texture.take().map(|(image, wrap)| Arc::new(Texture::new(&image, wrap)));
        let bare: Vec<bool> = look.skins.iter().map(Skin::is_bare).collect();
        let mut skins = look.skins;
        let textures: Vec<_> = skins.par_iter_mut().map(texture).collect();
        for (skin, _) in skins.iter_mut().zip(bare).filter(|(_, bare)| !bare) {
            skin.color.get_or_insert(glam::Vec4::ONE);
        }
        Ok((Self { mesh, corners, skin: look.skin, skins, textures }, look.notes))
    }
}
