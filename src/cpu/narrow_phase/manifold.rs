//! Contact points of two hulls along a given axis, by clipping whole face polygons against each other.
//!
//! The face best aligned with the axis, on either hull, is the reference face; the other hull's faces turned against it
//! are clipped to its outline, and every point of them within the margin is a contact. Where no face is aligned the
//! contact is one point. Hulls that overlap always get at least one point; hulls apart get none that is not truly
//! within the margin.

use super::{Feature, HullPair, MAX_MANIFOLD_POINTS, Manifold, ManifoldPoint, Separation, reduce};
use crate::world::Face;
use crate::world::constants::{
    ALIGNED_BIAS, ALIGNED_COSINE, CLIP_TOLERANCE, INCIDENT_COSINE, LINEAR_SLOP, MAX_CLIPPED, MAX_COLLECTED,
};
use glam::{Mat3, Vec3, Vec4};

/// Makes the contact points of `pair` within `margin` (m) along the axis of `separation`, which must be this pair's, at
/// these poses. `out.normal` is the reference face's normal, or the axis where no face is aligned.
pub fn manifold(pair: &HullPair, separation: &Separation, margin: f32, out: &mut Manifold) {
    out.normal = separation.normal;
    out.count = 0;
    let axis = separation.normal;
    let (face_a, cosine_a) = aligned_face(pair, 0, pair.poses[0].rotation.conjugate() * axis);
    let (face_b, cosine_b) = aligned_face(pair, 1, pair.poses[1].rotation.conjugate() * -axis);
    if cosine_a.max(cosine_b) < ALIGNED_COSINE {
        match separation.feature {
            Feature::Edges(i, j) => edge_point(pair, [i, j], axis, margin, out),
            Feature::Points { on_a, on_b } => single_point(on_a, on_b, axis, margin, out),
            // A face's own normal is always aligned with it.
            Feature::FaceA(_) | Feature::FaceB(_) => {}
        }
        return;
    }
    let (faces, cosines) = ([face_a, face_b], [cosine_a, cosine_b]);
    let larger = pair.larger();
    let reference = if cosines[1 - larger] > cosines[larger] + ALIGNED_BIAS { 1 - larger } else { larger };
    let clip = Clip::new(pair, reference, faces[reference]);
    let incident = faces[1 - reference];
    clip.faces(incident, margin, out);
    if out.count > 0 {
        return;
    }
    out.normal = axis;
    match separation.feature {
        Feature::Points { on_a, on_b } => single_point(on_a, on_b, axis, margin, out),
        Feature::Edges(i, j) => edge_point(pair, [i, j], axis, margin, out),
        Feature::FaceA(_) | Feature::FaceB(_) => {
            let (on_a, on_b) = clip.nearest_outlines(incident);
            if separation.distance > 0.0 {
                single_point(on_a, on_b, axis, margin, out);
            } else {
                // An edge pair lost by little against this face: the contact lies between the outlines.
                let (middle, half) = (on_a.midpoint(on_b), 0.5 * separation.distance * axis);
                single_point(middle - half, middle + half, axis, margin, out);
            }
        }
    }
}

/// The face of a hull whose normal is nearest to `direction` (unit, body frame), and its cosine.
fn aligned_face(pair: &HullPair, side: usize, direction: Vec3) -> (u32, f32) {
    let direction = direction.extend(0.0);
    let (mut best, mut high) = (0, f32::NEG_INFINITY);
    for (i, face) in pair.tables.faces_of(pair.hull(side)).iter().enumerate() {
        let cosine = direction.dot(face.plane);
        if cosine > high {
            (best, high) = (i as u32, cosine);
        }
    }
    (best, high)
}

/// One contact between two points that face each other along the axis, if near enough. Points apart are joined by their
/// own line: it is the exact normal of two corners.
fn single_point(on_a: Vec3, on_b: Vec3, axis: Vec3, margin: f32, out: &mut Manifold) {
    let along = axis.dot(on_b - on_a);
    let length = on_b.distance(on_a);
    let apart = along > LINEAR_SLOP;
    let separation = if apart { length } else { along };
    if separation > margin {
        return;
    }
    out.normal = if apart { (on_b - on_a) / length } else { axis };
    out.slots[0] = ManifoldPoint { on_a, on_b, separation };
    out.count = 1;
}

/// The contact of two crossing edges.
fn edge_point(pair: &HullPair, edges: [u32; 2], axis: Vec3, margin: f32, out: &mut Manifold) {
    let segment = |side: usize| {
        let hull = pair.hull(side);
        let vertices = pair.tables.vertices_of(hull);
        pair.tables.edges_of(hull)[edges[side] as usize]
            .vertices
            .map(|v| pair.poses[side].point(vertices[v as usize].truncate()))
    };
    let (on_a, on_b) = nearest_on_segments(segment(0), segment(1));
    single_point(on_a, on_b, axis, margin, out);
}

