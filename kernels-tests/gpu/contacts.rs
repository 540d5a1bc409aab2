//! Kernels `merge`, `contact_starts` and `emit`, which are `cpu::contacts`; and all of `Contacts` in a row.

use super::Test;
use super::fixture::{Device, SIZES, noise};
use super::states::{contact, patch};
use super::touching::{Expected, Touching, fan, raft, world};
use glam::Vec3;
use libtest_mimic::Failed;
use rest3d_gpu::cpu::contacts::{self, ContactSet, GROUND, Gatherer};
use rest3d_gpu::cpu::narrow_phase;
use rest3d_gpu::gpu::{Contact, Manifold, ManifoldPoint, Patch, Recorder};
use rest3d_gpu::world::{Status, World};

pub const TESTS: &[Test] = &[
    ("contacts::are_their_twin", are_their_twin),
    ("contacts::many_points_are_thinned_out_alike", many_points_are_thinned_out_alike),
    ("contacts::a_point_between_two_patches_is_of_the_first", a_point_between_two_patches_is_of_the_first),
    ("contacts::overflow_is_flagged", overflow_is_flagged),
    ("contacts::repeat_to_the_bit", repeat_to_the_bit),
    ("contacts::forget_after_reset", forget_after_reset),
];

/// Of positions in metres and of unit normals.
const TOLERANCE: f32 = 1e-5;

/// Share of the candidates in which a tie may fall otherwise.
const MOST_CHOICES: f32 = 0.01;

/// Contacts as the CPU makes them from the manifolds; bodies that are `still` keep those between them.
fn gather(world: &World, expected: &Expected, still: &[bool], old: &mut ContactSet) -> ContactSet {
    let mut made = ContactSet::default();
    let mut gatherer = Gatherer::default();
    let entries = world.pairs.len() + world.bodies.len();
    for entry in 0..entries {
        gatherer.clear();
        let bodies = match entry.checked_sub(world.pairs.len()) {
            None => {
                let [first, end] = [0, 1].map(|i| expected.starts[entry + i] as usize);
                expected.manifolds[first..end].iter().for_each(|m| gatherer.add(m.normal, m.points()));
                world.pairs[entry]
            }
            Some(body) => {
                expected.ground[world.hulls_of(body)].iter().for_each(|m| gatherer.add(m.normal, m.points()));
                [GROUND, body as u32]
            }
        };
        let of_entry = |patch: &contacts::Patch| patch.pair as usize == entry;
        let first = old.patches.iter().position(of_entry).unwrap_or(0);
        let range = first..first + old.patches.iter().filter(|patch| of_entry(patch)).count();
        let keeps = bodies.iter().all(|&body| body == GROUND || still[body as usize]);
        if keeps {
            made.keep(bodies, &expected.poses, old, range);
            continue;
        }
        gatherer.merge();
        for patch in gatherer.patches() {
            made.push(entry as u32, bodies, &expected.poses, patch, old, range.clone());
        }
    }
    made
}

/// What a solver would leave behind.
fn solve(candidate: usize, set: &mut ContactSet) {
    let random = noise(500 + candidate as u32, 8 * set.points.len());
    for (patch, x) in set.patches.iter_mut().zip(random.chunks_exact(4)) {
        patch.friction = Vec3::new(x[0], x[1], x[2]);
        patch.twist = x[3];
    }
    for (point, x) in set.points.iter_mut().zip(random.chunks_exact(3)) {
        (point.impulse, point.load, point.rest) = (x[0], x[1], x[2]);
    }
}

fn coded(set: &ContactSet) -> (Vec<Patch>, Vec<Contact>) {
    (set.patches.iter().map(patch).collect(), set.points.iter().map(contact).collect())
}

fn near(a: Vec3, b: Vec3) -> bool {
    a.distance(b) <= TOLERANCE
}

fn same_patch(a: &Patch, b: &Patch) -> bool {
    let numbers = |p: &Patch| [p.pair, p.a, p.b, p.first, p.count];
    numbers(a) == numbers(b) && near(a.normal, b.normal) && a.friction == b.friction && a.twist == b.twist
}

fn same_contact(a: &Contact, b: &Contact) -> bool {
    near(a.normal, b.normal)
        && near(a.point, b.point)
        && near(a.anchor_a, b.anchor_a)
        && near(a.anchor_b, b.anchor_b)
        && (a.separation - b.separation).abs() <= TOLERANCE
        && (a.found - b.found).abs() <= TOLERANCE
        && a.impulse == b.impulse
        && a.load == b.load
        && a.rest == b.rest
}

/// Which bodies keep the contacts between them: none before there are any, later the plate and some of the others.
fn still(world: &World, candidate: u32, age: usize) -> Vec<bool> {
    let random = noise(900 + candidate, world.bodies.len());
    random.iter().enumerate().map(|(body, x)| age > 0 && (body == 0 || *x > 0.0)).collect()
}

