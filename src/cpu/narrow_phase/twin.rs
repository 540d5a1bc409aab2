//! The separating-axis search that the shader runs, in A's frame.
//!
//! The axis of least overlap of two convex polyhedra is a face normal of A, a face normal of B, or a common normal of
//! an edge of each whose arcs on the Gauss map cross (Gregorius, "The separating axis test", GDC 2013). Three things
//! keep the search short. The axis of the last step is tried first. As soon as one axis separates by more than asked,
//! the search ends. And with c, r a ball inside the other hull, the separation along n is at most n · (c − p) − r for
//! any p that supports this hull along n, so that most faces and edges are ruled out without looking at a vertex.

use super::twin_tables::{EdgeLanes, Lanes, Planes, TwinHull, TwinTables};
use super::{Feature, HullPair, PairCache, Separation};
use crate::world::constants::{
    AXIS_BIAS, AXIS_BIAS_RELATIVE, CLIP_TOLERANCE, COHERENT_DEPTH, LINEAR_SLOP, MAX_HULL_EDGES, MAX_HULL_FACES,
    PARALLEL_SINE,
};
use crate::world::{Edge, HullTables};
use glam::{Mat3, Vec3, Vec4};

const PLANE_GROUPS: usize = MAX_HULL_FACES.div_ceil(4);

/// The search, with its tables of all hulls of a world.
#[derive(Clone, Debug)]
pub struct Twin {
    tables: TwinTables,
}

/// An axis in A's frame, the separation along it and what that is worth beside others, m.
#[derive(Clone, Copy)]
struct Axis {
    distance: f32,
    worth: f32,
    normal: Vec3,
    feature: Feature,
}

/// What the search returns when one axis separates by more than asked.
struct Apart(Feature);

impl Twin {
    /// Tables for the hulls of a world.
    pub fn new(tables: &HullTables) -> Self {
        Self { tables: TwinTables::new(tables) }
    }

    /// See `Separator::separation`.
    pub fn separation(&self, pair: &HullPair, margin: f32, cache: &mut PairCache) -> Option<Separation> {
        let frame = Frame::new(&self.tables, pair, margin)?;
        let world = |axis: Axis| Separation {
            distance: axis.distance,
            normal: pair.poses[0].rotation * axis.normal,
            feature: axis.feature,
        };
        let cached = cache.feature().and_then(|feature| frame.evaluate(feature));
        if let Some(axis) = cached {
            if axis.distance > margin {
                return None;
            }
            if axis.distance >= -COHERENT_DEPTH && frame.certified(&axis) {
                return Some(world(axis));
            }
        }
        match frame.search(cached, margin, AXIS_BIAS, AXIS_BIAS_RELATIVE) {
            Ok(axis) => {
                *cache = PairCache::store(axis.feature);
                Some(world(axis))
            }
            Err(Apart(feature)) => {
                *cache = PairCache::store(feature);
                None
            }
        }
    }

    /// See `Separator::depth`.
    pub fn depth(&self, pair: &HullPair, ignored: f32) -> f32 {
        let Some(frame) = Frame::new(&self.tables, pair, 0.0) else { return 0.0 };
        frame.search(None, -ignored, 0.0, 0.0).map_or(0.0, |axis| (-axis.distance).max(0.0))
    }
}

/// Both hulls and the motion that takes B's frame into A's.
struct Frame<'a> {
    pair: &'a HullPair<'a>,
    tables: &'a TwinTables,
    a: &'a TwinHull,
    b: &'a TwinHull,
    rotation: Mat3,
    shift: Vec3,
}

impl<'a> Frame<'a> {
    /// `None` if the balls around the hulls are farther apart than `margin` or a pose is not finite.
    fn new(tables: &'a TwinTables, pair: &'a HullPair<'a>, margin: f32) -> Option<Self> {
        let (rotation, shift) = pair.other_to(0);
        let (hull_a, hull_b) = (pair.hull(0), pair.hull(1));
        let reach = hull_a.radius + hull_b.radius + margin;
        let near = (rotation * hull_b.center + shift - hull_a.center).length_squared() <= reach * reach;
        let [a, b] = pair.hulls.map(|h| &tables.hulls[h as usize]);
        near.then_some(Self { pair, tables, a, b, rotation, shift })
    }

