//! Groups, starts, and how searches end.

use crate::fixture::*;
use glam::{DVec3, Vec3};
use rest3d_gpu::optimize::{Checkpoint, Config, OptimizeError, ResultFrom};
use rest3d_gpu::world::{BackendError, STATIC};

#[test]
fn groups_go_from_the_leaves_to_the_whole_scene() {
    let (boxes, backend, mut watch) = (room(), Fake::default(), Watch::default());
    let outcome = go(&boxes, &backend, &config(), 1, None, &mut watch).unwrap();
    assert_eq!(watch.groups, ["tray", "table", "shelf", "global"]);
    assert_eq!(watch.candidates, [96; 4]);
    let units: Vec<_> = outcome.groups.iter().map(|group| group.units.join(" ")).collect();
    assert_eq!(units, ["cup", "tray", "vase", "table chair vase"]);
    let worlds = backend.worlds.lock().unwrap();
    let bodies: Vec<_> = worlds.iter().map(|world| world.bodies.iter().map(|b| b.unit).collect::<Vec<_>>()).collect();
    assert_eq!(bodies[0], [STATIC, 0], "tray, cup");
    assert_eq!(bodies[1], [STATIC, 0, 0], "table, tray, cup");
    assert_eq!(bodies[2], [STATIC, 0], "shelf, vase");
    assert_eq!(bodies[3], [0, 0, 0, 1, STATIC, 2, STATIC], "table, tray, cup, chair, shelf, vase, stone");
    assert!(outcome.finished && outcome.at_rest && outcome.notes.is_empty(), "{:?}", outcome.notes);
    assert_eq!(outcome.iterations.len(), 4 * 6);
}

#[test]
fn global_only_takes_every_object_by_itself() {
    let (boxes, backend, mut watch) = (room(), Fake::default(), Watch::default());
    let config = Config { global_only: true, ..config() };
    let outcome = go(&boxes, &backend, &config, 1, None, &mut watch).unwrap();
    assert_eq!(watch.groups, ["global"]);
    assert_eq!(outcome.groups[0].units.join(" "), "table tray cup chair vase");
    let bodies: Vec<_> = backend.worlds.lock().unwrap()[0].bodies.iter().map(|body| body.unit).collect();
    assert_eq!(bodies, [0, 1, 2, 3, STATIC, 4, STATIC]);
}

/// The projected layout is where a search without any spread ends if that costs less, and only then.
#[test]
fn a_search_goes_on_from_the_better_of_two_starts() {
    let mut boxes = Boxes::default();
    boxes.add("a", GROUND, Vec3::splat(0.4), DVec3::ZERO);
    boxes.add("b", GROUND, Vec3::splat(0.4), DVec3::X * 0.3);
    let moved = |project: bool, layout: f32| {
        let mut config = Config { project, ..frozen() };
        config.energy.layout = layout;
        for cem in [&mut config.local, &mut config.global] {
            cem.sample_mean = true;
        }
        let backend = Fake { overlap: true, ..Default::default() };
        let outcome = simple(&boxes, &backend, &config);
        shift(&boxes, &outcome, 1).x - shift(&boxes, &outcome, 0).x
    };
    assert_eq!(moved(false, 1.0), 0.0);
    assert!((moved(true, 0.1) - 0.1).abs() < 2e-3, "parted: {}", moved(true, 0.1));
    assert!(moved(true, 100.0).abs() < 1e-6, "to be moved costs more: {}", moved(true, 100.0));
}

#[test]
fn an_unmovable_child_is_held_and_what_stands_on_it_is_a_unit() {
    let mut boxes = room();
    boxes.objects[1].movable = false;
    let (backend, mut watch) = (Fake::default(), Watch::default());
    let outcome = go(&boxes, &backend, &config(), 1, None, &mut watch).unwrap();
    assert_eq!(watch.groups, ["tray", "shelf", "global"]);
    assert_eq!(outcome.groups[2].units.join(" "), "table cup chair vase");
    assert_eq!(outcome.objects[1].pose, boxes.objects[1].pose);
}

