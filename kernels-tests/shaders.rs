//! The build step that reads the shaders: what it finds out, what it refuses, and errors that say where.
//!
//! That every shader translates for every platform is part of the step itself, see `build/translate.rs`.

#![allow(missing_docs, clippy::unwrap_used)]

#[allow(dead_code)]
#[path = "../build/check.rs"]
mod check;
#[allow(dead_code)]
#[path = "../build/compose.rs"]
mod compose;
#[path = "../build/generate.rs"]
mod generate;
#[path = "../build/raster.rs"]
mod raster;
#[allow(dead_code)]
#[path = "../build/reflect.rs"]
mod reflect;

use compose::{File, Library};
use reflect::{Access, Kernel};
use std::collections::BTreeMap;
use std::path::Path;

fn shipped() -> Library {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let constants = ["src/world/constants.rs", "src/render/shading.rs"];
    Library::read(&root.join("shaders"), &constants.map(|path| File::read(&root.join(path)).unwrap())).unwrap()
}

fn file(path: &str, text: &str) -> File {
    File { path: path.into(), text: text.into() }
}

/// A library of two files, `kernel.wgsl` and `shared/module.wgsl`.
fn library(kernel: &str, module: &str) -> Library {
    let mut library = Library::default();
    library.kernels.insert("kernel".into(), file("kernel.wgsl", kernel));
    library.shared.insert("module".into(), file("shared/module.wgsl", module));
    library
}

fn kernels(library: &Library) -> (Vec<Kernel>, Vec<String>) {
    reflect::kernels(library, |_, _, _| Vec::new())
}

fn errors(kernel: &str, module: &str) -> String {
    kernels(&library(kernel, module)).1.join("\n")
}

const GOOD: &str = "
@group(0) @binding(0) var<storage, read> source: array<u32>;
@group(0) @binding(1) var<storage, read_write> target_: array<u32>;
@compute @workgroup_size(8, 2)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    target_[id.x] = source[id.x];
}";

#[test]
fn constants_have_their_rust_values() {
    let library = shipped();
    for module in ["constants", "shading"].map(|name| &library.shared[name]) {
        let rust = std::fs::read_to_string(&module.path).unwrap();
        let count = compose::rust_constants(&rust).count();
        assert_eq!(count, rust.matches("pub const ").count());
        for (name, _, _) in compose::rust_constants(&rust) {
            let line = |text: &str, word: String| text.lines().position(|line| line.starts_with(&word)).unwrap();
            let [ours, theirs] =
                [line(&module.text, format!("const {name}:")), line(&rust, format!("pub const {name}:"))];
            assert_eq!(ours, theirs, "errors in {name} would point to the wrong line");
        }
        // The values themselves are compared when the library is compiled.
        let used = naga::front::wgsl::parse_str(&module.text).unwrap();
        assert_eq!(used.constants.len(), count);
    }
}

#[test]
fn a_kernel_is_reflected() {
    let (kernels, errors) = kernels(&library(GOOD, ""));
    assert!(errors.is_empty(), "{errors:?}");
    let kernel = &kernels[0];
    assert_eq!((kernel.name.as_str(), kernel.workgroup), ("kernel", [8, 2, 1]));
    let slots: Vec<_> = kernel.bindings.iter().map(|b| (b.name.as_str(), b.access, b.element.as_str())).collect();
    assert_eq!(slots, [("source", Access::Read, "u32"), ("target", Access::Write, "u32")]);
}

/// What is generated names every kernel, buffer and member, so that a change of any of them does not compile.
#[test]
fn the_generated_code_checks_names_types_and_layouts() {
    let (kernels, _) = kernels(&shipped());
    let constants = file("src/world/constants.rs", "pub const TOUCHING_DEPTH: f32 = 1e-3;");
    let code = generate::source(&kernels, &[constants]);
    for line in [
        "pub place: Kernel,",
        "pub struct PlaceBuffers<'a> {",
        "pub deltas: Read<'a, f32>,",
        "pub placed: Write<'a, Pose>,",
        "assert!(size_of::<Pose>() == 32,",
        "assert!(offset_of!(Pose, translation) == 16,",
        "assert!(offset_of!(Energy, layout) == 16,",
        "assert!(constants::TOUCHING_DEPTH == crate::world::constants::TOUCHING_DEPTH,",
    ] {
        assert!(code.contains(line), "{line}");
    }
}

