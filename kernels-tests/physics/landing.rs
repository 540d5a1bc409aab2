//! What falls lands on what is below it, lies flat, and does not pass through.

use super::{both, measured, settings};
use crate::common::hulls::{cuboid, prism};
use crate::common::scenario::{Scenario, any, box_inertia, run};
use glam::{Quat, Vec3};
use rest3d_gpu::world::{Backend, Pose};

const COIN: Vec3 = Vec3::new(0.012, 0.001, 0.012);
const TILE: Vec3 = Vec3::new(0.02, 0.002, 0.02);
const CARD: Vec3 = Vec3::new(0.043, 0.0005, 0.028);

/// Thin things, by their half extents.
fn thin_things() -> [(&'static str, Vec<Vec3>, Vec3); 4] {
    let cube = Vec3::splat(0.01);
    [
        ("coin", prism(COIN.x, COIN.y, 24), COIN),
        ("tile", cuboid(TILE), TILE),
        ("card", cuboid(CARD), CARD),
        ("cube", cuboid(cube), cube),
    ]
}

fn tumbled(number: usize) -> Quat {
    let angle = |j: usize| 3.0 * any(number, j) - 1.5;
    Quat::from_rotation_y(2.0 * angle(0)) * Quat::from_rotation_x(angle(1)) * Quat::from_rotation_z(angle(2))
}

pub fn thin_things_come_to_lie_on_the_ground(backend: &dyn Backend) {
    const STEPS: u32 = 240;
    for (name, hull, half) in thin_things() {
        let (mut deepest, mut fastest) = (0.0f32, 0.0f32);
        for number in 0..24 {
            let turn = tumbled(number);
            let low = hull.iter().map(|&v| (turn * v).y).fold(f32::INFINITY, f32::min);
            // Dropped from up to 15 cm, or begun with a part of it in the ground.
            let lift = if number % 2 == 0 { 0.15 * any(number, 3) } else { -0.3 * half.x * any(number, 3) };
            let mut s = Scenario::default();
            s.body(vec![hull.clone()], 0.01, box_inertia(0.01, half), Pose::new(turn, Vec3::Y * (lift - low)));
            let states = run(backend, &s.world(), &settings(STEPS));
            deepest = deepest.max(-s.lowest(0, states.last().unwrap()));
            fastest = states[STEPS as usize - 40..].iter().map(|(_, v)| v[0].linear.length()).fold(fastest, f32::max);
        }
        measured(&format!("24 drops of a {name}: deepest in the ground after 4 s, m"), deepest, "< 0.0001");
        measured("and its speed, m/s", fastest, 0);
        assert!(deepest < 1e-4, "a {name} lies {deepest} m in the ground");
        assert!(fastest < 2e-3, "a {name} still moves at {fastest} m/s");
    }
}

pub fn thin_things_do_not_pass_through_boards(backend: &dyn Backend) {
    const TOP: f32 = 0.5;
    for (name, hull, half) in thin_things() {
        for (thickness, fixed) in [(0.01, true), (0.01, false), (0.002, true)] {
            let board = Vec3::new(0.3, 0.5 * thickness, 0.2);
            for number in 0..16 {
                let mut s = Scenario::default();
                let at = Vec3::Y * (TOP - board.y);
                if fixed {
                    s.fixed(vec![cuboid(board)], at, Quat::IDENTITY);
                } else {
                    s.cuboid(board, 1.0, at, Quat::IDENTITY);
                    let post = Vec3::new(0.03, 0.5 * (TOP - thickness), 0.15);
                    for x in [-0.25, 0.25] {
                        s.fixed(vec![cuboid(post)], Vec3::new(x, post.y, 0.0), Quat::IDENTITY);
                    }
                }
                let start = Pose::new(tumbled(number), Vec3::Y * (TOP + 0.1 + 0.4 * any(number, 4)));
                let thing = s.body(vec![hull.clone()], 0.01, box_inertia(0.01, half), start);
                let states = run(backend, &s.world(), &settings(90));
                let end = states.last().unwrap().0[thing].translation;
                let kind = if fixed { "fixed" } else { "loose" };
                assert!(end.y > TOP - 1e-3, "{name} {number} is at {end} under a {kind} board of {thickness} m");
            }
        }
    }
}

/// Convex parts of scanned feet have such corners.
pub fn a_corner_within_the_outline_of_a_foot_bears(backend: &dyn Backend) {
    const HALF: Vec3 = Vec3::new(0.15, 0.2, 0.1);
    for settings in both(backend, 600) {
        for inset in [0.0, 0.5, 0.9] {
            for height in [0.0018, 0.004] {
                let tip = Vec3::new(inset * HALF.x, -HALF.y - height, inset * HALF.z);
                let above = [[0.02, 0.0], [-0.02, 0.0], [0.0, -0.02]].map(|[x, z]| tip + Vec3::new(x, 0.1, z));
                let mut s = Scenario::default();
                let peg = above.into_iter().chain([tip]).collect();
                let at = Pose::new(Quat::IDENTITY, Vec3::Y * (HALF.y + height));
                s.body(vec![cuboid(HALF), peg], 5.0, box_inertia(5.0, HALF), at);
                let states = run(backend, &s.world(), &settings);
                let low = s.lowest(0, states.last().unwrap());
                let creep = states[599].0[0].translation.distance(states[500].0[0].translation);
                measured(&format!("foot on a corner of {height} m at {inset}: lowest, m"), low, "> -0.0001");
                assert!(low > -1e-4, "a corner of {height} m at {inset} sinks to {low} m");
                assert!(creep < 1e-5, "a foot on a corner of {height} m at {inset} creeps by {creep} m");
            }
        }
    }
}

/// Contacts are looked for ahead of what moves; air must not stop it.
pub fn what_falls_past_an_edge_falls_freely(backend: &dyn Backend) {
    const STEPS: u32 = 45;
    const HALF: Vec3 = Vec3::new(0.05, 0.05, 0.05);
    for settings in both(backend, STEPS) {
        let fall = |gap: f32, turn: Quat, ledge: bool| {
            let mut s = Scenario::default();
            let start = Vec3::new(0.0, 1.6, 0.0);
            let thing = s.cuboid(HALF, 1.0, start, turn);
            if ledge {
                let reach = |x: f32| turn * Vec3::new(x, 0.0, 0.0) + Vec3::Y;
                s.fixed(vec![cuboid(Vec3::new(0.2, 0.02, 0.3))], reach(HALF.x + gap + 0.2), turn);
                s.fixed(vec![cuboid(Vec3::new(0.2, 0.02, 0.3))], reach(-HALF.x - gap - 0.2), turn);
            }
            run(backend, &s.world(), &settings).into_iter().map(|(poses, _)| poses[thing]).collect::<Vec<_>>()
        };
        for gap in [1e-4, 1e-3, 5e-3] {
            for turn in [Quat::IDENTITY, Quat::from_rotation_y(0.6)] {
                let [free, past] = [false, true].map(|ledge| fall(gap, turn, ledge));
                let off = |(a, b): (&Pose, &Pose)| a.translation.distance(b.translation);
                let most = free.iter().zip(&past).map(off).fold(0.0, f32::max);
                measured(&format!("past an edge at {gap} m: farthest from free fall, m"), most, "< 1e-6");
                assert!(most < 1e-6, "at {gap} m of air: {most} m from free fall");
            }
        }
        let stopped = fall(-1e-3, Quat::IDENTITY, true);
        assert!(stopped[STEPS as usize - 1].translation.y > 1.06, "what does not fit falls through");
    }
}

/// Their edges come down at up to 30 m/s, and must see the ground before they are in it.
pub fn large_boxes_do_not_sink_in(backend: &dyn Backend) {
    for number in 0..40 {
        let half = 0.02 + 1.18 * Vec3::new(any(number, 3), any(number, 4), any(number, 5));
        let mut s = Scenario::default();
        let height = 2.0 + 6.0 * any(number, 6) + half.length();
        s.cuboid(half, 2400.0 * half.element_product(), Vec3::Y * height, tumbled(number));
        let states = run(backend, &s.world(), &settings(180));
        let lowest = states.iter().map(|state| s.lowest(0, state)).fold(f32::INFINITY, f32::min);
        measured(&format!("box {number} of {half} m, deepest in the ground, m"), -lowest, "< 0.001");
        assert!(lowest > -1e-3, "a box of {half} m dropped from {height} m is {lowest} m in the ground");
    }
}

/// What of these places is farthest along `side`.
fn farthest(places: impl Iterator<Item = Vec3>, side: Vec3) -> Vec3 {
    places.max_by(|a, b| a.dot(side).total_cmp(&b.dot(side))).unwrap()
}

/// Largest distance between the same body's places in two runs, m.
fn apart(one: &[Pose], other: &[Pose]) -> f32 {
    one.iter().zip(other).map(|(a, b)| a.translation.distance(b.translation)).fold(0.0, f32::max)
}

fn corners(half: Vec3, pose: Pose) -> impl Iterator<Item = Vec3> {
    cuboid(half).into_iter().map(move |corner| pose.point(corner))
}

/// Seen from above there is air between the two, but none of their faces has it before it.
pub fn tilted_boxes_fall_past_each_other(backend: &dyn Backend) {
    let half = |number, j| 0.02 + 0.28 * Vec3::new(any(number, j), any(number, j + 1), any(number, j + 2));
    let mut most = 0.0f32;
    for number in 0..16 {
        let gap = [5e-4, 2e-3, 5e-3, 0.01][number % 4];
        let side = Quat::from_rotation_y(6.3 * any(number, 20)) * Vec3::X;
        let (thing, other) = (half(number, 5), half(number, 9));
        let start = Pose::new(tumbled(number), Vec3::Y * 12.0);
        let below = 12.0 - thing.length() - other.length() - 2.0 * any(number, 21);
        let turn = tumbled(number + 100);
        let reach = farthest(corners(thing, start), side).dot(side);
        let near = farthest(corners(other, Pose::new(turn, Vec3::ZERO)), -side).dot(side);
        let fall = |is_beside: bool| {
            let mut s = Scenario::default();
            s.cuboid(thing, 1.0, start.translation, start.rotation);
            if is_beside {
                s.fixed(vec![cuboid(other)], Vec3::Y * below + side * (reach + gap - near), turn);
            }
            run(backend, &s.world(), &settings(60)).into_iter().map(|(poses, _)| poses[0]).collect::<Vec<_>>()
        };
        let off = apart(&fall(false), &fall(true));
        most = most.max(off);
        assert!(off < 1e-5, "box {number} is {off} m from free fall beside {gap} m of air");
    }
    measured("tilted boxes past each other: farthest from free fall, m", most, "< 1e-5");
}

/// Boxes that a peg has set spinning come within millimetres of another.
pub fn spinning_boxes_pass_what_they_do_not_reach(backend: &dyn Backend) {
    /// Poses between two steps that are looked at.
    const BETWEEN: usize = 32;
    let mut most = 0.0f32;
    for number in 28..40 {
        let half = 0.03 + 0.3 * Vec3::new(any(number, 5), any(number, 6), any(number, 7));
        let other = 0.01 + 0.25 * Vec3::new(any(number, 8), any(number, 9), any(number, 10));
        let gap = [3e-3, 6e-3][number % 2];
        let turn = tumbled(number);
        let fall = |obstacle: Option<Vec3>| {
            let mut s = Scenario::default();
            s.cuboid(half, 1.0, Vec3::Y * 20.0, Quat::from_rotation_y(any(number, 11)));
            s.fixed(vec![cuboid(Vec3::splat(0.05))], Vec3::new(0.8 * half.x, 19.5 - half.y, 0.0), Quat::IDENTITY);
            if let Some(at) = obstacle {
                s.fixed(vec![cuboid(other)], at, turn);
            }
            run(backend, &s.world(), &settings(80)).into_iter().map(|(poses, _)| poses[0]).collect::<Vec<_>>()
        };
        let free = fall(None);
        let between = |i: usize| {
            let (a, b, share) = (free[i / BETWEEN], free[i / BETWEEN + 1], (i % BETWEEN) as f32 / BETWEEN as f32);
            corners(half, Pose::new(a.rotation.slerp(b.rotation, share), a.translation.lerp(b.translation, share)))
        };
        let side = Quat::from_rotation_y(6.3 * any(number, 20)) * Vec3::X;
        let reach = farthest((0..79 * BETWEEN).flat_map(between), side).dot(side);
        let place = farthest((45 * BETWEEN..70 * BETWEEN).flat_map(between), side);
        let near = farthest(corners(other, Pose::new(turn, Vec3::ZERO)), -side);
        let off = apart(&free, &fall(Some(place - near + side * (reach - place.dot(side) + gap))));
        most = most.max(off);
        assert!(off < 1e-5, "box {number} is {off} m from its way beside {gap} m of air");
    }
    measured("spinning boxes past another: farthest from their way, m", most, "< 1e-5");
}
