//! Reads off checked shaders what the host must know: workgroup sizes, bindings, struct layouts, constants.
//!
//! The conventions are enforced here: one compute entry point `main`, bindings of group 0 numbered from 0 in the order
//! of their declaration, each used as declared.

use crate::check::{check, report};
use crate::compose::{Composed, Library};
use naga::proc::Layouter;
use naga::valid::{GlobalUse, ModuleInfo};
use naga::{
    AddressSpace, Expression, Handle, Literal, Module, Scalar, ScalarKind, ShaderStage, StorageAccess, Type, TypeInner,
    VectorSize,
};
use std::collections::{BTreeMap, BTreeSet};

/// How a kernel uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Small, the same for all invocations.
    Uniform,
    /// Read.
    Read,
    /// Read and written.
    Write,
}

/// One buffer of a kernel; its binding number is its index.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// Name of the variable.
    pub name: String,
    /// How it is used.
    pub access: Access,
    /// Rust type of an element.
    pub element: String,
    /// Bytes of an element.
    pub bytes: u32,
}

/// How a struct lies in memory.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Layout {
    /// Size.
    pub bytes: u32,
    /// Name and offset of each member.
    pub members: Vec<(String, u32)>,
}

/// One kernel as the host sees it.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// Name of its file.
    pub name: String,
    /// WGSL without imports.
    pub source: String,
    /// Invocations of a workgroup.
    pub workgroup: [u32; 3],
    /// Bytes of workgroup memory.
    pub workgroup_bytes: u32,
    /// Buffers.
    pub bindings: Vec<Binding>,
    /// Structs that buffers hold, by name.
    pub structs: BTreeMap<String, Layout>,
    /// Names, types and values of all constants.
    pub constants: BTreeSet<(String, String)>,
}

/// All kernels of a library, and all errors. `translate` tells what other platforms have against a shader that is
/// valid.
pub fn kernels(
    library: &Library,
    translate: impl Fn(&Composed, &Module, &ModuleInfo) -> Vec<String>,
) -> (Vec<Kernel>, Vec<String>) {
    let (mut kernels, mut errors) = (Vec::new(), Vec::new());
    for name in library.kernels.keys() {
        let kernel = library.compose(name).and_then(|shader| {
            let (module, info) = check(&shader)?;
            let kernel = reflect(&shader, &module, &info)?;
            let errors = translate(&shader, &module, &info);
            if errors.is_empty() { Ok(kernel) } else { Err(errors) }
        });
        match kernel {
            Ok(kernel) => kernels.push(kernel),
            Err(found) => {
                // A fault in a shared module is told once, not once a kernel.
                errors.extend(found.into_iter().filter(|error| !errors.contains(error)).collect::<Vec<_>>());
            }
        }
    }
    (kernels, errors)
}

