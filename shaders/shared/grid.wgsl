// How invocations are numbered.

const WORKGROUP: u32 = 64u;

// Number of an invocation. Adapters limit a row of the grid to 65535 workgroups, so large grids have several rows.
fn invocation(id: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return id.y * workgroups.x * WORKGROUP + id.x;
}
