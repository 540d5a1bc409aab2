//! Top-down: from triangles to convex-ish pieces, each with exactly the surface that lies in it.
//!
//! Triangles are clipped exactly, so that every hull's vertices lie on the mesh, or deep in the solid, and the hulls
//! together cover it. What a cut disconnects (four legs) falls apart at once.

use super::hull::{Hull, plane_sides, supports};
use super::solid::Solid;
use super::tolerances::split::FLAT;
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};

/// A part of the surface and its hull.
#[derive(Clone)]
pub(super) struct Piece {
    /// Clipped triangles, m.
    pub triangles: Vec<[Vec3; 3]>,
    /// Hull of these and of what lies behind them, deep in the solid.
    pub hull: Hull,
    /// Free space in the hull, weighted by its distance to the surface, m⁴.
    pub bulge: f32,
}

impl Piece {
    /// The piece that consists of these triangles.
    pub fn new(triangles: Vec<[Vec3; 3]>, solid: &Solid) -> Option<Self> {
        Self::around(triangles, &[], solid)
    }

    /// The same with points inside the solid that belong to it, too.
    fn around(triangles: Vec<[Vec3; 3]>, core: &[Vec3], solid: &Solid) -> Option<Self> {
        let hull = Hull::new(&[triangles.as_flattened(), core].concat())?;
        let bulge = solid.protrusion(&hull).0;
        Some(Self { triangles, hull, bulge })
    }

    /// What lies on both sides of the plane `normal · x = offset`.
    pub fn sides(&self, normal: Vec3, offset: f32, solid: &Solid) -> [Option<Self>; 2] {
        let [below, above] = clip(&self.triangles, normal, offset);
        let [core_below, core_above] = self.core(normal, offset, solid);
        [Self::around(below, &core_below, solid), Self::around(above, &core_above, solid)]
    }

    /// The same, each side in as many pieces as nothing solid connects.
    fn parted(&self, normal: Vec3, offset: f32, solid: &Solid) -> Vec<Self> {
        let sides = clip(&self.triangles, normal, offset).map(|side| connected(side, solid, normal, offset));
        let sides = sides.into_iter().zip(self.core(normal, offset, solid));
        let pieces = sides.flat_map(|(mut connected, core)| match connected.len() {
            1 => vec![Self::around(connected.remove(0), &core, solid)],
            _ => connected.into_iter().map(|triangles| Self::new(triangles, solid)).collect(),
        });
        pieces.flatten().collect()
    }

    /// What of the hull lies deep in the solid, on both sides of a plane. The surface on one side of three planes
    /// leaves out the corner in which they meet: a ball would be hollow.
    fn core(&self, normal: Vec3, offset: f32, solid: &Solid) -> [Vec<Vec3>; 2] {
        let (below, above) = plane_sides(&self.hull.vertices, &self.hull.edges(), normal, offset);
        [below, above].map(|mut side| {
            side.retain(|&point| solid.is_deep(solid.index(point)));
            side
        })
    }
}

/// Splits the pieces with the largest bulge until there are `most` of them, none bulges by more than `enough` (m⁴) or
/// `cut` (the plane `normal · x = offset`) knows of no way.
pub(super) fn split(
    mut pieces: Vec<Piece>,
    solid: &Solid,
    most: usize,
    enough: f32,
    cut: impl Fn(&Piece) -> Option<(Vec3, f32)>,
) -> Vec<Piece> {
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
        let sides = cut(&piece).map(|(normal, offset)| piece.parted(normal, offset, solid)).unwrap_or_default();
        if sides.len() < 2 {
            done.push(piece);
        } else {
            pieces.extend(sides);
        }
    }
    done.extend(pieces);
    done
}

/// Vertex numbers of the triangles' corners, equal positions sharing one, and how many there are.
pub(super) fn numbered(triangles: &[[Vec3; 3]]) -> (Vec<[u32; 3]>, usize) {
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
    let flat = FLAT * scale;
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
