//! Kernels `aligned_faces`, `clip_faces` and `single_points`, which are `cpu::narrow_phase::manifold`, `passing`, which
//! is `cpu::narrow_phase::passes`, and `ground`, which is `cpu::narrow_phase::plane_hull`.
//!
//! Where two choices are equally good to the last bit, the kernels and the CPU may choose differently: then normal,
//! deepest point and extent must agree, and it must be rare.

use super::Test;
use super::fixture::{Device, SIZES};
use super::touching::{Touching, world};
use glam::Vec3;
use libtest_mimic::Failed;
use rest3d_gpu::cpu::narrow_phase::{self, tangents};
use rest3d_gpu::gpu::{Manifold, ManifoldPoint};
use rest3d_gpu::world::constants::{LINEAR_SLOP, MAX_MANIFOLD_POINTS, SAME_POINT};

pub const TESTS: &[Test] = &[
    ("manifold::is_its_twin", is_its_twin),
    ("manifold::ground_leaves_what_is_still", ground_leaves_what_is_still),
    ("manifold::notices_an_error", notices_an_error),
];

/// Of positions in metres and of unit normals.
const TOLERANCE: f32 = 1e-5;

/// Of differences of positions that are computed alike, m.
const ROUNDING: f32 = 1e-7;

/// Share of the manifolds that may differ by a choice.
const MOST_CHOICES: f32 = 0.01;

/// How two manifolds compare.
#[derive(Debug, PartialEq)]
enum Likeness {
    Same,
    OtherChoice,
    Different(String),
}

fn compare(head: &Manifold, points: &[ManifoldPoint], expected: &narrow_phase::Manifold, margin: f32) -> Likeness {
    let wanted = expected.points();
    if head.count as usize > MAX_MANIFOLD_POINTS {
        return Likeness::Different(format!("{} points", head.count));
    }
    let found = &points[..head.count as usize];
    let near = |a: Vec3, b: Vec3| a.distance(b) <= TOLERANCE;
    let same = found.len() == wanted.len()
        && found.iter().zip(wanted).all(|(a, b)| {
            near(a.on_a, b.on_a) && near(a.on_b, b.on_b) && (a.separation - b.separation).abs() <= TOLERANCE
        });
    // The normal of two points apart is rounded as much more as they are nearer.
    let rounding = match wanted {
        [point] if point.separation > LINEAR_SLOP => ROUNDING / point.separation,
        _ => 0.0,
    };
    if same && (found.is_empty() || head.normal.distance(expected.normal) <= TOLERANCE + rounding) {
        return Likeness::Same;
    }
    // At the very margin a point may be lost.
    let deepest = |separations: &mut dyn Iterator<Item = f32>| separations.fold(margin, f32::min);
    let depths = [deepest(&mut found.iter().map(|p| p.separation)), deepest(&mut wanted.iter().map(|p| p.separation))];
    if (depths[0] - depths[1]).abs() > 2e-4 {
        return Likeness::Different(format!("deepest {} instead of {}", depths[0], depths[1]));
    }
    if found.is_empty() || wanted.is_empty() {
        return if depths[0].min(depths[1]) > margin - 1e-4 {
            Likeness::OtherChoice
        } else {
            Likeness::Different("no points".into())
        };
    }
    if head.normal.dot(expected.normal) < 0.9999 {
        return Likeness::Different(format!("normal {} instead of {}", head.normal, expected.normal));
    }
    if let ([found], [wanted]) = (found, wanted) {
        // Parallel edges have a point of contact anywhere; the gap between the edges is the same.
        let gaps = [found.on_b - found.on_a, wanted.on_b - wanted.on_a];
        // Of two neighbouring points either may come out as the nearer one, if rounding decides: so far apart they are
        // at most (Pythagoras).
        let apart = wanted.separation > LINEAR_SLOP;
        let equally_near = apart && (gaps[0].length() - gaps[1].length()).abs() <= ROUNDING;
        let aside = (2.0 * ROUNDING * wanted.separation).sqrt();
        return if near(gaps[0], gaps[1]) || (equally_near && gaps[0].distance(gaps[1]) <= aside) {
            Likeness::OtherChoice
        } else {
            Likeness::Different("another point".into())
        };
    }
    let [u, v] = tangents(expected.normal);
    for direction in [u, v, -u, -v] {
        let reach = |points: &mut dyn Iterator<Item = Vec3>| points.map(|p| p.dot(direction)).fold(f32::MIN, f32::max);
        let extents = [reach(&mut found.iter().map(|p| p.on_b)), reach(&mut wanted.iter().map(|p| p.on_b))];
        if (extents[0] - extents[1]).abs() > 4.0 * SAME_POINT {
            return Likeness::Different(format!("extent {} instead of {}", extents[0], extents[1]));
        }
    }
    Likeness::OtherChoice
}

