//! The parts that are written: what bears in the result does so with faces of four corners.

use super::rig::Rig;
use super::tolerances::{FOOT_UPWARD, FOOT_WITHIN, SAME};
use crate::scene::Pose;
use crate::shape::{MassProperties, Part, Shape, four_cornered};
use glam::{DVec3, Vec3};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose as Isometry;
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::contact;
use parry3d::shape::ConvexPolyhedron;

/// A part of an object in the world.
struct Piece<'a> {
    pose: &'a Pose,
    object: usize,
    solid: Option<ConvexPolyhedron>,
    bounds: Aabb,
    /// Where it bears: outward directions in the object's frame.
    towards: Vec<Vec3>,
}

impl<'a> Piece<'a> {
    fn new(object: usize, pose: &'a Pose, part: &Part) -> Self {
        let corner = |vertex: &Vec3| pose.point(vertex.as_dvec3()).as_vec3();
        let (low, high) = part
            .vertices
            .iter()
            .map(corner)
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let reach = Vec3::splat(0.5 * FOOT_WITHIN);
        let mut piece = Self {
            pose,
            object,
            solid: ConvexPolyhedron::from_convex_hull(&part.vertices),
            bounds: Aabb::new(low - reach, high + reach),
            towards: Vec::new(),
        };
        if low.y < FOOT_WITHIN {
            piece.bears(DVec3::NEG_Y);
        }
        piece
    }

    /// It bears towards this direction of the world, unless that is sideways.
    fn bears(&mut self, direction: DVec3) {
        if direction.y.abs() < FOOT_UPWARD {
            return;
        }
        let direction = (self.pose.rotation.conjugate() * direction).as_vec3().normalize();
        if self.towards.iter().all(|known| known.dot(direction) < SAME) {
            self.towards.push(direction);
        }
    }

    /// The direction of the world in which it touches another part, if it does.
    fn touches(&self, other: &Self) -> Option<DVec3> {
        let (one, two) = (self.solid.as_ref()?, other.solid.as_ref()?);
        let back = self.pose.rotation.conjugate();
        let there = Isometry::from_parts(
            (back * (other.pose.translation - self.pose.translation)).as_vec3(),
            (back * other.pose.rotation).normalize().as_quat(),
        );
        let contact = contact(&Isometry::IDENTITY, one, &there, two, FOOT_WITHIN).ok().flatten()?;
        Some(self.pose.rotation * contact.normal1.as_dvec3())
    }
}

/// What is written of the objects, in the scene's order.
pub(super) struct Written {
    pub parts: Vec<Vec<Part>>,
    /// Their bodies with these parts.
    pub rigs: Vec<Rig>,
}

impl Written {
    /// What bears in a layout does so with four corners, but for objects that are to keep their parts.
    pub fn new(shapes: &[Shape], layout: &[Pose], kept: &[bool]) -> Self {
        let parts = parts(shapes, layout, kept);
        let rig = |(parts, shape): (&Vec<Part>, &Shape)| match *parts == shape.parts {
            true => Rig::new(shape),
            false => Rig::of_parts(parts, &MassProperties::of(parts, shape.mass.mass)),
        };
        Self { rigs: parts.iter().zip(shapes).map(rig).collect(), parts }
    }
}

/// Notes that what moves is to keep its parts, and if it has them already, that what bears it is to.
pub(super) fn keep(kept: &mut [bool], moving: &[usize], bearer: impl Fn(usize) -> Option<usize>) {
    let old: Vec<bool> = moving.iter().map(|&object| kept[object]).collect();
    for (&object, old) in moving.iter().zip(old) {
        let to_keep = if old { bearer(object).unwrap_or(object) } else { object };
        kept[to_keep] = true;
    }
}

