//! Kernel `first_loads`: what contacts carry when a simulation begins, from the CPU's contacts.

use super::Test;
use super::fixture::{Device, SIZES};
use super::states::{State, Tables, Uploaded, beginnings};
use crate::common::scenario::Scenario;
use crate::physics::concave::snug_shelf;
use crate::physics::stacks::{house_of_cards, leaning_book};
use glam::{Quat, Vec3};
use libtest_mimic::Failed;
use rest3d_gpu::gpu::{Contact, Patch, Recorder, Sim, Way};
use rest3d_gpu::world::{SimSettings, World};

pub const TESTS: &[Test] = &[
    ("first_loads::are_their_twins", are_their_twins),
    ("first_loads::go_on_where_they_stopped", go_on_where_they_stopped),
];

/// Every body of a candidate is moved by up to this, m: some contacts open too far to bear anything.
const SPREAD: f32 = 5e-4;

/// A pile of boards on a light box, with a weight beside its middle; a book on a wall; a house of cards; and what is snug
/// in a shelf, of which loads go round.
fn worlds() -> [World; 5] {
    let mut pile = Scenario::default();
    pile.cuboid(Vec3::splat(0.1), 0.5, Vec3::Y * 0.1, Quat::IDENTITY);
    for level in 0..6 {
        let turn = Quat::from_rotation_y(0.2 * level as f32);
        pile.cuboid(Vec3::new(0.2, 0.01, 0.15), 1.0, Vec3::Y * (0.21 + 0.02 * level as f32), turn);
    }
    pile.cuboid(Vec3::splat(0.05), 8.0, Vec3::new(0.03, 0.37, 0.02), Quat::IDENTITY);
    let [alone, on_tray] = [false, true].map(|on_tray| snug_shelf(5e-4, [20.0, 0.5], on_tray).world());
    [pile.world(), leaning_book(60.0).world(), house_of_cards(1).world(), alone, on_tray]
}

/// What the kernel makes of contacts that carry nothing yet; compared with what is expected, if anything.
fn found(
    device: &Device,
    (world, parameters): (&World, &Sim),
    before: &Tables,
    after: Option<&Tables>,
) -> Result<(Vec<Patch>, Vec<Contact>), Failed> {
    let uploaded = Uploaded::new(device, (world, parameters, 0, Way::Candidates), before)?;
    let mut recorder = Recorder::new(&device.gpu);
    recorder.run(uploaded.solver.load_steps());
    recorder.submit();
    if let Some(after) = after {
        uploaded.expect_contacts(device, &format!("of {}", before.counts.len()), after)?;
    }
    Ok((device.fetch(&uploaded.patches)?, device.fetch(&uploaded.contacts)?))
}

/// Tables of so many candidates before and after.
fn tables(world: &World, settings: &SimSettings, candidates: u32) -> [Tables; 2] {
    let (bare, loaded): (Vec<State>, Vec<State>) =
        beginnings(world, settings, SPREAD, candidates.min(9)).into_iter().map(|[bare, loaded]| (bare, loaded)).unzip();
    [&bare, &loaded].map(|states| Tables::new(world, states, candidates))
}

fn are_their_twins(device: &Device) -> Result<(), Failed> {
    for world in worlds() {
        for rest_offset in [0.0, 2e-4] {
            let settings = SimSettings { rest_offset, ..Default::default() };
            let sim = Sim::new(&settings, world.capacities);
            for candidates in SIZES {
                let [before, after] = tables(&world, &settings, candidates);
                found(device, (&world, &sim), &before, Some(&after))?;
            }
        }
    }
    Ok(())
}

/// However few rounds its loops may take at a time, down to a single sweep.
fn go_on_where_they_stopped(device: &Device) -> Result<(), Failed> {
    let settings = SimSettings::default();
    for world in worlds() {
        let [before, _] = tables(&world, &settings, 65);
        let sim = Sim::new(&settings, world.capacities);
        let whole = found(device, (&world, &sim), &before, None)?;
        for loops in [0, 3000, 20_000] {
            if found(device, (&world, &Sim { loops, ..sim }), &before, None)? != whole {
                return Err(format!("with {loops} rounds of its loops").into());
            }
        }
    }
    Ok(())
}
