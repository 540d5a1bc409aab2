// Kernel `energy`: what each simulated candidate costs (the paper's four terms).
//
// One invocation a candidate sums over its bodies and pairs in their order, so that the result depends on nothing else.

#import constants
#import batch
#import body
#import energy
#import grid
#import pose
#import status

struct Weights {
    stability: f32,
    velocity: f32,
    penetration: f32,
    layout_: f32,
    // Per metre inside the layout term.
    position: f32,
    // 0: a penetrating pair costs 1; 1: its depth beyond touching, in units of `depth_unit`.
    penetration_mode: u32,
    // m
    depth_unit: f32,
}

@group(0) @binding(0) var<uniform> batch: Batch;
@group(0) @binding(1) var<uniform> weights: Weights;
@group(0) @binding(2) var<storage, read> bodies: array<Body>;
@group(0) @binding(3) var<storage, read> reference: array<Pose>;
@group(0) @binding(4) var<storage, read> placed: array<Pose>;
@group(0) @binding(5) var<storage, read> settled: array<Pose>;
@group(0) @binding(6) var<storage, read> snapshot: array<Velocity>;
@group(0) @binding(7) var<storage, read> depths_placed: array<f32>;
@group(0) @binding(8) var<storage, read> depths_settled: array<f32>;
@group(0) @binding(9) var<storage, read> statuses: array<u32>;
@group(0) @binding(10) var<storage, read_write> energies: array<Energy>;

// Cost of one pair's overlap, m.
fn overlap(depth: f32) -> f32 {
    let excess = depth - TOUCHING_DEPTH;
    let cost = select(1.0, excess / weights.depth_unit, weights.penetration_mode == 1u);
    return select(0.0, cost, excess > 0.0);
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) workgroups: vec3<u32>) {
    let candidate = invocation(id, workgroups);
    if (candidate >= batch.candidates) {
        return;
    }
    var energy = Energy();
    for (var body = 0u; body < batch.bodies; body++) {
        if (bodies[body].unit == STATIC) {
            continue;
        }
        let i = candidate * batch.bodies + body;
        let at = settled[i];
        energy.stability += distance(at.translation, placed[i].translation)
            + angle_between(at.rotation, placed[i].rotation);
        energy.velocity += length(snapshot[i].linear);
        energy.layout_ += weights.position * distance(at.translation, reference[body].translation);
        energy.layout_ += angle_between(at.rotation, reference[body].rotation);
    }
    var before = 0.0;
    var after = 0.0;
    for (var pair = 0u; pair < batch.pairs; pair++) {
        let i = candidate * batch.pairs + pair;
        before += overlap(depths_placed[i]);
        after += overlap(depths_settled[i]);
    }
    energy.penetration = before + after;
    let total = weights.stability * energy.stability + weights.velocity * energy.velocity
        + weights.penetration * energy.penetration + weights.layout_ * energy.layout_;
    let bits = bitcast<u32>(total);
    let usable = is_usable(statuses[candidate]) && is_finite(bits);
    energy.total = bitcast<f32>(select(INFINITY_BITS, bits, usable));
    energies[candidate] = energy;
}
