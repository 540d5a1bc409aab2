//! Mass, centre of mass and inertia of a union of convex parts at uniform density.

use super::eigen::symmetric_eigen;
use super::hull::Hull;
use glam::{DMat3, DVec3, Mat3, Quat, Vec3};

/// Points in each part at which its overlap with the others is measured.
const SAMPLES: usize = 600;
/// Products of inertia below this share of the largest moment are noise: such a body keeps the mesh's axes.
const ALIGNED: f64 = 1e-2;

/// Mass and how it is spread.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties {
    /// kg.
    pub mass: f32,
    /// Centre of mass, scaled mesh frame, m.
    pub center: Vec3,
    /// Rotation from the frame of principal axes to the mesh frame.
    pub axes: Quat,
    /// Principal moments of inertia about the centre of mass, kg m².
    pub inertia: Vec3,
}

/// Zeroth, first and second moments at density 1, in the mesh frame.
#[derive(Clone, Copy, Debug)]
struct Moments {
    volume: f64,
    first: DVec3,
    second: DMat3,
}

impl Moments {
    fn add(&mut self, volume: f64, first: DVec3, second: DMat3) {
        self.volume += volume;
        self.first += first;
        self.second += second;
    }
}

fn outer(a: DVec3) -> DMat3 {
    DMat3::from_cols(a * a.x, a * a.y, a * a.z)
}

/// Volume of the union of the parts (m³) and its mass properties for a mass of 1 kg.
///
/// Every part is integrated exactly; where parts overlap, sampled points carry the share of the parts that hold them,
/// so that an overlap counts once (to the sampling error).
pub(super) fn of_union(parts: &[Hull]) -> (f32, MassProperties) {
    let mut sum = Moments { volume: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };
    for (i, part) in parts.iter().enumerate() {
        let neighbours: Vec<&Hull> =
            (0..parts.len()).filter(|&j| j != i && boxes_meet(part, &parts[j])).map(|j| &parts[j]).collect();
        integrate(part, &neighbours, &mut sum);
    }
    let center = sum.first / sum.volume;
    let second = sum.second * sum.volume.recip() - outer(center);
    let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
    let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - second;
    let (axes, principal) = principal_axes(inertia);
    let properties = MassProperties {
        mass: 1.0,
        center: center.as_vec3(),
        axes,
        inertia: principal.as_vec3().max(Vec3::splat(1e-9)),
    };
    (sum.volume as f32, properties)
}

/// Adds the moments of one part, less what its overlap with the neighbours counts too much.
fn integrate(part: &Hull, neighbours: &[&Hull], sum: &mut Moments) {
    let corner = |i: u32| part.vertices[i as usize].as_dvec3();
    let origin = part.vertices.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / part.vertices.len() as f64;
    let tetrahedra: Vec<[DVec3; 4]> =
        part.triangles.iter().map(|t| [origin, corner(t[0]), corner(t[1]), corner(t[2])]).collect();
    let volume_of = |t: &[DVec3; 4]| (t[1] - t[0]).dot((t[2] - t[0]).cross(t[3] - t[0])) / 6.0;
    let mut volume = 0.0;
    for t in &tetrahedra {
        let v = volume_of(t);
        let total = t[0] + t[1] + t[2] + t[3];
        let squares = t.iter().fold(outer(total), |m, p| m + outer(*p));
        volume += v;
        sum.add(v, total * (v / 4.0), squares * (v / 20.0));
    }
    if neighbours.is_empty() || volume <= 0.0 {
        return;
    }
    // Stratified by volume, then spread within each tetrahedron by a low-discrepancy sequence.
    let (mut passed, mut next, step) = (0.0, 0, volume / SAMPLES as f64);
    for t in &tetrahedra {
        passed += volume_of(t);
        while (next as f64 + 0.5) * step < passed && next < SAMPLES {
            let p = in_tetrahedron(t, next);
            let holders = neighbours.iter().filter(|n| n.excess(p.as_vec3()) < 0.0).count();
            if holders > 0 {
                let surplus = step * (holders as f64 / (holders + 1) as f64);
                sum.add(-surplus, p * -surplus, outer(p) * -surplus);
            }
            next += 1;
        }
    }
}

