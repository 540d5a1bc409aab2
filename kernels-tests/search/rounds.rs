//! Rounds, in which ever fewer candidates are looked at for longer.

use crate::fixture::*;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::cpu::energy::{Trial, energy};
use rest3d_gpu::cpu::search::{CpuSearch, GoesOn, Record, Rollout};
use rest3d_gpu::world::{Backend, CemSettings, Energy, IterationStats, Pose, Search, SearchSettings, Status, Velocity};

/// As `settings`, in three rounds.
fn narrowing(candidates: u32, draws: u32, elite_fraction: f32, finalists: f32) -> SearchSettings {
    let cem = CemSettings { candidates, draws, short_steps: 16, finalists, elite_fraction, ..settings(candidates).cem };
    SearchSettings { cem, ..Default::default() }
}

#[test]
fn rounds_narrow_down_to_no_fewer_than_the_elites() {
    let rounds = |settings: SearchSettings, steps| -> Vec<[u32; 2]> {
        settings.cem.rounds(steps).iter().map(|round| [round.candidates, round.steps]).collect()
    };
    assert_eq!(rounds(settings(50), 60), [[50, 60]], "the paper's");
    assert_eq!(rounds(narrowing(50, 4, 0.1, 0.25), 60), [[200, 0], [50, 16], [13, 60]]);
    assert_eq!(rounds(narrowing(50, 4, 0.5, 0.25), 60), [[200, 0], [50, 16], [25, 60]], "elites");
    assert_eq!(rounds(narrowing(50, 1, 0.1, 0.25), 60), [[50, 16], [13, 60]]);
    assert_eq!(rounds(narrowing(50, 4, 0.1, 0.25), 16), [[200, 0], [50, 16]], "no longer than short");
}

#[test]
fn few_that_were_chosen_are_as_good_as_all() {
    // What a candidate costs is known as it is placed, so the best of all reach the last round.
    let world = world();
    let (few, all) = (narrowing(25, 4, 0.24, 0.3), narrowing(100, 1, 0.06, 1.0));
    let mut few = CpuSearch::new(&world, &few, STREAM, NEVER);
    let mut all = CpuSearch::new(&world, &all, STREAM, NEVER);
    for iteration in 0..5 {
        let found = few.iterate().unwrap();
        assert_eq!(found, IterationStats { steps: found.steps, ..all.iterate().unwrap() }, "{iteration}");
        assert_eq!(few.distribution(), all.distribution(), "{iteration}");
    }
    assert_eq!(few.best().unwrap(), all.best().unwrap());
    let (few, all) = (few.energies().unwrap(), all.energies().unwrap());
    assert_eq!(few.len(), 100);
    let finalists: Vec<usize> = (0..100).filter(|&candidate| few[candidate].total.is_finite()).collect();
    assert_eq!(finalists.len(), 8);
    let worst = finalists.iter().map(|&candidate| few[candidate].total).fold(0.0, f32::max);
    for candidate in 0..100 {
        let chosen = finalists.contains(&candidate);
        assert!(if chosen { few[candidate] == all[candidate] } else { all[candidate].total >= worst }, "{candidate}");
    }
}

/// Things stay, but what was placed to the right of the start is found out to be bad after some steps.
struct FoundOut;

impl Rollout for FoundOut {
    type Scratch = u32;

    fn scratch(&self) -> u32 {
        0
    }

    fn run(&self, scratch: &mut u32, placed: &[Pose], steps: u32, records: &mut [Record], _: &GoesOn<'_>) {
        NEVER.run(scratch, placed, steps, records, &|_, _| true);
        if steps > 0 && placed[1].translation.x > 1.0 {
            records[0].depths_settled.fill(1.0);
        }
    }
}

#[test]
fn what_is_found_out_does_not_go_on() {
    let (world, settings) = (world(), narrowing(40, 4, 0.1, 0.25));
    let mut search = CpuSearch::new(&world, &settings, STREAM, FoundOut);
    search.iterate().unwrap();
    let energies = search.energies().unwrap();
    let finalists = |&candidate: &u32| energies[candidate as usize].total.is_finite();
    let finalists: Vec<u32> = (0..160).filter(finalists).collect();
    assert_eq!(finalists.len(), 10);
    for candidate in finalists {
        assert!(search.placed(candidate).unwrap()[1].translation.x <= 1.0, "{candidate} had been found out");
    }
    // It was a near thing: the wanted place is on the right, so more than half of those chosen as placed were there.
    let right = |candidate: &u32| search.placed(*candidate).unwrap()[1].translation.x > 1.0;
    let chosen = (0..160).filter(|&candidate| energies[candidate as usize].penetration > 0.0);
    assert!(chosen.clone().all(|candidate| right(&candidate)) && (20..40).contains(&chosen.count()));
}

#[test]
fn what_is_passed_over_is_known_as_it_was_placed() {
    let (world, settings) =
        (world(), SearchSettings { cem: CemSettings { draws: 6, ..settings(5).cem }, ..Default::default() });
    let mut search = CpuBackend.search(&world, &settings, STREAM).unwrap();
    for iteration in 0..2 {
        search.iterate().unwrap();
        let energies = search.energies().unwrap();
        let out: Vec<u32> = (0..30).filter(|&candidate| energies[candidate as usize].total.is_infinite()).collect();
        assert_eq!(out.len(), 25, "{iteration}");
        for candidate in out {
            let placed = search.placed(candidate).unwrap();
            let depths = CpuBackend.overlaps(&world, &settings.simulation, &placed).unwrap();
            let snapshot = vec![Velocity::default(); placed.len()];
            let trial = Trial {
                placed: &placed,
                settled: &placed,
                snapshot: &snapshot,
                depths_placed: &depths,
                depths_settled: &depths,
                status: Status::default(),
            };
            let expected = Energy { total: f32::INFINITY, ..energy(&world, &settings.energy, &trial) };
            assert_eq!(energies[candidate as usize], expected, "{iteration}: {candidate}");
        }
    }
}
