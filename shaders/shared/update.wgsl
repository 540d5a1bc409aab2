// How the distribution follows the elites.

struct Update {
    // ⌈ρK⌉
    wanted: u32,
    // Added to every deviation, m and rad.
    epsilon: f32,
}
