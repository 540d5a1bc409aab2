//! What happens before the first iteration, and when a device is lost: compiling, memory, the self-test.

use super::Test;
use super::fixture::{Device, boxes_world};
use libtest_mimic::Failed;
use rest3d_gpu::cpu::CpuBackend;
use rest3d_gpu::gpu::{
    AdapterChoice, Funnel, Gpu, GpuBackend, GpuError, GpuSearch, Kernels, Options, Population, Recorder, SHADERS,
    Simulation, Way, plan, self_test,
};
use rest3d_gpu::world::{
    Backend, BackendError, CemSettings, Flow, OnStep, Pose, Search, SearchSettings, SimSettings, Status, Stream, World,
};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};
use std::{env, fs};

pub const TESTS: &[Test] = &[
    ("startup::kernels_compile_in_time", kernels_compile_in_time),
    ("startup::compiled_kernels_are_kept_and_damaged_ones_ignored", compiled_kernels_are_kept),
    ("startup::memory_is_as_planned", memory_is_as_planned),
    ("startup::a_split_population_gives_the_same_bits", a_split_population_gives_the_same_bits),
    ("startup::more_than_is_ranked_is_refused", more_than_is_ranked_is_refused),
    ("startup::a_slow_substep_is_split", a_slow_substep_is_split),
    ("startup::a_lost_device_is_an_error", a_lost_device_is_an_error),
    ("startup::a_device_lost_at_the_winner_is_an_error", a_device_lost_at_the_winner_is_an_error),
    ("startup::the_self_test_passes", the_self_test_passes),
    ("startup::the_self_test_sees_what_is_wrong", the_self_test_sees_what_is_wrong),
];

/// Processor seconds from nothing to the first dispatch of every kernel, and of a single kernel, on a machine that
/// reads all shaders `READINGS` times in `READINGS_SECONDS`; a slower or busier one, by that measure, may take longer.
const ALL_SECONDS: f64 = 15.0;
const KERNEL_SECONDS: f64 = 3.0;
const READINGS: usize = 40;
const READINGS_SECONDS: f64 = 1.0;

const CHILD: &str = "REST3D_GPU_STARTUP_CHILD";
const STREAM: Stream = Stream { seed: 3, stage: 0 };

/// True in the process that `kernels_compile_in_time` starts.
pub fn is_child() -> bool {
    env::var_os(CHILD).is_some()
}

/// Prints the processor seconds of the readings, of the start and of every kernel's first dispatch.
#[allow(clippy::print_stdout)]
pub fn child() -> ExitCode {
    let choice: AdapterChoice = env::var(CHILD).unwrap().parse().unwrap();
    let clock = Clock::start();
    for shader in SHADERS.iter().cycle().take(READINGS * SHADERS.len()) {
        naga::front::wgsl::parse_str(shader.source).unwrap();
    }
    println!("readings {}", clock.seconds());
    let clock = Clock::start();
    let gpu = Gpu::open(&choice).unwrap();
    let kernels = Kernels::compile(&gpu).unwrap();
    println!("start {}", clock.seconds());
    let world = boxes_world();
    let cem = CemSettings { candidates: 8, draws: 2, ..Default::default() };
    let settings = SearchSettings { cem, ..Default::default() };
    let population = Population::new(&gpu, &kernels, &world, &settings, STREAM).unwrap();
    let simulation = Simulation::fitting(&gpu, &kernels, &world, &settings.simulation, 8, gpu.room()).unwrap();
    let mut recorder = Recorder::new(&gpu);
    simulation.rest(&mut recorder);
    recorder.submit();
    gpu.wait().unwrap();
    let funnel = Funnel::new(&gpu, &kernels, &world, &settings, &population, gpu.room()).unwrap();
    let simulating = simulation.kernels(0).chain(simulation.load_kernels()).chain(simulation.measuring_kernels());
    for step in population.kernels().chain(funnel.kernels()).chain(simulating) {
        let clock = Clock::start();
        let mut recorder = Recorder::new(&gpu);
        recorder.run([step]);
        recorder.submit();
        gpu.wait().unwrap();
        println!("{} {}", step.name, clock.seconds());
    }
    ExitCode::SUCCESS
}

