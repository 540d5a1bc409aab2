// What the kernels of the separating-axis search share. They find an axis in turns: the last substep's, faces, edges.

// `Separation::feature` and `HullPair::cache`: kind, and numbers of 12 bits.
const FACE_A: u32 = 1u << 24u;
const FACE_B: u32 = 2u << 24u;
const EDGES: u32 = 3u << 24u;
const KIND: u32 = 3u << 24u;

// Between the kernels: the search goes on, and the axis so far is only the last substep's.
const UNSETTLED: u32 = 1u << 31u;
const REMEMBERED: u32 = 1u << 30u;

// Larger than every length, m.
const FAR: f32 = 1e30;

// Ball inside a hull, body frame, m.
struct Ball {
    center: vec3<f32>,
    radius: f32,
    // How far a face's plane may lie outside its own edges, m.
    slack: f32,
}
