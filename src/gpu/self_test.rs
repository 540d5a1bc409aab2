//! Whether a driver can be trusted: a small batch of known physics, on the device and on the processor.
//!
//! A driver that miscompiles a kernel gives wrong layouts without a word. Everything that a run uses is tried: the
//! simulation of boxes that stand, fall, lean, slide and are pressed down by heavier ones, few, in a block and many,
//! because different kernels solve these, and one iteration of a search in three rounds.

use crate::shape::box_corners;
use crate::world::constants::{SELF_TEST_DISTANCE, SELF_TEST_ENERGY, SELF_TEST_NUDGE};
use crate::world::{
    Backend, BackendError, BodyDef, CemSettings, Flow, Pose, STATIC, SearchSettings, SimSettings, Stream, World,
    angle_between,
};
use glam::{Quat, Vec3};

/// Candidates: more than a workgroup of any kernel, and no multiple of one.
const CANDIDATES: u32 = 70;

/// Half a second: long enough for a fall and what follows. Where there is more to simulate, half of that must do.
const STEPS: u32 = 30;

/// Runs the test on `backend` and compares with `reference`.
///
/// # Errors
/// What differs, or why it could not be run.
pub fn self_test(backend: &dyn Backend, reference: &dyn Backend) -> Result<(), String> {
    let settings = SimSettings { steps: STEPS, ..SimSettings::default() };
    for (what, world, steps) in [("few", few(), STEPS), ("a block", block(), STEPS / 2), ("many", many(), STEPS / 2)] {
        let settings = SimSettings { steps, ..settings.clone() };
        simulates_alike(backend, reference, &world, &settings).map_err(|problem| format!("{what}: {problem}"))?;
    }

    let world = gentle();
    let cem = CemSettings { candidates: CANDIDATES, draws: 2, short_steps: STEPS / 2, ..CemSettings::default() };
    let settings = SearchSettings { simulation: settings, cem, ..SearchSettings::default() };
    let stream = Stream { seed: 1, stage: 0 };
    let [mut search, mut expected] = [backend, reference].map(|backend| backend.search(&world, &settings, stream));
    let (search, expected) =
        (search.as_mut().map_err(|e| e.to_string())?, expected.as_mut().map_err(|e| e.to_string())?);
    let (stats, known) = (search.iterate().map_err(ran)?, expected.iterate().map_err(ran)?);
    for candidate in 0..settings.cem.drawn() {
        let (found, known) = (search.placed(candidate).map_err(ran)?, expected.placed(candidate).map_err(ran)?);
        compare("placement", &found, &known, &[0.0])?;
    }
    // Contacts make the difference between samples large, so single energies differ.
    for (what, found, known) in [
        ("best energy", stats.best.total, known.best.total),
        ("mean energy of the elites", stats.elite_mean, known.elite_mean),
    ] {
        let off = (found / known - 1.0).abs();
        if off.is_nan() || off > SELF_TEST_ENERGY {
            return Err(format!("{what}: {found} instead of {known}"));
        }
    }
    Ok(())
}

/// The same simulation on both backends, and once more on the one that is tested.
fn simulates_alike(
    backend: &dyn Backend,
    reference: &dyn Backend,
    world: &World,
    settings: &SimSettings,
) -> Result<(), String> {
    let starts: Vec<Pose> = (0..CANDIDATES)
        .flat_map(|candidate| world.start.iter().map(move |pose| pose.raised(1e-5 * candidate as f32)))
        .collect();
    let run = |backend: &dyn Backend, starts: &[Pose]| -> Result<Vec<Pose>, String> {
        let mut ends = Vec::new();
        let statuses = backend.simulate(world, settings, starts, &mut |_, poses, _| {
            ends.clear();
            ends.extend_from_slice(poses);
            Flow::Continue
        });
        match statuses.map_err(ran)?.iter().all(|status| status.is_usable()) {
            true => Ok(ends),
            false => Err("a simulation failed".into()),
        }
    };
    let (found, known) = (run(backend, &starts)?, run(reference, &starts)?);
    let nudged: Vec<Pose> = starts.iter().map(|pose| pose.raised(SELF_TEST_NUDGE)).collect();
    let slack = slack(&known, &run(reference, &nudged)?, world.bodies.len());
    compare("pose", &found, &known, &slack)?;
    if run(backend, &starts)? != found {
        return Err("the same simulation twice gives two results".into());
    }
    Ok(())
}

fn ran(error: BackendError) -> String {
    error.to_string()
}

/// A box of this size and mass.
fn cuboid(size: Vec3, mass: f32, start: Pose, unit: u32) -> BodyDef {
    let parts = vec![box_corners(0.5 * size)];
    let inertia = mass * (Vec3::splat(size.length_squared()) - size * size) / 12.0;
    BodyDef { parts, mass, inertia, unit, start, reference: start }
}