/// Time of the processor where the system tells it, because cores may be shared; else of the wall.
struct Clock(Option<f64>, Instant);

impl Clock {
    fn start() -> Self {
        Self(Self::processor(), Instant::now())
    }

    fn seconds(&self) -> f64 {
        match (self.0, Self::processor()) {
            (Some(from), Some(now)) => now - from,
            _ => self.1.elapsed().as_secs_f64(),
        }
    }

    /// User and system time of this process; Linux counts hundredths of a second.
    fn processor() -> Option<f64> {
        let stat = fs::read_to_string("/proc/self/stat").ok()?;
        let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        let ticks: Option<f64> = [11, 12].iter().map(|&i| fields.get(i)?.parse::<f64>().ok()).sum();
        ticks.map(|ticks| ticks / 100.0)
    }
}

/// Other processes may disturb a measurement, not three in a row.
fn kernels_compile_in_time(device: &Device) -> Result<(), Failed> {
    compile_in_time(device).or_else(|_| compile_in_time(device)).or_else(|_| compile_in_time(device))
}

fn compile_in_time(device: &Device) -> Result<(), Failed> {
    let output = Command::new(env::current_exe()?)
        .env(CHILD, device.gpu.report().index.to_string())
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .output()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut seconds: Vec<(&str, f64)> = Vec::new();
    for line in text.lines() {
        let (name, time) = line.split_once(' ').ok_or_else(|| line.to_owned())?;
        let time = time.parse()?;
        // A kernel's second dispatch compiles nothing.
        if seconds.iter().all(|(known, _)| *known != name) {
            seconds.push((name, time));
        }
    }
    let readings =
        if seconds.is_empty() { return Err(format!("nothing ran: {output:?}").into()) } else { seconds.remove(0).1 };
    let slower = (readings / READINGS_SECONDS).max(1.0);
    let all: f64 = seconds.iter().map(|(_, time)| time).sum();
    let needless: &[&str] = if Way::best(&device.gpu) == Way::Waves { &[] } else { &["solve_waves"] };
    let missing: Vec<&str> = SHADERS
        .iter()
        .map(|shader| shader.name)
        .filter(|name| !needless.contains(name) && seconds.iter().all(|(known, _)| known != name))
        .collect();
    seconds.sort_by(|a, b| b.1.total_cmp(&a.1));
    let slow: Vec<_> = seconds.iter().filter(|(_, time)| *time > KERNEL_SECONDS * slower).collect();
    eprintln!("ready after {all:.1} s; readings {readings} s; {:?}", &seconds[..seconds.len().min(6)]);
    if !missing.is_empty() || all > ALL_SECONDS * slower || !slow.is_empty() {
        let text = format!("{all} s, {slower} times slower; too slow: {slow:?}; not compiled: {missing:?}");
        return Err(format!("{text}; {}", output.status).into());
    }
    Ok(())
}

fn options(device: &Device) -> Options {
    Options { adapter: AdapterChoice::Index(device.gpu.report().index), ..Options::default() }
}

fn compiled_kernels_are_kept(device: &Device) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let options = Options { cache: Some(folder.path().join("cache")), ..options(device) };
    let files = || -> Vec<_> {
        let entries = fs::read_dir(folder.path().join("cache")).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect()
    };
    GpuBackend::open_with(&options)?;
    if !device.gpu.keeps_pipelines() {
        return if files().is_empty() { Ok(()) } else { Err("kept what cannot be kept".into()) };
    }
    let [file] = &files()[..] else { return Err(format!("{:?}", files()).into()) };
    let first = fs::read(file)?;
    for damaged in [&first[..first.len() - 1], &[], &[7; 4096]] {
        fs::write(file, damaged)?;
        let backend = GpuBackend::open_with(&options)?;
        if files().len() != 1 || fs::read(file)?.len() < first.len() {
            return Err("a damaged file stays".into());
        }
        self_test(&backend, &CpuBackend)?;
    }
    // A directory that is a file costs time only.
    GpuBackend::open_with(&Options { cache: Some(file.clone()), ..options })?;
    Ok(())
}

