//! A posed mesh with a tree of boxes over its triangles, which looks along a direction or around itself at another.

use super::tolerances::ROUNDING;
use crate::scene::Pose;
use crate::shape::Mesh;
use crate::shape::triangle::{Triangle, blocked, way};
use glam::{DMat3, DVec3, Vec3};
use parry3d::bounding_volume::Aabb;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use std::cell::Cell;

/// How many pairs of triangles may still be looked at.
pub(super) type Budget = Cell<u64>;

/// A mesh in the world as the exact step found it, m. Degenerate triangles are left out.
pub(super) struct Surface {
    triangles: Vec<Triangle>,
    tree: Bvh,
    pub low: DVec3,
    pub high: DVec3,
}

impl Surface {
    pub fn new(mesh: &Mesh, pose: &Pose) -> Self {
        let corner = |&i: &u32| pose.point(mesh.vertices[i as usize].as_dvec3());
        let triangles: Vec<Triangle> = (mesh.triangles.iter())
            .map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])])
            .filter(|[a, b, c]| (*b - *a).cross(*c - *a).length_squared() > 0.0)
            .collect();
        let boxed = |t: &Triangle| {
            let (low, high) = (t[0].min(t[1]).min(t[2]) - ROUNDING, t[0].max(t[1]).max(t[2]) + ROUNDING);
            Aabb::new(low.as_vec3(), high.as_vec3())
        };
        let boxes: Vec<Aabb> = triangles.iter().map(boxed).collect();
        let corners = || triangles.iter().flatten().copied();
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        Self { tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes), triangles, low, high }
    }

    /// The least coordinate along a direction, m; +∞ without triangles.
    pub fn lowest_along(&self, direction: DVec3) -> f64 {
        self.triangles.iter().flatten().map(|p| p.dot(direction)).fold(f64::INFINITY, f64::min)
    }

    /// The shifts of this surface along the third axis of `frame`, within `range`, at which it meets `other`, each
    /// widened by `margin`, m. `apart`: how this surface has been moved relative to `other` since. None if the budget
    /// does not suffice.
    pub fn blocked(
        &self,
        other: &Self,
        apart: DVec3,
        frame: &DMat3,
        range: [f64; 2],
        margin: f64,
        budget: &Budget,
    ) -> Option<Vec<[f64; 2]>> {
        let along = frame.transpose().z_axis;
        let ends = range.map(|t| apart + along * t);
        let spare = DVec3::splat(margin);
        let reach = [ends[0].min(ends[1]) - spare, ends[0].max(ends[1]) + spare];
        let mut found = Vec::new();
        let looked = self.pairs(other, reach, budget, |a, b| {
            if let Some([low, high]) = blocked(&a.map(|p| p + apart), b, frame)
                && low - margin <= range[1]
                && high + margin >= range[0]
            {
                found.push([low - margin, high + margin]);
            }
        });
        looked.then_some(found)
    }

    /// The shortest way from `other` to this surface, if it is shorter than `reach`, m; zero if they meet.
    pub fn way(&self, other: &Self, apart: DVec3, reach: f64, budget: &Budget) -> Option<DVec3> {
        let mut best: Option<DVec3> = None;
        let spare = DVec3::splat(reach);
        self.pairs(other, [apart - spare, apart + spare], budget, |a, b| {
            let nearest = best.map_or(reach, |best| best.length());
            if nearest > 0.0 {
                let found = way(&a.map(|p| p + apart), b);
                if found.length() < nearest {
                    best = Some(found);
                }
            }
        });
        best
    }

    /// Visits pairs of triangles whose boxes meet when this surface is moved by something within `reach`. False if the
    /// budget does not suffice.
    fn pairs(
        &self,
        other: &Self,
        reach: [DVec3; 2],
        budget: &Budget,
        mut visit: impl FnMut(&Triangle, &Triangle),
    ) -> bool {
        let [low, high] = reach;
        if (self.low + low).cmpgt(other.high).any() || (self.high + high).cmplt(other.low).any() {
            return true;
        }
        let [low, high]: [Vec3; 2] = [(low - ROUNDING).as_vec3(), (high + ROUNDING).as_vec3()];
        let meet = |a: &BvhNode, b: &BvhNode| {
            (a.mins() + low).cmple(b.maxs()).all() && (a.maxs() + high).cmpge(b.mins()).all()
        };
        for (a, b) in self.tree.leaf_pairs(&other.tree, meet) {
            let Some(left) = budget.get().checked_sub(1) else {
                return false;
            };
            budget.set(left);
            if let (Some(a), Some(b)) = (self.triangles.get(a as usize), other.triangles.get(b as usize)) {
                visit(a, b);
            }
        }
        true
    }
}