fn is_its_twin(device: &Device) -> Result<(), Failed> {
    let world = world();
    let (capacity, hulls) = (world.capacities.hull_pairs as usize, world.hulls.hulls.len());
    for candidates in SIZES {
        let touching = Touching::new(device, &world, candidates)?;
        touching.set_age(device, &world, 0);
        touching.contacts.steps(0)[..5].iter().for_each(|step| device.run(step));
        let heads = device.fetch(&touching.contacts.manifolds)?;
        let points = device.fetch(&touching.contacts.manifold_points)?;
        let rows =
            heads.chunks_exact(capacity + hulls).zip(points.chunks_exact(MAX_MANIFOLD_POINTS * (capacity + hulls)));
        let (mut all, mut choices, mut single) = (0, 0, 0);
        for (candidate, ((heads, points), expected)) in rows.zip(&touching.expected[0]).enumerate() {
            let pairs = (0..)
                .zip(&expected.manifolds)
                .zip(&expected.hull_pairs)
                .map(|((slot, manifold), pair)| (slot, manifold, expected.margin(&world, pair.pair)));
            let ground = expected.ground.iter().enumerate().map(|(hull, manifold)| (capacity + hull, manifold, 0.1));
            for (slot, manifold, margin) in pairs.chain(ground) {
                let found = &points[MAX_MANIFOLD_POINTS * slot..];
                all += usize::from(manifold.count > 0);
                single += usize::from(manifold.count == 1 && slot < capacity);
                match compare(&heads[slot], found, manifold, margin) {
                    Likeness::Same => {}
                    Likeness::OtherChoice => choices += 1,
                    Likeness::Different(what) => {
                        return Err(format!(
                            "candidate {candidate} of {candidates}, slot {slot}: {what}: {:?} {:?} instead of {manifold:?}",
                            heads[slot], &found[..heads[slot].count.min(8) as usize]
                        )
                        .into());
                    }
                }
            }
        }
        let passing: usize = touching.expected[0].iter().map(|expected| expected.passing).sum();
        eprintln!(
            "{candidates} candidates: {all} manifolds, {single} of one point, {choices} other choices, {passing} dropped"
        );
        if choices as f32 > MOST_CHOICES * all as f32 {
            return Err(format!("{choices} of {all} manifolds differ by a choice").into());
        }
        if candidates > 100 && single < all / 50 {
            return Err("too few contacts of one point".into());
        }
        if candidates > 100 && passing < all / 1000 {
            return Err("too few hulls that pass each other".into());
        }
    }
    Ok(())
}

/// Bodies that keep their contacts with the ground get no new ones.
fn ground_leaves_what_is_still(device: &Device) -> Result<(), Failed> {
    let world = world();
    let (capacity, hulls) = (world.capacities.hull_pairs as usize, world.hulls.hulls.len());
    let touching = Touching::new(device, &world, 65)?;
    touching.set_age(device, &world, 0);
    let still = |i: usize| i % world.bodies.len() % 2 == 1;
    touching.set_still(device, &(0..65 * world.bodies.len()).map(still).collect::<Vec<_>>())?;
    let before = device.fetch(&touching.contacts.manifolds)?;
    device.run(&touching.contacts.steps(0)[4]);
    let after = device.fetch(&touching.contacts.manifolds)?;
    for body in 0..world.bodies.len() {
        for hull in world.hulls_of(body) {
            let slots = (0..65).map(|candidate| candidate * (capacity + hulls) + capacity + hull);
            let same = slots.filter(|slot| before[*slot].count == after[*slot].count).count();
            if same != if still(body) { 65 } else { 0 } {
                return Err(format!("{same} of 65 manifolds of body {body} are as they were").into());
            }
        }
    }
    Ok(())
}

fn notices_an_error(_: &Device) -> Result<(), Failed> {
    let mut expected = narrow_phase::Manifold { normal: Vec3::Y, count: 4, ..Default::default() };
    for (i, slot) in expected.slots.iter_mut().enumerate() {
        slot.on_b = 0.1 * Vec3::new((i & 1) as f32, 0.0, (i >> 1) as f32);
        slot.on_a = slot.on_b;
    }
    let mut points = [ManifoldPoint::default(); MAX_MANIFOLD_POINTS];
    for (point, slot) in points.iter_mut().zip(&expected.slots) {
        (point.on_a, point.on_b) = (slot.on_a, slot.on_b);
    }
    let head = Manifold { normal: Vec3::Y, count: 4 };
    let mut deeper = points;
    deeper[2].separation = -0.001;
    let mut shorter = points;
    (1..4).for_each(|i| shorter[i].on_b.x *= 0.9);
    let cases = [
        (head, points, true),
        (Manifold { normal: Vec3::X, ..head }, points, false),
        (Manifold { count: 0, ..head }, points, false),
        (head, deeper, false),
        (head, shorter, false),
    ];
    for (at, (head, points, same)) in cases.iter().enumerate() {
        let likeness = compare(head, points, &expected, 0.02);
        if (likeness == Likeness::Same) != *same || (likeness == Likeness::OtherChoice) {
            return Err(format!("case {at}: {likeness:?}").into());
        }
    }
    Ok(())
}
