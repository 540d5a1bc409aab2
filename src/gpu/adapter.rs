//! Which adapters there are, and whether they can run the kernels: what these need is read off them.

use super::kernel::{Access, Shader};
use super::kernels::SHADERS;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Bytes that one buffer must be able to hold: what WebGPU promises everywhere.
const LEAST_BINDING: u64 = 128 << 20;

/// What kind of processor an adapter is, the preferred first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AdapterKind {
    /// A card with memory of its own.
    Discrete,
    /// Shares the processor's memory.
    Integrated,
    /// A part of a card, lent by a hypervisor.
    Virtual,
    /// The driver does not say.
    Other,
    /// The processor itself.
    Software,
}

impl AdapterKind {
    const NAMES: [(Self, &'static str); 5] = [
        (Self::Discrete, "discrete"),
        (Self::Integrated, "integrated"),
        (Self::Virtual, "virtual"),
        (Self::Other, "other"),
        (Self::Software, "software"),
    ];
}

impl fmt::Display for AdapterKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Self::NAMES.iter().filter(|(kind, _)| kind == self).try_for_each(|(_, name)| f.write_str(name))
    }
}

impl From<wgpu::DeviceType> for AdapterKind {
    fn from(kind: wgpu::DeviceType) -> Self {
        match kind {
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu => Self::Integrated,
            wgpu::DeviceType::VirtualGpu => Self::Virtual,
            wgpu::DeviceType::Cpu => Self::Software,
            wgpu::DeviceType::Other => Self::Other,
        }
    }
}

/// Which adapter the user wants.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The best that is fit.
    #[default]
    Auto,
    /// Its number in the list of `adapters`.
    Index(usize),
    /// The best of a kind.
    Kind(AdapterKind),
    /// A part of its name, in any case.
    Name(String),
}

impl FromStr for AdapterChoice {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim().to_lowercase();
        if text.is_empty() || text == "auto" {
            return Ok(Self::Auto);
        }
        if let Ok(index) = text.parse() {
            return Ok(Self::Index(index));
        }
        let kind = AdapterKind::NAMES.iter().find(|(_, name)| *name == text);
        Ok(kind.map_or(Self::Name(text), |(kind, _)| Self::Kind(*kind)))
    }
}

impl fmt::Display for AdapterChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Index(index) => write!(f, "{index}"),
            Self::Kind(kind) => write!(f, "{kind}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

/// One adapter and its fitness.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AdapterReport {
    /// Number that selects it.
    pub index: usize,
    /// Name that its driver gives it.
    pub name: String,
    /// Kind of processor.
    pub kind: AdapterKind,
    /// Graphics interface by which it is reached.
    pub api: String,
    /// Driver and its version.
    pub driver: String,
    /// Largest buffer that a kernel can use, bytes.
    pub max_binding_bytes: u64,
    /// What it lacks; empty if it can run the kernels.
    pub missing: Vec<String>,
}

impl AdapterReport {
    /// True if it can run the kernels.
    pub fn is_fit(&self) -> bool {
        self.missing.is_empty()
    }

    fn new(index: usize, adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let limits = adapter.limits();
        Self {
            index,
            name: info.name,
            kind: info.device_type.into(),
            api: format!("{:?}", info.backend),
            driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
            max_binding_bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            missing: missing(adapter, &limits),
        }
    }

    pub(super) fn matches(&self, choice: &AdapterChoice) -> bool {
        match choice {
            AdapterChoice::Auto => true,
            AdapterChoice::Index(index) => self.index == *index,
            AdapterChoice::Kind(kind) => self.kind == *kind,
            AdapterChoice::Name(part) => self.name.to_lowercase().contains(part),
        }
    }
}

/// What the kernels need and an adapter does not have.
fn missing(adapter: &wgpu::Adapter, limits: &wgpu::Limits) -> Vec<String> {
    let most = |of: &dyn Fn(&Shader) -> u32| SHADERS.iter().map(|shader| of(shader)).max().unwrap_or(0);
    let slots = |shader: &Shader, uniform: bool| {
        shader.slots.iter().filter(|slot| (slot.access == Access::Uniform) == uniform).count() as u32
    };
    let needs = [
        ("storage buffers a kernel", most(&|s| slots(s, false)), limits.max_storage_buffers_per_shader_stage),
        ("uniform buffers a kernel", most(&|s| slots(s, true)), limits.max_uniform_buffers_per_shader_stage),
        (
            "invocations a workgroup",
            most(&|s| s.workgroup.iter().product()),
            limits.max_compute_invocations_per_workgroup,
        ),
        ("bytes of workgroup memory", most(&|s| s.workgroup_bytes), limits.max_compute_workgroup_storage_size),
    ];
    let mut missing = Vec::new();
    if !adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        missing.push("compute shaders".into());
    }
    for (what, need, have) in needs {
        if have < need {
            missing.push(format!("{need} {what} (it has {have})"));
        }
    }
    let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if binding < LEAST_BINDING {
        missing.push(format!("buffers of {} MiB (it has {})", LEAST_BINDING >> 20, binding >> 20));
    }
    missing
}

pub(super) fn instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle())
}

pub(super) fn enumerate(instance: &wgpu::Instance) -> Vec<(AdapterReport, wgpu::Adapter)> {
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.into_iter().enumerate().map(|(i, adapter)| (AdapterReport::new(i, &adapter), adapter)).collect()
}

/// All adapters of this machine.
pub fn adapters() -> Vec<AdapterReport> {
    enumerate(&instance()).into_iter().map(|(report, _)| report).collect()
}
