//! Top-down: from triangles to convex-ish pieces, each with exactly the surface that lies in it.
//!
//! A piece is cut by the plane that leaves the least bulge (`Solid::protrusion`) on its two sides; triangles are
//! clipped exactly, so that every hull's vertices lie on the mesh and the hulls together cover it. Candidate planes
//! are evenly spaced and, above all, the planes of large flat facets: the underside of a table top is where it parts
//! from its legs. What a cut disconnects (four legs) falls apart at once.

use super::hull::{Hull, MIN_THICKNESS, directions, plane_sides, supports};
use super::solid::Solid;
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// Evenly spaced candidate planes for each direction.
const EVEN_CUTS: usize = 9;
/// Candidate planes for each direction that lie in large flat facets.
const FACET_CUTS: usize = 8;

/// Cuts are planned on about so many triangles, evenly picked; they are made on all.
const PLANNED: usize = 10_000;

/// A part of the surface and its hull.
#[derive(Clone)]
pub(super) struct Piece {
    /// Clipped triangles, m.
    pub triangles: Vec<[Vec3; 3]>,
    /// Their hull.
    pub hull: Hull,
    /// Free space in the hull, weighted by its distance to the surface, m⁴.
    pub bulge: f32,
}

impl Piece {
    /// The piece that consists of these triangles.
    pub fn new(triangles: Vec<[Vec3; 3]>, solid: &Solid) -> Option<Self> {
        Self::with_core(triangles, Vec::new(), solid)
    }

    /// The same with points inside the solid that belong to it, too.
    fn with_core(triangles: Vec<[Vec3; 3]>, core: Vec<Vec3>, solid: &Solid) -> Option<Self> {
        let points = [triangles.as_flattened(), &core].concat();
        let hull = Hull::new(&points)?;
        let bulge = solid.protrusion(&hull).0;
        Some(Self { triangles, hull, bulge })
    }

    /// The pieces on both sides of the plane through the middle of its extent along `axis`; `filled` if nothing else of the object
    /// reaches into its hull.
    pub fn halves(&self, axis: Vec3, solid: &Solid, filled: bool) -> [Option<Self>; 2] {
        let (low, high) = self.hull.extent(axis);
        let offset = 0.5 * (low + high);
        let [below, above] = clip(&self.triangles, axis, offset);
        let [core_below, core_above] = if filled { self.core(axis, offset, solid) } else { Default::default() };
        [Self::with_core(below, core_below, solid), Self::with_core(above, core_above, solid)]
    }

    /// What of the hull lies deep in the solid, on both sides of a plane. The surface on one side of three planes leaves out the
    /// corner in which they meet: a ball would be hollow.
    fn core(&self, normal: Vec3, offset: f32, solid: &Solid) -> [Vec<Vec3>; 2] {
        let (below, above) = plane_sides(&self.hull.vertices, &self.hull.edges(), normal, offset);
        [below, above].map(|mut side| {
            side.retain(|&point| solid.is_deep(solid.index(point)));
            side
        })
    }

    /// Several pieces as one.
    pub fn joined<'a>(members: impl Iterator<Item = &'a Piece> + Clone) -> Option<Self> {
        let points: Vec<Vec3> = members.clone().flat_map(|piece| piece.hull.vertices.iter().copied()).collect();
        let bulge = members.clone().map(|piece| piece.bulge).sum();
        let triangles = members.flat_map(|piece| piece.triangles.iter().copied()).collect();
        Some(Self { triangles, hull: Hull::new(&points)?, bulge })
    }
}

