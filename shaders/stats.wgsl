// Kernel `stats`: what an iteration reports; one invocation.

#import batch
#import energy
#import grid

struct Winner {
    energy: Energy,
    iteration: u32,
    candidate: u32,
}

struct Stats {
    best: Energy,
    // Total energies; +∞ if there is none.
    iteration_best: f32,
    elite_mean: f32,
}

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<storage, read> energies: array<Energy>;
@group(0) @binding(2) var<storage, read> order: array<u32>;
@group(0) @binding(3) var<storage, read> elites: array<u32>;
@group(0) @binding(4) var<storage, read> count: u32;
@group(0) @binding(5) var<storage, read> winner: Winner;
@group(0) @binding(6) var<storage, read_write> stats: Stats;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) lane: u32) {
    if (lane > 0u) {
        return;
    }
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        // The row past the candidates is the winner's.
        let row = elites[i];
        sum += select(energies[min(row, batch.candidates - 1u)].total, winner.energy.total, row == batch.candidates);
    }
    let mean = bitcast<u32>(sum / f32(max(count, 1u)));
    stats.best = winner.energy;
    stats.iteration_best = energies[order[0]].total;
    stats.elite_mean = bitcast<f32>(select(mean, INFINITY_BITS, count == 0u));
}
