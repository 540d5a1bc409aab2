//! The opened adapter, and how it fails.
//!
//! All its limits are asked for, and of the optional features those that save or measure time. A missing Vulkan loader,
//! driver or limit is an error with its remedy, never a panic.

use super::adapter::{AdapterChoice, AdapterKind, AdapterReport, enumerate, instance};
use super::pipelines::Pipelines;
use super::plan::Room;
use crate::world::BackendError;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use thiserror::Error;

/// What to do when no adapter shows up.
pub const INSTALL_HINT: &str = if cfg!(target_os = "linux") {
    "install the Vulkan loader and a driver (Debian, Ubuntu: apt-get install libvulkan1 mesa-vulkan-drivers, which also \
     brings a software adapter; NVIDIA cards need NVIDIA's own driver)"
} else {
    "install the graphics driver of the card's maker"
};

/// What is used where an adapter has it: the time of every kernel, and compiled kernels on disk.
const OPTIONAL: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES)
    .union(wgpu::Features::PIPELINE_CACHE);

/// How often Mesa's software driver lets all loops of an invocation together go round, less a few: after 65,535 times
/// it ends every loop, without a word.
const SOFTWARE_LOOPS: u32 = 65_000;

/// How long a submission may take: desktops reset a graphics card that does not answer for seconds, and stutter before.
const SUBMISSION: Duration = Duration::from_millis(50);

/// Why the GPU cannot be used.
#[derive(Clone, Debug, Error)]
pub enum GpuError {
    /// No adapter at all, or none that was asked for.
    #[error("{0}")]
    NoAdapter(String),
    /// The adapter lacks something.
    #[error("{name} cannot run the kernels: {}", missing.join("; "))]
    Unfit {
        /// The adapter.
        name: String,
        /// What it lacks.
        missing: Vec<String>,
    },
    /// A buffer is larger than the adapter allows.
    #[error("{0}")]
    Capacity(String),
    /// The driver failed.
    #[error("graphics device: {0}")]
    Device(String),
}

impl From<GpuError> for BackendError {
    fn from(error: GpuError) -> Self {
        match error {
            GpuError::Capacity(message) => Self::Capacity(message),
            other => Self::Device(other.to_string()),
        }
    }
}

/// How an adapter is opened.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Which.
    pub adapter: AdapterChoice,
    /// Directory for compiled kernels; none: they are compiled at every start.
    pub cache: Option<PathBuf>,
    /// Simulates so many times fewer candidates at a time, and submits as much less at once, than would fit; 0 and 1:
    /// as many as fit.
    pub split: u32,
    /// How long a submission may take, for tests; none: `SUBMISSION`, and as long as it takes on software adapters,
    /// which have no watchdog.
    pub submission: Option<Duration>,
    /// The device is lost after so many requests to searches, for an iteration or for the winner: a fault for tests.
    pub lost_after: Option<u32>,
}