/// Splits the pieces with the largest bulge until there are `most` of them or none bulges by more than `enough` (m⁴).
pub(super) fn split(mut pieces: Vec<Piece>, solid: &Solid, up: Vec3, most: usize, enough: f32) -> Vec<Piece> {
    let mut done: Vec<Piece> = Vec::new();
    while pieces.len() + done.len() < most {
        let Some(worst) = (0..pieces.len()).max_by(|&a, &b| pieces[a].bulge.total_cmp(&pieces[b].bulge)) else {
            break;
        };
        let piece = pieces.swap_remove(worst);
        if piece.bulge <= enough {
            done.push(piece);
            break;
        }
        let sides: Vec<Piece> = best_cut(&piece, solid, up)
            .map(|(normal, offset)| {
                clip(&piece.triangles, normal, offset)
                    .into_iter()
                    .flat_map(|side| connected(side, solid, normal, offset))
                    .filter_map(|side| Piece::new(side, solid))
                    .collect()
            })
            .unwrap_or_default();
        if sides.len() < 2 {
            done.push(piece);
        } else {
            pieces.extend(sides);
        }
    }
    done.extend(pieces);
    done
}

/// The plane `normal · x = offset` whose two sides bulge least. Facets come first and win ties: a cut beside a facet
/// leaves a layer too thin for the grid to see.
fn best_cut(piece: &Piece, solid: &Solid, up: Vec3) -> Option<(Vec3, f32)> {
    let probes = directions(42);
    let wire = Wire::new(&piece.triangles);
    let (u, v) = up.any_orthonormal_pair();
    let (u, v) = if u.abs().max_element() > 0.999 { (u, v) } else { (Vec3::X, Vec3::Z) };
    let normals = Vec3::AXES.into_iter().chain([(u + v).normalize(), (u - v).normalize()]);
    let spans: Vec<Span> = normals.map(|normal| Span::new(piece, normal, solid.cell())).collect();
    let facets = spans.iter().flat_map(|s| s.facets(piece, solid.cell()).into_iter().map(|at| (s.normal, at)));
    let mut best: Option<(f32, Vec3, f32)> = None;
    for (normal, offset) in facets.chain(spans.iter().flat_map(|s| s.even().map(|at| (s.normal, at)))) {
        let (below, above) = plane_sides(&wire.vertices, &wire.edges, normal, offset);
        let (Some(below), Some(above)) = (Hull::coarse(&below, &probes), Hull::coarse(&above, &probes)) else {
            continue;
        };
        let bulge = solid.protrusion(&below).0 + solid.protrusion(&above).0;
        if best.is_none_or(|b| bulge < b.0) {
            best = Some((bulge, normal, offset));
        }
    }
    best.map(|b| (b.1, b.2))
}

/// Where along a direction a piece may be cut.
struct Span {
    normal: Vec3,
    low: f32,
    high: f32,
    margin: f32,
}

impl Span {
    fn new(piece: &Piece, normal: Vec3, cell: f32) -> Self {
        let (low, high) = piece.hull.extent(normal);
        Self { normal, low, high, margin: (0.2 * cell).max(0.5 * MIN_THICKNESS).min(0.05 * (high - low)) }
    }

    /// The planes of the largest facets, largest first.
    fn facets(&self, piece: &Piece, cell: f32) -> Vec<f32> {
        let mut areas: BTreeMap<i64, (f32, f32)> = BTreeMap::new();
        for t in &piece.triangles {
            let cross = (t[1] - t[0]).cross(t[2] - t[0]);
            let area = cross.length();
            if area > 0.0 && cross.dot(self.normal).abs() > 0.995 * area {
                let at = self.normal.dot(t[0] + t[1] + t[2]) / 3.0;
                let slot = areas.entry((at / (0.1 * cell)).round() as i64).or_default();
                *slot = (slot.0 + area, slot.1 + area * at);
            }
        }
        let mut facets: Vec<(f32, f32)> = areas.into_values().map(|(area, sum)| (area, sum / area)).collect();
        facets.sort_by(|a, b| b.0.total_cmp(&a.0));
        let within = |at: &f32| *at > self.low + self.margin && *at < self.high - self.margin;
        facets.into_iter().map(|f| f.1).filter(within).take(FACET_CUTS).collect()
    }

    /// Evenly spaced planes.
    fn even(&self) -> impl Iterator<Item = f32> + use<'_> {
        (1..=EVEN_CUTS).map(|i| self.low + (self.high - self.low) * i as f32 / (EVEN_CUTS + 1) as f32)
    }
}

