//! Random pairs: the twin agrees with the reference, and nothing but the geometry matters.

use crate::fixture::*;
use rest3d_gpu::cpu::narrow_phase::*;
use rest3d_gpu::world::{NarrowPhase, Pose};

#[test]
fn twin_agrees_with_reference_on_random_pairs() {
    let mut random = Random(7);
    let (mut parry_fails, mut bare, mut touching, mut aligned, mut overlapping) = (0, 0, 0, 0, 0);
    for i in 0..10_000 {
        let case = random_case(&mut random);
        check(&case).unwrap_or_else(|e| panic!("pair {i}: {e}"));
        parry_fails += u32::from(Reference.first_attempt_fails(&case.pair(), MARGIN));
        if let (Some(t), Some(r)) = (case.separation(NarrowPhase::Twin), case.separation(NarrowPhase::Reference)) {
            if r.distance > 0.0 {
                touching += 1;
                bare += u32::from(case.manifold(NarrowPhase::Twin).count == 0);
            } else {
                overlapping += 1;
                aligned += u32::from(t.normal.dot(r.normal) > 0.999);
            }
        }
    }
    eprintln!(
        "parry's first answer fails on {parry_fails} of 10000; {bare} of {touching} pairs within the margin but apart have \
         no twin contact; {aligned} of {overlapping} overlapping pairs have the same axis"
    );
    assert!(overlapping > 5000 && touching > 100, "the sample is one-sided");
    assert!(parry_fails < 300, "parry fails on {parry_fails} of 10000 pairs");
    assert!(bare * 100 <= touching, "{bare} of {touching} pairs within the margin have no contact");
    // The others are ties, mostly symmetric hulls in the same place: `check` has compared their depths.
    assert!(aligned * 100 >= overlapping * 90, "only {aligned} of {overlapping} axes agree");
}

#[test]
fn a_shift_of_two_millimetres_is_noticed() {
    let mut random = Random(11);
    let mut noticed = 0;
    for _ in 0..50 {
        let case = random_case(&mut random);
        let before = case.separator(NarrowPhase::Twin).depth(&case.pair(), 0.0);
        if before < 0.01 {
            continue;
        }
        let moved = Case {
            tables: case.tables.clone(),
            poses: [
                case.poses[0],
                Pose::new(
                    case.poses[1].rotation,
                    case.poses[1].translation + case.separation(NarrowPhase::Twin).unwrap().normal * 0.002,
                ),
            ],
        };
        let after = moved.separator(NarrowPhase::Reference).depth(&moved.pair(), 0.0);
        assert!((before - after).abs() > case.tolerance(), "a shift of 2 mm along the axis goes unnoticed");
        noticed += 1;
    }
    assert!(noticed > 10);
}

#[test]
fn swapping_and_moving_both_change_nothing() {
    let mut random = Random(3);
    for i in 0..2000 {
        let case = random_case(&mut random);
        let twin = case.separator(NarrowPhase::Twin);
        let motion = Pose::new(random.rotation(), random.vector());
        let moved = Case { tables: case.tables.clone(), poses: case.poses.map(|p| motion.then(&p)) };
        let depth = twin.depth(&case.pair(), 0.0);
        // Poses are rounded to f32 at coordinates of metres.
        let rounding = 2e-6 * scale(&case);
        assert!((twin.depth(&case.swapped(), 0.0) - depth).abs() <= rounding, "pair {i} swapped: depth {depth}");
        assert!((twin.depth(&moved.pair(), 0.0) - depth).abs() <= 2.0 * rounding, "pair {i} moved: depth {depth}");
    }
}

#[test]
fn the_cache_changes_nothing_but_shallow_axes() {
    let mut random = Random(5);
    for i in 0..3000 {
        let mut case = random_case(&mut random);
        let twin = case.separator(NarrowPhase::Twin);
        let mut cache = PairCache::default();
        let _ = twin.separation(&case.pair(), MARGIN, &mut cache);
        case.poses[1].translation += 0.003 * random.vector();
        let cold = twin.separation(&case.pair(), MARGIN, &mut PairCache::default());
        let warm = twin.separation(&case.pair(), MARGIN, &mut cache);
        match (cold, warm) {
            // A kept axis is certified: exact where the hulls are apart, within twice its depth where they overlap.
            (Some(c), Some(w)) if w.distance >= -1e-4 => {
                assert!(w.distance <= c.distance + 2e-4, "pair {i}: {c:?} {w:?}");
                assert!(c.distance <= w.distance + 2.0 * (-w.distance).max(1e-5), "pair {i}: {c:?} {w:?}");
            }
            // A cached edge pair may separate although its arcs no longer cross by a rounding: both say apart or deep.
            (c, w) => assert_eq!(c.map(|s| s.feature), w.map(|s| s.feature), "pair {i}: {c:?} {w:?}"),
        }
    }
}
