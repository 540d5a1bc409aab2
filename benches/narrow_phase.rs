//! Time of one hull pair: far, near, touching and deep; twin cold, twin with a warm cache, reference; and the manifold.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::{Quat, Vec3};
use rest3d_gpu::cpu::narrow_phase::{HullPair, Manifold, PairCache, Separator, manifold};
use rest3d_gpu::world::{HullTables, NarrowPhase, Pose};
use std::hint::black_box;

/// Points spread evenly over a flattened ball, like a part of an organic shape.
fn pebble(vertices: usize) -> Vec<Vec3> {
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    (0..vertices)
        .map(|i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / vertices as f32;
            let (sin, cos) = (golden * i as f32).sin_cos();
            let r = (1.0 - y * y).sqrt();
            Vec3::new(0.05 * r * cos, 0.03 * y, 0.05 * r * sin)
        })
        .collect()
}

/// A prism with `sides` sides: a mug's bottom, a table top; a box for 4.
fn prism(sides: usize, radius: f32, half_height: f32) -> Vec<Vec3> {
    (0..2 * sides)
        .map(|i| {
            let angle = ((i / 2) as f32 + 0.5) / sides as f32 * std::f32::consts::TAU;
            let y = if i % 2 == 0 { half_height } else { -half_height };
            Vec3::new(radius * angle.cos(), y, radius * angle.sin())
        })
        .collect()
}

fn narrow_phase(c: &mut Criterion) {
    let kinds: [(&str, [Vec<Vec3>; 2]); 4] = [
        ("box-box", [prism(4, 0.05, 0.03), prism(4, 0.06, 0.03)]),
        ("prism12-prism12", [prism(12, 0.05, 0.03), prism(12, 0.06, 0.03)]),
        ("pebble24-pebble24", [pebble(24), pebble(24)]),
        ("pebble32-box", [pebble(32), prism(4, 0.3, 0.01)]),
    ];
    for (name, parts) in kinds {
        let mut tables = HullTables::default();
        parts.iter().for_each(|part| tables.push(part));
        let twin = Separator::new(NarrowPhase::Twin, &tables);
        let reference = Separator::new(NarrowPhase::Reference, &tables);
        let a = Pose::new(Quat::from_rotation_y(0.3), Vec3::new(0.4, 0.7, -0.2));
        let height = tables.hulls[0].half_extents.y + tables.hulls[1].half_extents.y;
        for (case, gap) in [("far", 0.015), ("near", 0.003), ("touching", -0.0002), ("deep", -0.02)] {
            let tilt = Quat::from_rotation_z(if case == "touching" { 0.0 } else { 0.1 });
            let b = Pose::new(tilt * Quat::from_rotation_y(1.1), a.translation + Vec3::new(0.01, height + gap, 0.005));
            let pair = HullPair { tables: &tables, hulls: [0, 1], poses: [&a, &b], room: HullPair::ANY_ROOM };
            let margin = 0.01;
            let mut group = c.benchmark_group(format!("{name}/{case}"));
            group.bench_function("twin cold", |bench| {
                bench.iter(|| twin.separation(black_box(&pair), margin, &mut PairCache::default()))
            });
            let mut cache = PairCache::default();
            let separation = twin.separation(&pair, margin, &mut cache);
            group.bench_function("twin warm", |bench| {
                bench.iter(|| twin.separation(black_box(&pair), margin, black_box(&mut cache)))
            });
            group.bench_function("reference", |bench| {
                bench.iter(|| reference.separation(black_box(&pair), margin, &mut PairCache::default()))
            });
            if let Some(separation) = separation {
                let mut out = Manifold::default();
                group.bench_function("manifold", |bench| {
                    bench.iter(|| manifold(black_box(&pair), &separation, margin, black_box(&mut out)))
                });
            }
            group.finish();
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(std::time::Duration::from_millis(100))
        .measurement_time(std::time::Duration::from_millis(300));
    targets = narrow_phase
}
criterion_main!(benches);
