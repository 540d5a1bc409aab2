//! What is simulated: the bodies of a scene, fewer or more of them, with whole or with cut hulls.

use crate::cpu::{place::place, sample::sample};
use crate::optimize::Rig;
use crate::scene::{Parent, Scene};
use crate::shape::{Shape, convex_hull};
use crate::world::{BodyDef, Pose, STATIC, Stream, World, constants::MAX_HULL_VERTICES};
use glam::Vec3;

/// Standard deviation of the noise on every movable body's start: shift x, y, z in m, axis-angle x, y, z in rad.
pub const NOISE: [f32; 6] = [0.05, 0.005, 0.05, 0.0, 0.0, 0.0];

/// Room between copies of a scene that stand side by side, m: ten standard deviations of the noise.
const GAP: f32 = 0.5;

/// The bodies of a scene, each where the scene has it; every movable one is a unit of its own.
#[derive(Clone, Debug, Default)]
pub struct Subject {
    /// The bodies.
    pub bodies: Vec<BodyDef>,
    /// The movable ones, each after what bears it.
    order: Vec<usize>,
}

impl Subject {
    /// All objects of a scene. `shapes` are theirs, in the scene's order.
    pub fn new(scene: &Scene, shapes: &[Shape]) -> Self {
        let mut units = 0..;
        let bodies = (scene.objects.iter().zip(shapes).enumerate())
            .map(|(i, (object, shape))| {
                let rig = Rig::new(shape);
                let pose = rig.body(&object.pose);
                let unit = if scene.is_static(i) { STATIC } else { units.next().unwrap_or(STATIC) };
                rig.def(unit, pose, pose)
            })
            .collect();
        let is_root = |i: &usize| matches!(scene.objects[*i].parent, Parent::Root(_));
        let mut stack: Vec<usize> = (0..scene.objects.len()).rev().filter(is_root).collect();
        let mut order = Vec::new();
        while let Some(object) = stack.pop() {
            order.push(object);
            let children: Vec<usize> = scene.children(object).collect();
            stack.extend(children.into_iter().rev());
        }
        order.retain(|&object| !scene.is_static(object));
        Self { bodies, order }
    }

    /// How many bodies move.
    pub fn movable(&self) -> usize {
        self.order.len()
    }

    /// So many movable bodies and nothing else: the scene's, each after what bears it, then those of copies beside it.
    #[must_use]
    pub fn with_bodies(&self, count: usize) -> Self {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for body in self.order.iter().map(|&i| &self.bodies[i]) {
            for x in body.parts.iter().flatten().map(|&vertex| body.start.point(vertex).x) {
                (low, high) = (low.min(x), high.max(x));
            }
        }
        let copies = (0..).flat_map(|copy| self.order.iter().map(move |&i| (copy, i)));
        let taken = if self.order.is_empty() { 0 } else { count };
        let bodies = copies.take(taken).enumerate().map(|(unit, (copy, i))| {
            let aside = Vec3::X * (copy as f32 * (high - low + GAP));
            let shifted = |pose: &Pose| Pose::new(pose.rotation, pose.translation + aside);
            let body = &self.bodies[i];
            let (start, reference) = (shifted(&body.start), shifted(&body.reference));
            BodyDef { unit: unit as u32, start, reference, ..body.clone() }
        });
        Self { bodies: bodies.collect(), order: (0..taken).collect() }
    }

    /// The same solids, every hull cut in two across its longest side, `times` times over. One whose halves would have
    /// more corners than a hull may have stays whole.
    #[must_use]
    pub fn with_cut_hulls(&self, times: u32) -> Self {
        let mut cut = self.clone();
        for _ in 0..times {
            for body in &mut cut.bodies {
                body.parts =
                    body.parts.iter().flat_map(|part| halves(part).unwrap_or_else(|| vec![part.clone()])).collect();
            }
        }
        cut
    }

    /// The tables.
    pub fn world(&self) -> World {
        let roots: Vec<u32> =
            (0u32..).zip(&self.bodies).filter(|(_, body)| body.unit != STATIC).map(|(i, _)| i).collect();
        World::new(&self.bodies, &roots)
    }
}

/// Start poses of a population, candidate-major: those that a search with this noise and seed draws first.
pub fn starts(world: &World, candidates: u32, seed: u64) -> Vec<Pose> {
    let width = world.dimensions();
    let (mean, std) = (vec![0.0; width], NOISE.repeat(world.units.len()));
    let mut delta = vec![0.0; width];
    let mut poses = world.start.repeat(candidates as usize);
    for (candidate, placed) in (0..candidates).zip(poses.chunks_exact_mut(world.bodies.len().max(1))) {
        sample(&mean, &std, Stream { seed, stage: 0 }, 0, candidate, &mut delta);
        place(world, &delta, placed);
    }
    poses
}

