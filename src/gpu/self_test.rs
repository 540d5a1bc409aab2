//! Whether a driver can be trusted: a small batch of known physics, on the device and on the processor.
//!
//! A driver that miscompiles a kernel gives wrong layouts without a word. Everything that a run uses is tried: the
//! simulation of boxes that stand, fall and lean, and one iteration of a search in three rounds.

use crate::world::constants::{SELF_TEST_DISTANCE, SELF_TEST_ENERGY, SELF_TEST_NUDGE};
use crate::world::{
    Backend, BackendError, BodyDef, CemSettings, Flow, Pose, SearchSettings, SimSettings, Stream, World, angle_between,
};
use glam::{Quat, Vec3};

/// Candidates: more than a workgroup of any kernel, and no multiple of one.
const CANDIDATES: u32 = 70;

/// Half a second: long enough for a fall and what follows.
const STEPS: u32 = 30;

/// Runs the test on `backend` and compares with `reference`.
///
/// # Errors
/// What differs, or why it could not be run.
pub fn self_test(backend: &dyn Backend, reference: &dyn Backend) -> Result<(), String> {
    let world = world();
    let settings = SimSettings { steps: STEPS, ..SimSettings::default() };
    let starts: Vec<Pose> = (0..CANDIDATES)
        .flat_map(|candidate| world.start.iter().map(move |pose| pose.raised(1e-5 * candidate as f32)))
        .collect();
    let ran = |error: BackendError| error.to_string();
    let run = |backend: &dyn Backend, starts: &[Pose]| -> Result<Vec<Pose>, String> {
        let mut ends = Vec::new();
        let statuses = backend.simulate(&world, &settings, starts, &mut |_, poses, _| {
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

/// A stack of two boxes, one that leans against it, and one that falls.
fn world() -> World {
    let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5;
    let boxes = [
        (Vec3::new(0.3, 0.1, 0.3), Vec3::new(0.0, 0.05, 0.0), Quat::IDENTITY),
        (Vec3::new(0.2, 0.2, 0.2), Vec3::new(0.01, 0.2, 0.02), Quat::from_rotation_y(0.3)),
        (Vec3::new(0.05, 0.4, 0.1), Vec3::new(0.24, 0.205, 0.0), Quat::from_rotation_z(0.1)),
        (Vec3::new(0.1, 0.2, 0.1), Vec3::new(-0.5, 0.3, 0.1), Quat::from_rotation_x(0.7)),
    ];
    let defs: Vec<BodyDef> = (boxes.into_iter().zip(0..))
        .map(|((size, at, turn), unit)| {
            let start = Pose::new(turn, at);
            let parts = vec![(0..8).map(|i| size * corner(i)).collect()];
            let inertia = (Vec3::splat(size.length_squared()) - size * size) / 12.0;
            BodyDef { parts, mass: 1.0, inertia, unit, start, reference: start }
        })
        .collect();
    World::new(&defs, &[0, 1, 2, 3])
}

/// How far two poses are apart, m + rad.
fn apart(a: &Pose, b: &Pose) -> f32 {
    a.translation.distance(b.translation) + angle_between(a.rotation, b.rotation)
}

/// How far each of so many bodies may be off because rounding errors grow where it tumbles: as far as a nudge takes it in the
/// candidate where that is farthest, and once more, because both differ from what is right.
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
