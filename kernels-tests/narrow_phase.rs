//! The two narrow phases against each other, against the hulls' extents and against closed forms.
//!
//! `twin` joins nearly coplanar triangles to one face, so its axes may be off by `COPLANAR_DISTANCE` a hull; parry's EPA
//! stops within 1e-5 of the size. Everything random is compared within the sum of the two.
#![allow(clippy::unwrap_used)]

use glam::{Quat, Vec3};
use rest3d_gpu::cpu::narrow_phase::*;
use rest3d_gpu::world::constants::{COPLANAR_DISTANCE, COPLANAR_SHARE};
use rest3d_gpu::world::{HullTables, NarrowPhase, Pose};
use std::path::Path;

/// A small generator (SplitMix64), so that every run sees the same pairs.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.bits() >> 40) as f32 / (1_u64 << 24) as f32
    }
    fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    fn vector(&mut self) -> Vec3 {
        loop {
            let v = Vec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if v.length_squared() <= 1.0 && v.length_squared() > 1e-4 {
                return v;
            }
        }
    }
    fn rotation(&mut self) -> Quat {
        Quat::from_axis_angle(self.vector().normalize(), self.between(0.0, std::f32::consts::PI))
    }
}

fn cuboid(half: Vec3) -> Vec<Vec3> {
    (0..8)
        .map(|i| {
            half * Vec3::new(
                if i & 1 > 0 { 1.0 } else { -1.0 },
                if i & 2 > 0 { 1.0 } else { -1.0 },
                if i & 4 > 0 { 1.0 } else { -1.0 },
            )
        })
        .collect()
}

fn prism(n: usize, radius: f32, half_height: f32) -> Vec<Vec3> {
    (0..2 * n)
        .map(|i| {
            let angle = (i / 2) as f32 / n as f32 * std::f32::consts::TAU;
            Vec3::new(radius * angle.cos(), if i % 2 == 0 { half_height } else { -half_height }, radius * angle.sin())
        })
        .collect()
}

/// Hulls of all kinds, from 5 mm to 2 m.
fn random_hull(random: &mut Random) -> Vec<Vec3> {
    let size = 0.0025 * 400.0_f32.powf(random.between(0.0, 1.0));
    match random.below(6) {
        0 => cuboid(Vec3::new(random.between(0.2, 1.0), random.between(0.2, 1.0), random.between(0.2, 1.0)) * size),
        1 => prism(3 + random.below(30), size, size * random.between(0.1, 1.0)),
        2 => cuboid(Vec3::new(size, 0.0005, size * random.between(0.3, 1.0))),
        3 => {
            let n = 4 + random.below(61);
            (0..n).map(|_| random.vector().normalize() * size).collect()
        }
        _ => {
            let n = 4 + random.below(61);
            let stretch = Vec3::new(1.0, random.between(0.1, 1.0), random.between(0.1, 1.0));
            (0..n).map(|_| random.vector() * stretch * size).collect()
        }
    }
}

const MARGIN: f32 = 0.01;

/// Two hulls in the world, owned.
struct Case {
    tables: HullTables,
    poses: [Pose; 2],
}

impl Case {
    fn new(parts: [&[Vec3]; 2], poses: [Pose; 2]) -> Self {
        let mut tables = HullTables::default();
        parts.iter().for_each(|part| tables.push(part));
        assert_eq!(tables.hulls.len(), 2);
        Self { tables, poses }
    }