    fn edges(&self, side: usize) -> &'a [Edge] {
        self.pair.tables.edges_of(self.pair.hull(side))
    }

    /// Start and direction (unit) of an edge in its body's frame.
    fn edge(&self, side: usize, edge: &Edge) -> (Vec3, Vec3) {
        let vertices = self.pair.tables.vertices_of(self.pair.hull(side));
        let [p, q] = edge.vertices.map(|v| vertices[v as usize].truncate());
        (p, (q - p).normalize_or_zero())
    }

    /// Separation along a unit axis, from all vertices.
    fn along(&self, axis: Vec3) -> f32 {
        let axis_b = self.rotation.transpose() * axis;
        lowest(self.tables.vertices_of(self.b), axis_b)
            + axis.dot(self.shift)
            + lowest(self.tables.vertices_of(self.a), -axis)
    }

    /// The axis of a feature at the present poses; `None` if edges are parallel or no longer support their hulls.
    fn evaluate(&self, feature: Feature) -> Option<Axis> {
        let faces = |side: usize| self.pair.tables.faces_of(self.pair.hull(side));
        let normal = match feature {
            Feature::FaceA(i) => faces(0)[i as usize].normal(),
            Feature::FaceB(j) => -(self.rotation * faces(1)[j as usize].normal()),
            Feature::Edges(i, j) => {
                let (p, u) = self.edge(0, &self.edges(0)[i as usize]);
                let (q, v) = self.edge(1, &self.edges(1)[j as usize]);
                let cross = u.cross(self.rotation * v);
                let axis = cross.normalize_or_zero();
                let axis = if axis.dot(p - self.a.center) < 0.0 { -axis } else { axis };
                let between = axis.dot(self.rotation * q + self.shift - p);
                let distance = self.along(axis);
                let supported =
                    between - distance <= LINEAR_SLOP && cross.length_squared() > PARALLEL_SINE * PARALLEL_SINE;
                return supported.then(|| self.axis(distance, axis, feature));
            }
            Feature::Points { .. } => return None,
        };
        Some(self.axis(self.along(normal), normal, feature))
    }

    fn axis(&self, distance: f32, normal: Vec3, feature: Feature) -> Axis {
        Axis { distance, worth: self.pair.worth(normal, distance), normal, feature }
    }

    /// True if two points of the hulls face each other along the axis at its distance: then the distance of hulls apart
    /// is exact, and no axis of overlapping ones is better by more than twice the depth.
    fn certified(&self, axis: &Axis) -> bool {
        let (side, face, direction) = match axis.feature {
            Feature::FaceA(i) => (0, i, axis.normal),
            Feature::FaceB(j) => (1, j, self.pair.tables.faces_of(self.pair.hull(1))[j as usize].normal()),
            Feature::Edges(i, j) => {
                let (p, u) = self.edge(0, &self.edges(0)[i as usize]);
                let (q, v) = self.edge(1, &self.edges(1)[j as usize]);
                let length = |side: usize, k: u32| {
                    let [p, q] = self.edges(side)[k as usize]
                        .vertices
                        .map(|v| self.pair.tables.vertices_of(self.pair.hull(side))[v as usize].truncate());
                    p.distance(q)
                };
                let (v, w) = (self.rotation * v, self.rotation * q + self.shift - p);
                let (b, c, d) = (u.dot(v), u.dot(w), v.dot(w));
                let determinant = 1.0 - b * b;
                let (s, t) = (c - b * d, b * c - d);
                return s >= 0.0 && t >= 0.0 && s <= length(0, i) * determinant && t <= length(1, j) * determinant;
            }
            Feature::Points { .. } => return false,
        };
        let tables = self.pair.tables;
        let hull = self.pair.hull(side);
        let face = &tables.faces_of(hull)[face as usize];
        let (corners, vertices) = (tables.corners_of(face), tables.vertices_of(hull));
        let (rotation, shift) = self.pair.other_to(side);
        let along = rotation.transpose() * direction;
        let deepest = face.plane.w + axis.distance - direction.dot(shift) + CLIP_TOLERANCE;
        tables.vertices_of(self.pair.hull(1 - side)).iter().map(|v| v.truncate()).any(|v| {
            let inside = |p: Vec3| {
                let mut start = vertices[corners[corners.len() - 1] as usize].truncate();
                corners.iter().all(|&c| {
                    let end = vertices[c as usize].truncate();
                    let outward = (end - start).cross(direction);
                    let beyond = outward.dot(p - start);
                    start = end;
                    beyond <= 0.0
                })
            };
            along.dot(v) <= deepest && inside(rotation * v + shift)
        })
    }

    /// The axis of largest separation, or one that separates by more than `stop`. Faces of the larger hull are
    /// preferred to faces of the other, and faces to edges, by `bias` plus a share `relative` of the depth.
    fn search(&self, cached: Option<Axis>, stop: f32, bias: f32, relative: f32) -> Result<Axis, Apart> {
        let preference = |distance: f32| bias + relative * (-distance).max(0.0);
        // Whatever is worse than the cached axis by more than both preferences cannot win.
        let floor = cached.map_or(f32::NEG_INFINITY, |c| c.worth - 2.0 * preference(c.worth) - LINEAR_SLOP);
        let threshold = |best: Option<Axis>| best.map_or(floor, |best| best.worth + preference(best.worth));

        let vertices_a = self.tables.vertices_of(self.a);
        let mut heights = [[Vec4::ZERO; PLANE_GROUPS]; 2];
        let balls =
            [(self.rotation * self.b.center + self.shift, self.b.inner_radius), (self.a.center, self.a.inner_radius)];
        let mut best = None;
        let first = self.pair.larger();
        for side in [first, 1 - first] {
            let hull = [self.a, self.b][side];
            let planes = |group: usize| {
                let planes = &self.tables.planes_of(hull)[group];
                if side == 0 { *planes } else { planes.moved(&self.rotation, self.shift) }
            };
            // Each hull's vertices stay in its own frame: as few are read as by the shader, in the same order.
            let height = |normal: Vec3| match side {
                0 => {
                    lowest(self.tables.vertices_of(self.b), self.rotation.transpose() * normal) + normal.dot(self.shift)
                }
                _ => lowest(vertices_a, normal),
            };
            let axis = |face: u32, normal: Vec3, distance: f32| match side {
                0 => self.axis(distance, normal, Feature::FaceA(face)),
                _ => self.axis(distance, -normal, Feature::FaceB(face)),
            };
            let heights = &mut heights[side][..hull.plane_groups as usize];
            let found = best_face(planes, height, axis, balls[side], threshold(best), stop, heights);
            if let Some(axis) = found {
                if axis.distance > stop {
                    return Err(Apart(axis.feature));
                }
                best = found;
            }
        }
        if let Some(edges) = self.best_edges(&heights, threshold(best), stop) {
            return if edges.distance > stop { Err(Apart(edges.feature)) } else { Ok(edges) };
        }
        // Neither: only where a pose is not a number.
        best.or(cached).ok_or(Apart(Feature::FaceA(0)))
    }

    /// The edge pair whose axis separates most, if by more than `threshold`, or the first that separates by more than
    /// `stop`.
    fn best_edges(&self, heights: &[[Vec4; PLANE_GROUPS]; 2], threshold: f32, stop: f32) -> Option<Axis> {
        let edges_b = self.edges(1);
        let mut list_a = [0_u8; MAX_HULL_EDGES];
        let mut list_b = [0_u8; MAX_HULL_EDGES];
        let list_a = self.facing_edges(0, &heights[0], self.b.inner_radius + threshold, &mut list_a);
        let list_b = self.facing_edges(1, &heights[1], self.a.inner_radius + threshold, &mut list_b);
        if list_a.is_empty() || list_b.is_empty() {
            return None;
        }
        let (faces_b, vertices_b) =
            (self.pair.tables.faces_of(self.pair.hull(1)), self.pair.tables.vertices_of(self.pair.hull(1)));
        let normal_b = |face: u32| self.rotation * faces_b[face as usize].normal();
        let vertex_b = |vertex: u32| self.rotation * vertices_b[vertex as usize].truncate() + self.shift;
        let lines_a = &self.tables.edges[self.pair.hull(0).first_edge as usize..];
        let line_a = |group: &[u8], k: usize| &lines_a[group[k.min(group.len() - 1)] as usize];
        // On the heap: an array for the most edges would take longer to clear than these few to fill.
        let groups_a = list_a.chunks(4).map(|group| EdgeLanes::gather(|k| line_a(group, k)));
        let groups_a: Vec<EdgeLanes> = groups_a.collect();

        let mut best: Option<Axis> = None;
        let mut least = threshold;
        // Edge by edge of B and, to each, of A by their numbers, four of A at a time: of pairs that part the hulls
        // equally far, the first is taken.
        for &j in list_b {
            let edge = &edges_b[j as usize];
            let [left, right] = edge.faces.map(normal_b);
            let [start, end] = edge.vertices.map(vertex_b);
            let along = (end - start).normalize_or_zero();
            for (group, list) in groups_a.iter().zip(list_a.chunks(4)) {
                // The arcs left–right of A and of B, the latter turned round, must cross on the Gauss map.
                let (left_side, right_side) = (group.along.dot(left), group.along.dot(right));
                let (near_side, far_side) = (group.left.dot(along), group.right.dot(along));
                let crossing = (left_side * right_side).cmplt(Vec4::ZERO)
                    & (near_side * far_side).cmplt(Vec4::ZERO)
                    & (left_side * far_side).cmplt(Vec4::ZERO);
                if !crossing.any() {
                    continue;
                }
                let cross = group.along.crossed_with(along);
                let square = cross.dot_lanes(&cross);
                let outward = cross.dot_lanes(&group.left.plus(&group.right));
                let gap = cross.dot_lanes(&group.start.toward(start));
                for (k, &i) in list.iter().enumerate() {
                    let (square, sign) = (square[k], if outward[k] < 0.0 { -1.0 } else { 1.0 });
                    if !crossing.test(k) || square < PARALLEL_SINE * PARALLEL_SINE {
                        continue;
                    }
                    let length = square.sqrt();
                    if sign * gap[k] <= least * length {
                        continue;
                    }
                    let normal = cross.lane(k) * (sign / length);
                    // Nearly parallel edges leave the axis uncertain: only the vertices tell what it separates.
                    let axis = self.axis(self.along(normal), normal, Feature::Edges(u32::from(i), u32::from(j)));
                    if axis.worth > least {
                        least = axis.worth;
                        best = Some(axis);
                        if axis.distance > stop {
                            return best;
                        }
                    }
                }
            }
        }
        best
    }

    /// Edges of `side` that can carry an axis on which the other hull's ball reaches `limit` (m) or farther. `heights`
    /// are the ball's centre over the faces.
    fn facing_edges<'l>(
        &self,
        side: usize,
        heights: &[Vec4; PLANE_GROUPS],
        limit: f32,
        list: &'l mut [u8; MAX_HULL_EDGES],
    ) -> &'l [u8] {
        let hull = [self.a, self.b][side];
        let edges = self.pair.hull(side).edge_count as usize;
        let heights: &[f32] = bytemuck::cast_slice(heights);
        let limit = limit - hull.slack;
        let mut count = 0;
        for (group, first) in self.tables.edge_faces_of(hull).iter().zip((0..edges).step_by(4)) {
            let [left, right] = [group.left, group.right].map(|f| Vec4::from_array(f.map(|f| heights[f as usize])));
            // The height over the arc between the two normals peaks inside the arc, or at one of its ends.
            let (toward_left, toward_right) = (left - group.cosine * right, right - group.cosine * left);
            let square = limit * limit * (1.0 - group.cosine * group.cosine);
            let peak = toward_left.cmpgt(Vec4::ZERO)
                & toward_right.cmpgt(Vec4::ZERO)
                & (left * toward_left + right * toward_right).cmpgt(square);
            let facing = (left.max(right).cmpgt(Vec4::splat(limit)) | peak).bitmask();
            for k in (0..4.min(edges - first)).filter(|k| facing >> k & 1 == 1) {
                list[count] = (first + k) as u8;
                count += 1;
            }
        }
        &list[..count]
    }
}