/// The vertices and edges of a set of triangles, or of so many of them as cuts are planned on, each once.
pub(super) struct Wire {
    pub vertices: Vec<Vec3>,
    pub edges: Vec<[u32; 2]>,
}

impl Wire {
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let stride = triangles.len().div_ceil(PLANNED).max(1);
        let planned: Vec<[Vec3; 3]> = triangles.iter().copied().step_by(stride).collect();
        let (corners, count) = numbered(&planned);
        let mut vertices = vec![Vec3::ZERO; count];
        let mut edges = Vec::with_capacity(3 * planned.len());
        for (t, c) in planned.iter().zip(&corners) {
            for k in 0..3 {
                vertices[c[k] as usize] = t[k];
                edges.push([c[k].min(c[(k + 1) % 3]), c[k].max(c[(k + 1) % 3])]);
            }
        }
        edges.sort_unstable();
        edges.dedup();
        Self { vertices, edges }
    }
}

/// Vertex numbers of the triangles' corners, equal positions sharing one, and how many there are.
fn numbered(triangles: &[[Vec3; 3]]) -> (Vec<[u32; 3]>, usize) {
    // Adding zero makes −0 and 0 the same key.
    let mut keyed: Vec<([u32; 3], u32)> = triangles
        .as_flattened()
        .iter()
        .enumerate()
        .map(|(i, p)| ((*p + Vec3::ZERO).to_array().map(f32::to_bits), i as u32))
        .collect();
    keyed.sort_unstable();
    let mut corners = vec![[0; 3]; triangles.len()];
    let mut count = 0;
    for same in keyed.chunk_by(|a, b| a.0 == b.0) {
        for (_, i) in same {
            corners[*i as usize / 3][*i as usize % 3] = count;
        }
        count += 1;
    }
    (corners, count as usize)
}

/// Cuts triangles at a plane. A triangle within it goes to the side on which the solid is, against its normal.
pub(super) fn clip(triangles: &[[Vec3; 3]], normal: Vec3, offset: f32) -> [Vec<[Vec3; 3]>; 2] {
    let (mut below, mut above) = (Vec::new(), Vec::new());
    let scale = triangles.as_flattened().iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    let flat = 2e-6 * scale;
    for t in triangles {
        let d = t.map(|p| normal.dot(p) - offset).map(|d| if d.abs() <= flat { 0.0 } else { d });
        if d == [0.0; 3] {
            let outward = (t[1] - t[0]).cross(t[2] - t[0]).dot(normal);
            if outward > 0.0 {
                below.push(*t)
            } else {
                above.push(*t)
            }
            continue;
        }
        for (side, sign) in [(&mut below, -1.0), (&mut above, 1.0)] {
            let mut polygon: Vec<Vec3> = Vec::with_capacity(4);
            for k in 0..3 {
                let (p, q, dp, dq) = (t[k], t[(k + 1) % 3], sign * d[k], sign * d[(k + 1) % 3]);
                if dp >= 0.0 {
                    polygon.push(p);
                }
                if dp * dq < 0.0 {
                    // The same formula from both sides, so that the two sides meet in the same point.
                    let (p, q, dp, dq) = if sign * dp < 0.0 { (p, q, dp, dq) } else { (q, p, dq, dp) };
                    polygon.push(p + (q - p) * (dp / (dp - dq)));
                }
            }
            if d.iter().any(|d| sign * d > 0.0) {
                side.extend((2..polygon.len()).map(|k| [polygon[0], polygon[k - 1], polygon[k]]));
            }
        }
    }
    [below, above]
}