    fn pair(&self) -> HullPair<'_> {
        HullPair { tables: &self.tables, hulls: [0, 1], poses: [&self.poses[0], &self.poses[1]] }
    }

    fn swapped(&self) -> HullPair<'_> {
        HullPair { tables: &self.tables, hulls: [1, 0], poses: [&self.poses[1], &self.poses[0]] }
    }

    fn separator(&self, kind: NarrowPhase) -> Separator {
        Separator::new(kind, &self.tables)
    }

    fn separation(&self, kind: NarrowPhase) -> Option<Separation> {
        self.separator(kind).separation(&self.pair(), MARGIN, &mut PairCache::default())
    }

    fn manifold(&self, kind: NarrowPhase) -> Manifold {
        let mut out = Manifold::default();
        if let Some(separation) = self.separation(kind) {
            manifold(&self.pair(), &separation, MARGIN, &mut out);
        }
        out
    }

    fn corners(&self, side: usize) -> impl Iterator<Item = Vec3> {
        let hull = &self.tables.hulls[side];
        self.tables.vertices_of(hull).iter().map(move |v| self.poses[side].point(v.truncate()))
    }

    /// Separation along a world axis, from all vertices.
    fn along(&self, axis: Vec3) -> f32 {
        let low = self.corners(1).map(|v| axis.dot(v)).fold(f32::INFINITY, f32::min);
        low - self.corners(0).map(|v| axis.dot(v)).fold(f32::NEG_INFINITY, f32::max)
    }

    /// How far a world point lies outside a hull, measured along its faces' normals.
    fn outside(&self, side: usize, point: Vec3) -> f32 {
        let local = self.poses[side].inverse_point(point);
        let faces = self.tables.faces_of(&self.tables.hulls[side]).iter();
        faces.map(|f| f.normal().dot(local) - f.plane.w).fold(f32::NEG_INFINITY, f32::max)
    }

    /// What `twin` and parry may differ by: see the module's notes.
    fn tolerance(&self) -> f32 {
        self.tables
            .hulls
            .iter()
            .map(|h| COPLANAR_DISTANCE.min(COPLANAR_SHARE * h.radius) + 1e-5 * h.radius)
            .sum::<f32>()
            + 2e-6
    }
}

/// A random pair: barely overlapping, overlapping, one inside the other, apart, or coincident in place.
fn random_case(random: &mut Random) -> Case {
    loop {
        let parts = [random_hull(random), random_hull(random)];
        let mut tables = HullTables::default();
        parts.iter().for_each(|part| tables.push(part));
        if tables.hulls.len() < 2 {
            continue;
        }
        let (r0, r1) = (tables.hulls[0].radius, tables.hulls[1].radius);
        let far = match random.below(5) {
            0 => random.between(0.5, 1.1) * (r0 + r1),
            1 => random.between(0.0, 0.5) * (r0 + r1),
            2 => random.between(0.5, 1.2) * r0.max(r1),
            3 => 0.5 * r0.min(r1),
            _ => 0.0,
        };
        let origin = 2.0 * random.vector();
        let turned = random.rotation();
        let parallel = random.below(4) == 0;
        let rotation = if parallel { turned } else { random.rotation() };
        let there = origin + random.vector().normalize() * far;
        return Case { tables, poses: [Pose::new(turned, origin), Pose::new(rotation, there)] };
    }
}

/// Checks one pair in every way that needs no closed form; an error says what is wrong.
fn check(case: &Case) -> Result<(), String> {
    let tolerance = case.tolerance();
    let [twin, reference] = [NarrowPhase::Twin, NarrowPhase::Reference].map(|kind| case.separation(kind));
    let [depth, depth_reference] =
        [NarrowPhase::Twin, NarrowPhase::Reference].map(|kind| case.separator(kind).depth(&case.pair(), 0.0));
    let fail = |what: &str| Err(format!("{what}: twin {twin:?} {depth}, reference {reference:?} {depth_reference}"));
    if (depth - depth_reference).abs() > tolerance {
        return fail("depths differ");
    }
    let (Some(t), Some(r)) = (twin, reference) else {
        // Distances of corners are underestimated by the axes: `twin` may keep a pair that is apart, never lose one.
        return if reference.is_some_and(|r| r.distance < MARGIN - tolerance) { fail("lost a pair") } else { Ok(()) };
    };
    if (t.normal.length() - 1.0).abs() > 1e-5 || (case.along(t.normal) - t.distance).abs() > 1e-6 * scale(case) {
        return fail("the axis does not separate by what it says");
    }
    if t.distance > r.distance + tolerance {
        return fail("farther than the distance");
    }
    // Both versions may choose another axis only where it is as good, up to the bias towards faces.
    let bias = 0.5e-4 * 2.0 + 0.02 * (-r.distance).max(0.0);
    if r.distance < 0.0 && t.distance < r.distance - bias - tolerance {
        return fail("overlaps more than it must");
    }
    for kind in [NarrowPhase::Twin, NarrowPhase::Reference] {
        let m = case.manifold(kind);
        if r.distance < -tolerance && m.count == 0 {
            return fail("overlap without a contact");
        }
        for p in m.points() {
            let length = (p.on_b - p.on_a).length();
            if (length - p.separation.abs()).abs() > 1e-5 * scale(case) || p.separation > MARGIN {
                return fail("a point's separation is wrong");
            }
            // Clipping tolerance and parry's witnesses.
            let slack = 1e-4 + tolerance;
            let off = [case.outside(0, p.on_a), case.outside(1, p.on_b)];
            // Where a face won against an edge pair by its bias, the one point lies between the two.
            let between = m.count == 1 && p.separation < 0.0;
            let near = 0.5 * case.tables.hulls[0].radius.min(case.tables.hulls[1].radius);
            if off.iter().any(|&d| d > if between { slack + near } else { slack }) {
                return Err(format!("{kind:?}: point off a hull by {off:?}, tolerance {slack}: {t:?} {r:?} {m:?}"));
            }
            if p.separation < r.distance - bias - tolerance - slack {
                return fail("a point deeper than the overlap");
            }
        }
    }
    Ok(())
}

