//! Placement on walls and ceiling, and walls that bear, in rooms of boxes at any angle and in the shared test room.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use common::meshes::{Placed, corners, meet};
use common::scenes::Keep;
use glam::{DQuat, DVec3, Vec3};
use parry3d::math::Pose as Isometry;
use parry3d::query::contact;
use parry3d::shape::ConvexPolyhedron;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::optimize::{Checkpoint, Config, Outcome, run, shape_requests};
use rest3d_gpu::scene::{Parent, Pose, Root, Scene};
use rest3d_gpu::shape::{Shape, ShapeSettings, build_shapes};
use serde_json::{Value, json};

/// Nearer than this is a touch, m: the requirement.
const TOUCHES: f64 = 0.01;
/// How deep something may be in a wall, m: what resting contact sinks in.
const SUNK: f64 = 0.2e-3;

/// A scene of boxes. Everything is said in a room whose back wall looks along +Z, and turned about +Y afterwards.
struct Boxes {
    turn: f64,
    objects: Vec<Value>,
    sizes: Vec<DVec3>,
    room: Option<Value>,
}

impl Boxes {
    fn new(turn: f64) -> Self {
        Self { turn, objects: Vec::new(), sizes: Vec::new(), room: None }
    }

    fn turned(&self, v: DVec3) -> DVec3 {
        DQuat::from_rotation_y(self.turn) * v
    }

    /// Walls 2 m behind and 2.5 m to the left and right of the origin, and a ceiling.
    fn with_room(mut self, ceiling: f64) -> Self {
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
    fn add(&mut self, name: &str, parent: &str, size: [f64; 3], middle: [f64; 3], yaw: f64, lean: f64) -> &mut Value {
        let rotation = DQuat::from_rotation_y(self.turn + yaw) * DQuat::from_rotation_x(lean);
        self.sizes.push(DVec3::from(size));
        self.objects.push(json!({
            "name": name, "mesh": format!("{name}.obj"), "parent": parent,
            "position": self.turned(DVec3::from(middle)).to_array(), "rotation_xyzw": rotation.to_array(),
        }));
        self.objects.last_mut().unwrap()
    }

    fn done(&self) -> Ready {
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
struct Ready {
    scene: Scene,
    shapes: Vec<Shape>,
}

/// A run of it.
struct Done<'a> {
    ready: &'a Ready,
    outcome: Outcome,
}

fn config() -> Config {
    let mut config = Config { seat: true, room: true, exact: true, ..Default::default() };
    for cem in [&mut config.local, &mut config.global] {
        (cem.candidates, cem.iterations, cem.episodes, cem.elite_fraction, cem.sample_mean) = (8, 2, 1, 0.3, true);
    }
    config.verify.seconds = 1.0;
    config
}

impl Ready {
    fn new(scene: Scene) -> Self {
        let shapes = build_shapes(&shape_requests(&scene), &ShapeSettings::default(), None, &|_, _, _| ()).unwrap();
        Self { scene, shapes }
    }

    fn run(&self, config: &Config) -> Done<'_> {
        let outcome = run(&self.scene, &self.shapes, &CpuBackend, config, 1, None, &mut Keep::default()).unwrap();
        Done { ready: self, outcome }
    }

    fn index(&self, name: &str) -> usize {
        self.scene.objects.iter().position(|object| object.name == name).unwrap()
    }
}

impl Done<'_> {
    fn pose(&self, name: &str) -> Pose {
        self.outcome.objects[self.ready.index(name)].pose
    }

    fn placed(&self, i: usize) -> Placed<'_> {
        (&self.ready.shapes[i].surface, &self.outcome.objects[i].pose)
    }

    /// How far the outermost corner of an object is inside a plane, m.
    fn gap(&self, i: usize, point: DVec3, normal: DVec3) -> f64 {
        corners(self.placed(i)).into_iter().map(|p| (p - point).dot(normal)).fold(f64::INFINITY, f64::min)
    }

    /// The least distance of an object from a plane that bounds the room, m.
    fn nearest_gap(&self, i: usize) -> f64 {
        let on_ceiling = self.ready.scene.objects[i].parent == Parent::Root(Root::Ceiling);
        let sides = self.outcome.room.sides.iter().filter(|side| (side.kind == Root::Ceiling) == on_ceiling);
        sides.map(|side| self.gap(i, side.point, side.normal)).min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap()
    }

    fn note(&self, name: &str) -> &str {
        self.outcome.placements[self.ready.index(name)].as_ref().map_or("", |placement| &placement.note)
    }

    /// Everything that hangs touches, and no two meshes meet.
    fn check(&self) {
        for (i, object) in self.ready.scene.objects.iter().enumerate() {
            if matches!(object.parent, Parent::Root(Root::Wall | Root::Ceiling)) && object.movable {
                let gap = self.nearest_gap(i);
                assert!((-1e-6..TOUCHES).contains(&gap), "{}: {} mm off", object.name, 1e3 * gap);
            }
        }
        self.check_apart();
    }

    fn check_apart(&self) {
        for (i, j) in (0..self.ready.shapes.len()).flat_map(|j| (0..j).map(move |i| (i, j))) {
            let (a, b) = (&self.ready.scene.objects[i].name, &self.ready.scene.objects[j].name);
            assert!(!meet(self.placed(i), self.placed(j)), "{a} and {b} meet");
        }
    }

    /// Yaw of an object's own +Z against that of the room, modulo a quarter turn, rad.
    fn askew(&self, name: &str, turn: f64) -> f64 {
        let front = DQuat::from_rotation_y(-turn) * (self.pose(name).rotation * DVec3::Z);
        let yaw = front.x.atan2(front.z);
        yaw - (yaw / std::f64::consts::FRAC_PI_2).round() * std::f64::consts::FRAC_PI_2
    }
}