/// A stack of two boxes, one that leans against it, and one that falls.
fn falling() -> Vec<BodyDef> {
    let boxes = [
        (Vec3::new(0.3, 0.1, 0.3), Vec3::new(0.0, 0.05, 0.0), Quat::IDENTITY),
        (Vec3::new(0.2, 0.2, 0.2), Vec3::new(0.01, 0.2, 0.02), Quat::from_rotation_y(0.3)),
        (Vec3::new(0.05, 0.4, 0.1), Vec3::new(0.24, 0.205, 0.0), Quat::from_rotation_z(0.1)),
        (Vec3::new(0.1, 0.2, 0.1), Vec3::new(-0.5, 0.3, 0.1), Quat::from_rotation_x(0.7)),
    ];
    (boxes.into_iter().zip(0..)).map(|((size, at, turn), unit)| cuboid(size, 1.0, Pose::new(turn, at), unit)).collect()
}

/// A box that slides down a fixed slope of 60°, and one that is dropped onto one thirty times as light.
fn pressed(first: u32) -> Vec<BodyDef> {
    let slope = Quat::from_rotation_z(60f32.to_radians());
    let on_slope = |height: f32| Pose::new(slope, Vec3::new(4.0, 1.5, 0.0) + slope * (height * Vec3::Y));
    let level = |y: f32| Pose::new(Quat::IDENTITY, Vec3::new(-3.0, y, 0.0));
    vec![
        cuboid(Vec3::new(2.0, 0.2, 1.0), 1.0, on_slope(0.0), STATIC),
        cuboid(Vec3::new(0.3, 0.1, 0.2), 2.0, on_slope(0.15), first),
        cuboid(Vec3::new(0.3, 0.1, 0.3), 1.0, level(0.05), first + 1),
        cuboid(Vec3::new(0.2, 0.2, 0.2), 30.0, level(0.22), first + 2),
    ]
}

fn world(defs: &[BodyDef]) -> World {
    let roots: Vec<u32> = (0u32..).zip(defs).filter(|(_, def)| def.unit != STATIC).map(|(i, _)| i).collect();
    World::new(defs, &roots)
}

/// What the search is tried with: nothing in it is decided by a hair.
fn gentle() -> World {
    world(&falling())
}

fn few() -> World {
    world(&[falling(), pressed(4)].concat())
}

/// More patches than there are invocations for a candidate.
fn block() -> World {
    let at = |i: u32| Vec3::new((i % 2) as f32, (i / 2 % 3) as f32 + 0.5, (i / 6) as f32);
    let boxes = (0..12).map(|i| cuboid(Vec3::splat(0.2), 1.0, Pose::new(Quat::IDENTITY, 0.2 * at(i)), i));
    world(&[boxes.collect(), pressed(12)].concat())
}

/// More bodies than a workgroup has room for.
fn many() -> World {
    let at = |i: u32| 0.3 * Vec3::new((i % 6) as f32, 0.4, (i / 6) as f32);
    let turn = |i: u32| Quat::from_rotation_z(0.02 * i as f32);
    let boxes = (0..36).map(|i| cuboid(Vec3::new(0.2, 0.1, 0.15), 1.0, Pose::new(turn(i), at(i)), i));
    world(&[boxes.collect(), pressed(36)].concat())
}

/// How far two poses are apart, m + rad.
fn apart(a: &Pose, b: &Pose) -> f32 {
    a.translation.distance(b.translation) + angle_between(a.rotation, b.rotation)
}

/// How far each of so many bodies may be off because rounding errors grow where it tumbles: as far as a nudge takes it
/// in the candidate where that is farthest, and once more, because both differ from what is right.
fn slack(known: &[Pose], nudged: &[Pose], bodies: usize) -> Vec<f32> {
    let farthest = |body: usize| {
        let rows = known.iter().zip(nudged).skip(body).step_by(bodies);
        2.0 * rows.map(|(a, b)| apart(a, b)).fold(0.0, f32::max)
    };
    (0..bodies).map(farthest).collect()
}

/// Fails with the first pose that is too far off; `slack` repeats.
fn compare(what: &str, found: &[Pose], known: &[Pose], slack: &[f32]) -> Result<(), String> {
    if found.len() != known.len() {
        return Err(format!("{} poses instead of {}", found.len(), known.len()));
    }
    for (i, ((a, b), slack)) in found.iter().zip(known).zip(slack.iter().cycle()).enumerate() {
        let off = apart(a, b);
        if off.is_nan() || off > SELF_TEST_DISTANCE + slack {
            return Err(format!("{what} {i}: {a:?} instead of {b:?}"));
        }
    }
    Ok(())
}
