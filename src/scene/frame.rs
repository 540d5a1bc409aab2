//! Between the file's frame (its up axis, unit and ground height) and ours: metres, Y up, ground at y = 0.

use super::{Pose, Wall};
use glam::{DQuat, DVec3};
use std::f64::consts::FRAC_1_SQRT_2;

/// −90° about X: takes +Z to +Y.
const UPRIGHT: DQuat = DQuat::from_xyzw(-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2);

/// Farther from the origin than this, a position is taken for a mistake, m: single precision is 6 cm there.
pub(super) const MAX_DISTANCE: f64 = 1e6;

/// True for a position in our frame that a simulation can do something with.
pub(crate) fn is_near(p: DVec3) -> bool {
    p.is_finite() && p.abs().max_element() <= MAX_DISTANCE
}

/// The axis that points up in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Up {
    Y,
    Z,
}

/// The frame of a file. Only the world side is converted; a mesh keeps its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub up: Up,
    /// > 0.
    pub meters_per_unit: f64,
    /// Height of the ground in the file's unit.
    pub ground: f64,
}

impl Frame {
    /// A position of the file in ours, m.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.direction(p) * self.meters_per_unit - DVec3::Y * self.lift()
    }

    /// The file's position of ours.
    pub fn point_back(&self, p: DVec3) -> DVec3 {
        self.direction_back((p + DVec3::Y * self.lift()) / self.meters_per_unit)
    }

    /// A rotation of the file in ours.
    pub fn rotation(&self, q: DQuat) -> DQuat {
        match self.up {
            Up::Y => q,
            Up::Z => UPRIGHT * q,
        }
    }

    /// The file's rotation of ours.
    pub fn rotation_back(&self, q: DQuat) -> DQuat {
        match self.up {
            Up::Y => q,
            Up::Z => UPRIGHT.conjugate() * q,
        }
    }

    /// A pose of the file in ours.
    pub fn pose(&self, rotation: DQuat, position: DVec3) -> Pose {
        Pose { rotation: self.rotation(rotation), translation: self.point(position) }
    }

    /// A wall of the file in ours; `normal` has unit length.
    pub fn wall(&self, name: String, point: DVec3, normal: DVec3) -> Wall {
        Wall { name, point: self.point(point), normal: self.direction(normal) }
    }

    /// The file's height of a height above our ground, m.
    pub fn height_back(&self, h: f64) -> f64 {
        (h + self.lift()) / self.meters_per_unit
    }

    /// A height of the file above our ground, m.
    pub fn height(&self, h: f64) -> f64 {
        h * self.meters_per_unit - self.lift()
    }

    /// The file's direction of ours.
    pub fn direction_back(&self, d: DVec3) -> DVec3 {
        // An exact permutation of the components; adding zero turns −0 into 0.
        DVec3::ZERO
            + match self.up {
                Up::Y => d,
                Up::Z => DVec3::new(d.x, -d.z, d.y),
            }
    }

    fn direction(&self, d: DVec3) -> DVec3 {
        match self.up {
            Up::Y => d,
            Up::Z => DVec3::new(d.x, d.z, -d.y),
        }
    }

    /// Height of the file's ground in the file's frame, m.
    pub fn lift(&self) -> f64 {
        self.ground * self.meters_per_unit
    }
}
