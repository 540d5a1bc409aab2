//! Rigid motions that fit points to points and scenes to surfaces.

use super::surface::Surface;
use crate::scene::Pose;
use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::PI;

/// Steps in which the rotation is found; each leaves a small share of the last error.
const ROTATION_STEPS: usize = 100;
/// Most rounds of the iterative closest point method.
const ROUNDS: usize = 60;
/// It ends when a round moves no point by more than this, m.
const SETTLED: f64 = 1e-5;

/// The motion that takes `from` nearest to `to` in the mean square. `turns` are added to the covariance: what is known
/// of the rotation from elsewhere, in m².
///
/// The rotation comes from the covariance by the iteration of Müller et al. (2016, "A robust method to extract the
/// rotational part of deformations"), which has no special cases for flat or symmetric clouds, from four starts: half
/// turns apart, so that it cannot end at the worst rotation instead of the best.
pub(super) fn fit(from: &[DVec3], to: &[DVec3], turns: DMat3) -> Pose {
    let [a, b] = [from, to].map(middle);
    let spread = from.iter().zip(to).fold(turns, |sum, (x, y)| {
        let (x, y) = (*x - a, *y - b);
        sum + DMat3::from_cols(y * x.x, y * x.y, y * x.z)
    });
    let starts = [DQuat::IDENTITY, DQuat::from_rotation_y(PI), DQuat::from_rotation_x(PI), DQuat::from_rotation_z(PI)];
    let best = starts.map(|start| rotation_of(&spread, start)).into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a });
    let rotation = best.map_or(DQuat::IDENTITY, |(rotation, _)| rotation);
    Pose { rotation, translation: b - rotation * a }
}

/// The rotation that agrees best with a covariance near `start`, and how much it agrees.
fn rotation_of(spread: &DMat3, start: DQuat) -> (DQuat, f64) {
    let mut rotation = start;
    let agreement = |r: DMat3| -> f64 { (0..3).map(|k| r.col(k).dot(spread.col(k))).sum() };
    for _ in 0..ROTATION_STEPS {
        let r = DMat3::from_quat(rotation);
        let torque: DVec3 = (0..3).map(|k| r.col(k).cross(spread.col(k))).sum();
        let turn = torque / (agreement(r).abs() + 1e-12);
        if turn.length() < 1e-12 {
            break;
        }
        rotation = (DQuat::from_scaled_axis(turn) * rotation).normalize();
    }
    (rotation, agreement(DMat3::from_quat(rotation)))
}

/// Mean of points, m.
pub(super) fn middle(points: &[DVec3]) -> DVec3 {
    points.iter().copied().sum::<DVec3>() / points.len().max(1) as f64
}

/// Where a motion takes a point.
pub(super) fn moved(motion: &Pose, point: DVec3) -> DVec3 {
    motion.rotation * point + motion.translation
}

/// Iterative closest points (Besl and McKay 1992) of `points` on `surface` from a first guess.
pub(super) fn icp(points: &[DVec3], surface: &Surface, guess: Pose) -> Pose {
    let mut motion = guess;
    for _ in 0..ROUNDS {
        let now: Vec<DVec3> = points.iter().map(|p| moved(&motion, *p)).collect();
        let nearest = surface.nearest(&now);
        let next = fit(points, &nearest, DMat3::ZERO);
        let step = points.iter().zip(&now).map(|(p, q)| moved(&next, *p).distance(*q)).fold(0.0, f64::max);
        motion = next;
        if step < SETTLED {
            break;
        }
    }
    motion
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_a_rigid_motion() {
        let points: Vec<DVec3> =
            (0..20).map(|i| DVec3::new((i * i % 7) as f64, (i % 5) as f64, (i % 3) as f64)).collect();
        for angle in [0.1, 1.0, 2.5, PI] {
            let truth = Pose {
                rotation: DQuat::from_axis_angle(DVec3::new(0.3, 1.0, -0.2).normalize(), angle),
                translation: DVec3::new(1.0, -2.0, 3.0),
            };
            let to: Vec<DVec3> = points.iter().map(|p| moved(&truth, *p)).collect();
            let found = fit(&points, &to, DMat3::ZERO);
            assert!(
                found.rotation.angle_between(truth.rotation) < 1e-6
                    && found.translation.distance(truth.translation) < 1e-6
            );
        }
    }

    #[test]
    fn mirrored_points_still_give_a_rotation() {
        let points = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ZERO];
        let mirrored = points.map(|p| DVec3::new(-p.x, p.y, p.z));
        let found = fit(&points, &mirrored, DMat3::ZERO);
        assert!(found.is_finite() && (found.rotation.length() - 1.0).abs() < 1e-9);
    }
}
