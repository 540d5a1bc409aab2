//! Hulls, random pairs of them, and the twin beside the reference.

use crate::common::hulls::{cuboid, prism};
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::narrow_phase::*;
use rest3d_gpu::world::constants::{COPLANAR_DISTANCE, COPLANAR_SHARE};
use rest3d_gpu::world::{HullTables, NarrowPhase, Pose};

/// A small generator (SplitMix64), so that every run sees the same pairs.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.bits() >> 40) as f32 / (1_u64 << 24) as f32
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    pub fn vector(&mut self) -> Vec3 {
        loop {
            let v = Vec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            if v.length_squared() <= 1.0 && v.length_squared() > 1e-4 {
                return v;
            }
        }
    }
    pub fn rotation(&mut self) -> Quat {
        Quat::from_axis_angle(self.vector().normalize(), self.between(0.0, std::f32::consts::PI))
    }
}

/// Hulls of all kinds, from 5 mm to 2 m.
pub fn random_hull(random: &mut Random) -> Vec<Vec3> {
    let size = 0.0025 * 400.0_f32.powf(random.between(0.0, 1.0));
    match random.below(6) {
        0 => cuboid(Vec3::new(random.between(0.2, 1.0), random.between(0.2, 1.0), random.between(0.2, 1.0)) * size),
        1 => {
            let sides = 3 + random.below(30);
            prism(size, size * random.between(0.1, 1.0), sides)
        }
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

pub const MARGIN: f32 = 0.01;

/// Two hulls in the world, owned.
pub struct Case {
    pub tables: HullTables,
    pub poses: [Pose; 2],
}

impl Case {
    pub fn new(parts: [&[Vec3]; 2], poses: [Pose; 2]) -> Self {
        let mut tables = HullTables::default();
        parts.iter().for_each(|part| tables.push(part));
        assert_eq!(tables.hulls.len(), 2);
        Self { tables, poses }
    }

    pub fn pair(&self) -> HullPair<'_> {
        let poses = [&self.poses[0], &self.poses[1]];
        HullPair { tables: &self.tables, hulls: [0, 1], poses, room: HullPair::ANY_ROOM }
    }

    pub fn swapped(&self) -> HullPair<'_> {
        HullPair { hulls: [1, 0], poses: [&self.poses[1], &self.poses[0]], ..self.pair() }
    }

    pub fn separator(&self, kind: NarrowPhase) -> Separator {
        Separator::new(kind, &self.tables)
    }

    pub fn separation(&self, kind: NarrowPhase) -> Option<Separation> {
        self.separator(kind).separation(&self.pair(), MARGIN, &mut PairCache::default())
    }

    pub fn manifold(&self, kind: NarrowPhase) -> Manifold {
        let mut out = Manifold::default();
        if let Some(separation) = self.separation(kind) {
            manifold(&self.pair(), &separation, MARGIN, &mut out);
        }
        out
    }

    pub fn corners(&self, side: usize) -> impl Iterator<Item = Vec3> {
        let hull = &self.tables.hulls[side];
        self.tables.vertices_of(hull).iter().map(move |v| self.poses[side].point(v.truncate()))
    }

    /// Separation along a world axis, from all vertices.
    pub fn along(&self, axis: Vec3) -> f32 {
        let low = self.corners(1).map(|v| axis.dot(v)).fold(f32::INFINITY, f32::min);
        low - self.corners(0).map(|v| axis.dot(v)).fold(f32::NEG_INFINITY, f32::max)
    }

    /// How far a world point lies outside a hull, measured along its faces' normals.
    pub fn outside(&self, side: usize, point: Vec3) -> f32 {
        let local = self.poses[side].inverse_point(point);
        let faces = self.tables.faces_of(&self.tables.hulls[side]).iter();
        faces.map(|f| f.normal().dot(local) - f.plane.w).fold(f32::NEG_INFINITY, f32::max)
    }

    /// What `twin` and parry may differ by: see the module's notes.
    pub fn tolerance(&self) -> f32 {
        self.tables
            .hulls
            .iter()
            .map(|h| COPLANAR_DISTANCE.min(COPLANAR_SHARE * h.radius) + 1e-5 * h.radius)
            .sum::<f32>()
            + 2e-6
    }
}

/// A random pair: barely overlapping, overlapping, one inside the other, apart, or coincident in place.
pub fn random_case(random: &mut Random) -> Case {
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
pub fn check(case: &Case) -> Result<(), String> {
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

pub fn scale(case: &Case) -> f32 {
    1.0 + case.poses[0].translation.length() + case.tables.hulls.iter().map(|h| h.radius).sum::<f32>()
}
