//! Which kernel parts from its twin: the simulation runs on both, substep by substep and kernel by kernel, and every
//! table is compared bit by bit.
//!
//! Two ways. `Way::Lockstep`: after each kernel its table is replaced by the twin's, so that every kernel is judged on
//! the processor's own inputs: the processor up to stage N, the device after, for every N. `Way::Free`: nothing is
//! replaced, and each candidate counts at the first kernel that parts. `REST3D_GPU_BISECT=SCENE` prints both for a
//! scene.

use super::Test;
use super::fixture::{Device, boxes_world};
use super::stages::{BOXES, Both, SOLVER, STAGES, Tally, Way};
use crate::common::scenes::as_it_stands;
use libtest_mimic::Failed;
use rest3d_gpu::bench::starts;
use rest3d_gpu::cpu::narrow_phase::Separator;
use rest3d_gpu::world::{NarrowPhase, Pose, SimSettings, World};
use std::env;
use std::fmt::{self, Display, Formatter};

pub const TESTS: &[Test] = &[
    ("bisect::boxes_do_not_part", boxes_do_not_part),
    ("bisect::a_wrong_kernel_is_named", a_wrong_kernel_is_named),
    ("bisect::a_room_does_not_part", a_room_does_not_part),
];

struct Bisection([Tally; STAGES.len()]);

impl Display for Bisection {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for ((name, _), Tally { parted, compared, worst }) in STAGES.iter().zip(&self.0) {
            writeln!(f, "{name:50} {parted:6} of {compared:6}, at most {worst:.1e}")?;
        }
        Ok(())
    }
}

fn bisect(
    device: &Device,
    world: &World,
    (settings, twin_settings): (&SimSettings, &SimSettings),
    starts: &[Pose],
    way: Way,
) -> Result<Bisection, Failed> {
    let mut both = Both::new(device, world, settings, starts, way)?;
    let narrow = Separator::new(NarrowPhase::Twin, &world.hulls);
    for substep in 0..settings.steps * settings.substeps {
        both.substep(twin_settings, &narrow, substep)?;
    }
    Ok(Bisection(both.tallies))
}

fn boxes_do_not_part(device: &Device) -> Result<(), Failed> {
    let (world, settings) = (boxes_world(), SimSettings::default());
    let found = bisect(device, &world, (&settings, &settings), &starts(&world, 65, 3), Way::Lockstep)?;
    same(device, &found)
}

/// Every kernel gives its twin's bits; a card, which rounds as it likes, only has to get through.
fn same(device: &Device, found: &Bisection) -> Result<(), Failed> {
    let exact = device.rounding(1.0) == 0.0;
    let wrong = exact && found.0.iter().any(|tally| tally.parted > 0);
    if wrong || found.0[SOLVER].compared == 0 { Err(found.to_string().into()) } else { Ok(()) }
}

fn a_wrong_kernel_is_named(device: &Device) -> Result<(), Failed> {
    let (world, settings) = (boxes_world(), SimSettings { steps: 10, ..Default::default() });
    for (wrong, first) in [
        (SimSettings { contact_offset: 0.02, ..settings.clone() }, BOXES),
        (SimSettings { friction: 0.9, ..settings.clone() }, SOLVER),
    ] {
        let Bisection(tallies) = bisect(device, &world, (&wrong, &settings), &starts(&world, 9, 3), Way::Lockstep)?;
        let named = tallies.iter().position(|tally| tally.worst > 1e-3);
        if named != Some(first) {
            return Err(format!("{named:?} instead of {first}:\n{}", Bisection(tallies)).into());
        }
    }
    Ok(())
}

fn a_room_does_not_part(device: &Device) -> Result<(), Failed> {
    let scene = env::var("REST3D_GPU_BISECT").unwrap_or_else(|_| "scenes/study/scene.json".into());
    let (_, world) = as_it_stands(&scene);
    let settings = SimSettings { steps: 20, ..Default::default() };
    // On cards all candidates part at once.
    let ways: &[Way] = if device.rounding(1.0) == 0.0 { &[Way::Lockstep, Way::Free] } else { &[Way::Lockstep] };
    for way in ways {
        let found = bisect(device, &world, (&settings, &settings), &starts(&world, 24, 0), *way)?;
        eprintln!("{found}");
        same(device, &found)?;
    }
    Ok(())
}
