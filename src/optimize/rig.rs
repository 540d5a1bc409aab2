//! From an object to a body and back: the only place where the document's f64 poses and the simulator's f32 meet.

use crate::scene;
use crate::shape::{MassProperties, Part, Shape};
use crate::world::{BodyDef, Pose};
use glam::{DQuat, DVec3, Vec3};

/// One object as a rigid body. The body's frame is its centre of mass with principal axes; the object's frame is that of
/// its scaled mesh.
#[derive(Clone, Debug)]
pub struct Rig {
    center: DVec3,
    axes: DQuat,
    /// Convex parts in the body's frame, m.
    pub parts: Vec<Vec<Vec3>>,
    mass: f32,
    inertia: Vec3,
}

impl Rig {
    /// The body of a shape.
    pub fn new(shape: &Shape) -> Self {
        Self::of_parts(&shape.parts, &shape.mass)
    }

    /// The same object as its other decomposition has it.
    pub(super) fn alternative(shape: &Shape) -> Self {
        Self::of_parts(&shape.alternative.parts, &shape.alternative.mass)
    }

    fn of_parts(parts: &[Part], mass: &MassProperties) -> Self {
        let to_body = |v: &Vec3| mass.axes.conjugate() * (*v - mass.center);
        Self {
            center: mass.center.as_dvec3(),
            axes: mass.axes.as_dquat().normalize(),
            parts: parts.iter().map(|part| part.vertices.iter().map(to_body).collect()).collect(),
            mass: mass.mass,
            inertia: mass.inertia,
        }
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
        object.translation + object.rotation * self.center
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