/// A table, a cabinet at the left wall, pictures, a shelf with books and two lamps, as a reconstruction leaves them.
fn furnished(turn: f64) -> Boxes {
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

#[test]
fn what_hangs_touches_and_meets_nothing_at_any_angle() {
    for turn in [0.0, 0.52, -1.1, 2.9] {
        let ready = furnished(turn).with_room(2.5).done();
        let done = ready.run(&config());
        done.check();
        for name in ["picture", "clock", "shelf"] {
            assert!(done.askew(name, turn).abs() < 1e-3, "{name} is askew by {} at {turn}", done.askew(name, turn));
            assert!((done.pose(name).rotation * DVec3::Y).distance(DVec3::Y) < 1e-6, "{name} is plumb");
        }
        let cabinet = done.nearest_gap(ready.index("cabinet"));
        assert!((-SUNK..TOUCHES).contains(&cabinet), "the cabinet is {cabinet} m from its wall");
        // The lamp and the fan were in each other.
        let apart = done.pose("lamp").translation.distance(done.pose("fan").translation);
        assert!(apart > 0.6, "{apart}");
        assert!(done.outcome.objects.iter().all(|object| object.stable && !object.lost_support));
    }
}

#[test]
fn books_ride_along_with_their_shelf_and_are_searched_there() {
    let ready = furnished(0.4).with_room(2.5).done();
    let done = ready.run(&config());
    let input = |name: &str| ready.scene.objects[ready.index(name)].pose;
    let moved = done.pose("shelf").translation.distance(input("shelf").translation);
    assert!(moved > 0.02, "a canary: the shelf is moved, by {moved}");
    let local = |shelf: Pose, book: Pose| shelf.rotation.conjugate() * (book.translation - shelf.translation);
    for name in ["book0", "book1", "book2"] {
        let (before, after) = (local(input("shelf"), input(name)), local(done.pose("shelf"), done.pose(name)));
        assert!(before.distance(after) < 0.02, "{name} has gone from {before} to {after}");
    }
    assert!(done.outcome.groups.iter().any(|group| group.name == "shelf" && group.units.len() == 3));
}

#[test]
fn without_a_room_walls_follow_the_furniture() {
    for turn in [0.0, 0.52, -0.3] {
        let ready = furnished(turn).done();
        let done = ready.run(&config());
        done.check();
        for side in done.outcome.room.sides.iter().filter(|side| side.kind == Root::Wall) {
            assert!(side.fitted && !side.bears);
            let yaw = (side.normal.x.atan2(side.normal.z) - turn).rem_euclid(std::f64::consts::FRAC_PI_2);
            assert!(!(0.03..std::f64::consts::FRAC_PI_2 - 0.03).contains(&yaw), "{} is off by {yaw}", side.name);
            for i in 0..ready.scene.objects.len() {
                assert!(done.gap(i, side.point, side.normal) > -SUNK, "{} is through {}", i, side.name);
            }
        }
    }
}

#[test]
fn a_wall_is_fitted_behind_what_is_held_too() {
    let mut boxes = Boxes::new(0.3);
    boxes.add("cabinet", "ground-wall", [1.4, 1.2, 0.5], [0.0, 0.6, -1.75], 0.0, 0.0)["movable"] = false.into();
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.3, 0.35, 0.4], 0.0, 0.0);
    boxes.add("picture", "wall", [0.8, 0.5, 0.03], [0.2, 1.6, -1.9], 0.1, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    done.check();
    let side = &done.outcome.room.sides[0];
    assert!((done.gap(0, side.point, side.normal) - 0.5e-3).abs() < 1e-6, "{side:?}");
}