fn settings(candidates: u32) -> SearchSettings {
    let cem = CemSettings { candidates, ..Default::default() };
    let simulation = SimSettings { steps: 6, snapshot_step: 3, ..Default::default() };
    SearchSettings { cem, simulation, ..Default::default() }
}

/// The same in three rounds, or two with a single draw.
fn narrowing(candidates: u32, draws: u32) -> SearchSettings {
    let plain = settings(candidates);
    let cem = CemSettings { draws, short_steps: 4, ..plain.cem };
    SearchSettings { cem, ..plain }
}

/// Rounds of which the second is as long as the last, and so the last.
fn no_shorter(candidates: u32) -> SearchSettings {
    let plain = narrowing(candidates, 2);
    let cem = CemSettings { short_steps: plain.simulation.steps, ..plain.cem };
    SearchSettings { cem, ..plain }
}

fn memory_is_as_planned(device: &Device) -> Result<(), Failed> {
    let world = boxes_world();
    // Of its own, because other tests make buffers at the same time, and keep it so busy that a search would do less at
    // once.
    let gpu = Gpu::open_with(&Options { submission: Some(Duration::from_secs(3600)), ..options(device) })?;
    let kernels = Kernels::compile(&gpu)?;
    for settings in
        [settings(1), settings(65), settings(1234), narrowing(65, 4), narrowing(1, 2), narrowing(7, 1), no_shorter(64)]
    {
        let candidates = settings.cem.candidates;
        let before = gpu.made_bytes();
        let mut search = GpuSearch::new(&gpu, &kernels, &world, &settings, STREAM)?;
        let (made, planned) = (gpu.made_bytes() - before, plan(&world, &settings, gpu.room()));
        if made != planned.bytes {
            return Err(format!("{candidates} candidates: {made} bytes instead of {planned:?}").into());
        }
        search.iterate()?;
        if gpu.made_bytes() != before + made {
            return Err("an iteration makes buffers".into());
        }
    }
    Ok(())
}

fn a_split_population_gives_the_same_bits(device: &Device) -> Result<(), Failed> {
    let world = boxes_world();
    let split = GpuBackend::open_with(&Options { split: 4, ..options(device) })?;
    for settings in [settings(65), narrowing(65, 3)] {
        let at_once = |backend: &GpuBackend| backend.memory(&world, &settings).at_once;
        if [at_once(&split), at_once(device.backend()?)] != [13, 65] {
            return Err(format!("{} at a time", at_once(&split)).into());
        }
        let run = |backend: &GpuBackend| -> Result<_, Failed> {
            let mut search = backend.search(&world, &settings, STREAM)?;
            let stats = search.iterate()?;
            Ok((stats, search.energies()?, search.distribution()))
        };
        if run(&split)? != run(device.backend()?)? {
            return Err(format!("splitting changes results of {:?}", settings.cem).into());
        }
    }
    Ok(())
}

