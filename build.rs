//! Turns `shaders/*.wgsl` into `$OUT_DIR/shaders.rs` and `shaders/raster/*.wgsl` into `$OUT_DIR/raster.rs`, or fails
//! with every error of every shader.

#[path = "build/check.rs"]
mod check;
#[path = "build/compose.rs"]
mod compose;
#[path = "build/generate.rs"]
mod generate;
#[path = "build/raster.rs"]
mod raster;
#[path = "build/reflect.rs"]
mod reflect;
#[path = "build/translate.rs"]
mod translate;

use std::path::Path;
use std::process::ExitCode;
use std::{env, fs};

fn main() -> ExitCode {
    const CONSTANTS: [&str; 2] = ["src/world/constants.rs", "src/render/shading.rs"];
    for input in ["build.rs", "build", "shaders"].into_iter().chain(CONSTANTS) {
        println!("cargo::rerun-if-changed={input}");
    }
    // Tests that need the files beside the project show as ignored where these are absent.
    println!("cargo::rustc-check-cfg=cfg(shared_files)");
    if Path::new("../shared/scenes").is_dir() {
        println!("cargo::rustc-cfg=shared_files");
    }
    let constants = CONSTANTS.map(|path| compose::File::read(Path::new(path)));
    let constants = constants.map(|file| file.expect("the constants belong to this package"));
    let library = compose::Library::read(Path::new("shaders"), &constants).expect("the shaders belong to this package");
    let (kernels, mut errors) = reflect::kernels(&library, translate::translate);
    let (rasters, found) = raster::rasters(&library, translate::translate);
    errors.extend(found);
    for error in &errors {
        eprintln!("{error}");
    }
    if !errors.is_empty() {
        eprintln!("{} errors in shaders", errors.len());
        return ExitCode::FAILURE;
    }
    let out = env::var_os("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join("shaders.rs"), generate::source(&kernels, &constants))
        .expect("cargo's folder can be written");
    fs::write(Path::new(&out).join("raster.rs"), raster::source(&rasters, &constants))
        .expect("cargo's folder can be written");
    ExitCode::SUCCESS
}