/// Separates triangles that no solid connects: cells they touch and inside cells on their side of the cut.
fn connected(triangles: Vec<[Vec3; 3]>, solid: &Solid, normal: Vec3, offset: f32) -> Vec<Vec<[Vec3; 3]>> {
    if triangles.is_empty() {
        return Vec::new();
    }
    let mean = triangles.iter().map(|t| normal.dot(t[0] + t[1] + t[2]) / 3.0 - offset).sum::<f32>();
    let (low, high) = super::hull::bounds(triangles.as_flattened());
    let touched: Vec<Vec<usize>> = triangles.iter().map(|t| cells(t, solid)).collect();
    // Triangles that touch a cell, sorted by cell.
    let mut holders: Vec<(usize, usize)> =
        touched.iter().enumerate().flat_map(|(t, cells)| cells.iter().map(move |&c| (c, t))).collect();
    holders.sort_unstable();
    const WALL: u8 = 0;
    const OPEN: u8 = 1;
    const SURFACE: u8 = 2;
    let mut state = vec![WALL; solid.cells()];
    for i in solid.cells_within(low, high) {
        if solid.is_inside(i) && (normal.dot(solid.center(i)) - offset) * mean >= 0.0 {
            state[i] = OPEN;
        }
    }
    holders.iter().for_each(|h| state[h.0] = SURFACE);
    let mut count = 0;
    let mut result: Vec<usize> = vec![usize::MAX; triangles.len()];
    for first in 0..triangles.len() {
        if result[first] != usize::MAX {
            continue;
        }
        result[first] = count;
        let mut stack: Vec<usize> = touched[first].clone();
        while let Some(i) = stack.pop() {
            let was = std::mem::replace(&mut state[i], WALL);
            if was == WALL {
                continue;
            }
            if was == SURFACE {
                let start = holders.partition_point(|h| h.0 < i);
                for &(_, t) in holders[start..].iter().take_while(|h| h.0 == i) {
                    if result[t] == usize::MAX {
                        result[t] = count;
                        stack.extend(&touched[t]);
                    }
                }
            }
            stack.extend(solid.neighbours(i).filter(|n| state[*n] != WALL));
        }
        count += 1;
    }
    let mut groups = vec![Vec::new(); count];
    for (t, triangle) in triangles.into_iter().enumerate() {
        groups[result[t]].push(triangle);
    }
    groups
}

/// Cells that a triangle passes, by samples closer than a cell, in rows along its longest edge.
fn cells(t: &[Vec3; 3], solid: &Solid) -> Vec<usize> {
    let length = [0, 1, 2].map(|k| t[k].distance(t[(k + 1) % 3]));
    let k = (1..3).fold(0, |best, k| if length[k] > length[best] { k } else { best });
    let (base, apex, origin) = (t[(k + 1) % 3] - t[k], t[(k + 2) % 3] - t[k], t[k]);
    let height = base.cross(apex).length() / length[k].max(f32::MIN_POSITIVE);
    let steps = |extent: f32| (extent / (0.7 * solid.cell())).ceil().max(1.0) as usize;
    let rows = steps(height);
    let mut cells = Vec::new();
    for row in 0..=rows {
        let v = row as f32 / rows as f32;
        let columns = steps(length[k] * (1.0 - v));
        cells.extend(
            (0..=columns).map(|c| solid.index(origin + apex * v + base * ((1.0 - v) * c as f32 / columns as f32))),
        );
    }
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// Connected components of a mesh: triangles that share a vertex position.
pub(super) fn components(triangles: &[[Vec3; 3]]) -> Vec<Vec<[Vec3; 3]>> {
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let (corners, count) = numbered(triangles);
    let mut parent: Vec<u32> = (0..count as u32).collect();
    for c in &corners {
        for k in 1..3 {
            let (a, b) = (root(&mut parent, c[0]), root(&mut parent, c[k]));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut groups: BTreeMap<u32, Vec<[Vec3; 3]>> = BTreeMap::new();
    for (t, c) in corners.iter().enumerate() {
        groups.entry(root(&mut parent, c[0])).or_default().push(triangles[t]);
    }
    groups.into_values().collect()
}

/// The points of a hull that matter for judging a merge: few, so that thousands of pairs can be tried.
pub(super) fn outline(hull: &Hull, probes: &[Vec3]) -> Vec<Vec3> {
    if hull.vertices.len() <= probes.len() {
        return hull.vertices.clone();
    }
    let chosen: BTreeSet<u32> = supports(&hull.vertices, probes).into_iter().collect();
    chosen.into_iter().map(|i| hull.vertices[i as usize]).collect()
}
