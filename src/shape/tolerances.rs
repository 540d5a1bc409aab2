//! What decides how meshes become convex parts, step by step: in metres unless it says otherwise, shares and counts. A
//! change of any of them changes the parts, and needs another `build::ALGORITHM`.

/// The grid of free space.
pub(super) mod solid {
    /// Keeps the grid of a mesh without extent finite, m.
    pub const SMALLEST_CELL: f32 = 1e-5;
    /// Most cells along the longest side, however many are asked for.
    pub const MOST_CELLS: f32 = 192.0;
    /// What is flatter than this share of its longest side counts as so deep when the size of a cell is chosen.
    pub const FLATTEST: f32 = 0.02;
}

/// What of it counts.
pub(super) mod fill {
    /// Depth of free space that the grid cannot tell from a face that runs through the cells, in cells: not counted.
    pub const UNSEEN: f32 = 0.4;
    /// Weight of free space above a surface of the object: things stand there. Below it is mostly legs and air.
    pub const ABOVE: f32 = 2.0;
    /// A hollow whose entrance is narrower than this share of it (a bottle, a teapot, slots in a housing) is filled.
    pub const ENTRANCE: f32 = 0.4;
}

/// Winding numbers.
pub(super) mod inside {
    /// A cluster of triangles this many times its radius away is seen as one dipole (Barill et al. 2018 use 2, with
    /// terms of higher order).
    pub const FAR: f64 = 3.0;
    /// Triangles that are not worth another level of the tree.
    pub const LEAF: usize = 8;
    /// Winding number beyond which a point is inside: half-way between outside and once around.
    pub const INSIDE: f64 = 0.5;
}

/// The decomposition as a whole.
pub(super) mod decompose {
    /// A mesh whose hull has at most this share of free space is its own hull.
    pub const CONVEX: f32 = 0.005;
    /// Bulge of a compartment that is worth a part beyond the budget, in units of the bounding box's volume^(4/3): the
    /// bay of a shelf has twice that, the air between the legs of a table a quarter.
    pub const COMPARTMENT: f32 = 0.004;
    /// What parts share costs so many times what a layer over the whole hull does that holds as much.
    pub const SHARED: f32 = 4.0;
    /// Meshes of more connected components than this are not cut like a cake: they are no bowls.
    pub const CAKE_COMPONENTS: usize = 4;
}

/// Planes along which is cut.
pub(super) mod planes {
    /// Evenly spaced candidate planes for each direction.
    pub const EVEN_CUTS: usize = 9;
    /// Facets that are smaller than this share of the hull's surface part nothing.
    pub const FACE: f32 = 0.02;
    /// Candidate planes for each direction that lie in large flat facets.
    pub const FACET_CUTS: usize = 8;
    /// Cuts are planned on about so many triangles, evenly picked; they are made on all.
    pub const PLANNED: usize = 10_000;
}

/// Cutting a mesh in two.
pub(super) mod split {
    /// Corners nearer to a cut than this share of the largest coordinate lie in it.
    pub const FLAT: f32 = 2e-6;
}

/// Cutting one hull.
pub(super) mod divide {
    /// Most pieces of one hull.
    pub const MOST_PIECES: usize = 64;
}

/// Merging pieces.
pub(super) mod merge {
    /// Sweeps in which every piece may change to another part.
    pub const SWEEPS: usize = 3;
}

/// Cutting anew what reaches into each other.
pub(super) mod recut {
    /// Two pieces are cut anew if they share more than this of the smaller one.
    pub const SHARED: f32 = 0.03;
    /// Points of a piece that are tried for what it shares.
    pub const SAMPLES: usize = 400;
    /// Planes that are tried beside those across the axes and across the way from one to the other: as many, with
    /// normals spread evenly.
    pub const PLANES: usize = 64;
    /// Times that every pair may be cut.
    pub const SWEEPS: usize = 2;
    /// A cut must save more than this share of what the two cost.
    pub const WORTH: f32 = 0.02;
}

/// Cutting parts that hold much free space.
pub(super) mod slim {
    /// A part more must free so much of what all parts hold …
    pub const FREED: f32 = 0.02;
    /// … or bring their centre of mass so much closer to the solid's, in diagonals of the object.
    pub const CLOSER: f32 = 1.5e-3;
    /// A cut may take so many times as much from the parts as it frees: where walls are thin, the grid is unsure of
    /// what is free.
    pub const LOST: f32 = 1.5;
    /// So many parts may be added.
    pub const MORE: usize = 8;
}

/// Cutting parts on which things stand.
pub(super) mod bearing {
    /// A part may stand above the surface by this much in nineteen of twenty places, m.
    pub const TOLERATED: f32 = 1e-3;
    /// Columns along the longer side of a piece at which that is measured.
    pub const COLUMNS: usize = 40;
    /// Cosine with the vertical of the steepest surface on which things rest (60°).
    pub const STEEPEST: f32 = 0.5;
    /// The pieces of one must stand above the surface by less than this share of what it does, by volume and depth.
    pub const WORTH: f32 = 0.8;
}

/// Leaving out vertices.
pub(super) mod reduce {
    /// What is no farther than this from the lowest or highest level of a mesh counts as its foot or top, m …
    pub const BAND: f32 = 2e-3;
    /// … or than this share of its height, if that is more.
    pub const BAND_SHARE: f32 = 2e-3;
    /// A hull with at most `soft` vertices may fall short of the full one by this much, m.
    pub const TOLERANCE: f32 = 0.6e-3;
    /// Below this shortfall nothing is added at all, m.
    pub const NEGLIGIBLE: f32 = 0.1e-3;
    /// Shortfall at feet and tops that weighs more than elsewhere, m …
    pub const SUPPORT_TOLERANCE: f32 = 0.7e-3;
    /// … and how many times as much.
    pub const SUPPORT_WEIGHT: f32 = 6.0;
}