/// The two halves of a convex hull, cut through the middle of the longest side of its box; none if one of them is no
/// hull.
fn halves(part: &[Vec3]) -> Option<Vec<Vec<Vec3>>> {
    let low = part.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = part.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let axis = (high - low).max_position();
    let height = |p: &Vec3| p[axis] - 0.5 * (low + high)[axis];
    let (below, above): (Vec<Vec3>, Vec<Vec3>) = part.iter().partition(|p| height(p) < 0.0);
    // Where the lines between the two sides meet the plane; those inside the section are no corners of a half.
    let section: Vec<Vec3> =
        (below.iter()).flat_map(|a| above.iter().map(|b| a.lerp(*b, height(a) / (height(a) - height(b))))).collect();
    let hull = |side: Vec<Vec3>| convex_hull(&[side, section.clone()].concat()).map(|(corners, _)| corners);
    let halves: Vec<Vec<Vec3>> = [below, above].into_iter().filter_map(hull).collect();
    (halves.len() == 2 && halves.iter().all(|half| half.len() <= MAX_HULL_VERTICES)).then_some(halves)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::box_corners;

    fn volume(part: &[Vec3]) -> f32 {
        let (vertices, triangles) = convex_hull(part).unwrap_or_default();
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| vertices[i as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// A table with a thing on it, 1 m wide, and something that is held.
    fn subject() -> Subject {
        let body = |half: Vec3, x: f32, y: f32, unit: u32| {
            let start = Pose::new(glam::Quat::IDENTITY, Vec3::new(x, y, 0.0));
            BodyDef { parts: vec![box_corners(half)], mass: 1.0, inertia: Vec3::ONE, unit, start, reference: start }
        };
        let bodies = vec![
            body(Vec3::splat(0.1), 0.0, 0.5, 0),
            body(Vec3::splat(0.1), 9.0, 0.1, STATIC),
            body(Vec3::new(0.5, 0.2, 0.3), 0.0, 0.2, 1),
        ];
        Subject { bodies, order: vec![2, 0] }
    }

    #[test]
    fn halves_are_the_whole() {
        let whole = box_corners(Vec3::new(0.1, 0.3, 0.2));
        let halves = halves(&whole).unwrap_or_default();
        let [below, above] = &halves[..] else { panic!("{halves:?}") };
        assert!((volume(below) + volume(above) - volume(&whole)).abs() < 1e-6);
        assert!((volume(below) - volume(above)).abs() < 1e-6);
        assert!(below.iter().all(|p| p.y <= 1e-6) && above.iter().all(|p| p.y >= -1e-6));
        assert_eq!(subject().with_cut_hulls(3).world().hulls.hulls.len(), 3 * 8);
    }

    #[test]
    fn more_bodies_are_copies_side_by_side() {
        let subject = subject();
        let one = subject.with_bodies(1);
        assert_eq!((one.movable(), one.bodies[0].start), (1, subject.bodies[2].start));
        let many = subject.with_bodies(5);
        let x: Vec<f32> = many.bodies.iter().map(|body| body.start.translation.x).collect();
        assert_eq!(x, [0.0, 0.0, 1.5, 1.5, 3.0]);
        assert_eq!(many.world().units.len(), 5);
        assert_eq!(Subject::default().with_bodies(3).bodies.len(), 0);
    }

    #[test]
    fn noise_shifts_what_moves_and_depends_on_the_candidate_alone() {
        let world = subject().world();
        let (few, many) = (starts(&world, 3, 7), starts(&world, 2000, 7));
        assert_eq!(few, many[..few.len()]);
        assert_ne!(starts(&world, 3, 8), few);
        assert!(many.chunks_exact(3).all(|poses| poses[1] == world.start[1]));
        let shifts: Vec<Vec3> =
            many.iter().step_by(3).map(|pose| pose.translation - world.start[0].translation).collect();
        let variance = shifts.iter().map(|v| *v * *v).sum::<Vec3>() / shifts.len() as f32;
        for (variance, std) in variance.to_array().into_iter().zip(NOISE) {
            assert!((variance.sqrt() / std - 1.0).abs() < 0.1, "{} for {std}", variance.sqrt());
        }
        assert!(many.iter().all(|pose| pose.rotation == glam::Quat::IDENTITY));
    }
}
