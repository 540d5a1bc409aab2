//! All buffers of one search, and the kernels before and after the simulation of its candidates.
//!
//! Everything is made here once. An iteration records `draw`, the simulation of `placed` into `poses`, and `rank`;
//! nothing comes back but what the caller fetches.

use super::buffer::Buffer;
use super::device::{Gpu, GpuError};
use super::kernel::{Recorder, Step};
use super::kernels::{self, Kernels};
use super::layout::{Batch, Body, Draw, Energy, Flags, Portion, Pose, Stats, Unit, Update, Velocity, Weights, Winner};
use super::simulation::State;
use crate::world::{Distribution, SearchSettings, Stream, World};

/// The candidates of a search. Tables of all candidates are candidate-major.
pub struct Population {
    /// Sizes of the tables; like all that follows up to `reference` the same in every iteration.
    pub batch: Buffer<Batch>,
    /// What the terms of the energy weigh.
    pub weights: Buffer<Weights>,
    /// How the distribution follows its elites.
    pub update: Buffer<Update>,
    /// `[bodies]`
    pub bodies: Buffer<Body>,
    /// `[units]`
    pub units: Buffer<Unit>,
    /// Where the bodies are without an adjustment, `[bodies]`.
    pub start: Buffer<Pose>,
    /// What the layout term compares with, `[bodies]`.
    pub reference: Buffer<Pose>,
    /// Which numbers are drawn, one.
    pub draw: Buffer<Draw>,
    /// Mean of the distribution, `[dimensions]`, m and rad.
    pub mean: Buffer<f32>,
    /// Its standard deviation, `[dimensions]`, m and rad.
    pub std: Buffer<f32>,
    /// What that does not fall below, `[dimensions]`, m and rad.
    pub floors: Buffer<f32>,
    /// `[candidates + 1][dimensions]`; the last row is the winner's.
    pub deltas: Buffer<f32>,
    /// Poses at placement, `[candidates][bodies]`.
    pub placed: Buffer<Pose>,
    /// Poses at the end of the simulation, `[candidates][bodies]`.
    pub poses: Buffer<Pose>,
    /// Velocities of step τ, `[candidates][bodies]`.
    pub snapshot: Buffer<Velocity>,
    /// Deepest overlaps at placement, `[candidates][pairs]`, m.
    pub depths_placed: Buffer<f32>,
    /// The same at the end.
    pub depths_settled: Buffer<f32>,
    /// Bits of `world::Status`, `[candidates]`.
    pub statuses: Buffer<u32>,
    /// `[candidates]`
    pub energies: Buffer<Energy>,
    /// Scratch of the sort, `[candidates rounded up to a power of two]`.
    pub keys: Buffer<[u32; 2]>,
    /// Candidates by rank, `[candidates]`.
    pub order: Buffer<u32>,
    /// How many of the first are usable elites, one.
    pub usable: Buffer<u32>,
    /// Rows of `deltas` that the distribution follows.
    pub elites: Buffer<u32>,
    /// Their number, one.
    pub count: Buffer<u32>,
    /// The best candidate so far, one.
    pub winner: Buffer<Winner>,
    /// What the host reads of a simulation, one.
    pub flags: Buffer<Flags>,
    /// What the host reads of an iteration, one.
    pub stats: Buffer<Stats>,
    drawing: [Step; 2],
    flagging: Step,
    choosing: Step,
    ranking: [Step; 5],
    first_draw: Draw,
}

