//! Writes the Rust side of the kernels: a struct with one field a kernel, a struct with one field a buffer for each,
//! and checks at compile time that structs and constants are the same in both languages.

use crate::compose::{File, rust_constants};
use crate::reflect::{Access, Binding, Kernel, Layout};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Rust source; the module that includes it has `Kernel`, `Gpu`, `GpuError`, `Step`, `Shader`, `Slot`, `Access`, the
/// buffer types `Uniform`, `Read` and `Write`, and every struct of the shaders in scope.
pub fn source(kernels: &[Kernel], constants: &[File]) -> String {
    let mut out = String::new();
    write_kernels(&mut out, kernels).expect("writing to a string");
    for kernel in kernels {
        write_kernel(&mut out, kernel).expect("writing to a string");
    }
    write_checks(&mut out, kernels, constants).expect("writing to a string");
    out
}

fn write_kernels(out: &mut String, kernels: &[Kernel]) -> std::fmt::Result {
    let names: Vec<&str> = kernels.iter().map(|kernel| kernel.name.as_str()).collect();
    writeln!(out, "/// All compiled kernels.\npub struct Kernels {{")?;
    for name in &names {
        writeln!(out, "    /// `shaders/{name}.wgsl`\n    pub {name}: Kernel,")?;
    }
    writeln!(out, "}}\n\nimpl Kernels {{")?;
    writeln!(
        out,
        "    /// Compiles all kernels, in parallel.\n    ///\n    /// # Errors\n    /// If the driver refuses one."
    )?;
    writeln!(out, "    pub fn compile(gpu: &Gpu) -> Result<Self, GpuError> {{")?;
    writeln!(out, "        let [{}] = compile_all(gpu, SHADERS)?;", names.join(", "))?;
    writeln!(out, "        Ok(Self {{ {} }})\n    }}\n}}\n", names.join(", "))?;
    writeln!(out, "/// Every shader, in alphabetical order.\npub const SHADERS: [&Shader; {}] = [", names.len())?;
    for name in &names {
        writeln!(out, "    &{}Buffers::SHADER,", camel(name))?;
    }
    writeln!(out, "];\n")
}

fn write_kernel(out: &mut String, kernel: &Kernel) -> std::fmt::Result {
    let name = camel(&kernel.name);
    writeln!(out, "/// Buffers of kernel `{}`.\n#[derive(Clone, Copy)]\npub struct {name}Buffers<'a> {{", kernel.name)?;
    for Binding { name, access, element, .. } in &kernel.bindings {
        writeln!(out, "    /// `{name}`\n    pub {name}: {access:?}<'a, {element}>,")?;
    }
    writeln!(out, "}}\n\nimpl {name}Buffers<'_> {{\n    /// What the shader says of itself.")?;
    writeln!(out, "    pub const SHADER: Shader = Shader {{\n        name: {:?},", kernel.name)?;
    writeln!(out, "        source: {:?},", kernel.source)?;
    writeln!(out, "        workgroup: {:?},", kernel.workgroup)?;
    writeln!(out, "        workgroup_bytes: {},\n        slots: &[", kernel.workgroup_bytes)?;
    for Binding { name, access, bytes, .. } in &kernel.bindings {
        let access = match access {
            Access::Uniform => "Uniform",
            Access::Read => "Read",
            Access::Write => "Write",
        };
        writeln!(out, "            Slot {{ name: {name:?}, access: Access::{access}, bytes: {bytes} }},")?;
    }
    writeln!(out, "        ],\n    }};\n")?;
    writeln!(out, "    /// The kernel on these buffers, with at least so many invocations.")?;
    writeln!(out, "    pub fn step(&self, gpu: &Gpu, kernels: &Kernels, invocations: u32) -> Step {{")?;
    let fields: Vec<String> = kernel.bindings.iter().map(|slot| format!("self.{}.0", slot.name)).collect();
    writeln!(out, "        kernels.{}.step(gpu, &[{}], invocations)\n    }}\n}}\n", kernel.name, fields.join(", "))
}

fn write_checks(out: &mut String, kernels: &[Kernel], constants: &[File]) -> std::fmt::Result {
    let mut structs: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for (name, layout) in kernels.iter().flat_map(|kernel| &kernel.structs) {
        structs.entry(name).or_default().insert(layout);
    }
    writeln!(out, "const _: () = {{\n    use std::mem::offset_of;")?;
    let structs = structs.iter().flat_map(|(name, all)| all.iter().map(move |one| (name.as_str(), *one)));
    write_layouts(out, structs)?;
    for Binding { element, bytes, .. } in kernels.iter().flat_map(|kernel| &kernel.bindings) {
        writeln!(out, "    assert!(size_of::<{element}>() == {bytes}, \"stride of {element}\");")?;
    }
    writeln!(out, "}};\n")?;
    write_constants(out, kernels.iter().flat_map(|kernel| &kernel.constants), constants)
}

/// Compile-time checks that the constants of Rust files are what naga makes of them, and all that it found.
pub fn write_constants<'a>(
    out: &mut String,
    found: impl Iterator<Item = &'a (String, String)>,
    files: &[File],
) -> std::fmt::Result {
    let found: BTreeSet<_> = found.collect();
    writeln!(out, "const _: () = {{")?;
    for File { path, text } in files {
        let module = path.trim_start_matches("src/").trim_end_matches(".rs").replace('/', "::");
        for (name, kind, _) in rust_constants(text) {
            if found.iter().any(|(known, _)| known == name) {
                let cast = if kind == "usize" { " as u32" } else { "" };
                writeln!(out, "    assert!(constants::{name} == crate::{module}::{name}{cast}, \"{name}\");")?;
            }
        }
    }
    writeln!(out, "}};\n")?;
    writeln!(out, "/// The constants of all shaders, as naga evaluates them.\npub mod constants {{")?;
    for (name, value) in found {
        writeln!(out, "    #[allow(missing_docs)]\n    pub const {name}: {value};")?;
    }
    writeln!(out, "}}")
}

/// Compile-time checks that structs lie in memory as the shaders say.
pub fn write_layouts<'a>(out: &mut String, structs: impl Iterator<Item = (&'a str, &'a Layout)>) -> std::fmt::Result {
    for (name, Layout { bytes, members }) in structs {
        writeln!(out, "    assert!(size_of::<{name}>() == {bytes}, \"size of {name}\");")?;
        for (member, offset) in members {
            writeln!(out, "    assert!(offset_of!({name}, {member}) == {offset}, \"{name}::{member}\");")?;
        }
    }
    Ok(())
}

/// `broad_phase` → `BroadPhase`.
fn camel(name: &str) -> String {
    name.split('_').map(|word| word[..1].to_uppercase() + &word[1..]).collect()
}
