//! Shaders of pictures: `shaders/raster/NAME.wgsl` with the vertex and fragment stages of one kind of pass.
//!
//! They are checked and translated as the kernels are. Their names and entry points become constants, so that one that
//! is missing does not compile. Constants and the layouts of structs are compared with those of the host.

use crate::check::{check, report};
use crate::compose::{Composed, File, Library};
use crate::generate::{write_constants, write_layouts};
use crate::reflect::{Layout, constants, structs};
use naga::proc::Layouter;
use naga::valid::ModuleInfo;
use naga::{AddressSpace, Module, ShaderStage};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// One shader as the host sees it.
#[derive(Clone, Debug)]
pub struct Raster {
    /// Name of its file.
    pub name: String,
    /// WGSL without imports.
    pub source: String,
    /// Names of its stages.
    pub stages: Vec<String>,
    /// Structs that its buffers hold, by name.
    pub structs: BTreeMap<String, Layout>,
    /// Names, types and values of all constants.
    pub constants: BTreeSet<(String, String)>,
}

/// All shaders of pictures, and all errors; `translate` as for kernels.
pub fn rasters(
    library: &Library,
    translate: impl Fn(&Composed, &Module, &ModuleInfo) -> Vec<String>,
) -> (Vec<Raster>, Vec<String>) {
    let (mut rasters, mut errors) = (Vec::new(), Vec::new());
    for (name, file) in &library.rasters {
        let raster = library.compose_file(name, file).and_then(|shader| {
            let (module, info) = check(&shader)?;
            let raster = reflect(&shader, &module)?;
            let errors = translate(&shader, &module, &info);
            if errors.is_empty() { Ok(raster) } else { Err(errors) }
        });
        match raster {
            Ok(raster) => rasters.push(raster),
            Err(found) => errors.extend(found),
        }
    }
    (rasters, errors)
}

fn reflect(shader: &Composed, module: &Module) -> Result<Raster, Vec<String>> {
    let fail = |message: &str| Err(vec![report(shader, message, [])]);
    let stages = || module.entry_points.iter().map(|entry| entry.stage);
    if !stages().any(|stage| stage == ShaderStage::Vertex) {
        return fail("a shader of pictures has a vertex stage");
    }
    if stages().any(|stage| !matches!(stage, ShaderStage::Vertex | ShaderStage::Fragment)) {
        return fail("a shader of pictures has vertex and fragment stages only");
    }
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).map_err(|error| vec![report(shader, &error.to_string(), [])])?;
    let mut found = BTreeMap::new();
    for (_, variable) in module.global_variables.iter() {
        if matches!(variable.space, AddressSpace::Uniform | AddressSpace::Storage { .. }) {
            structs(module, &layouter, variable.ty, &mut found);
        }
    }
    Ok(Raster {
        name: shader.name.clone(),
        source: shader.source.clone(),
        stages: module.entry_points.iter().map(|entry| entry.name.clone()).collect(),
        structs: found,
        constants: constants(module),
    })
}

/// Rust source; the module that includes it has every struct of the shaders in scope.
pub fn source(rasters: &[Raster], constants: &[File]) -> String {
    let mut out = String::new();
    write(&mut out, rasters, constants).expect("writing to a string");
    out
}

fn write(out: &mut String, rasters: &[Raster], constants: &[File]) -> std::fmt::Result {
    for Raster { name, source, stages, .. } in rasters {
        writeln!(out, "/// `shaders/raster/{name}.wgsl`\npub mod {name} {{")?;
        writeln!(out, "    pub const SOURCE: &str = {source:?};")?;
        for stage in stages {
            writeln!(out, "    pub const {}: &str = {stage:?};", stage.to_uppercase())?;
        }
        writeln!(out, "}}\n")?;
    }
    writeln!(out, "const _: () = {{\n    use std::mem::offset_of;")?;
    write_layouts(
        out,
        rasters.iter().flat_map(|raster| &raster.structs).map(|(name, layout)| (name.as_str(), layout)),
    )?;
    writeln!(out, "}};\n")?;
    write_constants(out, rasters.iter().flat_map(|raster| &raster.constants), constants)
}
