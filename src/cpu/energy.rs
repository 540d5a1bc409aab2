//! Kernel `energy`: what one simulated candidate costs (the paper's four terms), summed in the order of the bodies.

use crate::world::{
    Energy, EnergyWeights, PenetrationMode, Pose, Status, Velocity, World, angle_between,
    constants::{PRUNING_ANGLE, PRUNING_SHARE, TOUCHING_DEPTH},
};

/// What the simulation of one candidate left behind.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// Pose of every body at placement.
    pub placed: &'a [Pose],
    /// Pose of every body after the last step.
    pub settled: &'a [Pose],
    /// Velocity of every body after step τ.
    pub snapshot: &'a [Velocity],
    /// Deepest overlap of every pair of `World::pairs` at placement, m.
    pub depths_placed: &'a [f32],
    /// The same after the last step.
    pub depths_settled: &'a [f32],
    /// What went wrong.
    pub status: Status,
}

/// Energy of a candidate; the total is +∞ if its simulation is not usable.
pub fn energy(world: &World, weights: &EnergyWeights, trial: &Trial<'_>) -> Energy {
    let (mut stability, mut velocity, mut layout) = (0.0, 0.0, 0.0);
    for (i, body) in world.bodies.iter().enumerate() {
        if body.is_static() {
            continue;
        }
        let (placed, settled, reference) = (&trial.placed[i], &trial.settled[i], &world.reference[i]);
        stability +=
            settled.translation.distance(placed.translation) + angle_between(settled.rotation, placed.rotation);
        velocity += trial.snapshot[i].linear.length();
        // One after the other: drivers regroup a sum of products.
        layout += weights.position * settled.translation.distance(reference.translation);
        layout += angle_between(settled.rotation, reference.rotation);
    }
    let penetration = penetration(trial.depths_placed, weights) + penetration(trial.depths_settled, weights);
    let total = weights.stability * stability
        + weights.velocity * velocity
        + weights.penetration * penetration
        + weights.layout * layout;
    let usable = trial.status.is_usable() && total.is_finite();
    Energy { total: if usable { total } else { f32::INFINITY }, stability, velocity, penetration, layout }
}

/// What a candidate costs at least, whatever comes after its placement and, from step τ on, its velocities then
/// (`snapshot`, nought before): where it settles is off its placement or off the reference by their distance in all.
/// Short of it by more than rounding adds.
pub fn least(
    world: &World,
    weights: &EnergyWeights,
    placed: &[Pose],
    snapshot: &[Velocity],
    depths_placed: &[f32],
) -> f32 {
    let position = weights.stability.min(weights.layout * weights.position);
    let turn = weights.stability.min(weights.layout);
    let mut total = weights.penetration * penetration(depths_placed, weights);
    for (i, body) in world.bodies.iter().enumerate() {
        if !body.is_static() {
            let (placed, reference) = (&placed[i], &world.reference[i]);
            total += position * placed.translation.distance(reference.translation);
            total += turn * (angle_between(placed.rotation, reference.rotation) - PRUNING_ANGLE).max(0.0);
            total += weights.velocity * snapshot[i].linear.length();
        }
    }
    total * (1.0 - PRUNING_SHARE)
}

/// Cost of the overlaps of one layout: the number of body pairs deeper than the touching tolerance, or their depth
/// beyond it in units of `penetration_depth_unit`.
pub fn penetration(depths: &[f32], weights: &EnergyWeights) -> f32 {
    let excess = depths.iter().map(|depth| depth - TOUCHING_DEPTH).filter(|excess| *excess > 0.0);
    match weights.penetration_mode {
        PenetrationMode::Count => excess.count() as f32,
        PenetrationMode::Depth => excess.fold(0.0, |sum, excess| sum + excess / weights.penetration_depth_unit),
    }
}