fn upload_manifolds(device: &Device, world: &World, touching: &Touching, age: usize) {
    let head = |m: &narrow_phase::Manifold| Manifold { normal: m.normal, count: m.count };
    let point = |p: &narrow_phase::ManifoldPoint| {
        let mut made = ManifoldPoint::default();
        (made.on_a, made.separation, made.on_b) = (p.on_a, p.separation, p.on_b);
        made
    };
    let padding = narrow_phase::Manifold::default();
    let all = touching.expected[age].iter().flat_map(|e| {
        let padded = e.manifolds.iter().chain(std::iter::repeat(&padding)).take(world.capacities.hull_pairs as usize);
        padded.chain(&e.ground)
    });
    let (heads, points): (Vec<_>, Vec<_>) = all.map(|m| (head(m), m.slots.iter().map(point))).unzip();
    touching.contacts.manifolds.upload(&device.gpu, &heads);
    touching.contacts.manifold_points.upload(&device.gpu, &points.into_iter().flatten().collect::<Vec<_>>());
}

fn are_their_twin(device: &Device) -> Result<(), Failed> {
    SIZES.iter().try_for_each(|&candidates| is_twin(device, &world(), candidates))
}

/// What gathers more points than are looked at together is thinned out on the way.
fn many_points_are_thinned_out_alike(device: &Device) -> Result<(), Failed> {
    is_twin(device, &raft(), 65)
}

/// What looks about the way of several patches goes to the one that was found first.
fn a_point_between_two_patches_is_of_the_first(device: &Device) -> Result<(), Failed> {
    is_twin(device, &fan(), 65)
}

fn is_twin(device: &Device, world: &World, candidates: u32) -> Result<(), Failed> {
    let row = world.capacities.contacts as usize;
    let touching = Touching::new(device, world, candidates)?;
    let mut sets: Vec<ContactSet> = (0..candidates).map(|_| ContactSet::default()).collect();
    let mut choices = vec![false; candidates as usize];
    let (mut handed, mut kept) = (0, 0);
    for age in 0..2 {
        touching.set_age(device, world, age);
        let still: Vec<Vec<bool>> = (0..candidates).map(|candidate| still(world, candidate, age)).collect();
        touching.set_still(device, &still.concat())?;
        upload_manifolds(device, world, &touching, age);
        touching.contacts.steps(age)[5..].iter().for_each(|step| device.run(step));
        let mut patches = device.fetch(&touching.contacts.patches[age])?;
        let mut points = device.fetch(&touching.contacts.points[age])?;
        let counts = device.fetch(&touching.contacts.patch_counts[age])?;
        for (candidate, old) in sets.iter_mut().enumerate() {
            if choices[candidate] {
                continue;
            }
            let mut made = gather(world, &touching.expected[age][candidate], &still[candidate], old);
            kept += made.points.iter().filter(|p| p.found != p.separation).count();
            let (wanted_patches, wanted_points) = coded(&made);
            handed += wanted_points.iter().filter(|p| p.impulse != 0.0).count();
            let found_patches = &mut patches[candidate * row..][..wanted_patches.len()];
            let found_points = &mut points[candidate * row..][..wanted_points.len()];
            let is_same = |patches: &[Patch], points: &[Contact]| {
                counts[candidate] as usize == wanted_patches.len()
                    && patches.iter().zip(&wanted_patches).all(|(a, b)| same_patch(a, b))
                    && points.iter().zip(&wanted_points).all(|(a, b)| same_contact(a, b))
            };
            choices[candidate] = !is_same(found_patches, found_points);
            // The canary.
            if let Some(spoiled) = found_points.last_mut().filter(|_| !choices[candidate]) {
                spoiled.anchor_b.x += 3.0 * TOLERANCE;
                if is_same(
                    &patches[candidate * row..][..wanted_patches.len()],
                    &points[candidate * row..][..wanted_points.len()],
                ) {
                    return Err("the comparison does not see that a point is off".into());
                }
            }
            solve(candidate, &mut made);
            let (old_patches, old_points) = coded(&made);
            patches[candidate * row..][..old_patches.len()].copy_from_slice(&old_patches);
            points[candidate * row..][..old_points.len()].copy_from_slice(&old_points);
            *old = made;
        }
        touching.contacts.patches[age].upload(&device.gpu, &patches);
        touching.contacts.points[age].upload(&device.gpu, &points);
    }
    let other = choices.iter().filter(|other| **other).count();
    eprintln!("{candidates} candidates: {handed} impulses handed over, {other} with another choice");
    if other as f32 > MOST_CHOICES * candidates as f32 {
        return Err(format!("{other} of {candidates} candidates differ: {choices:?}").into());
    }
    if handed < candidates as usize || (candidates > 7 && kept < candidates as usize) {
        return Err(format!("only {handed} impulses handed over and {kept} contacts kept").into());
    }
    Ok(())
}

