//! Time of one candidate's substep on one core, at its start and at rest: collision detection, solver, a whole step.

use criterion::{Criterion, criterion_group, criterion_main};
use rest3d_gpu::bench::starts;
use rest3d_gpu::cpu::{Workspace, narrow_phase::Separator};
use rest3d_gpu::world::SimSettings;
use std::time::{Duration, Instant};

mod common;

fn step(c: &mut Criterion) {
    let world = common::subject(env!("CARGO_MANIFEST_DIR")).world();
    let settings = SimSettings::default();
    let narrow = Separator::new(settings.narrow_phase, &world.hulls);
    let placed = starts(&world, 1, 0);
    let mut candidate = Workspace::new(&world);

    c.bench_function("step/start", |bench| {
        bench.iter(|| {
            candidate.start(&placed);
            candidate.step(&world, &settings, &narrow);
        });
    });
    for _ in 0..settings.steps {
        candidate.step(&world, &settings, &narrow);
    }
    c.bench_function("step/rest", |bench| bench.iter(|| candidate.step(&world, &settings, &narrow)));

    // Neither half goes without the other: a substep runs whole, and one of them is timed.
    let mut halves = |timed: fn([Duration; 2]) -> Duration, substeps: u64| {
        let substep = |_| {
            let clock = Instant::now();
            candidate.collide(&world, &settings, &narrow);
            let collided = clock.elapsed();
            candidate.solve(&world, &settings);
            timed([collided, clock.elapsed() - collided])
        };
        (0..substeps).map(substep).sum()
    };
    c.bench_function("collide/rest", |bench| bench.iter_custom(|substeps| halves(|[collide, _]| collide, substeps)));
    c.bench_function("solve/rest", |bench| bench.iter_custom(|substeps| halves(|[_, solve]| solve, substeps)));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    targets = step
}
criterion_main!(benches);
