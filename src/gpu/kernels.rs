//! The kernels that the build found in `shaders/`: generated, see `build/generate.rs`.

use super::buffer::{Read, Uniform, Write};
use super::device::{Gpu, GpuError};
use super::kernel::{Access, Kernel, Shader, Slot, Step, compile_all};
use super::layout::*;

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