/// The parts of every object of a layout, cut so that the faces with which they bear, on the ground or each other, have
/// four corners, but for those that are `kept`. All in the scene's order.
fn parts(shapes: &[Shape], layout: &[Pose], kept: &[bool]) -> Vec<Vec<Part>> {
    let objects = || shapes.iter().zip(layout).enumerate();
    let mut pieces: Vec<Piece> = objects()
        .flat_map(|(object, (shape, pose))| shape.parts.iter().map(move |part| Piece::new(object, pose, part)))
        .collect();
    let boxes: Vec<Aabb> = pieces.iter().map(|piece| piece.bounds).collect();
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let near = tree.leaf_pairs(&tree, |a, b| a.intersects(b));
    let mut near: Vec<[usize; 2]> = near.map(|(a, b)| [a as usize, b as usize]).filter(|[a, b]| a < b).collect();
    near.sort_unstable();
    for [a, b] in near {
        if pieces[a].object != pieces[b].object
            && let Some(direction) = pieces[a].touches(&pieces[b])
        {
            pieces[a].bears(direction);
            pieces[b].bears(-direction);
        }
    }
    let mut parts = vec![Vec::new(); shapes.len()];
    let whole = shapes.iter().flat_map(|shape| &shape.parts);
    for (part, Piece { object, towards, .. }) in whole.zip(&pieces) {
        let towards = if kept[*object] { &[] } else { &towards[..] };
        parts[*object].extend(four_cornered(part, towards));
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Alternative, Mesh, Quality};
    use glam::{DQuat, Vec2};
    use std::f32::consts::TAU;
    use std::f64::consts::PI;

    /// A disc of 16 corners, 10 cm high.
    fn disc() -> Shape {
        let corner = |i: usize, y: f32| {
            let around = 0.1 * Vec2::from_angle(TAU * i as f32 / 16.0);
            Vec3::new(around.x, y, around.y)
        };
        let vertices = (0..32).map(|i| corner(i % 16, if i < 16 { 0.0 } else { 0.1 })).collect();
        let parts = vec![Part { vertices }];
        let mass = MassProperties::of(&parts, 1.0);
        let alternative = Alternative { parts: parts.clone(), mass: mass.clone() };
        Shape {
            parts,
            mass,
            alternatives: vec![alternative; 2],
            surface: Mesh::default(),
            bounds: [Vec3::new(-0.1, 0.0, -0.1), Vec3::splat(0.1)],
            quality: Quality::default(),
            notes: Vec::new(),
        }
    }

    #[test]
    fn only_what_bears_is_cut() {
        let at = |x: f64, y: f64| Pose { translation: DVec3::new(x, y, 0.0), ..Pose::IDENTITY };
        let on_edge = Pose { rotation: DQuat::from_rotation_x(1.2), translation: DVec3::new(2.0, 0.3, 0.0) };
        // A pile of two, one in the air, and one that is tilted above the ground.
        let layout = [at(0.0, 0.0), at(0.02, 0.0999), at(1.0, 0.5), on_edge];
        let shapes: Vec<Shape> = layout.iter().map(|_| disc()).collect();
        let counts: Vec<usize> = parts(&shapes, &layout, &[false; 4]).iter().map(Vec::len).collect();
        assert_eq!(counts, [8, 8, 1, 1]);
        assert_eq!(parts(&shapes[..1], &layout[..1], &[true])[0], shapes[0].parts);
    }

    #[test]
    fn what_touches_sideways_is_not_cut() {
        let lying = |z: f64| Pose { rotation: DQuat::from_rotation_x(0.5 * PI), translation: DVec3::new(0.0, 0.5, z) };
        let layout = [lying(0.0), lying(0.0999)];
        assert_eq!(parts(&[disc(), disc()], &layout, &[false; 2]), [disc().parts, disc().parts]);
    }

    #[test]
    fn what_bears_keeps_its_parts_only_if_keeping_those_above_does_not_help() {
        // A cup on a tray on a desk.
        let mut kept = [false; 3];
        let mut round = |moving: &[usize]| {
            keep(&mut kept, moving, |object| object.checked_sub(1));
            kept
        };
        assert_eq!(round(&[2]), [false, false, true]);
        assert_eq!(round(&[1, 2]), [false, true, true]);
        assert_eq!(round(&[1, 2]), [true, true, true]);
        assert_eq!(round(&[0]), [true, true, true]);
    }

    #[test]
    fn a_body_weighs_what_it_weighed() {
        let footed = Written::new(&[disc()], &[Pose::IDENTITY], &[false]);
        let weight = |rig: &Rig| rig.def(0, crate::world::Pose::IDENTITY, crate::world::Pose::IDENTITY);
        let (before, now) = (weight(&Rig::new(&disc())), weight(&footed.rigs[0]));
        assert_eq!(before.mass, now.mass);
        assert!(
            (before.inertia - now.inertia).length() < 0.1 * before.inertia.length(),
            "{} {}",
            before.inertia,
            now.inertia
        );
        let kept = Written::new(&[disc()], &[Pose::IDENTITY], &[true]);
        assert_eq!((kept.parts[0].len(), footed.parts[0].len()), (1, 8));
    }
}
