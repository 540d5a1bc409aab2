//! From an object to a body and back: the only place where the document's f64 poses and the simulator's f32 meet.

use super::tolerances::EVEN_DENSITY;
use crate::scene;
use crate::shape::{Alternative, MassProperties, Part, Shape};
use crate::world::{BodyDef, Pose};
use glam::{DQuat, DVec3, Vec2, Vec3};
use parry3d::shape::ConvexPolyhedron;
use std::sync::OnceLock;

/// One object as a rigid body. The body's frame is its centre of mass with principal axes; the object's frame is that
/// of its scaled mesh.
#[derive(Clone, Debug)]
pub struct Rig {
    center: DVec3,
    axes: DQuat,
    /// Convex parts in the body's frame, m.
    pub parts: Vec<Vec<Vec3>>,
    /// The parts with volume as parry takes them, made when they are first asked for.
    solids: OnceLock<Vec<ConvexPolyhedron>>,
    mass: f32,
    /// Of the parts, m³.
    volume: f32,
    inertia: Vec3,
}

impl Rig {
    /// The body of a shape.
    pub fn new(shape: &Shape) -> Self {
        Self::of_parts(&shape.parts, &shape.mass)
    }

    /// The same object as another decomposition has it.
    pub(super) fn alternative(alternative: &Alternative) -> Self {
        Self::of_parts(&alternative.parts, &alternative.mass)
    }

    /// The same object as engines weigh it that know only what the scene states: without a mass, by the volume of its
    /// parts.
    pub(super) fn with_stated_mass(&self, stated: Option<f64>) -> Self {
        let mass = stated.map_or(EVEN_DENSITY * self.volume, |mass| mass as f32);
        Self { mass, inertia: self.inertia * (mass / self.mass), ..self.clone() }
    }

    /// The same object on ground that falls by `slope` (rad, x and z): with its centre of mass off to that side by what
    /// the slope makes of its height above its lowest vertex, as it lies at `pose`.
    pub(super) fn on_slope(&self, pose: &scene::Pose, slope: Vec2) -> Self {
        let body = self.body(pose);
        let height = f64::from(body.translation.y - self.lowest(&body));
        let shift = pose.rotation.conjugate() * (height * DVec3::new(slope.x.into(), 0.0, slope.y.into()));
        let in_body = (self.axes.conjugate() * shift).as_vec3();
        let shifted = |part: &Vec<Vec3>| part.iter().map(|vertex| *vertex - in_body).collect();
        Self {
            center: self.center + shift,
            parts: self.parts.iter().map(shifted).collect(),
            solids: OnceLock::new(),
            ..self.clone()
        }
    }

    /// The body of these parts.
    pub(super) fn of_parts(parts: &[Part], mass: &MassProperties) -> Self {
        let to_body = |v: &Vec3| mass.axes.conjugate() * (*v - mass.center);
        Self {
            center: mass.center.as_dvec3(),
            axes: mass.axes.as_dquat().normalize(),
            parts: parts.iter().map(|part| part.vertices.iter().map(to_body).collect()).collect(),
            solids: OnceLock::new(),
            mass: mass.mass,
            volume: mass.volume,
            inertia: mass.inertia,
        }
    }

    /// The parts with volume in the body's frame, m.
    pub(super) fn solids(&self) -> &[ConvexPolyhedron] {
        let solid = |part: &Vec<Vec3>| ConvexPolyhedron::from_convex_hull(part);
        self.solids.get_or_init(|| self.parts.iter().filter_map(solid).collect())
    }

    /// The body's pose for an object's pose.
    pub fn body(&self, object: &scene::Pose) -> Pose {
        let rotation = (object.rotation * self.axes).normalize();
        Pose::new(rotation.as_quat().normalize(), self.center_of(object).as_vec3())
    }

    /// The object's pose for a body's pose.
    pub fn object(&self, body: &Pose) -> scene::Pose {
        let rotation = (body.rotation.as_dquat().normalize() * self.axes.conjugate()).normalize();
        scene::Pose { rotation, translation: body.translation.as_dvec3() - rotation * self.center }
    }

    /// Centre of mass of an object at a pose, m.
    pub fn center_of(&self, object: &scene::Pose) -> DVec3 {
        object.point(self.center)
    }

    /// The object with this rotation, its centre of mass where it was.
    pub fn turned(&self, object: &scene::Pose, rotation: DQuat) -> scene::Pose {
        let rotation = rotation.normalize();
        scene::Pose { rotation, translation: self.center_of(object) - rotation * self.center }
    }

    /// Height of the lowest vertex at a pose of the body, m; +∞ without parts.
    pub fn lowest(&self, body: &Pose) -> f32 {
        self.parts.iter().flatten().map(|v| body.point(*v).y).fold(f32::INFINITY, f32::min)
    }

    /// The body for the simulator.
    pub fn def(&self, unit: u32, start: Pose, reference: Pose) -> BodyDef {
        BodyDef { parts: self.parts.clone(), mass: self.mass, inertia: self.inertia, unit, start, reference }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_turned_keeps_its_centre() {
        let center = Vec3::new(0.1, 0.3, 0.1);
        let mass = MassProperties { mass: 1.0, volume: 1e-3, center, axes: glam::Quat::IDENTITY, inertia: Vec3::ONE };
        let rig = Rig::of_parts(&[], &mass);
        let pose = scene::Pose { rotation: DQuat::from_rotation_z(0.4), translation: DVec3::new(3.0, 0.5, -2.0) };
        let turned = rig.turned(&pose, DQuat::from_rotation_y(1.1) * 2.0);
        assert!(turned.rotation.angle_between(DQuat::from_rotation_y(1.1)) < 1e-9 && turned.rotation.is_normalized());
        assert!(rig.center_of(&turned).distance(rig.center_of(&pose)) < 1e-12);
    }

    #[test]
    fn on_a_slope_the_centre_is_off_and_the_parts_stay() {
        let corner =
            |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * Vec3::new(0.2, 0.6, 0.2);
        let vertices = (0..8).map(corner).collect();
        let axes = glam::Quat::from_rotation_z(0.7);
        let mass =
            MassProperties { mass: 1.0, volume: 1e-3, center: Vec3::new(0.1, 0.3, 0.1), axes, inertia: Vec3::ONE };
        let rig = Rig::of_parts(&[Part { vertices }], &mass);
        let rotation = DQuat::from_rotation_y(1.1);
        let pose = scene::Pose { rotation, translation: DVec3::new(3.0, 0.5, -2.0) };
        let sloped = rig.on_slope(&pose, Vec2::new(0.02, -0.01));
        let off = sloped.center_of(&pose) - rig.center_of(&pose);
        assert!(off.distance(0.3 * DVec3::new(0.02, 0.0, -0.01)) < 1e-6, "{off}");
        for (before, now) in rig.parts[0].iter().zip(&sloped.parts[0]) {
            let (before, now) = (rig.body(&pose).point(*before), sloped.body(&pose).point(*now));
            assert!(before.distance(now) < 1e-6, "{before} {now}");
        }
    }
}
