// Imported below the binding `vertices`.

// The least dot product of `direction` with any vertex of the hull.
fn lowest(hull: Hull, direction: vec3<f32>) -> f32 {
    var low = FAR;
    for (var i = 0u; i < hull.vertex_count; i++) {
        low = min(low, dot(vertices[hull.first_vertex + i].xyz, direction));
    }
    return low;
}
