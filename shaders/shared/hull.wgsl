// Tables of convex hulls, the same for all candidates: as `world::HullTables`.

struct Hull {
    first_vertex: u32,
    vertex_count: u32,
    first_face: u32,
    face_count: u32,
    first_edge: u32,
    edge_count: u32,
    // Largest distance of a vertex from the centre, m.
    radius: f32,
    // Centre of the box around it, body frame, m.
    center: vec3<f32>,
    half_extents: vec3<f32>,
}

struct Face {
    // Outward unit normal and offset, body frame.
    plane: vec4<f32>,
    first_corner: u32,
    corner_count: u32,
}

struct Edge {
    // Numbers within the hull.
    vertices: vec2<u32>,
    faces: vec2<u32>,
}
