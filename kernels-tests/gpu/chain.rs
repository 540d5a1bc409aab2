//! All kernels of an iteration in one submission, against the CPU's search with the same stand-in for the simulation.

use super::Test;
use super::fixture::{Device, compare, world};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::{CpuSearch, GoesOn, Record, Rollout};
use rest3d_gpu::gpu::{Download, Population, Recorder};
use rest3d_gpu::world::{CemSettings, Pose, Search, SearchSettings, Stream, Winner, World};

pub const TESTS: &[Test] = &[
    ("chain::searches_as_the_cpu_does", searches_as_the_cpu_does),
    ("chain::gives_the_same_bits_again", gives_the_same_bits_again),
];

const ITERATIONS: u32 = 8;
const STREAM: Stream = Stream { seed: 42, stage: 1 };

/// Nothing moves: the layout term alone is searched.
struct Frozen;

impl Rollout for Frozen {
    type Scratch = ();

    fn scratch(&self) {}

    fn run(&self, (): &mut (), placed: &[Pose], _: u32, records: &mut [Record], _: &GoesOn<'_>) {
        records[0].settled.copy_from_slice(placed);
    }
}

fn settings(candidates: u32) -> SearchSettings {
    let cem = CemSettings {
        candidates,
        elite_fraction: 0.15,
        translation_std: [1.0; 3],
        rotation_std: [0.5; 3],
        sample_mean: true,
        ..Default::default()
    };
    SearchSettings { cem, ..Default::default() }
}

/// Mean, deviation and winner after every iteration, and the winner's adjustment at last.
type Course = (Vec<(Vec<f32>, Vec<f32>, Winner)>, Vec<f32>);

fn searched(device: &Device, world: &World, settings: &SearchSettings) -> Result<Course, Failed> {
    let gpu = &device.gpu;
    let population = Population::new(gpu, device.kernels()?, world, settings, STREAM)?;
    let width = world.dimensions();
    let (mean, std) = (Download::new(gpu, "mean", width), Download::new(gpu, "std", width));
    let winner = Download::new(gpu, "winner", 1);
    let mut course = Vec::new();
    for iteration in 0..ITERATIONS {
        population.set_iteration(gpu, iteration);
        let mut recorder = Recorder::new(gpu);
        population.draw(&mut recorder);
        // Nothing moves.
        recorder.copy(&population.placed, &population.poses);
        population.rank(&mut recorder);
        recorder.fetch(&population.mean, &mean);
        recorder.fetch(&population.std, &std);
        recorder.fetch(&population.winner, &winner);
        recorder.submit();
        course.push((mean.take(gpu)?, std.take(gpu)?, winner.take(gpu)?[0]));
    }
    let rows = device.fetch(&population.deltas)?;
    Ok((course, rows[settings.cem.candidates as usize * width..].to_vec()))
}

fn searches_as_the_cpu_does(device: &Device) -> Result<(), Failed> {
    // The rounding of the samples, carried through eight updates.
    const TOLERANCE: f32 = 1e-4;
    let world = world();
    for candidates in [7, 65, 1234] {
        let settings = settings(candidates);
        let (course, delta) = searched(device, &world, &settings)?;
        let mut twin = CpuSearch::new(&world, &settings, STREAM, Frozen);
        for (iteration, (mean, std, winner)) in course.iter().enumerate() {
            let energy = twin.iterate()?.best;
            let expected = twin.distribution();
            compare(mean, &expected.mean, TOLERANCE).map_err(|e| format!("{candidates}, {iteration}, mean: {e}"))?;
            compare(std, &expected.std, TOLERANCE).map_err(|e| format!("{candidates}, {iteration}, deviation: {e}"))?;
            compare(&[winner.energy], &[energy], TOLERANCE).map_err(|e| format!("{candidates}, {iteration}: {e}"))?;
        }
        let best = twin.best()?.ok_or("no winner")?;
        let (_, _, winner) = course.last().ok_or("no iteration")?;
        if (winner.iteration, winner.candidate) != (best.iteration, best.candidate) {
            return Err(format!("{candidates}: {winner:?} instead of {best:?}").into());
        }
        compare(&delta, &best.delta, TOLERANCE)?;
    }
    Ok(())
}

fn gives_the_same_bits_again(device: &Device) -> Result<(), Failed> {
    let world = world();
    let [first, second] = [(); 2].map(|()| searched(device, &world, &settings(65)));
    let (first, second) = (first?, second?);
    let bits = |course: &Course| -> Vec<u32> {
        let rows = course.0.iter().flat_map(|(mean, std, winner)| mean.iter().chain(std).chain([&winner.energy.total]));
        rows.chain(&course.1).map(|x| x.to_bits()).collect()
    };
    if bits(&first) == bits(&second) { Ok(()) } else { Err("two runs differ".into()) }
}