/// A software adapter would end the sort early, without a word.
fn more_than_is_ranked_is_refused(device: &Device) -> Result<(), Failed> {
    let settings = settings(131_073);
    let search = GpuSearch::new(&device.gpu, device.kernels()?, &boxes_world(), &settings, STREAM);
    match search.map(|search| search.at_once()) {
        Err(GpuError::Capacity(text)) if text.contains("rank") && device.gpu.loops() != u32::MAX => Ok(()),
        Ok(_) if device.gpu.loops() == u32::MAX => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// Where a substep of all candidates takes longer than a submission may, fewer are simulated at a time, with the same
/// result.
fn a_slow_substep_is_split(device: &Device) -> Result<(), Failed> {
    let (world, settings) = (boxes_world(), settings(65));
    let run = |submission| -> Result<_, Failed> {
        let gpu = Gpu::open_with(&Options { submission, ..options(device) })?;
        let kernels = Kernels::compile(&gpu)?;
        let mut search = GpuSearch::new(&gpu, &kernels, &world, &settings, STREAM)?;
        let stats = (0..3).map(|_| search.iterate()).collect::<Result<Vec<_>, _>>()?;
        Ok((search.at_once(), (stats, search.distribution())))
    };
    let (usual, slow) = (run(Some(Duration::from_secs(60)))?, run(Some(Duration::from_micros(1)))?);
    match (usual.0, slow.0) {
        // How far it goes depends on whether it helps.
        (65, ..=33) if usual.1 == slow.1 => Ok(()),
        other => Err(format!("{other:?} at a time").into()),
    }
}

fn a_lost_device_is_an_error(device: &Device) -> Result<(), Failed> {
    let (world, settings) = (boxes_world(), settings(9));
    let backend = GpuBackend::open_with(&Options { lost_after: Some(1), ..options(device) })?;
    let mut search = backend.search(&world, &settings, STREAM)?;
    search.iterate()?;
    for _ in 0..2 {
        match search.iterate() {
            Err(BackendError::Device(message)) if message.contains("lost") => {}
            other => return Err(format!("{other:?}").into()),
        }
    }
    match (search.energies(), search.placed(0), search.best()) {
        (Err(BackendError::Device(_)), Err(BackendError::Device(_)), Err(BackendError::Device(_))) => {}
        other => return Err(format!("{other:?}").into()),
    }
    drop(search);
    let simulated = backend.simulate(&world, &settings.simulation, &world.start, &mut |_, _, _| Flow::Continue);
    let searched = backend.search(&world, &settings, STREAM).and_then(|mut search| search.iterate());
    match (simulated, searched, backend.overlaps(&world, &settings.simulation, &world.start)) {
        (Err(BackendError::Device(_)), Err(BackendError::Device(_)), Err(BackendError::Device(_))) => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

/// The winner is simulated once more, and the device may go just then: a group without it would count as failed.
fn a_device_lost_at_the_winner_is_an_error(device: &Device) -> Result<(), Failed> {
    let (world, settings) = (boxes_world(), settings(9));
    let backend = GpuBackend::open_with(&Options { lost_after: Some(1), ..options(device) })?;
    let mut search = backend.search(&world, &settings, STREAM)?;
    search.iterate()?;
    match search.best() {
        Err(BackendError::Device(message)) if !message.contains('\n') => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

fn the_self_test_passes(device: &Device) -> Result<(), Failed> {
    Ok(self_test(device.backend()?, &CpuBackend)?)
}

/// A backend that does one thing wrong.
struct Wrong(fn(&mut SimSettings), fn(&mut SearchSettings));

const WRONGS: [Wrong; 6] = [
    Wrong(|s| s.friction = 0.0, |_| ()),
    Wrong(|s| s.friction *= 0.95, |_| ()),
    Wrong(|s| s.position_iterations = 1, |_| ()),
    Wrong(|_| (), |s| s.cem.translation_std[0] *= 1.1),
    Wrong(|_| (), |s| s.energy.layout *= 1.2),
    Wrong(|_| (), |s| s.cem.elite_fraction = 0.5),
];

/// As much as a card may be off that rounds otherwise, in every step.
const RIGHTS: [Wrong; 5] = [
    Wrong(|_| (), |_| ()),
    Wrong(|s| s.gravity *= 1.0 + 5e-7, |_| ()),
    Wrong(|s| s.gravity *= 1.0 - 5e-7, |_| ()),
    Wrong(|s| s.friction *= 1.0 + 5e-7, |_| ()),
    Wrong(|s| s.max_push_out *= 1.0 - 5e-7, |_| ()),
];

impl Backend for Wrong {
    fn describe(&self) -> String {
        "wrong".into()
    }

    fn simulate(
        &self,
        world: &World,
        settings: &SimSettings,
        starts: &[Pose],
        on_step: &mut OnStep<'_>,
    ) -> Result<Vec<Status>, BackendError> {
        let mut settings = settings.clone();
        (self.0)(&mut settings);
        CpuBackend.simulate(world, &settings, starts, on_step)
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
        let mut settings = settings.clone();
        (self.1)(&mut settings);
        // For a test's sake the settings may stay for good.
        CpuBackend.search(world, Box::leak(Box::new(settings)), stream)
    }
}

fn the_self_test_sees_what_is_wrong(_: &Device) -> Result<(), Failed> {
    for (number, wrong) in WRONGS.iter().enumerate() {
        if self_test(wrong, &CpuBackend).is_ok() {
            return Err(format!("fault {number} goes unseen").into());
        }
    }
    for other in RIGHTS {
        self_test(&other, &CpuBackend)?;
    }
    Ok(())
}