fn scale(case: &Case) -> f32 {
    1.0 + case.poses[0].translation.length() + case.tables.hulls.iter().map(|h| h.radius).sum::<f32>()
}

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

fn upright(height: f32) -> [Pose; 2] {
    [Pose::IDENTITY, Pose::new(Quat::IDENTITY, Vec3::new(0.0, height, 0.0))]
}

const BOTH: [NarrowPhase; 2] = [NarrowPhase::Twin, NarrowPhase::Reference];

#[test]
fn box_on_box_touches_at_its_four_corners() {
    let (lower, upper) = (cuboid(Vec3::new(0.3, 0.1, 0.2)), cuboid(Vec3::new(0.1, 0.05, 0.08)));
    for gap in [0.004, 1e-6, -1e-6, -0.001, -0.03] {
        let case = Case::new([&lower, &upper], upright(0.15 + gap));
        for kind in BOTH {
            let m = case.manifold(kind);
            assert_eq!(m.count, 4, "{kind:?} at {gap}");
            assert!(m.normal.distance(Vec3::Y) < 1e-3, "{kind:?} at {gap}: {m:?}");
            for p in m.points() {
                assert!((p.separation - gap).abs() < 2e-6, "{kind:?} at {gap}: {m:?}");
                assert!((p.on_b.x.abs() - 0.1).abs() < 1e-5 && (p.on_b.z.abs() - 0.08).abs() < 1e-5);
                assert!((p.on_a.y - 0.1).abs() < 1e-6 && (p.on_b.y - 0.1 - gap).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn equal_boxes_meet_at_four_corners_and_coincident_ones_part_along_the_shortest_side() {
    let shape = cuboid(Vec3::new(0.3, 0.1, 0.2));
    for kind in BOTH {
        let m = Case::new([&shape, &shape], upright(0.2 - 1e-4)).manifold(kind);
        assert_eq!(m.count, 4, "{kind:?}");
        let coincident = Case::new([&shape, &shape], upright(0.0));
        let s = coincident.separation(kind).unwrap();
        assert!((s.distance + 0.2).abs() < 1e-5 && s.normal.y.abs() > 0.999, "{kind:?}: {s:?}");
        assert_eq!(coincident.manifold(kind).count, 4, "{kind:?}");
    }
}

#[test]
fn octagonal_prism_on_a_plate_keeps_all_eight_corners() {
    for kind in BOTH {
        let case = Case::new([&cuboid(Vec3::new(0.5, 0.01, 0.5)), &prism(8, 0.1, 0.1)], upright(0.11 - 2e-4));
        let m = case.manifold(kind);
        assert_eq!(m.count, 8, "{kind:?}");
        assert!(m.points().iter().all(|p| (p.separation + 2e-4).abs() < 2e-6), "{kind:?}: {m:?}");
    }
}

#[test]
fn crossing_edges_meet_in_one_point() {
    let shape = cuboid(Vec3::splat(0.1));
    let lower = Quat::from_rotation_z(std::f32::consts::FRAC_PI_4);
    let upper = Quat::from_rotation_x(std::f32::consts::FRAC_PI_4);
    for gap in [0.003, -0.002] {
        let height = 0.2 * std::f32::consts::SQRT_2 + gap;
        let poses = [Pose::new(lower, Vec3::ZERO), Pose::new(upper, Vec3::new(0.02, height, 0.03))];
        let case = Case::new([&shape, &shape], poses);
        for kind in BOTH {
            let m = case.manifold(kind);
            assert_eq!(m.count, 1, "{kind:?}");
            let p = m.points()[0];
            assert!((p.separation - gap).abs() < 1e-5 && m.normal.y > 0.9999, "{kind:?}: {m:?}");
            let expected = Vec3::new(0.02, 0.1 * std::f32::consts::SQRT_2, 0.03);
            // The lower box's edge runs along z at x = 0, the upper one's along x at z = 0.03.
            assert!((p.on_a - Vec3::new(0.0, expected.y, 0.03)).length() < 1e-4, "{kind:?}: {m:?}");
        }
    }
}

#[test]
fn boxes_diagonally_apart_have_no_false_contact() {
    let shape = cuboid(Vec3::splat(0.1));
    for (gap, near) in [(0.008, false), (0.005, true)] {
        // Corner to corner: each axis separates by `gap`, the distance is √3 times that.
        let poses = [Pose::IDENTITY, Pose::new(Quat::IDENTITY, Vec3::splat(0.2 + gap))];
        let case = Case::new([&shape, &shape], poses);
        for kind in BOTH {
            let m = case.manifold(kind);
            assert_eq!(m.count, u32::from(near), "{kind:?} at {gap}: {m:?}");
            if near {
                let p = m.points()[0];
                assert!((p.separation - gap * 3.0_f32.sqrt()).abs() < 1e-5, "{kind:?}: {m:?}");
                assert!(m.normal.distance(Vec3::splat(1.0 / 3.0_f32.sqrt())) < 1e-3, "{kind:?}: {m:?}");
            }
        }
    }
}

#[test]
fn swallowed_boxes_and_plates_leave_by_the_nearest_side() {
    let outer = cuboid(Vec3::new(0.5, 0.3, 0.4));
    for inner in [cuboid(Vec3::splat(0.02)), cuboid(Vec3::new(0.1, 0.0005, 0.1)), prism(16, 0.0025, 0.0025)] {
        for kind in BOTH {
            let case = Case::new([&outer, &inner], upright(0.2));
            let s = case.separation(kind).unwrap();
            let expected = -(0.1 + case.tables.hulls[1].half_extents.y);
            assert!((s.distance - expected).abs() < 2e-5 && s.normal.y > 0.9999, "{kind:?}: {s:?}, not {expected}");
            assert!(case.manifold(kind).count >= 4, "{kind:?}");
        }
    }
}

#[test]
fn a_bottom_of_two_facets_rests_on_both() {
    // Two facets 2° apart, too far from one plane to be joined: a wide wedge under a block, lying on a table.
    let sag = 0.1 * 1.0_f32.to_radians().tan();
    let mut points = cuboid(Vec3::new(0.1, 0.05, 0.05));
    points.extend([Vec3::new(0.0, -0.05 - sag, 0.05), Vec3::new(0.0, -0.05 - sag, -0.05)]);
    let case = Case::new([&cuboid(Vec3::new(0.5, 0.05, 0.5)), &points], upright(0.1 + sag - 1e-4));
    for kind in BOTH {
        let m = case.manifold(kind);
        let (low, high) = m.points().iter().fold((0.0_f32, 0.0_f32), |(l, h), p| (l.min(p.on_b.x), h.max(p.on_b.x)));
        assert!(low < -0.09 && high > 0.09, "{kind:?}: {m:?}");
        assert_eq!(m.count, 6, "{kind:?}: shared corners once: {m:?}");
    }
}

#[test]
fn a_plane_sees_the_corners_of_the_footprint() {
    let mut tables = HullTables::default();
    tables.push(&prism(8, 0.1, 0.002));
    tables.push(&prism(30, 0.1, 0.002));
    let mut out = Manifold::default();
    let pose = Pose::new(Quat::IDENTITY, Vec3::new(1.0, 0.502, 0.0));
    plane_hull(&tables, 0, &pose, (Vec3::Y, 0.5), MARGIN, &mut out);
    assert_eq!(out.count, 8, "the top of a thin plate lies within the margin but adds no support");
    assert!(out.points().iter().all(|p| p.separation.abs() < 1e-6 && (p.on_a.y - 0.5).abs() < 1e-6));
    plane_hull(&tables, 1, &pose, (Vec3::Y, 0.5), MARGIN, &mut out);
    assert_eq!(out.count, 8);
    assert!(out.points().iter().all(|p| p.separation.abs() < 1e-6), "{out:?}");
    let tilted = Pose::new(Quat::from_rotation_z(0.3), Vec3::new(1.0, 0.5, 0.0));
    plane_hull(&tables, 1, &tilted, (Vec3::Y, 0.5), MARGIN, &mut out);
    let deepest = |heights: &mut dyn Iterator<Item = f32>| heights.fold(1.0, f32::min);
    let expected =
        deepest(&mut tables.vertices_of(&tables.hulls[1]).iter().map(|v| tilted.point(v.truncate()).y - 0.5));
    let found = deepest(&mut out.points().iter().map(|p| p.separation));
    // Neighbours of the deepest corner are 0.6 mm higher; points within a millimetre of reach are interchangeable.
    assert!((found - expected).abs() < 1e-3, "{found}, not {expected}");
    plane_hull(&tables, 0, &pose, (Vec3::Y, 0.48), MARGIN, &mut out);
    assert_eq!(out.count, 0);
}

#[test]
fn reduction_keeps_the_outline_of_what_bears() {
    let circle = |radius: f32| {
        (0..24).map(move |i| {
            let (sin, cos) = (i as f32 / 24.0 * std::f32::consts::TAU).sin_cos();
            radius * Vec3::new(cos, 0.0, -sin)
        })
    };
    let inside = (0..20).map(|i| Vec3::new(0.002 * i as f32, 0.0, -0.03));
    let points: Vec<Vec3> = circle(0.1).chain(inside).collect();
    let kept = reduce(points.len(), |i| (points[i], 0.0), Vec3::Y);
    let corner = |k: usize| points[kept.indices()[k % kept.indices().len()] as usize];
    let area: f32 = (0..kept.indices().len()).map(|k| 0.5 * corner(k).cross(corner(k + 1)).y).sum();
    // The 24-gon has 0.0311 m², the best octagon 0.0283.
    assert!(kept.indices().len() == 8 && area > 0.027, "area {area}");
    // A ring that touches inside a wider one with a gap of 5 mm.
    let points: Vec<Vec3> = circle(0.11).chain(circle(0.1)).collect();
    let kept = reduce(points.len(), |i| (points[i], if i < 24 { 0.005 } else { 0.0 }), Vec3::Y);
    assert!(kept.indices().iter().all(|&i| i >= 24), "{:?}", kept.indices());
}

#[test]
fn no_finite_pose_no_contact() {
    let shape = cuboid(Vec3::splat(0.1));
    for bad in [f32::NAN, f32::INFINITY] {
        let case = Case::new([&shape, &shape], upright(bad));
        for kind in BOTH {
            assert_eq!(case.separation(kind), None);
            assert_eq!(case.separator(kind).depth(&case.pair(), 0.0), 0.0);
        }
    }
}

/// Vertices of the convex parts of a shared scene.
fn real_hulls() -> Vec<Vec<Vec3>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/bench12/meshes");
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files.retain(|f| f.file_name().unwrap().to_string_lossy().contains("_part"));
    files
        .iter()
        .map(|file| {
            let text = std::fs::read_to_string(file).unwrap();
            text.lines()
                .filter_map(|line| line.strip_prefix("v "))
                .map(|line| {
                    let numbers: Vec<f32> = line.split_whitespace().map(|n| n.parse().unwrap()).collect();
                    Vec3::from_slice(&numbers)
                })
                .collect()
        })
        .collect()
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn twin_agrees_with_reference_on_real_hulls() {
    let parts = real_hulls();
    let mut tables = HullTables::default();
    parts.iter().for_each(|part| tables.push(part));
    assert_eq!(tables.hulls.len(), parts.len(), "a part was taken for flat");
    let mut random = Random(13);
    for i in 0..5000 {
        let [a, b] = [0, 1].map(|_| random.below(parts.len()));
        let (p, q) = (tables.hulls[a], tables.hulls[b]);
        let turned = [random.rotation(), random.rotation()];
        let apart = random.vector().normalize() * random.between(0.0, p.radius + q.radius);
        let poses = [Pose::new(turned[0], turned[0] * -p.center), Pose::new(turned[1], apart - turned[1] * q.center)];
        let case = Case::new([&parts[a], &parts[b]], poses);
        check(&case).unwrap_or_else(|e| panic!("pair {i}, parts {a} and {b}: {e}"));
    }
}
