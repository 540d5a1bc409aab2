//! Rooms of boxes, and runs of them.

use crate::common::meshes::{Placed, corners, meet};
use crate::common::scenes::Keep;
use glam::{DQuat, DVec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::optimize::{Config, Outcome, ResultFrom, run, shape_requests};
use rest3d_gpu::scene::{Parent, Pose, Root, Scene};
use rest3d_gpu::shape::{Shape, ShapeSettings, build_shapes};
use serde_json::{Value, json};

/// Nearer than this is a touch, m: the requirement.
pub const TOUCHES: f64 = 0.01;
/// How deep something may be in a wall, m: what resting contact sinks in.
pub const SUNK: f64 = 0.2e-3;

/// A scene of boxes. Everything is said in a room whose back wall looks along +Z, and turned about +Y afterwards.
pub struct Boxes {
    turn: f64,
    objects: Vec<Value>,
    sizes: Vec<DVec3>,
    pub room: Option<Value>,
}

impl Boxes {
    pub fn new(turn: f64) -> Self {
        Self { turn, objects: Vec::new(), sizes: Vec::new(), room: None }
    }

    fn turned(&self, v: DVec3) -> DVec3 {
        DQuat::from_rotation_y(self.turn) * v
    }

    /// Walls 2 m behind and 2.5 m to the left and right of the origin, and a ceiling.
    pub fn with_room(mut self, ceiling: f64) -> Self {
        let planes = [(DVec3::NEG_Z * 2.0, DVec3::Z), (DVec3::NEG_X * 2.5, DVec3::X), (DVec3::X * 2.5, DVec3::NEG_X)];
        let walls = planes.map(|(point, normal)| {
            // Any point of the plane will do.
            let aside = self.turned(point + normal.cross(DVec3::Y) * 3.0 + DVec3::Y * 0.7);
            json!({"point": aside.to_array(), "normal": (self.turned(normal) * 2.0).to_array()})
        });
        self.room = Some(json!({"ceiling": ceiling, "walls": walls}));
        self
    }

    /// A box with its middle at a place, turned by yaw and then leaning by an angle about X, rad.
    pub fn add(
        &mut self,
        name: &str,
        parent: &str,
        size: [f64; 3],
        middle: [f64; 3],
        yaw: f64,
        lean: f64,
    ) -> &mut Value {
        let rotation = DQuat::from_rotation_y(self.turn + yaw) * DQuat::from_rotation_x(lean);
        self.sizes.push(DVec3::from(size));
        self.objects.push(json!({
            "name": name, "mesh": format!("{name}.obj"), "parent": parent,
            "position": self.turned(DVec3::from(middle)).to_array(), "rotation_xyzw": rotation.to_array(),
        }));
        self.objects.last_mut().unwrap()
    }

    pub fn done(&self) -> Ready {
        let folder = tempfile::tempdir().unwrap();
        for (object, size) in self.objects.iter().zip(&self.sizes) {
            let corner =
                |i: usize| 0.5 * *size * DVec3::from([0, 1, 2].map(|a| if i >> a & 1 == 1 { 1.0 } else { -1.0 }));
            let vertices: String = (0..8).map(corner).map(|v| format!("v {} {} {}\n", v.x, v.y, v.z)).collect();
            let faces = "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n";
            std::fs::write(folder.path().join(object["mesh"].as_str().unwrap()), vertices + faces).unwrap();
        }
        let mut document = json!({"format": "rest3d-scene", "version": 1, "objects": self.objects});
        document.as_object_mut().unwrap().extend(self.room.iter().map(|room| ("room".to_owned(), room.clone())));
        std::fs::write(folder.path().join("scene.json"), document.to_string()).unwrap();
        Ready::new(Scene::read(folder.path()).unwrap())
    }
}

/// A scene with its shapes.
pub struct Ready {
    pub scene: Scene,
    pub shapes: Vec<Shape>,
}

impl Ready {
    pub fn new(scene: Scene) -> Self {
        let shapes = build_shapes(&shape_requests(&scene), &ShapeSettings::default(), None, &|_, _, _| ()).unwrap();
        Self { scene, shapes }
    }

    pub fn run(&self, config: &Config) -> Done<'_> {
        let outcome = run(&self.scene, &self.shapes, &CpuBackend, config, 1, None, &mut Keep::default()).unwrap();
        Done { ready: self, outcome }
    }

    pub fn index(&self, name: &str) -> usize {
        self.scene.objects.iter().position(|object| object.name == name).unwrap()
    }
}