fn reflect(shader: &Composed, module: &Module, info: &ModuleInfo) -> Result<Kernel, Vec<String>> {
    let fail = |message: &str| Err(vec![report(shader, message, [])]);
    let [entry] = module.entry_points.as_slice() else {
        return fail("a shader has one entry point");
    };
    if entry.name != "main" || entry.stage != ShaderStage::Compute {
        return fail("the entry point is a compute shader called `main`");
    }
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).map_err(|error| vec![report(shader, &error.to_string(), [])])?;
    let mut kernel = Kernel {
        name: shader.name.clone(),
        source: shader.source.clone(),
        workgroup: entry.workgroup_size,
        workgroup_bytes: 0,
        bindings: Vec::new(),
        structs: BTreeMap::new(),
        constants: constants(module),
    };
    let mut errors = Vec::new();
    for (handle, variable) in module.global_variables.iter() {
        let mut fail = |message: String| {
            errors.push(report(shader, &message, [(module.global_variables.get_span(handle), String::new())]));
        };
        if variable.space == AddressSpace::WorkGroup {
            kernel.workgroup_bytes += layouter[variable.ty].size;
        }
        let Some(place) = &variable.binding else { continue };
        if (place.group, place.binding as usize) != (0, kernel.bindings.len()) {
            fail(format!("bindings are numbered in order: expected group 0, binding {}", kernel.bindings.len()));
        }
        let used = info.get_entry_point(0)[handle];
        let access = match variable.space {
            AddressSpace::Uniform => Access::Uniform,
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Access::Write,
            _ => Access::Read,
        };
        if used.is_empty() {
            fail("this buffer is never used".into());
        } else if access == Access::Write && !used.contains(GlobalUse::WRITE) {
            fail("this buffer is never written: declare it `read`".into());
        }
        let element = match module.types[variable.ty].inner {
            TypeInner::Array { base, .. } => base,
            _ => variable.ty,
        };
        match rust_type(module, element) {
            Some(rust) => kernel.bindings.push(Binding {
                name: rust_name(&variable.name),
                access,
                element: rust,
                bytes: layouter[element].to_stride(),
            }),
            None => fail("buffers hold structs, f32, u32, or vectors of two or four of them".into()),
        }
        structs(module, &layouter, element, &mut kernel.structs);
    }
    if errors.is_empty() { Ok(kernel) } else { Err(errors) }
}

/// WGSL reserves more words than Rust; there they end in an underscore.
fn rust_name(name: &Option<String>) -> String {
    name.as_deref().unwrap_or_default().trim_end_matches('_').into()
}

/// The Rust type that an element is stored as; structs have the same name.
fn rust_type(module: &Module, handle: Handle<Type>) -> Option<String> {
    const U32: Scalar = Scalar { kind: ScalarKind::Uint, width: 4 };
    let ty = &module.types[handle];
    Some(match ty.inner {
        TypeInner::Struct { .. } => ty.name.clone()?,
        TypeInner::Scalar(Scalar::F32) => "f32".into(),
        TypeInner::Scalar(U32) | TypeInner::Atomic(U32) => "u32".into(),
        TypeInner::Vector { size: VectorSize::Bi, scalar: U32 } => "[u32; 2]".into(),
        TypeInner::Vector { size: VectorSize::Quad, scalar: U32 } => "[u32; 4]".into(),
        TypeInner::Vector { size: VectorSize::Quad, scalar: Scalar::F32 } => "glam::Vec4".into(),
        _ => return None,
    })
}

/// Collects the layout of a struct and of the structs in it.
pub fn structs(module: &Module, layouter: &Layouter, handle: Handle<Type>, out: &mut BTreeMap<String, Layout>) {
    let ty = &module.types[handle];
    match &ty.inner {
        TypeInner::Array { base, .. } => structs(module, layouter, *base, out),
        TypeInner::Struct { members, .. } => {
            for member in members {
                structs(module, layouter, member.ty, out);
            }
            let members = members.iter().map(|member| (rust_name(&member.name), member.offset)).collect();
            let layout = Layout { bytes: layouter[handle].size, members };
            out.insert(ty.name.clone().unwrap_or_default(), layout);
        }
        _ => {}
    }
}

/// Names, types and values of all scalar constants.
pub fn constants(module: &Module) -> BTreeSet<(String, String)> {
    module.constants.iter().filter_map(|(_, constant)| value(module, constant)).collect()
}

/// A scalar constant as the Rust item `NAME: TYPE = VALUE`.
fn value(module: &Module, constant: &naga::Constant) -> Option<(String, String)> {
    let text = match module.global_expressions[constant.init] {
        // Bits, because a decimal might round.
        Expression::Literal(Literal::F32(x)) => format!("f32 = f32::from_bits({:#010x})", x.to_bits()),
        Expression::Literal(Literal::U32(x)) => format!("u32 = {x}"),
        Expression::Literal(Literal::I32(x)) => format!("i32 = {x}"),
        _ => return None,
    };
    Some((constant.name.clone()?, text))
}
