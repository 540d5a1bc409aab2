// Sizes of the batch. A table of all candidates is candidate-major: entry `candidate * row + i`.

struct Batch {
    candidates: u32,
    bodies: u32,
    pairs: u32,
    // Search dimensions, six a unit.
    dimensions: u32,
}
