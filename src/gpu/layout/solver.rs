//! Contacts, and what the solver makes of them.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// What is left of the contact points of a body pair, or of a body and the ground.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Merged {
    /// Points of each patch, eight bits a patch.
    pub sizes: u32,
    /// Where the numbers of its points begin; `u32::MAX` if it keeps its contacts.
    pub first: u32,
}

/// Contact points of two bodies in about one direction.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Patch {
    /// Unit, from `a` to `b`, world.
    pub normal: Vec3,
    /// Index into `World::pairs`; past its end, the body's contact with the ground.
    pub pair: u32,
    /// Tangential impulse on `b` of the last small step, world, N s.
    pub friction: Vec3,
    /// Angular impulse about the normal on `b` of the last small step, N m s.
    pub twist: f32,
    /// First body, or `cpu::contacts::GROUND`.
    pub a: u32,
    /// Second body.
    pub b: u32,
    /// First of its points.
    pub first: u32,
    /// Number of its points.
    pub count: u32,
}

/// A contact point of a patch.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Contact {
    /// Unit, from the first body to the second, world.
    pub normal: Vec3,
    /// m; negative: overlap.
    pub separation: f32,
    /// Middle between the two surfaces, world, m.
    pub point: Vec3,
    /// Normal impulse of the last small step, N s.
    pub impulse: f32,
    /// The point in the frame of the first body (the world for the ground), m.
    pub anchor_a: Vec3,
    /// Load carried on average lately, N s a small step.
    pub load: f32,
    /// The point in the frame of the second body, m.
    pub anchor_b: Vec3,
    /// The separation when the point was found, m.
    pub found: f32,
    /// Separation less the rest offset at which its spring is at rest, m; 0 before the first substep.
    pub rest: f32,
    pad: [u32; 3],
}

/// Motion of a body while a substep is solved.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Moving {
    /// m/s
    pub linear: Vec3,
    /// 1 / kg, 0 if static.
    pub inverse_mass: f32,
    /// Angular velocity, as the frame has it.
    pub spin: Vec3,
    /// The number of the last sweep of the small step in which its contacts are solved.
    pub restless: u32,
    /// Since the substep's start, m.
    pub shift: Vec3,
    /// 1 if it has contacts, or may come to touch something; 3 if that is something fixed.
    pub touched: u32,
    /// Since the substep's start, as the frame has it.
    pub turn: Vec3,
    /// Twice the most kinetic energy that it may have after the small step, J.
    pub allowed: f32,
}

/// From the world to a body's principal axes at the substep's start, each scaled by the root of its inverse moment of
/// inertia.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Axes {
    /// First column of the matrix.
    pub x: Vec3,
    /// One if the body may turn about this axis and keep its inertia about as it is (`Body::round_axes`), else zero.
    pub round_x: f32,
    /// Second column.
    pub y: Vec3,
    /// The same about y.
    pub round_y: f32,
    /// Third column.
    pub z: Vec3,
    /// The same about z.
    pub round_z: f32,
}

/// Motion of a body before the impulses of a small step; as in `Moving`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Free {
    /// m/s
    pub linear: Vec3,
    pad1: u32,
    /// In the body's frame.
    pub spin: Vec3,
    pad2: u32,
    /// m
    pub shift: Vec3,
    pad3: u32,
    /// rad
    pub turn: Vec3,
    pad4: u32,
}

/// A contact point while a substep is solved.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Normal {
    /// Unit, from the first body to the second, world.
    pub axis: Vec3,
    /// Effective mass, kg.
    pub mass: f32,
    /// Torque of a unit impulse about the first body, in its frame.
    pub torque_a: Vec3,
    /// Accumulated, N s.
    pub impulse: f32,
    /// The same torque about the second.
    pub torque_b: Vec3,
    /// `Contact::load`
    pub load: f32,
    /// Distance from the patch's centre, m.
    pub lever: f32,
    /// Speed at which the surfaces are to come closer if the contact is rigid, m/s.
    pub rigid_bias: f32,
    /// The same if it is a spring.
    pub spring_bias: f32,
    /// 0 if the surfaces are apart, 1 if they overlap, 2 if so by more than `TOUCHING_DEPTH`.
    pub depth: u32,
}

/// Lever arms.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Arms {
    /// On the first body, m.
    pub a: Vec3,
    pad1: u32,
    /// On the second body, m.
    pub b: Vec3,
    pad2: u32,
}

/// How far a contact point's surfaces are apart, and its lever arms.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Gap {
    /// At the substep's start.
    pub arms: Arms,
    /// Separation less the rest offset at the substep's start, m.
    pub found: f32,
    /// The same as the row has it, if the bodies were where they began the substep.
    pub start: f32,
    /// `Contact::rest`
    pub rest: f32,
    pad: u32,
}

/// Friction of a patch while a substep is solved.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Friction {
    /// First direction, unit.
    pub u: Vec3,
    /// Effective mass along the directions, the smaller one, kg.
    pub mass: f32,
    /// Second direction, unit.
    pub v: Vec3,
    /// Effective moment of inertia about the normal, kg m².
    pub mass_twist: f32,
    /// Torque of a unit impulse along the first direction about the first body, in its frame.
    pub u_a: Vec3,
    /// What the points' impulses allow along the surface, N s.
    pub limit: f32,
    /// The same torque about the second body.
    pub u_b: Vec3,
    /// What they allow about the normal, N m s.
    pub twist_limit: f32,
    /// Along the second direction.
    pub v_a: Vec3,
    /// Accumulated along the first direction, N s.
    pub impulse_u: f32,
    /// The same about the second body.
    pub v_b: Vec3,
    /// Accumulated along the second direction, N s.
    pub impulse_v: f32,
    /// Unit torque about the normal, in the first body's frame.
    pub twist_a: Vec3,
    /// Accumulated about the normal, N m s.
    pub impulse_twist: f32,
    /// In the second body's.
    pub twist_b: Vec3,
    pad: u32,
}

/// Lever arms of a patch.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Levers {
    /// Of its centre at the substep's start.
    pub center: Arms,
    /// For which motion its rows were made: how far the second body had moved past the first, m.
    pub passed: Vec3,
    pad1: u32,
    /// How far the first had turned, rad.
    pub rolled_a: Vec3,
    pad2: u32,
    /// The same of the second.
    pub rolled_b: Vec3,
    pad3: u32,
}

/// How far the solver has come with a candidate's substep.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Cursor {
    /// Small steps that are done.
    pub step: u32,
    /// The next sweep of the present one.
    pub sweep: u32,
}