/// Growing parts until they cover the mesh.
pub(super) mod cover {
    /// A part may stand out beyond its full hull by this share of its diagonal before it is worth another part …
    pub const GROWTH: f32 = 0.01;
    /// … but not by less than this, m (what an object stands on by no more: the bottom of a bowl is to be as round as
    /// it is), …
    pub const LEAST_GROWTH: f32 = 1e-3;
    /// … nor by more, m …
    pub const MOST_GROWTH: f32 = 1.5e-3;
    /// … and the two halves must stand out by less than this share of what the whole does, …
    pub const WORTH: f32 = 0.95;
    /// … unless that is more than so many times what it may: then the next cuts may do better …
    pub const FAR_OUT: f32 = 2.0;
    /// … up to so many in a row.
    pub const BLIND_CUTS: u32 = 3;
    /// What a part falls short of its full hull in the end, m.
    pub const SHORT: f32 = 0.02e-3;
    /// Rounds of growing: a moved vertex tilts the faces around it, and the next round sees those.
    pub const ROUNDS: usize = 4;
    /// Sweeps over the faces around a vertex that look for its new place.
    pub const SWEEPS: usize = 32;
    /// A vertex moves at most so many times what its faces lack: the edge of a blade would grow a spike.
    pub const SPIKE: f32 = 4.0;
    /// Cosine with the vertical above which a face is horizontal (about 2.5°).
    pub const HORIZONTAL: f32 = 0.999;
}

/// Flattening what an object stands on.
pub(super) mod soles {
    /// What is no farther above a plane belongs to the sole, m …
    pub const DEPTH: f32 = 0.5e-3;
    /// … or a half or a quarter of it, if that is more than this share of how far the sole reaches around the centre of
    /// mass: what is rounder rolls.
    pub const SLOPE: f32 = 0.04;
    /// How often it is halved.
    pub const HALVINGS: i32 = 2;
    /// Directions in which that reach is measured.
    pub const DIRECTIONS: usize = 64;
    /// What is nearer to a plane lies in it, m.
    pub const FLAT: f32 = 1e-6;
}

/// Faces of four corners where something bears.
pub(super) mod corners {
    /// Most corners of a face of which all engines make contacts.
    pub const MOST: usize = 4;
    /// A face is the one that bears if it lies that near to the direction (cosine, 11°).
    pub const FACING: f32 = 0.98;
    /// Four corners are enough if they hold this share of the outline …
    pub const ENOUGH: f32 = 0.8;
    /// … and those that are given up lie no farther aside of the four than this, m …
    pub const ASIDE: f32 = 6e-3;
    /// … nor reach beyond their plane by more than this, m.
    pub const BEYOND: f32 = 0.02e-3;
    /// So often is a part cut in two …
    pub const CUTS: u32 = 3;
    /// … and in so many ways is that tried: some cuts leave too little on one side.
    pub const TRIES: usize = 8;
    /// A cut leaves this share of the outline on either side, if one does.
    pub const SIDE: f32 = 0.25;
    /// A part becomes no more pieces than this …
    pub const PIECES: usize = 8;
    /// … and none has more vertices.
    pub const VERTICES: usize = 64;
    /// The halves of a part hold all of it but for this share …
    pub const WHOLE: f32 = 1e-3;
    /// … and each more than this.
    pub const LEAST: f32 = 0.02;
}

/// Hulls.
pub(super) mod hull {
    /// Least thickness of a part, m. Half of it lies on either side of a flat sheet: under a millimetre from the
    /// surface.
    pub const MIN_THICKNESS: f32 = 1.9e-3;
    /// More points than this (each vertex about six times) are thinned before their hull is made.
    pub const DENSE: usize = 12_000;
}

/// Hulls of thin or crowded points.
pub(super) mod convex_hull {
    /// A hull is wrong if its triangles are off by more than this share of its volume, or gape by more than this share
    /// of its surface …
    pub const OFF: f64 = 1e-3;
    /// … and a hull of points that were shaken if it is by this share.
    pub const OFF_SHAKEN: f64 = 1e-4;
    /// So far are points shaken, as a share of the largest coordinate: less than a hundredth of a millimetre for a
    /// table.
    pub const SHAKE: f64 = 4e-6;
    /// Ways in which they are shaken before that is given up: 98 of 100 hulls that it helps are right after three.
    pub const SHAKES: usize = 3;
}

/// Mass and inertia.
pub(super) mod mass {
    /// Products of inertia below this share of the largest moment are noise: such a body keeps the mesh's axes.
    pub const ALIGNED: f64 = 1e-2;
}

/// Measuring the result.
pub(super) mod measure {
    /// Points on the parts' faces at which the bulge is measured.
    pub const FACE_SAMPLES: usize = 2000;
    /// At most so many mesh vertices are tested for being covered, besides all feet and tops.
    pub const COVER_SAMPLES: usize = 4000;
    /// Largest volume ratio that is reported: sheets have no volume to compare with.
    pub const MAX_RATIO: f32 = 1000.0;
}

/// The second opinion of V-HACD.
pub(super) mod voxels {
    /// Voxels along the longest side.
    pub const RESOLUTION: u32 = 64;
}

/// From a request to a shape.
pub(super) mod build {
    /// Most parts of an `Alternative`.
    pub const ALTERNATIVE_PARTS: usize = 16;
    /// Parts that leave more of the mesh than this share of its size uncovered are worth a note.
    pub const UNCOVERED: f32 = 0.1;
    /// `up` within this cosine of an axis of the mesh means that axis: input poses are tilted, meshes seldom.
    pub const UP_SNAP: f32 = 0.8;
}