#[test]
fn children_ride_along_and_settled_poses_are_kept() {
    let boxes = room();
    let backend = Fake { slide: Vec3::X * 0.01, ..Default::default() };
    let outcome = simple(&boxes, &backend, &frozen());
    // One slide for every group in which the object moves; rounding of f32 near 1 m, three times.
    let slides = [1.0, 2.0, 3.0, 1.0, 0.0, 2.0, 0.0];
    for (i, slides) in slides.into_iter().enumerate() {
        let moved = shift(&boxes, &outcome, i);
        assert!(moved.distance(DVec3::X * 0.01 * slides) < 2e-6, "{}: {moved}", boxes.objects[i].name);
        assert!((outcome.objects[i].moved - 0.01 * slides).abs() < 2e-6);
    }

    let mut config = frozen();
    config.settle.from = ResultFrom::Placed;
    config.settle.max_seconds = 0.0;
    let outcome = simple(&boxes, &backend, &config);
    for (i, slides) in [0.0, 1.0, 2.0, 0.0, 0.0, 1.0, 0.0].into_iter().enumerate() {
        assert!(shift(&boxes, &outcome, i).distance(DVec3::X * 0.01 * slides) < 2e-6);
    }
}

#[test]
fn what_is_held_keeps_its_pose_to_the_bit() {
    let boxes = room();
    let outcome = simple(&boxes, &Fake { slide: Vec3::Z * 0.1, ..Default::default() }, &config());
    for (i, (object, outcome)) in boxes.objects.iter().zip(&outcome.objects).enumerate() {
        let held = [4, 6].contains(&i);
        assert_eq!(outcome.simulated, !held);
        assert_eq!(outcome.pose == object.pose, held, "{}", object.name);
        assert!(!held || outcome.stable && !outcome.lost_support && outcome.moved == 0.0);
    }
}

#[test]
fn a_seed_repeats_and_another_differs() {
    let (boxes, backend) = (room(), Fake::default());
    let result = |seed| results(go(&boxes, &backend, &config(), seed, None, &mut Watch::default()).unwrap());
    assert_eq!(result(1), result(1));
    assert_ne!(result(1), result(2));
}

#[test]
fn nothing_movable_is_done_at_once() {
    let mut boxes = room();
    for object in &mut boxes.objects {
        object.movable = false;
    }
    for boxes in [boxes, Boxes::default()] {
        let mut watch = Watch::default();
        let outcome = go(&boxes, &Fake::default(), &config(), 1, None, &mut watch).unwrap();
        assert!(outcome.finished && watch.iterations == 0 && watch.groups.is_empty());
        assert!(outcome.notes[0].contains("nothing in the scene is movable"));
        assert!(outcome.objects.iter().zip(&boxes.objects).all(|(o, b)| o.pose == b.pose && o.stable));
    }
}

#[test]
fn one_object_is_a_scene() {
    let mut boxes = Boxes::default();
    boxes.add("box", GROUND, Vec3::ONE, DVec3::ZERO);
    let outcome = simple(&boxes, &Fake::default(), &config());
    assert_eq!(outcome.groups.len(), 1);
    assert!(outcome.objects[0].stable && !outcome.objects[0].fallen && !outcome.objects[0].lost_support);
}

#[test]
fn a_simulator_that_always_fails_leaves_the_layout_and_says_so() {
    let boxes = room();
    let outcome = simple(&boxes, &Fake { fails: true, ..Default::default() }, &config());
    assert!(outcome.objects.iter().zip(&boxes.objects).all(|(o, b)| o.pose == b.pose));
    assert!(outcome.groups.iter().all(|group| group.best.is_none() && group.flagged == [0, 0, 96]));
    // Four groups, settling, check.
    assert_eq!(outcome.notes.len(), 6, "{:?}", outcome.notes);
    assert!(outcome.objects.iter().all(|object| object.stable != object.simulated));
}

#[test]
fn a_stop_keeps_the_best_so_far() {
    let boxes = room();
    let backend = Fake { slide: Vec3::X * 0.01, ..Default::default() };
    let mut watch = Watch { stop_at: Some(8), ..Default::default() };
    let outcome = go(&boxes, &backend, &frozen(), 1, None, &mut watch).unwrap();
    assert!(!outcome.finished);
    assert_eq!((outcome.groups.len(), outcome.iterations.len(), watch.checkpoints.len()), (2, 8, 1));
    assert!(shift(&boxes, &outcome, 2).distance(DVec3::X * 0.02) < 2e-6, "cup moved in both groups");
    assert!(outcome.objects.iter().all(|object| object.stable), "the check ran");

    let checkpoint = Checkpoint::from_json(&watch.checkpoints[0]).unwrap();
    let resumed = go(&boxes, &backend, &frozen(), 1, Some(checkpoint), &mut Watch::default()).unwrap();
    assert_eq!(results(resumed), results(simple(&boxes, &backend, &frozen())));
}