/// Every kernel has its twin, a file of its name or the one that its first lines name as `cpu::…`, and a test, a file
/// of its name or one that names it in its first lines.
#[test]
fn every_kernel_has_its_twin_and_its_test() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tests: Vec<String> = std::fs::read_dir(root.join("kernels-tests/gpu"))
        .unwrap()
        .map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap())
        .collect();
    for (name, file) in &shipped().kernels {
        let head = file.text.lines().take_while(|line| line.starts_with("//"));
        let head: String = head.map(|line| line.trim_start_matches("//")).collect();
        let named = head.split("`cpu::").nth(1).and_then(|rest| rest.split('`').next()).unwrap_or(name);
        let exists = |path: &Path| path.with_extension("rs").is_file() || path.join("mod.rs").is_file();
        let twin = root.join("src/cpu").join(named.split("::").next().unwrap());
        assert!(exists(&twin), "{name}: {} is missing", twin.display());
        let own = root.join("kernels-tests/gpu").join(name).with_extension("rs").is_file();
        let is_named = |test: &String| {
            test.lines().take_while(|line| line.starts_with("//!")).any(|line| line.contains(&format!("`{name}`")))
        };
        assert!(own || tests.iter().any(is_named), "{name}: no test names it");
    }
}

/// The tables of buffers in `docs/gpu.md` state the size of every struct, but of two that they tell in words. What a
/// struct takes in a shader it takes in Rust, or the build fails.
#[test]
fn the_documented_sizes_are_those_of_the_structs() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/gpu.md")).unwrap();
    let tables = text.split("| buffer | element, bytes |").skip(1);
    let mut documented: Vec<(&str, u32)> = Vec::new();
    for row in tables.flat_map(|table| table.lines().take_while(|line| line.contains('|'))) {
        // Names in code, and what follows each.
        let pieces: Vec<&str> = row.split('`').skip(1).collect();
        for piece in pieces.chunks_exact(2) {
            let digits = piece[1].trim_start().split(|c: char| !c.is_ascii_digit()).next().unwrap();
            documented.extend(digits.parse::<u32>().map(|bytes| (piece[0], bytes)));
        }
    }
    let (kernels, _) = kernels(&shipped());
    let mut actual = BTreeMap::new();
    for Kernel { bindings, structs, .. } in &kernels {
        let elements = bindings.iter().filter(|binding| structs.contains_key(&binding.element));
        actual.extend(elements.map(|binding| (binding.element.as_str(), binding.bytes)));
    }
    for (name, bytes) in &documented {
        assert_eq!(Some(bytes), actual.get(name), "{name}");
    }
    let untold = actual.keys().filter(|name| documented.iter().all(|(told, _)| told != *name));
    assert_eq!(untold.collect::<Vec<_>>(), [&"Preference", &"Sim"]);
}

/// Shaders of pictures are held to the same layouts, and have the stages of a raster pass and no others.
#[test]
fn shaders_of_pictures_are_reflected_and_checked() {
    let (rasters, errors) = raster::rasters(&shipped(), |_, _, _| Vec::new());
    assert!(errors.is_empty(), "{errors:?}");
    let shading = file("src/render/shading.rs", "pub const LINE: f32 = 0.0015;");
    let code = raster::source(&rasters, &[shading]);
    for line in [
        "pub mod picture {",
        "pub const SOLID: &str = \"solid\";",
        "assert!(offset_of!(Vertex, uv) == 16,",
        "assert!(constants::LINE == crate::render::shading::LINE,",
    ] {
        assert!(code.contains(line), "{line}");
    }
    const STAGE: &str = "@vertex fn vertex() -> @builtin(position) vec4<f32> { return vec4(0.0); }";
    for (text, complaint) in [
        (GOOD.to_owned(), "has a vertex stage"),
        (format!("{STAGE}{GOOD}"), "vertex and fragment stages only"),
        (STAGE.replace("vec4(0.0)", "nothing"), "picture.wgsl:1:"),
        (STAGE.replace("return", "for (;;) {} return"), "only bounded `for` loops"),
    ] {
        let mut library = Library::default();
        library.rasters.insert("picture".into(), File { path: "picture.wgsl".into(), text });
        let (_, errors) = raster::rasters(&library, |_, _, _| Vec::new());
        assert!(errors.join("\n").contains(complaint), "{complaint}: {errors:?}");
    }
}