/// The least dot product of `direction` with any of the vertices.
#[inline(always)]
fn lowest(vertices: &[Lanes], direction: Vec3) -> f32 {
    vertices.iter().fold(Vec4::INFINITY, |low, v| low.min(v.dot(direction))).min_element()
}

/// The axis of the plane over which a hull lies highest, by its worth, if that is more than `floor`; or of the first
/// over which it lies higher than `stop`. First is the plane farthest from the ball inside this hull, then the others
/// by their numbers. `lowest` is how far along a direction the hull begins. The heights of the ball's centre over the
/// planes go to `heights`.
fn best_face(
    planes: impl Fn(usize) -> Planes,
    lowest: impl Fn(Vec3) -> f32,
    axis: impl Fn(u32, Vec3, f32) -> Axis,
    (center, inner): (Vec3, f32),
    floor: f32,
    stop: f32,
    heights: &mut [Vec4],
) -> Option<Axis> {
    let mut peak = Vec4::NEG_INFINITY;
    for (group, height) in heights.iter_mut().enumerate() {
        let Planes { normal, offset } = planes(group);
        *height = normal.dot(center) - offset;
        peak = peak.max(*height);
    }
    let peak = Vec4::splat(peak.max_element());
    // The plane farthest from the centre first: it is often the best one and rules out the others.
    let reached = heights.iter().map(|h| h.cmpge(peak).bitmask()).zip(0..).find(|(lanes, _)| *lanes != 0);
    let start = reached.map_or(0, |(lanes, group)| 4 * group + lanes.trailing_zeros() as usize);
    let (mut least, mut best) = (floor, None);
    // True if the plane at this place ends the search.
    let mut ends = |group: usize, k: usize, least: &mut f32| {
        let Planes { normal, offset } = planes(group);
        let normal = normal.lane(k);
        let found = axis((4 * group + k) as u32, normal, lowest(normal) - offset[k]);
        let better = found.worth > *least;
        if better {
            (*least, best) = (found.worth, Some(found));
        }
        better && found.distance > stop
    };
    if heights[start / 4][start % 4] - inner > least && ends(start / 4, start % 4, &mut least) {
        return best;
    }
    for (group, height) in heights.iter().enumerate() {
        let height = *height - Vec4::splat(inner);
        if !height.cmpgt(Vec4::splat(least)).any() {
            continue;
        }
        for k in 0..4 {
            if height[k] > least && 4 * group + k != start && ends(group, k, &mut least) {
                return best;
            }
        }
    }
    best
}