#[test]
fn a_sunk_table_is_raised_for_its_group_only() {
    let mut boxes = room();
    for object in &mut boxes.objects[..3] {
        object.pose.translation.y -= 0.5;
    }
    let backend = Fake::default();
    let outcome = simple(&boxes, &backend, &frozen());
    let worlds = backend.worlds.lock().unwrap();
    let height = |world: usize, body: usize| worlds[world].start[body].translation.y;
    // Half heights: table 0.35 m, tray 0.01 m; rounding of f32 below 1 m.
    assert!((height(1, 0) - 0.35).abs() < 1e-6 && (height(1, 1) - 0.71).abs() < 1e-6);
    assert!((height(3, 0) - -0.15).abs() < 1e-6 && (height(3, 1) - 0.21).abs() < 1e-6);
    assert!(shift(&boxes, &outcome, 1).length() < 1e-6);
}

#[test]
fn searches_end_early() {
    let mut boxes = Boxes::default();
    boxes.add("box", GROUND, Vec3::ONE, DVec3::ZERO);
    let iterations = |change: &dyn Fn(&mut Config)| {
        let mut config = config();
        config.global.iterations = 20;
        change(&mut config);
        simple(&boxes, &Fake::default(), &config).iterations.len()
    };
    assert_eq!(iterations(&|_| ()), 40);
    assert_eq!(iterations(&|c| c.global.stop_energy = 1e9), 1);
    // Frozen: the first iteration improves on nothing, then three do not; twice.
    let frozen_std = |c: &mut Config| {
        c.global.translation_std = [0.0; 3];
        c.global.rotation_std = [0.0; 3];
        c.global.std_epsilon = 0.0;
        c.global.patience = 3;
    };
    assert_eq!(iterations(&frozen_std), 2 * 4 - 1);
}

#[test]
fn later_episodes_are_widened() {
    let mut boxes = Boxes::default();
    boxes.add("box", GROUND, Vec3::ONE, DVec3::ZERO);
    let spread = |restart_std: f32| {
        let mut config = config();
        config.global.iterations = 10;
        config.global.restart_std = restart_std;
        let records = simple(&boxes, &Fake::default(), &config).iterations;
        records[10].stats.elite_mean
    };
    // After ten iterations the samples lie close to the optimum; widened ones do not.
    assert!(spread(1.0) > 3.0 * spread(0.0), "{} {}", spread(1.0), spread(0.0));
}

#[test]
fn a_search_that_does_not_fit_into_memory_is_refused_before_it_starts() {
    let (boxes, backend, mut watch) = (room(), Fake { free_bytes: Some(1000), ..Default::default() }, Watch::default());
    let refused = go(&boxes, &backend, &config(), 1, None, &mut watch).unwrap_err();
    let OptimizeError::Backend(BackendError::Capacity(message)) = refused else { unreachable!("{refused}") };
    assert!(message.contains("memory") && message.contains("fewer"), "{message}");
    assert!(backend.worlds.lock().unwrap().is_empty());
}

#[test]
fn settings_without_sense_are_refused() {
    let boxes = room();
    let refused = |key: &str, change: &dyn Fn(&mut Config)| {
        let mut config = config();
        change(&mut config);
        let error = go(&boxes, &Fake::default(), &config, 1, None, &mut Watch::default()).unwrap_err();
        assert!(matches!(&error, OptimizeError::Config { key: found, .. } if found == key), "{error}");
    };
    refused("global.candidates", &|c| c.global.candidates = 0);
    refused("local.iterations", &|c| c.local.iterations = 0);
    refused("local.elite_fraction", &|c| c.local.elite_fraction = 1.5);
    refused("local.elite_fraction", &|c| c.local.elite_fraction = f32::NAN);
    refused("simulation.dt", &|c| c.simulation.dt = 0.0);
    refused("simulation.snapshot_step", &|c| c.simulation.steps = 10);
    refused("global.draws", &|c| c.global.draws = 0);
    refused("local.draws", &|c| (c.local.candidates, c.local.draws) = (1 << 20, 1000));
    refused("local.short_steps", &|c| c.local.short_steps = c.simulation.snapshot_step - 1);
    refused("global.finalists", &|c| c.global.finalists = 0.0);
    refused("energy.penetration", &|c| c.energy.penetration = -1.0);
    refused("global.rotation_std", &|c| c.global.rotation_std[1] = f32::INFINITY);
    refused("verify.seconds", &|c| c.verify.seconds = 0.0);
}