fn overflow_is_flagged(device: &Device) -> Result<(), Failed> {
    let mut world = world();
    world.capacities.contacts = 60;
    let row = 60;
    let touching = Touching::new(device, &world, 65)?;
    touching.set_age(device, &world, 0);
    upload_manifolds(device, &world, &touching, 0);
    touching.contacts.steps(0)[5..].iter().for_each(|step| device.run(step));
    let patches = device.fetch(&touching.contacts.patches[0])?;
    let points = device.fetch(&touching.contacts.points[0])?;
    let counts = device.fetch(&touching.contacts.patch_counts[0])?;
    let totals = device.fetch(&touching.contacts.point_counts)?;
    let statuses = device.fetch(&touching.statuses)?;
    let mut overflows = 0;
    for (candidate, expected) in touching.expected[0].iter().enumerate() {
        let (wanted_patches, wanted_points) = coded(&gather(&world, expected, &[false; 8], &mut ContactSet::default()));
        let over = wanted_points.len() > row;
        overflows += usize::from(over);
        let flag = if over { Status::CONTACTS.0 } else { 0 };
        // Entries are whole or absent.
        let misfit = wanted_patches.iter().find(|patch| (patch.first + patch.count) as usize > row);
        let fitting = |patch: &&Patch| misfit.is_none_or(|misfit| patch.pair < misfit.pair);
        let kept: Vec<&Patch> = wanted_patches.iter().take_while(fitting).collect();
        let used = kept.last().map_or(0, |patch| patch.first + patch.count) as usize;
        if [totals[candidate], statuses[candidate], counts[candidate]]
            != [wanted_points.len() as u32, flag, kept.len() as u32]
        {
            return Err(format!(
                "candidate {candidate}: {} patches and {} points instead of {} and {}, status {}",
                counts[candidate],
                totals[candidate],
                kept.len(),
                wanted_points.len(),
                statuses[candidate]
            )
            .into());
        }
        let (patches, points) = (&patches[candidate * row..][..row], &points[candidate * row..][..row]);
        if !patches.iter().zip(kept).all(|(a, b)| same_patch(a, b))
            || !points[..used].iter().zip(&wanted_points).all(|(a, b)| same_contact(a, b))
        {
            return Err(format!("candidate {candidate}: what fits differs").into());
        }
        if points[used..].iter().any(|point| !point.separation.is_nan()) {
            return Err(format!("candidate {candidate}: something was written behind the last entry that fits").into());
        }
    }
    if overflows == 0 || overflows == 65 { Err(format!("{overflows} overflows").into()) } else { Ok(()) }
}

/// Everything of two substeps, with a solver's impulses in between left at zero.
fn simulate(device: &Device, world: &World, candidates: u32) -> Result<(Vec<u8>, Vec<u8>), Failed> {
    let touching = Touching::new(device, world, candidates)?;
    for age in 0..2 {
        touching.set_age(device, world, age);
        let mut recorder = Recorder::new(&device.gpu);
        touching.contacts.record(&mut recorder, age);
        recorder.submit();
    }
    let patches = device.fetch(&touching.contacts.patches[1])?;
    let points = device.fetch(&touching.contacts.points[1])?;
    Ok((bytemuck::cast_slice(&patches).to_vec(), bytemuck::cast_slice(&points).to_vec()))
}

fn repeat_to_the_bit(device: &Device) -> Result<(), Failed> {
    let world = world();
    let few = simulate(device, &world, 7)?;
    let many = simulate(device, &world, 65)?;
    if many != simulate(device, &world, 65)? {
        return Err("two runs differ".into());
    }
    if few.0[..] != many.0[..few.0.len()] || few.1[..] != many.1[..few.1.len()] {
        return Err("candidates depend on how many there are".into());
    }
    Ok(())
}

fn forget_after_reset(device: &Device) -> Result<(), Failed> {
    let world = world();
    let touching = Touching::new(device, &world, 7)?;
    touching.set_age(device, &world, 0);
    let run = |reset: bool| -> Result<usize, Failed> {
        let mut recorder = Recorder::new(&device.gpu);
        touching.contacts.record(&mut recorder, 0);
        recorder.submit();
        let mut points = device.fetch(&touching.contacts.points[0])?;
        points.iter_mut().for_each(|point| point.impulse = 1.0);
        touching.contacts.points[0].upload(&device.gpu, &points);
        let mut recorder = Recorder::new(&device.gpu);
        if reset {
            touching.contacts.reset(&mut recorder);
        }
        touching.contacts.record(&mut recorder, 1);
        recorder.submit();
        Ok(device.fetch(&touching.contacts.points[1])?.iter().filter(|point| point.impulse == 1.0).count())
    };
    let (kept, forgotten) = (run(false)?, run(true)?);
    if kept == 0 || forgotten > 0 {
        return Err(format!("{kept} impulses handed over, {forgotten} after a reset").into());
    }
    Ok(())
}
