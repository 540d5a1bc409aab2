//! Two triangles: how far apart they are, and which shifts along a direction make them meet. In f64.

use glam::{DMat3, DVec2, DVec3};

/// Corners, m.
pub(crate) type Triangle = [DVec3; 3];

/// The shifts t, m, at which `a` moved by t · (third axis of `frame`) meets `b`: one interval, as both are convex. Its
/// ends are where a corner meets a face or an edge an edge. `frame`: rows are the axes.
pub(crate) fn blocked(a: &Triangle, b: &Triangle, frame: &DMat3) -> Option<[f64; 2]> {
    let (a, b) = (a.map(|p| *frame * p), b.map(|p| *frame * p));
    let (flat_a, flat_b) = (a.map(|p| p.truncate()), b.map(|p| p.truncate()));
    let low = |t: &[DVec2; 3]| t[0].min(t[1]).min(t[2]);
    let high = |t: &[DVec2; 3]| t[0].max(t[1]).max(t[2]);
    if low(&flat_a).cmpgt(high(&flat_b)).any() || low(&flat_b).cmpgt(high(&flat_a)).any() {
        return None;
    }
    let mut found = [f64::INFINITY, f64::NEG_INFINITY];
    let mut touch = |t: f64| found = [found[0].min(t), found[1].max(t)];
    for p in a {
        height(&b, &flat_b, p.truncate()).into_iter().for_each(|h| touch(h - p.z));
    }
    for p in b {
        height(&a, &flat_a, p.truncate()).into_iter().for_each(|h| touch(p.z - h));
    }
    for i in 0..3 {
        let j = (i + 1) % 3;
        for k in 0..3 {
            let l = (k + 1) % 3;
            if let Some([s, r]) = crossing([flat_a[i], flat_a[j]], [flat_b[k], flat_b[l]]) {
                touch(b[k].z + r * (b[l].z - b[k].z) - a[i].z - s * (a[j].z - a[i].z));
            }
        }
    }
    (found[0] <= found[1]).then_some(found)
}

/// Height of a triangle over a point of the plane; none beside it, or if it is seen edge-on.
fn height(triangle: &Triangle, flat: &[DVec2; 3], p: DVec2) -> Option<f64> {
    let [a, b, c] = *flat;
    let twice = (b - a).perp_dot(c - a);
    let weights = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)];
    let within = twice != 0.0 && weights.iter().all(|w| w * twice >= 0.0);
    within.then(|| weights.iter().zip(triangle).map(|(w, corner)| w / twice * corner.z).sum())
}

/// Where two segments of the plane cross, as shares of their lengths; none for parallels.
fn crossing([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> Option<[f64; 2]> {
    let (u, v) = (b - a, d - c);
    let det = u.perp_dot(v);
    if det == 0.0 {
        return None;
    }
    let [s, r] = [(c - a).perp_dot(v) / det, (c - a).perp_dot(u) / det];
    ((0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&r)).then_some([s, r])
}

/// The shortest way from `b` to `a`, m; zero if they meet.
pub(crate) fn way(a: &Triangle, b: &Triangle) -> DVec3 {
    if meet(a, b) {
        return DVec3::ZERO;
    }
    let mut best = DVec3::INFINITY;
    let mut consider = |way: DVec3| {
        if way.length_squared() < best.length_squared() {
            best = way;
        }
    };
    for i in 0..3 {
        above(a[i], b).into_iter().for_each(&mut consider);
        above(b[i], a).into_iter().for_each(|way| consider(-way));
        for k in 0..3 {
            consider(between([a[i], a[(i + 1) % 3]], [b[k], b[(k + 1) % 3]]));
        }
    }
    best
}

/// True if the triangles meet; touching counts. Two of one plane do not, but then others of their meshes do.
pub(crate) fn meet(a: &Triangle, b: &Triangle) -> bool {
    pierces(a, b) || pierces(b, a)
}

/// True if an edge of `a` passes through `b`.
fn pierces(a: &Triangle, b: &Triangle) -> bool {
    let normal = (b[1] - b[0]).cross(b[2] - b[0]);
    let side = a.map(|p| normal.dot(p - b[0]));
    (0..3).any(|i| {
        let j = (i + 1) % 3;
        if side[i] * side[j] > 0.0 || side[i] == side[j] {
            return false;
        }
        let p = a[i] + (a[j] - a[i]) * (side[i] / (side[i] - side[j]));
        (0..3).all(|k| (b[(k + 1) % 3] - b[k]).cross(p - b[k]).dot(normal) >= 0.0)
    })
}

/// From a triangle to a point over its inside; none beside it.
fn above(p: DVec3, t: &Triangle) -> Option<DVec3> {
    let normal = (t[1] - t[0]).cross(t[2] - t[0]).try_normalize()?;
    let inside = (0..3).all(|k| (t[(k + 1) % 3] - t[k]).cross(p - t[k]).dot(normal) >= 0.0);
    inside.then(|| normal * normal.dot(p - t[0]))
}

/// The shortest way from the segment `cd` to the segment `ab` (Ericson, Real-Time Collision Detection, 5.1.9).
fn between([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> DVec3 {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, vv, uv, uw, vw) = (u.dot(u), v.dot(v), u.dot(v), u.dot(w), v.dot(w));
    let share = |numerator: f64, denominator: f64| {
        if denominator > 0.0 { (numerator / denominator).clamp(0.0, 1.0) } else { 0.0 }
    };
    let s = share(uv * vw - uw * vv, uu * vv - uv * uv);
    let r = share(uv * s + vw, vv);
    let s = share(uv * r - uw, uu);
    (a + u * s) - (c + v * r)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const A: Triangle = [DVec3::ZERO, DVec3::X, DVec3::Z];

    fn up() -> DMat3 {
        DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y).transpose()
    }

    #[test]
    fn a_triangle_is_blocked_between_first_and_last_touch() {
        let leaning = [DVec3::new(0.1, 1.0, 0.1), DVec3::new(0.3, 2.0, 0.1), DVec3::new(0.1, 1.5, 0.3)];
        let [low, high] = blocked(&A, &leaning, &up()).unwrap();
        assert!((low - 1.0).abs() < 1e-12 && (high - 2.0).abs() < 1e-12, "{low} … {high}");
        assert!(blocked(&A, &leaning.map(|p| p + DVec3::X), &up()).is_none());
        // An edge over an edge, both corners outside.
        let across = [DVec3::new(-1.0, 0.5, 0.2), DVec3::new(2.0, 0.5, 0.2), DVec3::new(0.5, 5.0, -9.0)];
        let [low, _] = blocked(&A, &across, &up()).unwrap();
        assert!((low - 0.5).abs() < 1e-12, "{low}");
    }

    #[test]
    fn ways_are_shortest_and_vanish_where_triangles_meet() {
        let over = [DVec3::new(0.2, 0.3, 0.2), DVec3::new(0.4, 0.9, 0.2), DVec3::new(0.2, 0.9, 0.4)];
        assert!(way(&over, &A).distance(0.3 * DVec3::Y) < 1e-12);
        let beside = A.map(|p| p + 3.0 * DVec3::X);
        assert!(way(&beside, &A).distance(2.0 * DVec3::X) < 1e-12);
        assert_eq!(way(&over.map(|p| p - 0.4 * DVec3::Y), &A), DVec3::ZERO);
    }
}
