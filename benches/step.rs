//! Time of a substep of one candidate and of a full group on one core, at their start and at rest: collision detection,
//! solver, a whole step.

use criterion::{Criterion, criterion_group, criterion_main};
use rest3d_gpu::bench::starts;
use rest3d_gpu::cpu::{Group, narrow_phase::Separator};
use rest3d_gpu::world::SimSettings;
use std::time::{Duration, Instant};

mod common;

fn step(c: &mut Criterion) {
    let world = common::subject(env!("CARGO_MANIFEST_DIR")).world();
    let settings = SimSettings::default();
    let narrow = Separator::new(settings.narrow_phase, &world.hulls);
    for candidates in [1, Group::lanes()] {
        let placed = starts(&world, candidates as u32, 0);
        let mut group = Group::new(&world, candidates);
        let name = |what: &str| format!("{what}/{candidates}");

        c.bench_function(&name("step/start"), |bench| {
            bench.iter(|| {
                group.start(&placed);
                group.step(&world, &settings, &narrow);
            });
        });
        for _ in 0..settings.steps {
            group.step(&world, &settings, &narrow);
        }
        c.bench_function(&name("step/rest"), |bench| bench.iter(|| group.step(&world, &settings, &narrow)));

        // Neither half goes without the other: a substep runs whole, and one of them is timed.
        let mut halves = |timed: fn([Duration; 2]) -> Duration, substeps: u64| {
            let substep = |_| {
                let clock = Instant::now();
                group.collide(&world, &settings, &narrow);
                let collided = clock.elapsed();
                group.solve(&world, &settings);
                timed([collided, clock.elapsed() - collided])
            };
            (0..substeps).map(substep).sum()
        };
        c.bench_function(&name("collide/rest"), |bench| {
            bench.iter_custom(|substeps| halves(|[collide, _]| collide, substeps));
        });
        c.bench_function(&name("solve/rest"), |bench| {
            bench.iter_custom(|substeps| halves(|[_, solve]| solve, substeps));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    targets = step
}
criterion_main!(benches);