impl Population {
    /// Makes all buffers and binds the kernels to them.
    ///
    /// # Errors
    /// If a table is larger than the adapter's buffers.
    pub fn new(
        gpu: &Gpu,
        kernels: &Kernels,
        world: &World,
        settings: &SearchSettings,
        stream: Stream,
    ) -> Result<Self, GpuError> {
        let cem = &settings.cem;
        let sizes = Batch::new(world, cem.drawn());
        let [candidates, rows] = [sizes.candidates as usize, sizes.candidates as usize * world.bodies.len()];
        let depths = candidates * world.pairs.len();
        let initial = cem.initial(world.units.len());
        let floors: Vec<f32> = initial.std.iter().map(|std| cem.std_floor * std).collect();
        let wanted = cem.elite_count();

        let batch = Buffer::from_slice(gpu, "batch", &[sizes])?;
        let weights = Buffer::from_slice(gpu, "weights", &[Weights::from(&settings.energy)])?;
        let update = Buffer::from_slice(gpu, "update", &[Update { wanted, epsilon: cem.std_epsilon }])?;
        let bodies = Buffer::from_slice(gpu, "bodies", &world.bodies)?;
        let units = Buffer::from_slice(gpu, "units", &world.units)?;
        let start = Buffer::from_slice(gpu, "start", &world.start)?;
        let reference = Buffer::from_slice(gpu, "reference", &world.reference)?;
        let first_draw = Draw::new(stream, 0, cem);
        let draw = Buffer::from_slice(gpu, "draw", &[first_draw])?;
        let mean = Buffer::from_slice(gpu, "mean", &initial.mean)?;
        let std = Buffer::from_slice(gpu, "std", &initial.std)?;
        let floors = Buffer::from_slice(gpu, "floors", &floors)?;
        let deltas = Buffer::new(gpu, "deltas", (candidates + 1) * world.dimensions())?;
        let placed = Buffer::new(gpu, "placed", rows)?;
        let poses = Buffer::new(gpu, "poses", rows)?;
        let snapshot = Buffer::new(gpu, "snapshot", rows)?;
        let depths_placed = Buffer::new(gpu, "depths_placed", depths)?;
        let depths_settled = Buffer::new(gpu, "depths_settled", depths)?;
        let statuses = Buffer::new(gpu, "statuses", candidates)?;
        let energies = Buffer::new(gpu, "energies", candidates)?;
        let keys = Buffer::new(gpu, "keys", candidates.next_power_of_two())?;
        let order = Buffer::new(gpu, "order", candidates)?;
        let usable = Buffer::new(gpu, "usable", 1)?;
        let elites = Buffer::new(gpu, "elites", wanted as usize)?;
        let count = Buffer::new(gpu, "count", 1)?;
        let winner = Buffer::from_slice(gpu, "winner", &[Winner::NONE])?;
        let flags = Buffer::new(gpu, "flags", 1)?;
        let stats = Buffer::new(gpu, "stats", 1)?;

        let sample = kernels::SampleBuffers {
            batch: batch.uniform(),
            draw: draw.uniform(),
            mean: mean.read(),
            std: std.read(),
            deltas: deltas.write(),
        };
        let place = kernels::PlaceBuffers {
            batch: batch.uniform(),
            bodies: bodies.read(),
            units: units.read(),
            start: start.read(),
            deltas: deltas.read(),
            placed: placed.write(),
        };
        let energy = kernels::EnergyBuffers {
            batch: batch.uniform(),
            weights: weights.uniform(),
            bodies: bodies.read(),
            reference: reference.read(),
            placed: placed.read(),
            settled: poses.read(),
            snapshot: snapshot.read(),
            depths_placed: depths_placed.read(),
            depths_settled: depths_settled.read(),
            statuses: statuses.read(),
            energies: energies.write(),
        };
        let rank = kernels::ElitesBuffers {
            batch: batch.uniform(),
            update: update.uniform(),
            energies: energies.read(),
            keys: keys.write(),
            order: order.write(),
            usable: usable.write(),
        };
        let best = kernels::BestBuffers {
            batch: batch.uniform(),
            update: update.uniform(),
            draw: draw.uniform(),
            energies: energies.read(),
            order: order.read(),
            usable: usable.read(),
            deltas: deltas.write(),
            winner: winner.write(),
            elites: elites.write(),
            count: count.write(),
        };
        let moments = kernels::MomentsBuffers {
            batch: batch.uniform(),
            update: update.uniform(),
            deltas: deltas.read(),
            elites: elites.read(),
            count: count.read(),
            floors: floors.read(),
            mean: mean.write(),
            std: std.write(),
        };
        let flag = kernels::FlagsBuffers { batch: batch.uniform(), statuses: statuses.read(), flags: flags.write() };
        let report = kernels::StatsBuffers {
            batch: batch.uniform(),
            energies: energies.read(),
            order: order.read(),
            elites: elites.read(),
            count: count.read(),
            winner: winner.read(),
            stats: stats.write(),
        };
        let flagging = flag.step(gpu, kernels, 1);
        let pass_over = kernels::PassOverBuffers { batch: batch.uniform(), statuses: statuses.write() };
        let choosing = pass_over.step(gpu, kernels, sizes.candidates);
        let drawing = [
            sample.step(gpu, kernels, sizes.candidates * sizes.dimensions.div_ceil(4)),
            place.step(gpu, kernels, rows as u32),
        ];
        let ranking = [
            energy.step(gpu, kernels, sizes.candidates),
            rank.step(gpu, kernels, 1),
            best.step(gpu, kernels, 1),
            moments.step(gpu, kernels, sizes.dimensions),
            report.step(gpu, kernels, 1),
        ];
        Ok(Self {
            batch,
            weights,
            update,
            bodies,
            units,
            start,
            reference,
            draw,
            mean,
            std,
            floors,
            deltas,
            placed,
            poses,
            snapshot,
            depths_placed,
            depths_settled,
            statuses,
            energies,
            keys,
            order,
            usable,
            elites,
            count,
            winner,
            flags,
            stats,
            drawing,
            flagging,
            choosing,
            ranking,
            first_draw,
        })
    }

