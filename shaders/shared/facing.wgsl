// How the two hulls of a pair face each other, and the outlines of faces.

// `Facing::side`, besides 0 and 1, where no face is aligned with the axis, and where the hulls are too far apart.
const NO_FACE: u32 = 2u;
const NO_CONTACT: u32 = 3u;

struct Facing {
    bodies: vec2<u32>,
    hulls: vec2<u32>,
    // The reference face and the face of the other hull that is turned against it, numbers within the hulls.
    faces: vec2<u32>,
    // Hull A (0) or B (1) has the reference face.
    side: u32,
    // Distance within which contacts are made, m.
    margin: f32,
}

// What a face bears and where that ends: as `world::Outline`, one for each face of the tables.
struct Outline {
    // In the table of lines: first the outline's (outward direction and limit), then the planes of the bearing faces.
    first: u32,
    lines: u32,
    bearing: u32,
}