#[test]
fn a_translation_that_fails_is_an_error() {
    let (kernels, errors) = reflect::kernels(&library(GOOD, ""), |_, _, _| vec!["not on this platform".into()]);
    assert!(kernels.is_empty());
    assert_eq!(errors, ["not on this platform"]);
}

#[test]
fn imports_are_taken_once_and_nest() {
    let mut library = library("#import module\n#import module\n#import other\nlast", "#import other\nmiddle");
    library.shared.insert("other".into(), File { path: "shared/other.wgsl".into(), text: "first".into() });
    let composed = library.compose("kernel").unwrap();
    assert_eq!(composed.source, "first\nmiddle\nlast\n");
    let places: Vec<_> = composed.origins.iter().map(|o| (o.file.as_str(), o.line)).collect();
    assert_eq!(places, [("shared/other.wgsl", 1), ("shared/module.wgsl", 2), ("kernel.wgsl", 4)]);
}

#[test]
fn an_unknown_import_is_an_error() {
    let text = errors("\n#import modul\n", "");
    assert!(text.contains("unknown import `modul`") && text.contains("kernel.wgsl:2"), "{text}");
}

#[test]
fn errors_point_into_the_file_that_has_them() {
    let text = errors(&format!("#import module\n{GOOD}"), "fn one() -> u32 {\n    return 1.5;\n}");
    assert!(text.contains("shared/module.wgsl:2:"), "{text}");
    let text = errors(&GOOD.replace("source[id.x]", "sauce[id.x]"), "");
    assert!(text.contains("kernel.wgsl:6:") && text.contains("^^^^^ "), "{text}");
}

#[test]
fn the_errors_of_all_shaders_are_collected() {
    let mut library = library("fn main() { missing(); }", "");
    library.kernels.insert("second".into(), File { path: "second.wgsl".into(), text: "#import nothing".into() });
    let (_, errors) = kernels(&library);
    assert_eq!(errors.len(), 2, "{errors:?}");
    assert!(errors[0].contains("kernel.wgsl:1:") && errors[1].contains("second.wgsl:1"), "{errors:?}");
}

#[test]
fn conventions_are_enforced() {
    for (from, to, complaint) in [
        ("target_[id.x] =", "while (true) {} target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] =", "for (;;) { break; } target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] =", "loop { break; } target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] =", "for(var i = 0u; ; i += 1u) {} target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] =", "for (var i = 0u; i < 2u; ) {} target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] =", "for (var i = 0u; i < 9u; i = 0u) {} target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] =", "for (var i = 0u; i < 9u; i++) { i = 0u; } target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] =", "for (var i = 0u; true; i += 1u) {} target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] =", "for (var i = 0u; id.y < 1u; i += 1u) {} target_[id.x] =", "only bounded `for` loops"),
        ("target_[id.x] = source[id.x]", "target_[id.x] = 1u", "never used"),
        ("target_[id.x] = source[id.x]", "let x = target_[source[id.x]]", "never written"),
        ("binding(1)", "binding(2)", "expected group 0, binding 1"),
        ("fn main", "fn start", "called `main`"),
        ("array<u32>", "array<mat3x3<f32>>", "buffers hold"),
        ("target_[id.x] =", "let x = f16(1.0); target_[id.x] =", "f16"),
    ] {
        let text = errors(&GOOD.replace(from, to), "");
        assert!(text.contains(complaint), "{to}: {text}");
    }
}