    /// The kernels of an iteration but for the simulation's, in their order.
    pub fn kernels(&self) -> impl Iterator<Item = &Step> {
        self.drawing.iter().chain([&self.flagging, &self.choosing]).chain(&self.ranking)
    }

    /// Names the random numbers of everything that is submitted from now on.
    pub fn set_iteration(&self, gpu: &Gpu, iteration: u32) {
        self.draw.upload(gpu, &[Draw { iteration, ..self.first_draw }]);
    }

    /// Replaces the distribution.
    pub fn set_distribution(&self, gpu: &Gpu, distribution: &Distribution) {
        self.mean.upload(gpu, &distribution.mean);
        self.std.upload(gpu, &distribution.std);
    }

    /// Draws and places the candidates.
    pub fn draw(&self, recorder: &mut Recorder<'_>) {
        recorder.run(&self.drawing);
    }

    /// Places what `deltas` holds.
    pub fn place(&self, recorder: &mut Recorder<'_>) {
        recorder.run(&self.drawing[1..]);
    }

    /// Copies the poses at placement of some candidates, by number, to what simulates them.
    pub(super) fn hand_over(&self, recorder: &mut Recorder<'_>, some: &State, Portion { first, count }: Portion) {
        let [first, count, bodies] = [first as usize, count as usize, self.bodies.len()];
        recorder.copy_range((&self.placed, first * bodies), (&some.poses, 0), count * bodies);
    }

    /// Copies what came of them back.
    pub(super) fn take_back(&self, recorder: &mut Recorder<'_>, some: &State, Portion { first, count }: Portion) {
        let [first, count, bodies] = [first as usize, count as usize, self.bodies.len()];
        let pairs = self.depths_placed.len() / self.statuses.len().max(1);
        recorder.copy_range((&some.poses, 0), (&self.poses, first * bodies), count * bodies);
        recorder.copy_range((&some.snapshot, 0), (&self.snapshot, first * bodies), count * bodies);
        recorder.copy_range((&some.depths_placed, 0), (&self.depths_placed, first * pairs), count * pairs);
        recorder.copy_range((&some.depths_settled, 0), (&self.depths_settled, first * pairs), count * pairs);
        recorder.copy_range((&some.statuses, 0), (&self.statuses, first), count);
    }

    /// Ranks the candidates by what was simulated so far, and passes all over but those that are simulated next.
    pub(super) fn choose(&self, recorder: &mut Recorder<'_>) {
        recorder.run(&self.ranking[..2]);
        recorder.run([&self.choosing]);
    }

    /// Counts what went wrong in the simulation, into `flags`.
    pub fn flag(&self, recorder: &mut Recorder<'_>) {
        recorder.run([&self.flagging]);
    }

    /// Turns what was simulated into energies, elites, the next distribution and `stats`.
    pub fn rank(&self, recorder: &mut Recorder<'_>) {
        recorder.run(&self.ranking);
    }
}