/// The nearest points of two segments (Ericson, "Real-Time Collision Detection", 5.1.9).
fn nearest_on_segments([p, p1]: [Vec3; 2], [q, q1]: [Vec3; 2]) -> (Vec3, Vec3) {
    let (u, v, w) = (p1 - p, q1 - q, p - q);
    let (a, e, b) = (u.length_squared(), v.length_squared(), u.dot(v));
    let (c, f) = (u.dot(w), v.dot(w));
    let determinant = a * e - b * b;
    // Parallel segments: any point will do, take the start.
    let s = if determinant > f32::EPSILON * a * e { ((b * f - c * e) / determinant).clamp(0.0, 1.0) } else { 0.0 };
    let t = if e > 0.0 { ((b * s + f) / e).clamp(0.0, 1.0) } else { 0.0 };
    let s = if a > 0.0 { ((b * t - c) / a).clamp(0.0, 1.0) } else { 0.0 };
    (p + s * u, q + t * v)
}

/// A convex polygon in an array of fixed size.
struct Polygon {
    count: usize,
    corners: [Vec3; MAX_CLIPPED],
}

impl Polygon {
    const EMPTY: Self = Self { count: 0, corners: [Vec3::ZERO; MAX_CLIPPED] };

    fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    fn push(&mut self, corner: Vec3) {
        if self.count < MAX_CLIPPED {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// What of `self` lies on the inner side of a line (Sutherland–Hodgman), into `kept`. False if all of it does, and
    /// `kept` is not written.
    fn cut(&self, line: Vec4, kept: &mut Self) -> bool {
        let beyond = |p: Vec3| line.truncate().dot(p) - line.w;
        if self.corners().iter().all(|&p| beyond(p) <= CLIP_TOLERANCE) {
            return false;
        }
        kept.count = 0;
        let mut last = self.corners[self.count - 1];
        let mut last_beyond = beyond(last);
        for &next in self.corners() {
            let next_beyond = beyond(next);
            if (last_beyond > CLIP_TOLERANCE) != (next_beyond > CLIP_TOLERANCE) {
                let share = (last_beyond / (last_beyond - next_beyond)).clamp(0.0, 1.0);
                kept.push(last + share * (next - last));
            }
            if next_beyond <= CLIP_TOLERANCE {
                kept.push(next);
            }
            (last, last_beyond) = (next, next_beyond);
        }
        true
    }
}

/// A reference face and the way from the other hull's frame into its own.
struct Clip<'a> {
    pair: &'a HullPair<'a>,
    reference: usize,
    vertices: &'a [Vec4],
    /// See `HullTables::ring_of`.
    ring: &'a [u32],
    normal: Vec3,
    offset: f32,
    rotation: Mat3,
    shift: Vec3,
    /// The outline, and the planes of what bears with the face.
    lines: &'a [Vec4],
    bearing: &'a [Vec4],
}

impl<'a> Clip<'a> {
    fn new(pair: &'a HullPair<'a>, reference: usize, face: u32) -> Self {
        let hull = pair.hull(reference);
        let (lines, bearing) = pair.tables.outline_of(hull, face);
        let plane = pair.tables.faces_of(hull)[face as usize].plane;
        let (rotation, shift) = pair.other_to(reference);
        Self {
            pair,
            reference,
            vertices: pair.tables.vertices_of(hull),
            ring: pair.tables.ring_of(hull, face),
            normal: plane.truncate(),
            offset: plane.w,
            rotation,
            shift,
            lines,
            bearing,
        }
    }

    /// Separation of a point in the reference hull's frame from its bearing faces, m.
    fn separation(&self, p: Vec3) -> f32 {
        self.bearing.iter().map(|plane| plane.truncate().dot(p) - plane.w).fold(f32::NEG_INFINITY, f32::max)
    }

    /// A face of the other hull, in the reference hull's frame, into `polygon`. False if it is nowhere within `margin`.
    fn polygon(&self, face: &Face, margin: f32, polygon: &mut Polygon) -> bool {
        let vertices = self.pair.tables.vertices_of(self.pair.hull(1 - self.reference));
        polygon.count = 0;
        let mut lowest = f32::INFINITY;
        for &corner in self.pair.tables.corners_of(face) {
            let p = self.carried(vertices[corner as usize]);
            lowest = lowest.min(self.normal.dot(p) - self.offset);
            polygon.push(p);
        }
        lowest <= margin
    }