#[test]
fn a_guess_that_nothing_needs_changes_no_bit() {
    let mut boxes = Boxes::new(0.3);
    boxes.add("cabinet", "ground-wall", [0.5, 1.2, 1.4], [-2.2, 0.62, 0.2], -0.03, 0.02);
    boxes.add("box", "cabinet", [0.2, 0.2, 0.2], [-2.2, 1.33, 0.2], 0.2, 0.0);
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.3, 0.34, 0.4], 0.02, 0.0);
    let ready = boxes.done();
    let with = ready.run(&config()).outcome;
    let without = ready.run(&Config { room: false, ..config() }).outcome;
    assert!(with.room.sides.is_empty());
    assert_eq!(with.objects, without.objects);
}

#[test]
fn what_cannot_be_placed_well_is_said() {
    let mut boxes = furnished(0.2).with_room(2.0);
    boxes.add("screen", "wall", [0.8, 0.5, 0.03], [1.6, 0.9, -1.6], 0.6, 0.0);
    boxes.add("mirror", "wall", [0.4, 0.8, 0.03], [1.3, 1.2, -0.8], 0.0, 0.0);
    boxes.add("hook", "wall", [0.05, 0.05, 0.05], [2.2, 1.2, 1.5], 0.1, 0.0)["movable"] = false.into();
    boxes.add("pole", "ground", [0.3, 2.2, 0.3], [1.5, 1.1, 1.5], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    assert!(done.note("screen").contains("not turned"), "{}", done.note("screen"));
    assert!(done.note("mirror").contains("was 1.1"), "{}", done.note("mirror"));
    assert!(done.note("hook").contains("not movable"), "{}", done.note("hook"));
    assert_eq!(done.pose("hook"), ready.scene.objects[ready.index("hook")].pose);
    assert!(done.outcome.notes.iter().any(|note| note.contains("pole: reaches 0.2")), "{:?}", done.outcome.notes);
    // Nothing that hangs is higher than the ceiling.
    done.check();
    let high = |i: usize| corners(done.placed(i)).iter().map(|p| p.y).fold(0.0, f64::max);
    assert!((0..ready.scene.objects.len()).all(|i| high(i) < 2.0 || ready.scene.objects[i].name == "pole"));
}

#[test]
fn what_has_no_place_on_its_wall_stands_off_it() {
    let mut boxes = Boxes::new(0.0).with_room(2.5);
    // A cupboard from wall to wall, up to the ceiling.
    boxes.add("cupboard", "ground", [4.9, 2.45, 0.3], [0.0, 1.225, -1.84], 0.0, 0.0)["movable"] = false.into();
    boxes.add("picture", "wall", [0.8, 0.5, 0.03], [0.2, 1.5, -1.9], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    done.check_apart();
    let gap = done.gap(1, DVec3::NEG_Z * 2.0, DVec3::Z);
    assert!((0.31..0.33).contains(&gap), "{gap}");
    assert!(done.note("picture").contains("no free place"), "{}", done.note("picture"));
    assert!(done.outcome.notes.iter().any(|note| note.contains("picture")));
}

#[test]
fn furniture_is_brought_inside_and_stays_there() {
    let mut boxes = Boxes::new(0.7).with_room(2.5);
    boxes.add("desk", "ground", [1.2, 0.7, 0.6], [0.0, 0.35, -1.8], 0.1, 0.0);
    boxes.add("cup", "desk", [0.1, 0.1, 0.1], [0.0, 0.75, -1.97], 0.1, 0.0);
    boxes.add("chest", "ground", [0.5, 0.5, 0.5], [2.3, 0.25, 0.5], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    for side in done.outcome.room.sides.iter().filter(|side| side.kind == Root::Wall) {
        assert!(side.bears);
        for (i, object) in ready.scene.objects.iter().enumerate() {
            let gap = done.gap(i, side.point, side.normal);
            assert!(gap > -SUNK, "{} is {gap} m from {}", object.name, side.name);
        }
    }
    assert!(done.outcome.objects.iter().all(|object| object.stable && !object.lost_support));
}

#[test]
fn a_wall_in_the_middle_of_the_furniture_bears_nothing() {
    let mut boxes = Boxes::new(0.0).with_room(2.5);
    boxes.add("table", "ground", [1.6, 0.7, 0.8], [0.0, 0.35, -2.1], 0.0, 0.0);
    let ready = boxes.done();
    let done = ready.run(&config());
    assert!(done.outcome.objects[0].moved < 0.01, "{}", done.outcome.objects[0].moved);
    assert!(done.outcome.notes.iter().any(|note| note.contains("wall 1")), "{:?}", done.outcome.notes);
}

#[test]
fn what_leans_needs_its_wall_and_keeps_leaning() {
    let leaning = |boxes: &mut Boxes| {
        boxes.add("mattress", "ground-wall", [1.4, 2.0, 0.2], [0.0, 1.0, -1.6], 0.03, -0.26);
        boxes.add("picture", "ground-wall", [0.6, 0.8, 0.03], [1.5, 0.4, -1.85], 0.0, -0.2);
        boxes.add("chest", "ground", [1.0, 0.5, 0.5], [0.0, 0.25, 0.5], 0.0, 0.0);
    };
    let (mut given, mut implied) = (Boxes::new(0.4).with_room(2.5), Boxes::new(0.4));
    leaning(&mut given);
    leaning(&mut implied);
    for boxes in [given, implied] {
        let ready = boxes.done();
        let done = ready.run(&config());
        for name in ["mattress", "picture"] {
            let outcome = &done.outcome.objects[ready.index(name)];
            assert!(outcome.stable && !outcome.fallen && !outcome.lost_support, "{name}: {outcome:?}");
            assert!(outcome.turned < 0.12, "{name} leans as it did, but for {} rad", outcome.turned);
            assert!((-SUNK..TOUCHES).contains(&done.nearest_gap(ready.index(name))), "{name}");
        }
        let alone = ready.run(&Config { room: false, ..config() });
        let fallen =
            alone.outcome.objects.iter().filter(|object| object.fallen || !object.stable || object.turned > 0.15);
        assert!(fallen.count() >= 2, "a canary: without a wall they do not stay");
    }
}

/// What the search left against a given wall, though nobody said that it leans there, falls in every engine that knows
/// objects only.
#[test]
fn what_leans_by_chance_is_set_up_again() {
    let mut boxes = Boxes::new(0.4).with_room(2.5);
    boxes.add("cabinet", "ground", [0.4, 1.0, 0.4], [0.0, 0.537, -1.6], 0.0, -0.45);
    let ready = boxes.done();
    let as_it_is = Config { seat: false, second_opinion: false, ..config() };
    let left = &ready.run(&as_it_is).outcome.objects[0];
    assert!(left.turned < 0.3 && !left.stable, "it leans on, and that is said: {left:?}");
    let up = &ready.run(&Config { second_opinion: true, ..as_it_is }).outcome.objects[0];
    assert!(up.stable && up.stable_otherwise && !up.fallen, "{up:?}");
}

#[test]
fn a_run_with_walls_repeats_and_resumes_to_the_bit() {
    let ready = furnished(0.3).with_room(2.5).done();
    let mut keep = Keep::default();
    let mut go = |resume| run(&ready.scene, &ready.shapes, &CpuBackend, &config(), 1, resume, &mut keep).unwrap();
    let first = go(None);
    assert_eq!(first.objects, go(None).objects);
    let checkpoint = Checkpoint::from_json(&keep.0[0]).unwrap();
    let resumed = run(&ready.scene, &ready.shapes, &CpuBackend, &config(), 1, Some(checkpoint), &mut Keep::default());
    let resumed = resumed.unwrap();
    assert_eq!((first.objects, first.placements), (resumed.objects, resumed.placements));
}

#[test]
#[cfg_attr(not(shared_files), ignore = "needs ../shared")]
fn the_test_room_has_everything_in_its_place() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/wall_ceiling");
    let ready = Ready::new(Scene::read(&folder).unwrap());
    let done = ready.run(&config());
    done.check();
    assert_eq!(done.outcome.clearances.overlaps, []);
    let parts = |i: usize| {
        let pose = done.outcome.objects[i].pose;
        let place = move |v: &Vec3| (pose.translation + pose.rotation * v.as_dvec3()).as_vec3();
        ready.shapes[i].parts.iter().filter_map(move |part| {
            ConvexPolyhedron::from_convex_hull(&part.vertices.iter().map(place).collect::<Vec<_>>())
        })
    };
    let here = Isometry::IDENTITY;
    for side in done.outcome.room.sides.iter().filter(|side| side.bears) {
        for (i, object) in ready.scene.objects.iter().enumerate() {
            assert!(done.gap(i, side.point, side.normal) > -SUNK, "{} is through {}", object.name, side.name);
        }
    }
    // What hangs is clear of everything else by its parts, too.
    let hung = |i: &usize| matches!(ready.scene.objects[*i].parent, Parent::Root(Root::Wall | Root::Ceiling));
    for i in (0..ready.scene.objects.len()).filter(hung) {
        for j in (0..i).filter(|&j| ready.scene.objects[j].parent != Parent::Object(i)) {
            for (a, b) in parts(i).flat_map(|a| parts(j).map(move |b| (a.clone(), b))) {
                let depth = contact(&here, &a, &here, &b, 0.0).ok().flatten().map_or(0.0, |contact| -contact.dist);
                assert!(depth < 1e-3, "{} and {}", ready.scene.objects[i].name, ready.scene.objects[j].name);
            }
        }
    }
}
