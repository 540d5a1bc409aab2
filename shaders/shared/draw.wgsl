// Names the random numbers of one iteration.

struct Draw {
    key_low: u32,
    key_high: u32,
    stage: u32,
    iteration: u32,
    // 1: candidate 0 is the mean itself.
    sample_mean: u32,
    // 1: candidates 2i and 2i + 1 mirror each other about the mean.
    antithetic: u32,
}
