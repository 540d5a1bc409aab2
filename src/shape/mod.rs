//! From a mesh to convex parts, mass, centre of mass and inertia.

mod mesh;
mod read;

pub use mesh::{Mesh, MeshError, read_mesh};
