//! Parts that hold much free space, cut further: what they hold has weight.
//!
//! Parts that bridge the bars of a chair's back weigh what is between them, and a bowl's wedges weigh what is within
//! their chords. So the chair would tip at 17° instead of 20°, and the bowl lean to the side with fewer wedges.

use super::cluster::Cluster;
use super::mass;
use super::planes::best_cut;
use super::solid::Solid;
use super::tolerances::slim::{CLOSER, FREED, LOST, MORE};
use glam::Vec3;

/// Cuts clusters as long as that is worth it and there are fewer than `most`.
pub(super) fn slim(clusters: Vec<Cluster>, solid: &Solid, up: Vec3, most: usize) -> Vec<Cluster> {
    let hulls: Vec<_> = clusters.iter().map(|cluster| cluster.hull.clone()).collect();
    let (low, high) = hulls
        .iter()
        .map(|hull| hull.bounds())
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), b| (l.min(b.0), h.max(b.1)));
    let whole = mass::of_parts(&hulls);
    let mut loads: Vec<Load> = clusters.into_iter().map(|cluster| Load::new(cluster, solid, whole.center)).collect();
    let mut cuts: Vec<Option<[Load; 2]>> = loads.iter().map(|load| load.cut(solid, up, whole.center)).collect();
    let mut moment: Vec3 = loads.iter().map(|load| load.moment).sum();
    let mut held = whole.volume;
    let most = most.min(loads.len() + MORE);
    while loads.len() < most {
        let worth = |i: usize| {
            let Some([one, other]) = &cuts[i] else { return 0.0 };
            let closer = moment.length() - (moment - loads[i].moment + one.moment + other.moment).length();
            ((loads[i].open - one.open - other.open) / FREED).max(closer / (CLOSER * low.distance(high))) / held
        };
        let gains: Vec<f32> = (0..cuts.len()).map(worth).collect();
        let Some(best) = (0..cuts.len()).max_by(|&i, &j| gains[i].total_cmp(&gains[j])) else { break };
        let Some([one, other]) = cuts[best].take().filter(|_| gains[best] > 1.0) else { break };
        moment += one.moment + other.moment - loads[best].moment;
        held += one.open + other.open - loads[best].open;
        cuts[best] = one.cut(solid, up, whole.center);
        cuts.push(other.cut(solid, up, whole.center));
        loads[best] = one;
        loads.push(other);
    }
    loads.into_iter().map(|load| load.cluster).collect()
}

/// A cluster and the free space in it.
struct Load {
    cluster: Cluster,
    /// Free volume, m³.
    open: f32,
    /// The same times its way from the centre of all, m⁴.
    moment: Vec3,
}

impl Load {
    fn new(cluster: Cluster, solid: &Solid, center: Vec3) -> Self {
        let open = solid.protrusion(&cluster.hull).1;
        let moment = open * (mass::of_parts(std::slice::from_ref(&cluster.hull)).center - center);
        Self { cluster, open, moment }
    }

    /// Its two sides, cut where they hold least free space.
    fn cut(&self, solid: &Solid, up: Vec3, center: Vec3) -> Option<[Self; 2]> {
        let triangles: Vec<[Vec3; 3]> = self.cluster.triangles().copied().collect();
        let (normal, offset) = best_cut(&triangles, &self.cluster.hull, solid, up, |hull| solid.protrusion(hull).1)?;
        let [one, other] = self.cluster.sides(normal, offset, solid);
        let sides = [one?, other?].map(|side| Self::new(side, solid, center));
        let left = |of: fn(&Self) -> f32| of(self) - of(&sides[0]) - of(&sides[1]);
        let (freed, lost) = (left(|load| load.open), left(|load| load.cluster.hull.volume()));
        (lost < LOST * freed).then_some(sides)
    }
}
