//! Every tolerance and physical constant of the simulator, with its unit and what it does.

/// Length below which two surfaces count as touching, m. Everything else that is a tolerance on lengths derives from it.
pub const LINEAR_SLOP: f32 = 1e-4;

/// Depth up to which two parts only touch and the energy counts no penetration, m (the paper is silent; see `EnergyWeights`).
pub const TOUCHING_DEPTH: f32 = 1e-3;

/// Most vertices of a hull (the paper's limit).
pub const MAX_HULL_VERTICES: usize = 64;

/// Most corners of a face polygon that clipping works on; larger polygons are thinned, supports are not.
pub const MAX_FACE_VERTICES: usize = 32;

/// Faces of a hull whose vertices lie within this distance of one plane are one polygon, m. Too small: manifolds of one
/// triangle, on which stacks creep. Too large: contacts beside the surface.
pub const COPLANAR_DISTANCE: f32 = LINEAR_SLOP;

/// Smallest cosine between two triangles that may share a face polygon (about 2.6°).
pub const COPLANAR_COSINE: f32 = 0.999;

/// Smallest principal moment of inertia, as a share of the largest: a needle would spin without bound in f32.
pub const MIN_INERTIA_RATIO: f32 = 1e-3;
