//! temporary
use crate::world::constants::*;
use crate::world::*;
use glam::{Mat3, Vec3};
use parry3d::math::Pose as Iso;
use parry3d::shape::ConvexPolyhedron;
#[derive(Clone, Copy, Debug, Default)]
pub struct ManifoldPoint {
    pub on_a: Vec3,
    pub on_b: Vec3,
    pub separation: f32,
}
#[derive(Default)]
pub struct Manifold {
    pub normal: Vec3,
    p: Vec<ManifoldPoint>,
}
impl Manifold {
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.p
    }
}
#[derive(Clone, Copy, Default)]
pub struct PairCache;
pub struct Separation {
    pub distance: f32,
    pub normal: Vec3,
    pa: Vec3,
    pb: Vec3,
}
pub struct Narrow {
    polys: Vec<Option<ConvexPolyhedron>>,
}
pub struct Kept(Vec<usize>);
impl Kept {
    pub fn as_slice(&self) -> &[usize] {
        &self.0
    }
}
pub fn reduce(p: &[ManifoldPoint], n: Vec3, max: usize) -> Kept {
    // deepest, farthest, then greedy farthest-from-set
    let mut k = vec![];
    let d = (0..p.len()).min_by(|&a, &b| p[a].separation.total_cmp(&p[b].separation)).unwrap();
    k.push(d);
    let flat = |v: Vec3| v - n * n.dot(v);
    let mut dist: Vec<f32> = p.iter().map(|q| flat(q.on_b - p[d].on_b).length()).collect();
    while k.len() < max {
        let f = (0..p.len()).max_by(|&a, &b| dist[a].total_cmp(&dist[b]).then(b.cmp(&a))).unwrap();
        if dist[f] <= 0.0 {
            for i in 0..p.len() {
                if k.len() < max && !k.contains(&i) {
                    k.push(i)
                }
            }
            break;
        }
        k.push(f);
        for i in 0..p.len() {
            dist[i] = dist[i].min(flat(p[i].on_b - p[f].on_b).length());
        }
    }
    k.sort();
    Kept(k)
}
impl Narrow {
    pub fn new(_: NarrowPhase, t: &HullTables) -> Self {
        Narrow {
            polys: t
                .hulls
                .iter()
                .map(|h| {
                    ConvexPolyhedron::from_convex_hull(
                        &t.vertices_of(h).iter().map(|v| v.truncate()).collect::<Vec<_>>(),
                    )
                })
                .collect(),
        }
    }
    pub fn separation(
        &self,
        t: &HullTables,
        a: usize,
        pa: &Pose,
        b: usize,
        pb: &Pose,
        margin: f32,
        _: &mut PairCache,
    ) -> Option<Separation> {
        sat(t, a, pa, b, pb, margin)
    }
    pub fn depth(&self, t: &HullTables, a: usize, pa: &Pose, b: usize, pb: &Pose) -> f32 {
        self.separation(t, a, pa, b, pb, 0.0, &mut PairCache).map_or(0.0, |s| (-s.distance).max(0.0))
    }
}
fn best_face(t: &HullTables, h: usize, dir: Vec3) -> (usize, f32) {
    let mut b = (0, -2.0);
    for (i, f) in t.faces_of(&t.hulls[h]).iter().enumerate() {
        let d = f.normal().dot(dir);
        if d > b.1 {
            b = (i, d)
        }
    }
    b
}
fn polygon(t: &HullTables, h: usize, f: usize, p: &Pose, m: &Mat3) -> Vec<Vec3> {
    let hull = &t.hulls[h];
    let vs = t.vertices_of(hull);
    t.corners_of(&t.faces_of(hull)[f]).iter().map(|&i| *m * vs[i as usize].truncate() + p.translation).collect()
}
#[allow(clippy::too_many_arguments)]
pub fn manifold(
    t: &HullTables,
    a: usize,
    pa: &Pose,
    b: usize,
    pb: &Pose,
    s: &Separation,
    margin: f32,
    out: &mut Manifold,
) {
    out.p.clear();
    out.normal = s.normal;
    let (fa, da) = best_face(t, a, pa.rotation.conjugate() * s.normal);
    let (fb, db) = best_face(t, b, pb.rotation.conjugate() * -s.normal);
    let single = |out: &mut Manifold| out.p.push(ManifoldPoint { on_a: s.pa, on_b: s.pb, separation: s.distance });
    if da.max(db) < 0.998 {
        single(out);
        return;
    }
    let flip = db > da + 1e-3;
    let (h1, p1, f1, h2, p2, f2) = if flip { (b, pb, fb, a, pa, fa) } else { (a, pa, fa, b, pb, fb) };
    let (m1, m2) = (Mat3::from_quat(p1.rotation), Mat3::from_quat(p2.rotation));
    let refp = polygon(t, h1, f1, p1, &m1);
    let mut poly = polygon(t, h2, f2, p2, &m2);
    let face = &t.faces_of(&t.hulls[h1])[f1];
    let n = m1 * face.normal();
    let off = n.dot(refp[0]);
    for i in 0..refp.len() {
        let (v0, v1) = (refp[i], refp[(i + 1) % refp.len()]);
        let side = (v1 - v0).cross(n);
        let so = side.dot(v0);
        let mut o = Vec::new();
        for j in 0..poly.len() {
            let (x, y) = (poly[j], poly[(j + 1) % poly.len()]);
            let (dx, dy) = (side.dot(x) - so, side.dot(y) - so);
            if dx <= 0.0 {
                o.push(x)
            }
            if (dx < 0.0 && dy > 0.0) || (dx > 0.0 && dy < 0.0) {
                o.push(x + (y - x) * (dx / (dx - dy)))
            }
        }
        poly = o;
        if poly.is_empty() {
            break;
        }
    }
    for v in poly {
        let d = n.dot(v) - off;
        if d <= margin {
            let on1 = v - n * d;
            out.p.push(if flip {
                ManifoldPoint { on_a: v, on_b: on1, separation: d }
            } else {
                ManifoldPoint { on_a: on1, on_b: v, separation: d }
            })
        }
    }
    if out.p.is_empty() {
        single(out)
    } else {
        out.normal = if flip { -n } else { n }
    }
    let _ = MAX_FACE_VERTICES;
}
#[allow(clippy::too_many_arguments)]
pub fn plane_hull(t: &HullTables, h: usize, pose: &Pose, n: Vec3, o: f32, m: f32, out: &mut Manifold) {
    out.p.clear();
    out.normal = n;
    for v in t.vertices_of(&t.hulls[h]) {
        let w = pose.point(v.truncate());
        let s = n.dot(w) - o;
        if s < m && out.p.len() < 64 {
            out.p.push(ManifoldPoint { on_a: w - n * s, on_b: w, separation: s })
        }
    }
}

