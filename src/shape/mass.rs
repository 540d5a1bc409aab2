//! Mass, centre of mass and inertia of convex parts at uniform density.

use super::Part;
use super::eigen::symmetric_eigen;
use super::hull::Hull;
use super::tolerances::mass::ALIGNED;
use glam::{DMat3, DVec3, Mat3, Quat, Vec3};

/// Mass and how it is spread.
#[derive(Clone, Debug, PartialEq)]
pub struct MassProperties {
    /// kg.
    pub mass: f32,
    /// Of all parts before they are padded, m³; what they share counts in each.
    pub volume: f32,
    /// Centre of mass, scaled mesh frame, m.
    pub center: Vec3,
    /// Rotation from the frame of principal axes to the mesh frame.
    pub axes: Quat,
    /// Principal moments of inertia about the centre of mass, kg m².
    pub inertia: Vec3,
}

impl MassProperties {
    /// Of parts as they are written, for a mass in kg.
    pub fn of(parts: &[Part], mass: f32) -> Self {
        let hulls: Vec<Hull> = parts.iter().filter_map(|part| Hull::new(&part.vertices)).collect();
        let unit = of_parts(&hulls);
        Self { mass, inertia: unit.inertia * mass, ..unit }
    }
}

/// Zeroth, first and second moments at density 1, in the mesh frame.
#[derive(Clone, Copy, Debug)]
struct Moments {
    volume: f64,
    first: DVec3,
    second: DMat3,
}

fn outer(a: DVec3) -> DMat3 {
    DMat3::from_cols(a * a.x, a * a.y, a * a.z)
}

/// Mass properties of the parts for a mass of 1 kg.
///
/// What parts share counts in each of them: so weigh the engines into which they are loaded (the parts are made to
/// share little), and a body whose centre of mass is elsewhere there would tip over there and not here.
pub(super) fn of_parts(parts: &[Hull]) -> MassProperties {
    let mut sum = Moments { volume: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };
    for part in parts {
        integrate(part, &mut sum);
    }
    let center = sum.first / sum.volume;
    let second = sum.second * sum.volume.recip() - outer(center);
    let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
    let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - second;
    let (axes, principal) = principal_axes(inertia);
    MassProperties {
        mass: 1.0,
        volume: sum.volume as f32,
        center: center.as_vec3(),
        axes,
        inertia: principal.as_vec3().max(Vec3::splat(1e-9)),
    }
}

/// Adds the moments of one part.
fn integrate(part: &Hull, sum: &mut Moments) {
    let corner = |i: u32| part.vertices[i as usize].as_dvec3();
    let origin = part.vertices.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / part.vertices.len() as f64;
    for t in &part.triangles {
        let [a, b, c] = t.map(corner);
        let volume = (a - origin).dot((b - origin).cross(c - origin)) / 6.0;
        let total = origin + a + b + c;
        let squares = [origin, a, b, c].iter().fold(outer(total), |m, p| m + outer(*p));
        sum.volume += volume;
        sum.first += total * (volume / 4.0);
        sum.second += squares * (volume / 20.0);
    }
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
        let p = of_parts(&[block(Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.4, 2.2, 3.8))]);
        // f32 vertices, f64 sums.
        assert!((p.volume - 0.064).abs() < 1e-6, "{}", p.volume);
        assert!(p.center.distance(Vec3::new(1.2, 2.1, 3.4)) < 1e-5, "{}", p.center);
        let size = Vec3::new(0.4, 0.2, 0.8);
        let squares = size * size;
        let inertia = (Vec3::splat(squares.element_sum()) - squares) / 12.0;
        assert!(p.inertia.distance(inertia) < 1e-5, "{} {inertia}", p.inertia);
        assert_eq!(p.axes, Quat::IDENTITY);
    }

    #[test]
    fn what_parts_share_counts_in_each() {
        let halves =
            [block(Vec3::ZERO, Vec3::new(0.7, 0.3, 0.2)), block(Vec3::new(0.5, 0.0, 0.0), Vec3::new(1.0, 0.3, 0.2))];
        let p = of_parts(&halves);
        assert!((p.volume - 0.072).abs() < 1e-6, "{}", p.volume);
        let center = (0.7 * 0.35 + 0.5 * 0.75) / 1.2;
        assert!(p.center.distance(Vec3::new(center, 0.15, 0.1)) < 1e-6, "{}", p.center);
    }
}