    /// What of `polygon` lies over the bearing faces, in one of the two buffers.
    fn clipped<'p>(&self, polygon: &'p mut Polygon, other: &'p mut Polygon) -> &'p Polygon {
        let (mut from, mut to) = (polygon, other);
        for &line in self.lines {
            if from.count == 0 {
                break;
            }
            if from.cut(line, to) {
                std::mem::swap(&mut from, &mut to);
            }
        }
        from
    }

    /// Clips every face of the other hull that is turned against the reference face, and in any case what is in the
    /// plane of `incident`.
    fn faces(&self, incident: u32, margin: f32, out: &mut Manifold) {
        let mut points = [Vec4::ZERO; MAX_COLLECTED];
        let mut buffers = [Polygon::EMPTY; 2];
        let mut count = 0;
        let facing = -(self.rotation.transpose() * self.normal).extend(0.0);
        let faces = self.pair.tables.faces_of(self.pair.hull(1 - self.reference));
        for face in faces {
            if face.plane != faces[incident as usize].plane && facing.dot(face.plane) < INCIDENT_COSINE {
                continue;
            }
            if count > MAX_MANIFOLD_POINTS {
                count = self.thin(&mut points, count);
            }
            if !self.polygon(face, margin, &mut buffers[0]) {
                continue;
            }
            let earlier = count;
            let [polygon, other] = &mut buffers;
            for &p in self.clipped(polygon, other).corners() {
                let separation = self.separation(p);
                // Neighbouring faces share corners.
                let again = |q: &Vec4| q.truncate().distance_squared(p) < CLIP_TOLERANCE * CLIP_TOLERANCE;
                if separation <= margin && !points[..earlier].iter().any(again) {
                    points[count] = p.extend(separation);
                    count += 1;
                }
            }
        }
        if count > MAX_MANIFOLD_POINTS {
            count = self.thin(&mut points, count);
        }
        if count > 0 {
            let normal = self.pair.poses[self.reference].rotation * self.normal;
            out.normal = if self.reference == 0 { normal } else { -normal };
            points[..count].iter().for_each(|p| self.put(p.truncate(), p.w, out));
        }
    }

    /// Keeps `MAX_MANIFOLD_POINTS` of the points (w: separation).
    fn thin(&self, points: &mut [Vec4; MAX_COLLECTED], count: usize) -> usize {
        let kept = reduce(count, |i| (points[i].truncate(), points[i].w), self.normal);
        let mut chosen = [Vec4::ZERO; MAX_MANIFOLD_POINTS];
        chosen.iter_mut().zip(kept.indices()).for_each(|(to, &from)| *to = points[from as usize]);
        points[..MAX_MANIFOLD_POINTS].copy_from_slice(&chosen);
        kept.indices().len()
    }

    /// Adds a point of the other hull, in the reference hull's frame, and its foot on the reference face.
    fn put(&self, point: Vec3, separation: f32, out: &mut Manifold) {
        let pose = self.pair.poses[self.reference];
        let on_other = pose.point(point);
        let shift = separation * out.normal;
        let (on_a, on_b) =
            if self.reference == 0 { (on_other - shift, on_other) } else { (on_other, on_other + shift) };
        out.slots[out.count as usize] = ManifoldPoint { on_a, on_b, separation };
        out.count += 1;
    }

    /// The nearest points (on A, on B, world frame) of the outlines of the reference face and of a face of the other
    /// hull.
    fn nearest_outlines(&self, incident: u32) -> (Vec3, Vec3) {
        let other = self.pair.hull(1 - self.reference);
        let vertices = self.pair.tables.vertices_of(other);
        let other = self.pair.tables.ring_of(other, incident);
        let at = |k: usize| self.vertices[self.ring[k % self.ring.len()] as usize].truncate();
        let other_at = |l: usize| self.carried(vertices[other[l % other.len()] as usize]);
        let (mut least, mut nearest) = (f32::INFINITY, (Vec3::ZERO, Vec3::ZERO));
        for k in 0..self.ring.len() {
            for l in 0..other.len() {
                let (p, q) = nearest_on_segments([at(k), at(k + 1)], [other_at(l), other_at(l + 1)]);
                let square = p.distance_squared(q);
                if square < least {
                    (least, nearest) = (square, (p, q));
                }
            }
        }
        let pose = self.pair.poses[self.reference];
        let (p, q) = (pose.point(nearest.0), pose.point(nearest.1));
        if self.reference == 0 { (p, q) } else { (q, p) }
    }

    /// A vertex of the other hull in the reference hull's frame.
    fn carried(&self, vertex: Vec4) -> Vec3 {
        self.rotation * vertex.truncate() + self.shift
    }
}