fn sat(t: &HullTables, a: usize, pa: &Pose, b: usize, pb: &Pose, margin: f32) -> Option<Separation> {
    // in A frame
    let (ha, hb) = (&t.hulls[a], &t.hulls[b]);
    let q = pa.rotation.conjugate() * pb.rotation;
    let m = Mat3::from_quat(q);
    let o = pa.rotation.conjugate() * (pb.translation - pa.translation);
    let va: Vec<Vec3> = t.vertices_of(ha).iter().map(|v| v.truncate()).collect();
    let vb: Vec<Vec3> = t.vertices_of(hb).iter().map(|v| m * v.truncate() + o).collect();
    let mut best = (-f32::INFINITY, Vec3::Y, false, 0usize, 0usize);
    let fa = t.faces_of(ha);
    let fb = t.faces_of(hb);
    for f in fa {
        let n = f.normal();
        let s = vb.iter().map(|v| n.dot(*v)).fold(f32::INFINITY, f32::min) - f.plane.w;
        if s > margin {
            return None;
        }
        if s > best.0 {
            best = (s, n, false, 0, 0)
        }
    }
    for f in fb {
        let n = m * f.normal();
        let off = f.plane.w + n.dot(o);
        let s = va.iter().map(|v| n.dot(*v)).fold(f32::INFINITY, f32::min) - off;
        if s > margin {
            return None;
        }
        if s > best.0 + 1e-4 {
            best = (s, -n, false, 0, 0)
        }
    }
    let eb = t.edges_of(hb);
    for (i, e) in t.edges_of(ha).iter().enumerate() {
        let (na0, na1) = (fa[e.faces[0] as usize].normal(), fa[e.faces[1] as usize].normal());
        let da = va[e.vertices[1] as usize] - va[e.vertices[0] as usize];
        for (j, g) in eb.iter().enumerate() {
            let (nb0, nb1) = (-(m * fb[g.faces[0] as usize].normal()), -(m * fb[g.faces[1] as usize].normal()));
            let bxa = na1.cross(na0);
            let dxc = nb1.cross(nb0);
            let cba = nb0.dot(bxa);
            let dba = nb1.dot(bxa);
            let adc = na0.dot(dxc);
            let bdc = na1.dot(dxc);
            if !(cba * dba < 0.0 && adc * bdc < 0.0 && cba * bdc > 0.0) {
                continue;
            }
            let db = vb[g.vertices[1] as usize] - vb[g.vertices[0] as usize];
            let c = da.cross(db);
            let l = c.length();
            if l < 1e-3 * da.length() * db.length() {
                continue;
            }
            let mut n = c / l;
            if n.dot(na0 + na1) < 0.0 {
                n = -n
            }
            let s = n.dot(vb[g.vertices[0] as usize] - va[e.vertices[0] as usize]);
            if s > margin {
                return None;
            }
            if s > best.0 + 2e-4 {
                best = (s, n, true, i, j)
            }
        }
    }
    let (mut p1, mut p2) = (Vec3::ZERO, Vec3::ZERO);
    if best.2 {
        let e = &t.edges_of(ha)[best.3];
        let g = &eb[best.4];
        let (a0, a1, b0, b1) = (
            va[e.vertices[0] as usize],
            va[e.vertices[1] as usize],
            vb[g.vertices[0] as usize],
            vb[g.vertices[1] as usize],
        );
        let (d1, d2, r) = (a1 - a0, b1 - b0, a0 - b0);
        let (aa, ee, ff, cc, bb) = (d1.dot(d1), d2.dot(d2), d2.dot(r), d1.dot(r), d1.dot(d2));
        let den = aa * ee - bb * bb;
        let s_ = ((bb * ff - cc * ee) / den).clamp(0.0, 1.0);
        let t_ = ((bb * s_ + ff) / ee).clamp(0.0, 1.0);
        p1 = a0 + d1 * s_;
        p2 = b0 + d2 * t_;
    } else {
        // witness: deepest vertex of B along -n
        let v = *vb.iter().min_by(|x, y| best.1.dot(**x).total_cmp(&best.1.dot(**y))).unwrap();
        p2 = v;
        p1 = v - best.1 * best.0;
    }
    Some(Separation { distance: best.0, normal: pa.rotation * best.1, pa: pa.point(p1), pb: pa.point(p2) })
}