/// An opened adapter.
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) limits: wgpu::Limits,
    /// Compiled kernels on disk.
    pub(super) pipelines: Option<Pipelines>,
    /// Bytes of all buffers ever made.
    pub(super) made: AtomicU64,
    split: u32,
    submission: Option<Duration>,
    requests_left: Option<AtomicU32>,
    report: AdapterReport,
    failure: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the adapter that was asked for; among several, the fit before the unfit, then the best kind.
    ///
    /// # Errors
    /// If there is none, it lacks something, or its driver refuses.
    pub fn open(choice: &AdapterChoice) -> Result<Self, GpuError> {
        Self::open_with(&Options { adapter: choice.clone(), ..Options::default() })
    }

    /// The same, in a certain manner.
    ///
    /// # Errors
    /// As `open`.
    pub fn open_with(options: &Options) -> Result<Self, GpuError> {
        let choice = &options.adapter;
        let mut found = enumerate(&instance());
        if found.is_empty() {
            return Err(GpuError::NoAdapter(format!("no graphics adapter: {INSTALL_HINT}")));
        }
        let names: Vec<String> = found.iter().map(|(report, _)| format!("{} {}", report.index, report.name)).collect();
        found.retain(|(report, _)| report.matches(choice));
        let best = found.into_iter().min_by_key(|(report, _)| (!report.is_fit(), report.kind, report.index));
        let Some((report, adapter)) = best else {
            return Err(GpuError::NoAdapter(format!(
                "no graphics adapter `{choice}`; there are: {}",
                names.join(", ")
            )));
        };
        if !report.is_fit() {
            return Err(GpuError::Unfit { name: report.name, missing: report.missing });
        }
        let limits = adapter.limits();
        let request = wgpu::DeviceDescriptor {
            label: Some("rest3d-gpu"),
            required_features: adapter.features() & OPTIONAL,
            required_limits: limits.clone(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&request))
            .map_err(|error| GpuError::Device(format!("{}: {error}", report.name)))?;
        let failure = Arc::new(Mutex::new(None));
        let keep = |message: String, failure: &Mutex<Option<String>>| {
            failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
        };
        let uncaptured = Arc::clone(&failure);
        let one_line = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(one_line(error.to_string()), &uncaptured)));
        let lost = Arc::clone(&failure);
        device.set_device_lost_callback(move |reason, message| {
            // What else went wrong follows from that.
            let message = format!("lost ({reason:?}) {message}").trim_end().to_owned();
            *lost.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
        });
        let pipelines =
            options.cache.as_ref().and_then(|directory| Pipelines::open(&device, &adapter.get_info(), directory));
        Ok(Self {
            device,
            queue,
            limits,
            pipelines,
            made: AtomicU64::new(0),
            split: options.split.max(1),
            submission: options.submission,
            requests_left: options.lost_after.map(AtomicU32::new),
            report,
            failure,
        })
    }

    /// The adapter.
    pub fn report(&self) -> &AdapterReport {
        &self.report
    }

    /// True if a candidate can be solved by a workgroup: DirectX's older compiler refuses barriers in loops whose end
    /// it does not know.
    pub fn has_waves(&self) -> bool {
        self.report.api != "Dx12"
    }

    /// How often all loops of an invocation together may go round.
    pub fn loops(&self) -> u32 {
        if self.report.kind == AdapterKind::Software { SOFTWARE_LOOPS } else { u32::MAX }
    }

    /// What a search may take.
    pub fn room(&self) -> Room {
        Room { binding: self.report.max_binding_bytes, split: self.split }
    }

    /// How long a submission should take.
    pub(super) fn submission(&self) -> Duration {
        self.submission.unwrap_or(SUBMISSION) / self.split
    }

    /// True if it must not take longer, even with fewer candidates at a time.
    pub(super) fn is_watched(&self) -> bool {
        self.submission.is_some() || self.report.kind != AdapterKind::Software
    }

    /// True if compiled kernels can be kept on disk.
    pub fn keeps_pipelines(&self) -> bool {
        self.device.features().contains(wgpu::Features::PIPELINE_CACHE)
    }

    /// True if it tells how long kernels take.
    pub fn has_times(&self) -> bool {
        self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Bytes of all buffers made since it was opened.
    pub fn made_bytes(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
    }

    /// A request begins: with `Options::lost_after` so many before, the device is lost.
    pub(super) fn count_request(&self) {
        let Some(left) = &self.requests_left else { return };
        match left.load(Ordering::Relaxed) {
            0 => {
                self.device.destroy();
                // The callback tells of it; what comes next fails.
                let _ = self.device.poll(wgpu::PollType::Poll);
            }
            more => left.store(more - 1, Ordering::Relaxed),
        }
    }

    /// Fails if anything went wrong on the device since it was opened.
    ///
    /// # Errors
    /// With the driver's first complaint.
    pub fn check(&self) -> Result<(), GpuError> {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.clone().map_or(Ok(()), |message| Err(GpuError::Device(message)))
    }

    /// Waits until everything submitted is done.
    ///
    /// # Errors
    /// If the device failed.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| GpuError::Device(error.to_string()))?;
        self.check()
    }
}
