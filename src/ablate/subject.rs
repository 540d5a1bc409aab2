//! A scene in the states that the variants start from.

use crate::scene::Scene;
use crate::shape::{Mesh, Shape};

/// A scene with the bodies of its objects.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The scene.
    pub scene: Scene,
    /// Its objects' shapes, in the scene's order.
    pub shapes: Vec<Shape>,
}

/// What all variants are run on.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The name of the scene.
    pub name: String,
    /// As it was reconstructed.
    pub raw: Stage,
    /// The same made canonical.
    pub canonical: Stage,
    /// The objects' meshes, in the scene's order, scaled to metres.
    pub meshes: Vec<Mesh>,
    /// The truth with its meshes, if it is known.
    pub reference: Option<(Scene, Vec<Mesh>)>,
}