/// The `i`-th point of a low-discrepancy sequence (Roberts' R3) in a tetrahedron.
fn in_tetrahedron(t: &[DVec3; 4], i: usize) -> DVec3 {
    let mut u = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3]
        .map(|a: f64| (0.5 + a * (i + 1) as f64).fract());
    u.sort_by(f64::total_cmp);
    t[0] * u[0] + t[1] * (u[1] - u[0]) + t[2] * (u[2] - u[1]) + t[3] * (1.0 - u[2])
}

fn boxes_meet(a: &Hull, b: &Hull) -> bool {
    let ((al, ah), (bl, bh)) = (a.bounds(), b.bounds());
    al.cmple(bh).all() && bl.cmple(ah).all()
}

/// Principal axes and moments, the axes in the order and with the signs that turn the body least.
fn principal_axes(inertia: DMat3) -> (Quat, DVec3) {
    let diagonal = DVec3::new(inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z);
    let products = DVec3::new(inertia.x_axis.y, inertia.x_axis.z, inertia.y_axis.z);
    let largest = diagonal.max_element();
    if products.abs().max_element() <= ALIGNED * largest || largest.is_nan() {
        return (Quat::IDENTITY, diagonal);
    }
    let vectors = symmetric_eigen(inertia).map(|(_, vector)| vector);
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let closeness = |o: &[usize; 3]| (0..3).map(|i| vectors[o[i]][i].abs()).sum::<f64>();
    let order = orders.iter().fold(&orders[0], |best, o| if closeness(o) > closeness(best) { o } else { best });
    let column = |i: usize| vectors[order[i]] * if vectors[order[i]][i] < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = (column(0), column(1));
    let axes = DMat3::from_cols(x, y, x.cross(y));
    let moments = axes.transpose() * inertia * axes;
    let moments = DVec3::new(moments.x_axis.x, moments.y_axis.y, moments.z_axis.z);
    let axes = Mat3::from_cols(axes.x_axis.as_vec3(), axes.y_axis.as_vec3(), axes.z_axis.as_vec3());
    (Quat::from_mat3(&axes).normalize(), moments)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(low: Vec3, high: Vec3) -> Hull {
        let corner =
            |i: usize| Vec3::from_array(std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] }));
        Hull::new(&(0..8).map(corner).collect::<Vec<_>>()).unwrap_or_default()
    }

    #[test]
    fn block_has_the_closed_form_and_stays_axis_aligned() {
        let (volume, p) = of_union(&[block(Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.4, 2.2, 3.8))]);
        // f32 vertices, f64 sums.
        assert!((volume - 0.064).abs() < 1e-6, "{volume}");
        assert!(p.center.distance(Vec3::new(1.2, 2.1, 3.4)) < 1e-5, "{}", p.center);
        let size = Vec3::new(0.4, 0.2, 0.8);
        let squares = size * size;
        let inertia = (Vec3::splat(squares.element_sum()) - squares) / 12.0;
        assert!(p.inertia.distance(inertia) < 1e-5, "{} {inertia}", p.inertia);
        assert_eq!(p.axes, Quat::IDENTITY);
    }

    #[test]
    fn overlap_counts_once() {
        let halves =
            [block(Vec3::ZERO, Vec3::new(0.7, 0.3, 0.2)), block(Vec3::new(0.3, 0.0, 0.0), Vec3::new(1.0, 0.3, 0.2))];
        let (volume, p) = of_union(&halves);
        // The sampling error of 600 points.
        assert!((volume - 0.06).abs() < 0.001, "{volume}");
        assert!(p.center.distance(Vec3::new(0.5, 0.15, 0.1)) < 0.005, "{}", p.center);
    }
}