/// A run of it.
pub struct Done<'a> {
    ready: &'a Ready,
    pub outcome: Outcome,
}

impl Done<'_> {
    pub fn pose(&self, name: &str) -> Pose {
        self.outcome.objects[self.ready.index(name)].pose
    }

    pub fn placed(&self, i: usize) -> Placed<'_> {
        (&self.ready.shapes[i].surface, &self.outcome.objects[i].pose)
    }

    /// How far the outermost corner of an object is inside a plane, m.
    pub fn gap(&self, i: usize, point: DVec3, normal: DVec3) -> f64 {
        corners(self.placed(i)).into_iter().map(|p| (p - point).dot(normal)).fold(f64::INFINITY, f64::min)
    }

    /// The least distance of an object from a plane that bounds the room, m.
    pub fn nearest_gap(&self, i: usize) -> f64 {
        let on_ceiling = self.ready.scene.objects[i].parent == Parent::Root(Root::Ceiling);
        let sides = self.outcome.room.sides.iter().filter(|side| (side.kind == Root::Ceiling) == on_ceiling);
        sides.map(|side| self.gap(i, side.point, side.normal)).min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap()
    }

    pub fn note(&self, name: &str) -> &str {
        self.outcome.placements[self.ready.index(name)].as_ref().map_or("", |placement| &placement.note)
    }

    /// Everything that hangs touches, and no two meshes meet.
    pub fn check(&self) {
        for (i, object) in self.ready.scene.objects.iter().enumerate() {
            if matches!(object.parent, Parent::Root(Root::Wall | Root::Ceiling)) && object.movable {
                let gap = self.nearest_gap(i);
                assert!((-1e-6..TOUCHES).contains(&gap), "{}: {} mm off", object.name, 1e3 * gap);
            }
        }
        self.check_apart();
    }

    pub fn check_apart(&self) {
        for (i, j) in (0..self.ready.shapes.len()).flat_map(|j| (0..j).map(move |i| (i, j))) {
            let (a, b) = (&self.ready.scene.objects[i].name, &self.ready.scene.objects[j].name);
            assert!(!meet(self.placed(i), self.placed(j)), "{a} and {b} meet");
        }
    }

    /// Yaw of an object's own +Z against that of the room, modulo a quarter turn, rad.
    pub fn askew(&self, name: &str, turn: f64) -> f64 {
        let front = DQuat::from_rotation_y(-turn) * (self.pose(name).rotation * DVec3::Z);
        let yaw = front.x.atan2(front.z);
        yaw - (yaw / std::f64::consts::FRAC_PI_2).round() * std::f64::consts::FRAC_PI_2
    }
}

pub fn config() -> Config {
    let mut config = Config { seat: true, room: true, exact: true, ..Default::default() };
    (config.settle.max_seconds, config.settle.from) = (5.0, ResultFrom::Settled);
    for cem in [&mut config.local, &mut config.global] {
        (cem.candidates, cem.iterations, cem.episodes, cem.elite_fraction, cem.sample_mean) = (8, 2, 1, 0.3, true);
    }
    config.verify.seconds = 1.0;
    config
}

/// A table, a cabinet at the left wall, pictures, a shelf with books and two lamps, as a reconstruction leaves them.
pub fn furnished(turn: f64) -> Boxes {
    let mut boxes = Boxes::new(turn);
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.3, 0.34, 0.4], 0.02, 0.0);
    boxes.add("cabinet", "ground-wall", [0.5, 1.2, 1.4], [-2.2, 0.62, 0.2], -0.03, 0.0);
    boxes.add("picture", "wall", [0.8, 0.5, 0.03], [0.2, 1.5, -1.93], 0.12, 0.05);
    boxes.add("clock", "wall", [0.3, 0.3, 0.06], [-2.53, 1.7, -1.2], 1.5, -0.04);
    boxes.add("shelf", "wall", [0.9, 0.03, 0.25], [-1.2, 1.5, -1.85], -0.06, 0.0);
    for (i, x) in [-1.4, -1.3, -1.2].into_iter().enumerate() {
        boxes.add(&format!("book{i}"), "shelf", [0.05, 0.24, 0.16], [x, 1.64, -1.85], -0.06, 0.0);
    }
    boxes.add("lamp", "ceiling", [0.4, 0.3, 0.4], [0.3, 2.3, 0.4], 0.3, 0.06)["relation"] = "hanging".into();
    boxes.add("fan", "ceiling", [1.0, 0.2, 1.0], [0.9, 2.45, 0.4], 0.0, 0.0)["relation"] = "hanging".into();
    boxes
}
