//! Parts that reach into each other, cut anew.
//!
//! A merged part spans what lies between its pieces, also where another part is. Such two are joined and cut by one
//! plane, so that they share nothing, if that bulges and holds less in all.

use super::cluster::Cluster;
use super::hull::{Hull, directions};
use super::planes::{Wire, cheapest};
use super::solid::Solid;
use super::tolerances::recut::{PLANES, SAMPLES, SHARED, SWEEPS, WORTH};
use glam::Vec3;

/// Cuts pieces that reach into each other anew; what they hold costs `shared` (m⁴ for each m³) beside their bulge.
pub(super) fn recut(mut clusters: Vec<Cluster>, solid: &Solid, shared: f32) -> Vec<Cluster> {
    let probes = directions(2 * PLANES);
    for _ in 0..SWEEPS {
        let mut changed = false;
        for i in 0..clusters.len() {
            for j in 0..i {
                if share(&clusters[i].hull, &clusters[j].hull) > SHARED
                    && let Some([one, other]) = apart(&clusters[i], &clusters[j], solid, shared, &probes)
                {
                    (clusters[i], clusters[j]) = (one, other);
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
    }
    clusters
}

/// Share of the smaller of two hulls that lies in the other, roughly: of points spread over its box.
fn share(a: &Hull, b: &Hull) -> f32 {
    let ((al, ah), (bl, bh)) = (a.bounds(), b.bounds());
    let (low, high) = (al.max(bl), ah.min(bh));
    if low.cmpge(high).any() {
        return 0.0;
    }
    let at = |i: usize| {
        let u = [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|step: f32| (0.5 + step * (i + 1) as f32).fract());
        low + (high - low) * Vec3::from(u)
    };
    let within = (0..SAMPLES).map(at).filter(|&p| a.excess(p) < 0.0 && b.excess(p) < 0.0).count();
    let volume = (high - low).element_product() * within as f32 / SAMPLES as f32;
    volume / a.volume().min(b.volume()).max(f32::MIN_POSITIVE)
}

/// Two pieces as the two sides of a plane through the middle of what they share along its normal, if that costs less.
fn apart(a: &Cluster, b: &Cluster, solid: &Solid, shared: f32, probes: &[Vec3]) -> Option<[Cluster; 2]> {
    let cost = |hull: &Hull| solid.protrusion(hull).0 + shared * hull.volume();
    let now = cost(&a.hull) + cost(&b.hull);
    let both = a.joined(b)?;
    let wire = Wire::new(&both.triangles().copied().collect::<Vec<_>>());
    let middle = |hull: &Hull| 0.5 * (hull.bounds().0 + hull.bounds().1);
    let across = (middle(&a.hull) - middle(&b.hull)).try_normalize();
    let spread = probes.iter().copied().filter(|n| n.y > 0.0);
    let halfway = |normal: Vec3| {
        let (a, b) = (a.hull.extent(normal), b.hull.extent(normal));
        (normal, 0.5 * (a.0.max(b.0) + a.1.min(b.1)))
    };
    let planes = Vec3::AXES.into_iter().chain(across).chain(spread).map(halfway);
    let (normal, offset) = cheapest(planes, &wire, probes, now, cost)?;
    let [below, above] = both.sides(normal, offset, solid);
    let (below, above) = (below?, above?);
    (cost(&below.hull) + cost(&above.hull) < (1.0 - WORTH) * now).then_some([below, above])
}

#[cfg(test)]
mod tests {
    use super::super::split::Piece;
    use super::*;

    /// An angle of two legs of 1 m, 0.2 m thick and 0.5 m wide.
    fn angle() -> Vec<[Vec3; 3]> {
        let outline = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.2], [0.2, 0.2], [0.2, 1.0], [0.0, 1.0]];
        let at = |i: usize, z: f32| Vec3::new(outline[i % 6][0], outline[i % 6][1], z);
        let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 5], [3, 4, 5]];
        let front = caps.map(|[a, b, c]| [at(a, 0.5), at(b, 0.5), at(c, 0.5)]);
        let back = caps.map(|[a, b, c]| [at(a, 0.0), at(c, 0.0), at(b, 0.0)]);
        let side = |i: usize| [[at(i, 0.0), at(i + 1, 0.0), at(i + 1, 0.5)], [at(i, 0.0), at(i + 1, 0.5), at(i, 0.5)]];
        front.into_iter().chain(back).chain((0..6).flat_map(side)).collect()
    }

    #[test]
    fn legs_that_share_a_corner_part_at_it() {
        let triangles = angle();
        let solid = Solid::new(&triangles, Vec3::Y, 40_000);
        let whole = Piece::new(triangles, &solid).unwrap_or_else(|| panic!("an angle has volume"));
        let below = |normal: Vec3| {
            let [below, _] = whole.sides(normal, 0.2, &solid);
            below
                .and_then(|piece| Cluster::new(vec![piece]))
                .unwrap_or_else(|| panic!("nothing on one side of {normal}"))
        };
        let legs = vec![below(Vec3::X), below(Vec3::Y)];
        let volume = |legs: &[Cluster]| legs.iter().map(|leg| leg.hull.volume()).sum::<f32>();
        let bulge = |legs: &[Cluster]| legs.iter().map(|leg| solid.protrusion(&leg.hull).0).sum::<f32>();
        assert!((share(&legs[0].hull, &legs[1].hull) - 0.2).abs() < 0.02);
        assert!((volume(&legs) - 0.2).abs() < 1e-5);
        let bulged = bulge(&legs);
        let parted = recut(legs, &solid, 0.01);
        assert!(parted.len() == 2 && (volume(&parted) - 0.18).abs() < 0.002, "{}", volume(&parted));
        assert!(share(&parted[0].hull, &parted[1].hull) < 1e-3 && bulge(&parted) < bulged + 1e-5);
    }
}
