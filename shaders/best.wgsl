// Kernel `best`: keeps the best candidate ever, and lists the rows that the distribution follows.
//
// One workgroup. Once no candidate of the iteration is better than the winner, the winner takes the place of the worst
// elite. Its adjustment lies in the row after the last candidate's.

#import batch
#import draw
#import energy
#import grid
#import update

struct Winner {
    energy: Energy,
    iteration: u32,
    candidate: u32,
}

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> update: Update;
@group(0) @binding(2) var<uniform> draw: Draw;
@group(0) @binding(3) var<storage, read> energies: array<Energy>;
@group(0) @binding(4) var<storage, read> order: array<u32>;
@group(0) @binding(5) var<storage, read> usable: u32;
@group(0) @binding(6) var<storage, read_write> deltas: array<f32>;
@group(0) @binding(7) var<storage, read_write> winner: Winner;
@group(0) @binding(8) var<storage, read_write> elites: array<u32>;
@group(0) @binding(9) var<storage, read_write> count: u32;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(local_invocation_index) lane: u32) {
    let first = order[0];
    let known = bitcast<u32>(winner.energy.total);
    let better = orderable(bitcast<u32>(energies[first].total)) < orderable(known);
    let again = select(1u, 0u, better || !is_finite(known));
    let rows = again + min(usable, update.wanted - again);
    // Everyone has read the old winner.
    storageBarrier();
    for (var d = lane; d < select(0u, batch.dimensions, better); d += WORKGROUP) {
        deltas[batch.candidates * batch.dimensions + d] = deltas[first * batch.dimensions + d];
    }
    for (var i = lane; i < rows; i += WORKGROUP) {
        elites[i] = select(order[max(i, again) - again], batch.candidates, i < again);
    }
    if (lane == 0u) {
        count = rows;
        if (better) {
            winner = Winner(energies[first], draw.iteration, first);
        }
    }
}
