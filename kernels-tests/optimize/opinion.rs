//! The second opinion: what other parts, other masses and slopes have against a layout.

use crate::fixture::*;
use glam::{DVec3, Vec3};
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::optimize::{Checkpoint, Config, run};
use rest3d_gpu::scene::{Parent, Relation};
use rest3d_gpu::world::{
    Backend, BackendError, OnStep, Pose, Search, SearchSettings, SimSettings, Status, Stream, World,
};

#[test]
fn what_the_search_pushed_off_its_support_is_set_onto_it_again() {
    let mut boxes = Boxes::default();
    let table = boxes.add("table", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    let cup = boxes.add("cup", Parent::Object(table), Vec3::splat(0.1), DVec3::Y * 0.5);
    // It reaches 1.5 mm into the cup's place: no reason to look for another one.
    let stone = boxes.add("stone", GROUND, Vec3::splat(0.2), DVec3::new(0.1485, 0.5, 0.0));
    boxes.objects[table].movable = false;
    boxes.objects[stone].movable = false;
    let with = |second_opinion, room| {
        let backend = Fake { slide: Vec3::X * 0.8, room, ..Default::default() };
        simple(&boxes, &backend, &Config { second_opinion, ..frozen() }).objects[cup].clone()
    };
    assert!(with(false, None).lost_support);
    let object = with(true, None);
    // However few copies the simulator takes at once.
    assert_eq!(format!("{:?}", with(true, Some(5))), format!("{object:?}"));
    assert!(!object.lost_support && object.moved < 1e-3, "{object:?}");
}

/// A cup beside the edge of its table, in the air. A stone leaves it no room at the nearest place.
#[test]
fn what_has_no_support_is_set_onto_the_nearest_place_that_bears_it() {
    let mut boxes = Boxes::default();
    let table = boxes.add("table", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    let cup = boxes.add("cup", Parent::Object(table), Vec3::splat(0.1), DVec3::new(0.58, 0.5, 0.0));
    let stone = boxes.add("stone", GROUND, Vec3::new(0.1, 0.1, 0.04), DVec3::new(0.47, 0.5, 0.0));
    boxes.objects[table].movable = false;
    boxes.objects[stone].movable = false;
    let with = |second_opinion| {
        let config = Config { second_opinion, ..frozen() };
        simple(&boxes, &Fake::default(), &config).objects[cup].clone()
    };
    assert!(with(false).lost_support);
    let object = with(true);
    assert!(!object.lost_support && (0.06..0.1).contains(&object.moved), "{object:?}");
}

/// A crate with a cup on it, 5 cm in a stone, both on the ground.
#[test]
fn what_was_thrown_far_is_brought_back_with_what_is_on_it() {
    let mut boxes = Boxes::default();
    let crates = boxes.add("crate", GROUND, Vec3::new(0.4, 0.3, 0.4), DVec3::ZERO);
    let cup = boxes.add("cup", Parent::Object(crates), Vec3::splat(0.1), DVec3::Y * 0.3);
    let stone = boxes.add("stone", GROUND, Vec3::splat(0.2), DVec3::X * 0.25);
    boxes.objects[stone].movable = false;
    let with = |second_opinion, way: f32| {
        let backend = Fake { slide: Vec3::X * way, ..Default::default() };
        let config = Config { second_opinion, global_only: true, ..frozen() };
        let outcome = simple(&boxes, &backend, &config);
        [crates, cup].map(|object| shift(&boxes, &outcome, object).with_y(0.0))
    };
    let [thrown, _] = with(false, 0.8);
    assert!((thrown.length() - 0.8).abs() < 0.01, "{thrown}");
    let [back, with_it] = with(true, 0.8);
    assert!((0.045..0.08).contains(&back.length()) && back.x < 0.0, "{back}");
    assert!(with_it.distance(back) < 5e-3, "{with_it} with {back}");
    let [near, _] = with(true, 0.24);
    assert!((near.length() - 0.24).abs() < 0.01, "what is not far stays: {near}");
}

/// A plank with its head 3 cm in a beam, which pushes it over until it leans against a stone.
#[test]
fn what_leans_is_set_upright_where_there_is_room() {
    let mut boxes = Boxes::default();
    let plank = boxes.add("plank", GROUND, Vec3::new(0.04, 0.5, 0.2), DVec3::ZERO);
    let beam = boxes.add("beam", GROUND, Vec3::new(0.2, 0.05, 0.2), DVec3::new(-0.09, 0.44, 0.0));
    let stone = boxes.add("stone", GROUND, Vec3::new(0.2, 0.6, 0.6), DVec3::new(0.29, 0.0, 0.0));
    boxes.objects[beam].movable = false;
    boxes.objects[stone].movable = false;
    let with = |second_opinion: bool| {
        let config = Config { second_opinion, project: false, ..frozen() };
        let outcome = simple(&boxes, &CpuBackend, &config);
        outcome.objects[plank].clone()
    };
    let object = with(false);
    assert!(object.stable && (0.3..0.6).contains(&object.turned), "{object:?}");
    let object = with(true);
    assert!(object.stable && object.turned < 0.02 && (0.029..0.08).contains(&object.moved), "{object:?}");
}

/// A crate at the edge of a stone block, which stands with its own parts and tips with the others, whose centre of mass
/// is 20 mm farther out.
#[test]
fn what_stands_on_one_decomposition_only_is_searched_again() {
    let mut boxes = Boxes::default();
    let stone = boxes.add("stone", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    boxes.objects[stone].movable = false;
    let at_edge = DVec3::new(0.49, 0.5, 0.0);
    let crate_ = boxes.add("crate", Parent::Object(stone), Vec3::splat(0.2), at_edge);
    let mass = &mut boxes.shapes[crate_].alternatives[1].mass;
    mass.center += mass.axes * Vec3::X * 0.02;
    let with = |second_opinion: bool| {
        let config = Config { second_opinion, ..frozen() };
        let outcome = simple(&boxes, &CpuBackend, &config);
        outcome.objects[crate_].clone()
    };
    let object = with(false);
    assert!(object.stable && !object.stable_otherwise && object.moved < 1e-3, "{object:?}");
    let object = with(true);
    assert!(object.stable && object.stable_otherwise && !object.fallen && !object.lost_support, "{object:?}");
    assert!(object.moved < 0.05, "{object:?}");
}

/// A die in a tray, which other parts fill up to the brim: the die finds rest nowhere on those.
#[test]
fn other_parts_that_fill_what_something_is_in_say_nothing() {
    let mut boxes = Boxes::default();
    let tray = boxes.add("tray", GROUND, Vec3::new(0.4, 0.1, 0.3), DVec3::ZERO);
    let die = boxes.add("die", Parent::Object(tray), Vec3::splat(0.04), DVec3::new(0.05, 0.02, 0.0));
    boxes.hollow(tray, 0.02);
    let mut scene = boxes.scene();
    scene.objects[die].relation = Relation::Inside;
    let config = Config { second_opinion: true, ..frozen() };
    let outcome = run(&scene, &boxes.shapes, &CpuBackend, &config, 1, None, &mut Watch::default()).unwrap();
    let object = &outcome.objects[die];
    assert!(object.stable && object.stable_otherwise && object.moved < 1e-3, "{object:?}");
    assert!(outcome.notes.iter().any(|note| note.contains("\"tray\"")), "{:?}", outcome.notes);
}

/// A plank that reaches 4 mm too far over the edge of a stone, and a weight on its other end: it holds the plank if it
/// is as heavy, but not if it is as much lighter as it is smaller. What the scene says of masses holds.
#[test]
fn what_only_a_guessed_mass_holds_is_searched_again() {
    let mut boxes = Boxes::default();
    let stone = boxes.add("stone", GROUND, Vec3::new(1.0, 0.5, 1.0), DVec3::ZERO);
    boxes.objects[stone].movable = false;
    let plank = boxes.add("plank", Parent::Object(stone), Vec3::new(1.0, 0.02, 0.2), DVec3::new(0.504, 0.5, 0.0));
    boxes.add("weight", Parent::Object(plank), Vec3::splat(0.03), DVec3::new(0.1, 0.52, 0.0));
    let moved = |second_opinion: bool, mass: Option<f64>| {
        let mut scene = boxes.scene();
        scene.objects.iter_mut().for_each(|object| object.mass = mass);
        let config = Config { second_opinion, ..frozen() };
        let outcome = run(&scene, &boxes.shapes, &CpuBackend, &config, 1, None, &mut Watch::default()).unwrap();
        let plank = &outcome.objects[plank];
        assert!(plank.stable && !plank.lost_support && !plank.fallen, "{plank:?}");
        plank.moved
    };
    assert!(moved(false, None) < 1e-3 && moved(true, Some(2.0)) < 1e-3);
    let far = moved(true, None);
    assert!((0.002..0.05).contains(&far), "{far} m");
}

/// A board of 30 cm on its edge, which stands as long as nothing pushes it: on a slope of 1.1° it falls if it is
/// thinner than 6 mm.
#[test]
fn what_stands_on_next_to_nothing_is_laid_down() {
    let board = |thickness: f32, second_opinion: bool| {
        let mut boxes = Boxes::default();
        let board = boxes.add("board", GROUND, Vec3::new(0.2, 0.3, thickness), DVec3::ZERO);
        let config = Config { second_opinion, ..frozen() };
        let outcome = simple(&boxes, &CpuBackend, &config);
        outcome.objects[board].clone()
    };
    for (thickness, second_opinion) in [(0.003, false), (0.012, true)] {
        let object = board(thickness, second_opinion);
        assert!(object.stable && object.moved < 1e-3 && object.turned < 1e-3, "{thickness} m: {object:?}");
    }
    let object = board(0.003, true);
    assert!(object.stable && object.turned > 1.5, "{object:?}");
}

#[test]
fn what_stands_side_by_side_gets_room() {
    let mut boxes = Boxes::default();
    let cupboard = Vec3::new(1.0, 1.0, 0.5);
    let left = boxes.add("left", GROUND, cupboard, DVec3::ZERO);
    boxes.add("vase on it", Parent::Object(left), Vec3::splat(0.2), DVec3::new(0.0, 1.0, 0.0));
    boxes.add("right", GROUND, cupboard, DVec3::new(1.002, 0.0, 0.0));
    boxes.add("apart", GROUND, cupboard, DVec3::new(0.0, 0.0, 3.0));
    for (name, x) in [("left side of a niche", 4.0), ("right side", 5.506)] {
        let side = boxes.add(name, GROUND, Vec3::new(1.0, 1.0, 2.0), DVec3::new(x, 0.0, 0.0));
        boxes.objects[side].movable = false;
    }
    boxes.add("in the niche", GROUND, Vec3::splat(0.5), DVec3::new(4.753, 0.0, 0.0));
    let config = Config { second_opinion: true, ..frozen() };
    let outcome = simple(&boxes, &CpuBackend, &config);
    let [left, vase, right, apart, .., niche] = &outcome.objects[..] else { panic!("{:?}", outcome.objects) };
    let gap = right.pose.translation.x - left.pose.translation.x - 1.0;
    assert!((0.010..0.013).contains(&gap), "{gap} m between them");
    assert!((2e-3..right.moved).contains(&left.moved), "the fuller one moves less: {} {} m", left.moved, right.moved);
    assert!((vase.moved - left.moved).abs() < 5e-4, "what stands on it comes along: {} m", vase.moved);
    assert!(apart.moved < 1e-3 && niche.moved < 1e-3, "{} {} m", apart.moved, niche.moved);
}

/// A crate whose edge is 10 mm under a board, 8 mm too high for it: board and slab press on it and keep it in, at rest.
#[test]
fn what_is_jammed_is_freed() {
    let mut boxes = Boxes::default();
    let slab = boxes.add("slab", GROUND, Vec3::new(1.0, 0.1, 1.0), DVec3::ZERO);
    let board = boxes.add("board", GROUND, Vec3::new(1.0, 0.3, 0.2), DVec3::new(0.0, 0.292, 0.0));
    boxes.objects[slab].movable = false;
    boxes.objects[board].movable = false;
    let crate_ = boxes.add("crate", Parent::Object(slab), Vec3::splat(0.2), DVec3::new(0.0, 0.1, 0.19));
    let mut scene = boxes.scene();
    // Room beside each other is not made for what lies in something.
    scene.objects[crate_].relation = Relation::Inside;
    let with = |second_opinion: bool| {
        let config = Config { second_opinion, ..frozen() };
        let outcome = run(&scene, &boxes.shapes, &CpuBackend, &config, 1, None, &mut Watch::default()).unwrap();
        outcome.objects[crate_].clone()
    };
    let object = with(false);
    assert!(object.drift < 0.01 && object.overlap > 2e-3 && !object.stable, "engines throw it out: {object:?}");
    let object = with(true);
    assert!(object.stable && object.overlap < 1e-3 && object.moved < 0.05 && !object.lost_support, "{object:?}");
}

/// A tile, too thin to stand, that leans by 25° towards a block, or away from it, and would come to lie on its foot.
#[test]
fn what_would_fall_over_leans_on_what_stands_beside_it() {
    let with = |side: f64, second_opinion: bool| {
        let mut boxes = Boxes::default();
        let table = Parent::Object(boxes.add("table", GROUND, Vec3::new(1.0, 0.7, 1.0), DVec3::ZERO));
        boxes.add("block", table, Vec3::splat(0.2), DVec3::new(0.233, 0.7, 0.0));
        let tile = boxes.add("tile", table, Vec3::new(0.003, 0.15, 0.2), DVec3::ZERO);
        let lean = 25_f64.to_radians();
        boxes.turn(tile, -lean * side, DVec3::new(0.032, 0.701 + 0.075 * lean.cos(), 0.0));
        let config = Config { seat: true, second_opinion, ..frozen() };
        let mut watch = Watch::default();
        let tile = go(&boxes, &CpuBackend, &config, 1, None, &mut watch).unwrap().objects[tile].clone();
        assert!(tile.stable && !tile.lost_support, "{side} {second_opinion}: {tile:?}");
        (tile, watch.rounds)
    };
    assert!(with(1.0, false).0.fallen && with(-1.0, true).0.fallen);
    let (tile, rounds) = with(1.0, true);
    assert!(!tile.fallen && tile.turned < 0.2 && tile.moved < 0.1, "{tile:?}");
    assert_eq!(rounds, 0, "it takes none to set it down anew");
}

/// A tile that leans by 25° towards a post and pushes it over, and behind that towards a block that holds it.
#[test]
fn what_was_pushed_over_is_set_up_again() {
    let mut boxes = Boxes::default();
    let table = Parent::Object(boxes.add("table", GROUND, Vec3::new(1.0, 0.7, 1.0), DVec3::ZERO));
    let post = boxes.add("post", table, Vec3::new(0.02, 0.13, 0.03), DVec3::new(0.135, 0.7, 0.085));
    boxes.add("block", table, Vec3::new(0.2, 0.2, 0.12), DVec3::new(0.233, 0.7, -0.04));
    let tile = boxes.add("tile", table, Vec3::new(0.003, 0.15, 0.2), DVec3::ZERO);
    let lean = 25_f64.to_radians();
    boxes.turn(tile, -lean, DVec3::new(0.032, 0.701 + 0.075 * lean.cos(), 0.0));
    let config = Config { seat: true, second_opinion: true, ..frozen() };
    let mut watch = Watch::default();
    let outcome = go(&boxes, &CpuBackend, &config, 1, None, &mut watch).unwrap();
    for object in [post, tile].map(|object| &outcome.objects[object]) {
        assert!(!object.fallen && object.stable && object.moved < 0.1, "{object:?}");
    }
    assert_eq!(watch.rounds, 0, "it takes none to set it down anew");
}

/// A block of 1 : 3 that leans by 25° and is set up, because it would fall over, is thrown aside by the search.
#[test]
fn what_rolls_and_stands_far_off_is_set_down_anew_in_its_place() {
    let mut boxes = Boxes::default();
    let block = boxes.add("block", GROUND, Vec3::new(0.1, 0.3, 0.1), DVec3::ZERO);
    boxes.turn(block, 25.0_f64.to_radians(), DVec3::Y * 0.2);
    let with = |second_opinion, way: f32, resume, watch: &mut Watch| {
        let config = Config { seat: true, second_opinion, ..frozen() };
        let backend = InTurn(Some(Fake { slide: Vec3::X * way, ..Default::default() }));
        let outcome = go(&boxes, &backend, &config, 1, resume, watch).unwrap();
        let object = &outcome.objects[block];
        assert!(object.stable && (object.turned.to_degrees() - 25.0).abs() < 0.5, "{object:?}");
        (shift(&boxes, &outcome, block).with_y(0.0).length(), outcome)
    };
    let (placed, _) = with(true, 0.0, None, &mut Watch::default());
    let (thrown, _) = with(false, 0.2, None, &mut Watch::default());
    let (back, whole) = with(true, 0.2, None, &mut Watch::default());
    assert!((thrown - placed).abs() > 0.15 && (back - placed).abs() < 0.05, "{placed}, {thrown}, {back} m");
    // An observer may end it there, and it may be resumed.
    let mut watch = Watch { stop_at_anew: true, ..Default::default() };
    let (left, stopped) = with(true, 0.2, None, &mut watch);
    assert!(!stopped.finished && (left - thrown).abs() < 0.01, "{left} m");
    let last = Checkpoint::from_json(watch.checkpoints.last().unwrap()).unwrap();
    let (_, resumed) = with(true, 0.2, Some(last), &mut Watch::default());
    assert_eq!(results(resumed), results(whole));
}

/// The processor, said to simulate one thing at a time; if there is a fake simulator, that does the searches.
struct InTurn(Option<Fake>);

impl Backend for InTurn {
    fn describe(&self) -> String {
        CpuBackend.describe()
    }

    fn simulate(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        CpuBackend.simulate(world, settings, starts, on_step)
    }

    fn overlaps(&self, world: &World, settings: &SimSettings, poses: &[Pose]) -> Result<Vec<f32>, BackendError> {
        CpuBackend.overlaps(world, settings, poses)
    }

    fn search<'a>(
        &'a self,
        world: &'a World,
        settings: &'a SearchSettings,
        stream: Stream,
    ) -> Result<Box<dyn Search + 'a>, BackendError> {
        match &self.0 {
            Some(fake) => fake.search(world, settings, stream),
            None => CpuBackend.search(world, settings, stream),
        }
    }
}

/// Three crates that stand with their own parts and tip with others, each on a stone of its own, and a board on its
/// edge that falls on slopes.
#[test]
fn runs_beside_one_another_end_as_in_turn() {
    let mut boxes = Boxes::default();
    for (i, [stone, crate_]) in [["a", "on a"], ["b", "on b"], ["c", "on c"]].into_iter().enumerate() {
        let middle = DVec3::X * 3.0 * i as f64;
        let stone = boxes.add(stone, GROUND, Vec3::new(1.0, 0.5, 1.0), middle);
        boxes.objects[stone].movable = false;
        let at_edge = middle + DVec3::new(0.491 - 0.003 * i as f64, 0.5, 0.0);
        let crate_ = boxes.add(crate_, Parent::Object(stone), Vec3::splat(0.2), at_edge);
        let mass = &mut boxes.shapes[crate_].alternatives[i % 2].mass;
        mass.center += mass.axes * Vec3::X * 0.02;
    }
    boxes.add("board", GROUND, Vec3::new(0.2, 0.3, 0.003), DVec3::new(0.0, 0.0, 3.0));
    let config = Config { second_opinion: true, ..frozen() };
    let with = |backend: &dyn Backend| {
        let mut watch = Watch::default();
        let outcome = go(&boxes, backend, &config, 1, None, &mut watch).unwrap();
        (outcome.objects.iter().map(|object| object.pose).collect::<Vec<_>>(), watch.rounds)
    };
    assert!(CpuBackend.busy_with() > InTurn(None).busy_with());
    let (beside, rounds) = with(&CpuBackend);
    assert!(rounds > 0, "nothing was searched again");
    assert_eq!((beside, rounds), with(&InTurn(None)));
}
