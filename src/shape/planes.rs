//! Where to cut a piece: at the plane whose two sides cost least, or along its largest face.
//!
//! Candidate planes are evenly spaced and, above all, the planes of large flat facets: the underside of a table top is
//! where it parts from its legs.

use super::hull::{Hull, directions, plane_sides};
use super::solid::Solid;
use super::split::numbered;
use super::tolerances::hull::MIN_THICKNESS;
use super::tolerances::planes::{EVEN_CUTS, FACE, FACET_CUTS, PLANNED};
use glam::Vec3;
use std::collections::BTreeMap;

/// The plane `normal · x = offset` whose two sides cost least. Facets come first and win ties: a cut beside a facet
/// leaves a layer too thin for the grid to see.
pub(super) fn best_cut(
    triangles: &[[Vec3; 3]],
    hull: &Hull,
    solid: &Solid,
    up: Vec3,
    cost: impl Fn(&Hull) -> f32,
) -> Option<(Vec3, f32)> {
    let spans = spans(hull, up, solid.cell());
    let facets = spans.iter().flat_map(|s| s.facets(triangles, solid.cell()).into_iter().map(|(_, at)| (s.normal, at)));
    let planes = facets.chain(spans.iter().flat_map(|s| s.even().map(|at| (s.normal, at))));
    cheapest(planes, &Wire::new(triangles), &directions(42), f32::INFINITY, cost)
}

/// The first of the planes at which the two sides of a surface cost least together, if less than `limit`. A cost is never
/// below 0; hulls of the sides have their extreme points along the `probes`.
pub(super) fn cheapest(
    planes: impl Iterator<Item = (Vec3, f32)>,
    wire: &Wire,
    probes: &[Vec3],
    limit: f32,
    cost: impl Fn(&Hull) -> f32,
) -> Option<(Vec3, f32)> {
    let (mut least, mut best) = (limit, None);
    for (normal, offset) in planes {
        let (below, above) = plane_sides(&wire.vertices, &wire.edges, normal, offset);
        // Where the side with more of the surface costs too much already, the other need not be looked at.
        let [larger, other] = if below.len() < above.len() { [above, below] } else { [below, above] };
        let cost = |side: &[Vec3]| Hull::coarse(side, probes).map(|hull| cost(&hull));
        let Some(first) = cost(&larger).filter(|first| *first < least) else { continue };
        if let Some(both) = cost(&other).map(|second| first + second).filter(|both| *both < least) {
            (least, best) = (both, Some((normal, offset)));
        }
    }
    best
}

/// The plane of the largest facet that is more than a share `FACE` of the hull's surface.
pub(super) fn largest_face(triangles: &[[Vec3; 3]], hull: &Hull, solid: &Solid, up: Vec3) -> Option<(Vec3, f32)> {
    let spans = spans(hull, up, solid.cell());
    let largest =
        spans.iter().filter_map(|s| s.facets(triangles, solid.cell()).first().map(|&(area, at)| (area, s.normal, at)));
    let (area, normal, at) = largest.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (area > FACE * hull.area()).then_some((normal, at))
}

/// The axes, and the two horizontal directions between them.
fn spans(hull: &Hull, up: Vec3, cell: f32) -> [Span; 5] {
    let (u, v) = up.any_orthonormal_pair();
    let (u, v) = if u.abs().max_element() > 0.999 { (u, v) } else { (Vec3::X, Vec3::Z) };
    [Vec3::X, Vec3::Y, Vec3::Z, (u + v).normalize(), (u - v).normalize()].map(|normal| Span::new(hull, normal, cell))
}

/// Where along a direction a piece may be cut.
struct Span {
    normal: Vec3,
    low: f32,
    high: f32,
    margin: f32,
}

impl Span {
    fn new(hull: &Hull, normal: Vec3, cell: f32) -> Self {
        let (low, high) = hull.extent(normal);
        Self { normal, low, high, margin: (0.2 * cell).max(0.5 * MIN_THICKNESS).min(0.05 * (high - low)) }
    }

    /// Areas of the largest facets and their planes, largest first.
    fn facets(&self, triangles: &[[Vec3; 3]], cell: f32) -> Vec<(f32, f32)> {
        let mut areas: BTreeMap<i64, (f32, f32)> = BTreeMap::new();
        for t in triangles {
            let cross = (t[1] - t[0]).cross(t[2] - t[0]);
            let area = cross.length();
            if area > 0.0 && cross.dot(self.normal).abs() > 0.995 * area {
                let at = self.normal.dot(t[0] + t[1] + t[2]) / 3.0;
                let slot = areas.entry((at / (0.1 * cell)).round() as i64).or_default();
                *slot = (slot.0 + area, slot.1 + area * at);
            }
        }
        let mut facets: Vec<(f32, f32)> = areas.into_values().map(|(area, sum)| (0.5 * area, sum / area)).collect();
        facets.retain(|&(_, at)| at > self.low + self.margin && at < self.high - self.margin);
        facets.sort_by(|a, b| b.0.total_cmp(&a.0));
        facets.truncate(FACET_CUTS);
        facets
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
