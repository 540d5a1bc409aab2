// What the candidates of a workgroup with an invocation each have to tell one another: they go through their loops
// together. Import it below the bindings: the kernel has `batch`, `sim` and `patch_counts`.

#import sim

var<workgroup> most_patches: atomic<u32>;

// How many patches a candidate has, and how many any of its workgroup. What is no candidate has none, but must ask, too.
fn patches_of(candidate: u32, lane: u32) -> vec2<u32> {
    let own = min(patch_counts[min(candidate, batch.candidates - 1u)], patch_rows(sim.contacts));
    let count = select(own, 0u, candidate >= batch.candidates);
    if (lane == 0u) {
        atomicStore(&most_patches, 0u);
    }
    workgroupBarrier();
    atomicMax(&most_patches, count);
    workgroupBarrier();
    return vec2(count, atomicLoad(&most_patches));
}
