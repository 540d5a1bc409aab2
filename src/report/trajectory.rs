//! The states of a simulation over time, written as the JSON that `simulate` promises.

use crate::optimize::Rig;
use crate::scene::Scene;
use crate::world::{Pose, Velocity, free_memory};
use serde::ser::{Serialize, SerializeStruct, Serializer};

/// All states of one simulation. Serializes as
/// `{"dt", "objects": [{"name", "poses": [[px, py, pz, qx, qy, qz, qw]], "velocities": [[vx, vy, vz, wx, wy, wz]]}]}`
/// row by row, without a second copy in memory; the first row of each list is the start.
///
/// Everything is in the frame of the scene's file: its unit of length, its up axis, its ground height. A pose is that
/// of the object, as `scene.json` states it; a velocity is that of its centre of mass, in units/s and rad/s.
pub struct Trajectory<'a> {
    scene: &'a Scene,
    rigs: &'a [Rig],
    /// s.
    dt: f64,
    /// Step-major, a state for every object.
    states: Vec<(Pose, Velocity)>,
}

impl<'a> Trajectory<'a> {
    /// The start: the scene as it stands, at rest. Room for `steps` more; `None` if there is not so much memory.
    pub fn new(scene: &'a Scene, rigs: &'a [Rig], dt: f64, steps: u32) -> Option<Self> {
        let mut states = Vec::new();
        let count = scene.objects.len().checked_mul(steps as usize + 1)?;
        let bytes = count.checked_mul(size_of::<(Pose, Velocity)>())? as u64;
        // The reservation alone succeeds where more is promised than there is.
        if free_memory().is_some_and(|free| bytes > free) {
            return None;
        }
        states.try_reserve_exact(count).ok()?;
        let at_rest = |(object, rig): (&crate::scene::Object, &Rig)| (rig.body(&object.pose), Velocity::default());
        states.extend(scene.objects.iter().zip(rigs).map(at_rest));
        Some(Self { scene, rigs, dt, states })
    }

    /// Poses of the bodies at the start, in the scene's order.
    pub fn start(&self) -> Vec<Pose> {
        self.states[..self.rigs.len()].iter().map(|(pose, _)| *pose).collect()
    }

    /// Adds one step.
    pub fn push(&mut self, poses: &[Pose], velocities: &[Velocity]) {
        self.states.extend(poses.iter().copied().zip(velocities.iter().copied()));
    }

    /// Distance of each object's centre of mass between start and end, m.
    pub fn distances(&self) -> Vec<f64> {
        let (first, last) = (&self.states[..self.rigs.len()], &self.states[self.states.len() - self.rigs.len()..]);
        first.iter().zip(last).map(|((a, _), (b, _))| f64::from(a.translation.distance(b.translation))).collect()
    }

    fn of(&self, object: usize) -> impl Iterator<Item = &(Pose, Velocity)> {
        self.states.iter().skip(object).step_by(self.rigs.len())
    }

    /// What has not moved a bit is written as it was read.
    fn pose(&self, object: usize, body: &Pose) -> [f64; 7] {
        let input = &self.scene.objects[object].pose;
        let rig = &self.rigs[object];
        self.scene.pose_in_file(&if *body == rig.body(input) { *input } else { rig.object(body) })
    }

    fn velocity(&self, velocity: &Velocity) -> [f64; 6] {
        let [linear, angular] = [velocity.linear, velocity.angular].map(|v| v.as_dvec3());
        let ([x, y, z], [i, j, k]) =
            (self.scene.velocity_in_file(linear).to_array(), self.scene.direction_in_file(angular).to_array());
        [x, y, z, i, j, k]
    }
}

impl Serialize for Trajectory<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut document = serializer.serialize_struct("Trajectory", 2)?;
        document.serialize_field("dt", &self.dt)?;
        let objects = (0..self.rigs.len()).map(|object| Object { trajectory: self, object });
        document.serialize_field("objects", &Rows(|| objects.clone()))?;
        document.end()
    }
}

struct Object<'a> {
    trajectory: &'a Trajectory<'a>,
    object: usize,
}

impl Serialize for Object<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { trajectory, object } = *self;
        let mut document = serializer.serialize_struct("Object", 3)?;
        document.serialize_field("name", &trajectory.scene.objects[object].name)?;
        let states = || trajectory.of(object);
        document.serialize_field("poses", &Rows(|| states().map(|(pose, _)| trajectory.pose(object, pose))))?;
        document.serialize_field("velocities", &Rows(|| states().map(|(_, v)| trajectory.velocity(v))))?;
        document.end()
    }
}

/// A list that is made while it is written.
struct Rows<F>(F);

impl<F: Fn() -> I, I: Iterator<Item: Serialize>> Serialize for Rows<F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0())
    }
}
