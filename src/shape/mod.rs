//! From a mesh to convex parts, mass, centre of mass and inertia.
//!
//! A decomposition error becomes a placement error: parts that bulge make a mug float, parts that cut off feet make it
//! sink. So the surface is cut exactly (`split`), the pieces are merged by the bulge they add (`merge`), the hulls lose
//! vertices where it shows least (`reduce`) and grow until they cover the surface again (`cover`), and both errors are
//! measured (`measure`). In the end every part is padded by less than a tenth of a millimetre (`padding`).

mod bearing;
mod build;
mod cache;
mod category;
mod cluster;
mod convex_hull;
mod convex_polygon;
mod corners;
mod cover;
mod decompose;
mod divide;
mod eigen;
mod hull;
mod inside;
mod look;
mod mass;
mod measure;
mod merge;
mod mesh;
mod obj;
mod padding;
mod planes;
mod read;
mod recut;
mod reduce;
mod slim;
mod soles;
mod solid;
mod split;
mod tolerances;
pub(crate) mod triangle;
mod voxels;

pub use build::{build_shapes, scaled_mesh};
pub use cache::{CACHE_VARIABLE, Cache};
pub use category::{part_budget, typical_mass};
pub use convex_hull::convex_hull;
pub(crate) use convex_polygon::convex_polygon;
pub use corners::four_cornered;
pub use hull::{box_corners, solid_hull};
pub use inside::Inside;
pub use look::{Corner, Look, Pixels, Skin, Wrap};
pub use mass::MassProperties;
pub use measure::Quality;
pub use mesh::{Mesh, MeshError, read_look, read_mesh};
pub use obj::part_obj;
pub use padding::PADDING;

use glam::Vec3;
use std::path::PathBuf;

/// Vertices farther from the mesh's origin than this lose millimetres to rounding, m.
const MAX_REACH: f32 = 1000.0;

/// One convex part.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// 4 to 64 vertices in convex position, scaled mesh frame, m.
    pub vertices: Vec<Vec3>,
}

/// Another decomposition of the same mesh, shrunk onto its surface as most tools make them: what stands only on the
/// facets of one set of parts does not stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// Convex parts, largest first.
    pub parts: Vec<Part>,
    /// Their mass, centre and inertia at uniform density; the mass is the shape's.
    pub mass: MassProperties,
}

/// What stands for a mesh in the simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Convex parts, largest first.
    pub parts: Vec<Part>,
    /// Mass, centre and inertia of the parts at uniform density.
    pub mass: MassProperties,
    /// Two others: by the same method, and by V-HACD; the parts themselves where one finds nothing. None where
    /// `ShapeSettings` want none.
    pub alternatives: Vec<Alternative>,
    /// The scaled mesh, m.
    pub surface: Mesh,
    /// Lowest and highest corner of the scaled mesh, m.
    pub bounds: [Vec3; 2],
    /// How well the parts stand for the mesh.
    pub quality: Quality,
    /// What the user should know: thickened, reduced, not convex.
    pub notes: Vec<String>,
}

/// A mesh to turn into a shape.
#[derive(Clone, Debug)]
pub struct ShapeRequest {
    /// The object's name, for messages.
    pub name: String,
    /// Free text that decides the part budget and the mass class.
    pub category: String,
    /// The mesh file.
    pub mesh: PathBuf,
    /// Metres per mesh unit, all > 0.
    pub scale: Vec3,
    /// kg, if given.
    pub mass: Option<f32>,
    /// Ready-made convex parts in the mesh frame, used instead of a decomposition.
    pub convex_parts: Vec<PathBuf>,
    /// World up in the mesh frame at the input pose. A hint: poses may be tilted.
    pub up: Vec3,
    /// True if something rests on it: its parts follow its tops more closely.
    pub bears: bool,
}

/// Parameters of the decomposition.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeSettings {
    /// Cells of the grid on which free space is measured.
    pub cells: usize,
    /// Pieces are cut for each part of the budget, before merging.
    pub oversplit: f32,
    /// Most pieces before merging.
    pub max_pieces: usize,
    /// Depth of a layer of free space, spread over the whole object, that is not worth more parts, m.
    pub accuracy: f32,
    /// Meshes of more connected components are only cut as a whole.
    pub max_components: usize,
    /// Vertices of a part that suffice where they are accurate to 0.6 mm.
    pub soft_vertices: usize,
    /// Most vertices of a part.
    pub max_vertices: usize,
    /// Most parts; the category may say less.
    pub max_parts: usize,
    /// Parts beyond the category's budget that may be used to keep a compartment open (the paper has none).
    pub extra_parts: usize,
    /// Parts that an object may have so that they follow its surface, above all where others rest on it.
    pub following_parts: usize,
    /// True: parts grow until they cover the mesh. False: their vertices lie on it.
    pub covering: bool,
    /// True: the mesh is cut in other ways, too, as `optimize` needs it.
    pub alternatives: bool,
}

impl ShapeSettings {
    /// The settings of an `Alternative`.
    fn alternative(&self) -> Self {
        Self { oversplit: 2.0, extra_parts: 0, following_parts: 16, covering: false, ..self.clone() }
    }
}

impl Default for ShapeSettings {
    fn default() -> Self {
        Self {
            cells: 500_000,
            oversplit: 4.0,
            max_pieces: 72,
            accuracy: 1e-3,
            max_components: 128,
            soft_vertices: 32,
            max_vertices: 64,
            max_parts: 32,
            extra_parts: 4,
            following_parts: 32,
            covering: true,
            alternatives: true,
        }
    }
}

/// Why a shape could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ShapeError {
    /// The mesh or a ready-made part could not be read.
    #[error("object \"{object}\", field \"{field}\": {source}")]
    Read {
        /// Name of the object.
        object: String,
        /// `mesh` or `convex_parts`.
        field: &'static str,
        /// What is wrong with the file.
        source: MeshError,
    },
    /// The scale makes the mesh so large that its coordinates are no numbers any more.
    #[error("object \"{object}\", field \"scale\": {scale} times {} is not finite: use a smaller scale", file.display())]
    Scale {
        /// Name of the object.
        object: String,
        /// Its scale.
        scale: Vec3,
        /// The mesh or part file.
        file: PathBuf,
    },
    /// The mesh lies so far from its own origin that rounding would spoil it.
    #[error(
        "object \"{object}\", field \"{field}\": {} lies up to {reach:.0} m from its own origin, and {MAX_REACH} m are plausible: \
         centre the mesh, or correct \"scale\"",
        file.display()
    )]
    Far {
        /// Name of the object.
        object: String,
        /// `mesh` or `convex_parts`.
        field: &'static str,
        /// The file.
        file: PathBuf,
        /// Distance of its farthest vertex, m.
        reach: f32,
    },
    /// A ready-made part has nothing to do with the mesh.
    #[error(
        "object \"{object}\", field \"convex_parts\": {} reaches {beyond:.3} m beyond the mesh, more than the mesh is long: \
         parts must be in the frame and unit of the mesh",
        file.display()
    )]
    Part {
        /// Name of the object.
        object: String,
        /// The part's file.
        file: PathBuf,
        /// How far it reaches out of the mesh's box, m.
        beyond: f32,
    },
    /// No hull could be made.
    #[error("object \"{object}\", field \"{field}\": no convex part can be made of it: repair the mesh")]
    Empty {
        /// Name of the object.
        object: String,
        /// `mesh` or `convex_parts`.
        field: &'static str,
    },
}
