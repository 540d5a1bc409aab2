//! How long each kernel works, by timestamps that the device writes between dispatches.
//!
//! Everything is made before the work begins. An iteration's timestamps stay on the device until it ends; one read of a
//! few kilobytes then turns them into milliseconds. Where an iteration has more than fit into a query set, every n-th
//! unit of work (a substep, a measurement of overlaps) is timed and counts n times.

use super::buffer::Download;
use super::device::{Gpu, GpuError};
use super::kernel::Step;
use crate::world::KernelTime;
use std::cell::RefCell;

/// Timestamps of a query set: the most that there may be.
const MARKS: u32 = wgpu::QUERY_SET_MAX_QUERIES;

/// Timestamps set aside for what is not repeated: drawing, ranking and the first loads.
const SINGLE_MARKS: u32 = 256;

/// Timestamps of one adapter, and what they added up to.
pub struct Timer {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: Download<u64>,
    /// Timestamps may stand between the dispatches of a pass; else each dispatch is a pass of its own.
    inside: bool,
    /// Milliseconds of a tick.
    tick: f64,
    log: RefCell<Log>,
}

/// What has been recorded since the last collection, and the sums of all before.
struct Log {
    marks: u32,
    spans: Vec<Span>,
    unit: u32,
    stride: u32,
    sums: Vec<KernelTime>,
}

/// A dispatch between two timestamps, and how many it stands for.
struct Span {
    kernel: &'static str,
    ends: [u32; 2],
    weight: u32,
}

impl Timer {
    /// Makes everything; none where the adapter has no timestamps.
    pub fn new(gpu: &Gpu) -> Option<Self> {
        let features = gpu.device.features();
        if !gpu.has_times() {
            return None;
        }
        let inside = features.contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES);
        let label = Some("timestamps");
        let ty = wgpu::QueryType::Timestamp;
        let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor { label, ty, count: MARKS });
        let resolved = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label,
            size: u64::from(MARKS * wgpu::QUERY_SIZE),
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let log = Log { marks: 0, spans: Vec::with_capacity(MARKS as usize), unit: 0, stride: 1, sums: Vec::new() };
        let tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        let read = Download::new(gpu, "timestamps", MARKS as usize);
        Some(Self { set, resolved, read, inside, tick, log: RefCell::new(log) })
    }

    /// There will be so many units of work between two collections, each of at most `steps` dispatches in `passes`
    /// passes.
    pub(super) fn expect(&self, [units, steps, passes]: [u32; 3]) {
        let marks = if self.inside { steps + passes } else { 2 * steps };
        let room = (MARKS - SINGLE_MARKS) / marks.max(1);
        self.log.borrow_mut().stride = units.div_ceil(room.max(1)).max(1);
    }

    /// A unit of work begins: how many it stands for; 0 if it is not timed.
    pub(super) fn next_unit(&self) -> u32 {
        let mut log = self.log.borrow_mut();
        let timed = log.unit.is_multiple_of(log.stride);
        log.unit += 1;
        if timed { log.stride } else { 0 }
    }

    /// Runs the steps one after the other with timestamps between them. What finds no room is run without.
    pub(super) fn run<'s>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        weight: u32,
        steps: impl IntoIterator<Item = &'s Step>,
    ) {
        let mut log = self.log.borrow_mut();
        if self.inside {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let mut last = log.mark();
            last.inspect(|mark| pass.write_timestamp(&self.set, *mark));
            for step in steps {
                step.dispatch(&mut pass);
                let next = last.and_then(|_| log.mark());
                next.inspect(|mark| pass.write_timestamp(&self.set, *mark));
                log.span(step.name, [last, next], weight);
                last = next;
            }
            return;
        }
        for step in steps {
            let ends = [log.mark(), log.mark()];
            let writes = ends[1].map(|_| wgpu::ComputePassTimestampWrites {
                query_set: &self.set,
                beginning_of_pass_write_index: ends[0],
                end_of_pass_write_index: ends[1],
            });
            let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes: writes };
            step.dispatch(&mut encoder.begin_compute_pass(&descriptor));
            log.span(step.name, ends, weight);
        }
    }

    /// Fetches the timestamps, as the last thing that is recorded before `collect`.
    pub(super) fn fetch(&self, encoder: &mut wgpu::CommandEncoder) {
        let marks = self.log.borrow().marks;
        if marks > 0 {
            let bytes = u64::from(marks * wgpu::QUERY_SIZE);
            encoder.resolve_query_set(&self.set, 0..marks, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.read.raw, 0, bytes);
        }
    }

    /// Adds up what was fetched, and begins anew.
    ///
    /// # Errors
    /// If the device failed.
    pub fn collect(&self, gpu: &Gpu) -> Result<(), GpuError> {
        let ticks = self.read.take(gpu)?;
        let Log { marks, spans, unit, sums, .. } = &mut *self.log.borrow_mut();
        for Span { kernel, ends: [begin, end], weight } in spans.drain(..) {
            // A clock that was reset in between tells nothing.
            let ticks = ticks[end as usize].saturating_sub(ticks[begin as usize]);
            let milliseconds = ticks as f64 * self.tick * f64::from(weight);
            match sums.iter_mut().find(|sum| sum.name == kernel) {
                Some(sum) => sum.milliseconds += milliseconds,
                None => sums.push(KernelTime { name: kernel.into(), milliseconds }),
            }
        }
        (*marks, *unit) = (0, 0);
        Ok(())
    }

    /// The sums over everything collected, in the order of first use.
    pub fn times(&self) -> Vec<KernelTime> {
        self.log.borrow().sums.clone()
    }
}

impl Log {
    /// The next timestamp, if there is room.
    fn mark(&mut self) -> Option<u32> {
        let mark = self.marks;
        (mark < MARKS).then(|| {
            self.marks += 1;
            mark
        })
    }

    fn span(&mut self, kernel: &'static str, ends: [Option<u32>; 2], weight: u32) {
        if let [Some(begin), Some(end)] = ends {
            self.spans.push(Span { kernel, ends: [begin, end], weight });
        }
    }
}
