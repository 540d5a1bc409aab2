//! The two narrow phases against each other and against closed forms.
#![allow(clippy::unwrap_used)]

use glam::{Quat, Vec3};
use rest3d_gpu::cpu::narrow_phase::*;
use rest3d_gpu::world::{HullTables, NarrowPhase, Pose};

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

#[test]
fn explore() {
    let mut random = Random(1);
    let (mut n, mut fails, mut sep, mut worst) = (0, 0, 0, 0.0_f32);
    let mut hist = [0; 12];
    for _ in 0..20000 {
        let mut tables = HullTables::default();
        tables.push(&random_hull(&mut random));
        tables.push(&random_hull(&mut random));
        if tables.hulls.len() < 2 {
            continue;
        }
        let twin = Separator::new(NarrowPhase::Twin, &tables);
        let reference = Separator::new(NarrowPhase::Reference, &tables);
        let r = tables.hulls[0].radius + tables.hulls[1].radius;
        let small = tables.hulls[0].radius.min(tables.hulls[1].radius);
        let base = random.vector() * 2.0;
        let mode = random.below(3);
        let d = match mode {
            0 => r * 0.9,
            1 => r * 0.3,
            _ => 0.5 * small,
        };
        let pa = Pose::new(random.rotation(), base);
        let pb = Pose::new(random.rotation(), base + random.vector().normalize() * random.between(0.0, 1.0) * d);
        let pair = HullPair { tables: &tables, hulls: [0, 1], poses: [&pa, &pb] };
        n += 1;
        if (Reference.first_attempt_fails(&pair, 0.01)) {
            fails += 1;
        }
        let t = twin.separation(&pair, 0.01, &mut PairCache::default());
        let e = reference.separation(&pair, 0.01, &mut PairCache::default());
        let dt = twin.depth(&pair, 0.0);
        let de = reference.depth(&pair, 0.0);
        if e.is_none() {
            sep += 1;
        }
        if e.is_none() && t.is_some() {
            hist[9] += 1;
        }
        if e.is_some() && t.is_none() {
            hist[10] += 1;
            eprintln!("twin none, ref {:?}", e);
        }
        if dt > de + 1e-3 * small && de > 0.0 {
            // brute force over all edges and faces
            let verts = |k: usize| -> Vec<Vec3> {
                tables.vertices_of(&tables.hulls[k]).iter().map(|v| pair.poses[k].point(v.truncate())).collect()
            };
            let (va, vb) = (verts(0), verts(1));
            let along = |n: Vec3| {
                vb.iter().map(|v| n.dot(*v)).fold(f32::INFINITY, f32::min)
                    - va.iter().map(|v| n.dot(*v)).fold(f32::NEG_INFINITY, f32::max)
            };
            let edges = |k: usize| tables.edges_of(&tables.hulls[k]).to_vec();
            let mut best = (f32::NEG_INFINITY, 0, 0, Vec3::ZERO);
            for (i, e) in edges(0).iter().enumerate() {
                for (j, f) in edges(1).iter().enumerate() {
                    let u = va[e.vertices[1] as usize] - va[e.vertices[0] as usize];
                    let v = vb[f.vertices[1] as usize] - vb[f.vertices[0] as usize];
                    let n = u.cross(v).normalize_or_zero();
                    for n in [n, -n] {
                        if n != Vec3::ZERO && along(n) > best.0 {
                            best = (along(n), i, j, n);
                        }
                    }
                }
            }
            let mut bf = f32::NEG_INFINITY;
            for k in 0..2 {
                for f in tables.faces_of(&tables.hulls[k]) {
                    let n = pair.poses[k].rotation * f.normal();
                    bf = bf.max(along(n)).max(along(-n));
                }
            }
            let (e, f) = (edges(0)[best.1], edges(1)[best.2]);
            let na = e.faces.map(|i| pair.poses[0].rotation * tables.faces_of(&tables.hulls[0])[i as usize].normal());
            let nb = f.faces.map(|i| pair.poses[1].rotation * tables.faces_of(&tables.hulls[1])[i as usize].normal());
            let (v, w) = (
                va[e.vertices[1] as usize] - va[e.vertices[0] as usize],
                vb[f.vertices[1] as usize] - vb[f.vertices[0] as usize],
            );
            let all: Vec<Vec<f32>> = (0..2)
                .map(|k| {
                    let h = &tables.hulls[k];
                    tables.faces_of(h).iter().map(|f| tables.corners_of(f).len() as f32).collect()
                })
                .collect();
            eprintln!(
                "twin {dt} ref {de} brute edges {best:?} faces {bf} V {} {} E {} {} F {} {} | c.v {} d.v {} a.w {} b.w {}  n.a {:?} n.b {:?} {:?}",
                va.len(),
                vb.len(),
                edges(0).len(),
                edges(1).len(),
                tables.hulls[0].face_count,
                tables.hulls[1].face_count,
                nb[0].dot(v.normalize()),
                nb[1].dot(v.normalize()),
                na[0].dot(w.normalize()),
                na[1].dot(w.normalize()),
                na.map(|n| n.dot(best.3)),
                nb.map(|n| n.dot(best.3)),
                all.iter().map(|c| c.iter().copied().filter(|c| *c < 3.0).count()).collect::<Vec<_>>()
            );
        }
        let err = (dt - de).abs() / small.max(0.01);
        if err > 1e-3 {
            eprintln!(
                "mode {mode} twin {dt} ref {de} r {:?} v {:?}\n  {e:?}\n  {t:?}",
                tables.hulls.iter().map(|h| h.radius).collect::<Vec<_>>(),
                tables.hulls.iter().map(|h| h.vertex_count).collect::<Vec<_>>()
            );
        }
        let k = ((-err.max(1e-9).log10()) as i32).clamp(0, 8) as usize;
        hist[k] += 1;
        if dt < de - 1e-4 * small {
            hist[11] += 1;
            eprintln!("parry deeper: {dt} {de} small {small} {e:?}\n {t:?}");
        }
        worst = worst.max(err);
    }
    eprintln!("pairs {n} parry first fails {fails} apart {sep} worst {worst} hist {hist:?}");
}
