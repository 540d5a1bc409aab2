// Candidates that are simulated at a time, by rank.

struct Portion {
    first: u32,
    count: u32,
}
