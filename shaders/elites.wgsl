// Kernel `elites`: sorts the candidates by total energy, ties to the lower index.
//
// One workgroup runs a bitonic sorting network over `keys`, pairs (orderable energy, index) padded to a power of two:
// no two are equal, so the order is unique. Counting ranks in parallel needs no barrier, but K² comparisons: 0.8 s for
// 16384 candidates on a software adapter.

#import batch
#import energy
#import update

const SORT_WORKGROUP: u32 = 256u;

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> update: Update;
@group(0) @binding(2) var<storage, read> energies: array<Energy>;
@group(0) @binding(3) var<storage, read_write> keys: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> order: array<u32>;
@group(0) @binding(5) var<storage, read_write> usable: u32;

// True if the pair at rank `i` is a candidate of finite energy.
fn is_usable_rank(i: u32) -> bool {
    return i < batch.candidates && keys[i].x < orderable(INFINITY_BITS);
}

@compute @workgroup_size(SORT_WORKGROUP)
fn main(@builtin(local_invocation_index) lane: u32) {
    let size = 1u << (32u - countLeadingZeros(batch.candidates - 1u));
    for (var i = lane; i < size; i += SORT_WORKGROUP) {
        let key = orderable(bitcast<u32>(energies[min(i, batch.candidates - 1u)].total));
        keys[i] = vec2(select(0xffffffffu, key, i < batch.candidates), i);
    }
    storageBarrier();
    for (var width = 2u; width <= size; width <<= 1u) {
        for (var stride = width >> 1u; stride > 0u; stride >>= 1u) {
            for (var i = lane; i < size / 2u; i += SORT_WORKGROUP) {
                // The lower and the upper end of the i-th pair that is `stride` apart.
                let low = 2u * i - (i & (stride - 1u));
                let a = keys[low];
                let b = keys[low + stride];
                let sorted = a.x < b.x || (a.x == b.x && a.y < b.y);
                if (sorted != ((low & width) == 0u)) {
                    keys[low] = b;
                    keys[low + stride] = a;
                }
            }
            storageBarrier();
        }
    }
    for (var i = lane; i < batch.candidates; i += SORT_WORKGROUP) {
        order[i] = keys[i].y;
        // One rank alone is the last usable one.
        if (is_usable_rank(i) && !is_usable_rank(i + 1u)) {
            usable = min(i + 1u, update.wanted);
        }
    }
    if (lane == 0u && !is_usable_rank(0u)) {
        usable = 0u;
    }
}
