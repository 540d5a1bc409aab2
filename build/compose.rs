//! Puts a shader together from its file and the shared modules that it names with `#import NAME`.
//!
//! An imported module replaces the first line that names it; later imports of the same one are dropped, so every
//! definition occurs once. A file of Rust constants is such a module, too: `#import constants` is made from
//! `src/world/constants.rs`, so that no tolerance is written twice. Every line keeps its origin, because errors are
//! told where the author wrote them.

use std::collections::BTreeMap;
use std::path::Path;
use std::{fs, io};

/// A line's place in the sources.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// Path of the file.
    pub file: String,
    /// Counted from 1.
    pub line: usize,
}

/// A shader without imports.
#[derive(Clone, Debug)]
pub struct Composed {
    /// Name of its file without the ending.
    pub name: String,
    /// WGSL.
    pub source: String,
    /// Where each line of `source` comes from.
    pub origins: Vec<Origin>,
}

/// A file of WGSL with imports, or of Rust constants.
#[derive(Clone, Debug)]
pub struct File {
    /// As shown in errors.
    pub path: String,
    /// What it holds.
    pub text: String,
}

impl File {
    /// Reads it.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(path: &Path) -> io::Result<Self> {
        Ok(Self { path: path.display().to_string(), text: fs::read_to_string(path)? })
    }

    /// What it is imported by.
    fn name(&self) -> String {
        Path::new(&self.path).file_stem().unwrap_or_default().to_string_lossy().into()
    }
}

/// All shader sources.
#[derive(Clone, Debug, Default)]
pub struct Library {
    /// One kernel a file.
    pub kernels: BTreeMap<String, File>,
    /// Vertex and fragment shaders, the stages of one kind of picture a file.
    pub rasters: BTreeMap<String, File>,
    /// What kernels import.
    pub shared: BTreeMap<String, File>,
}

impl Library {
    /// Reads `folder/*.wgsl`, `folder/raster/*.wgsl` and `folder/shared/*.wgsl`; `constants` are shared, too.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn read(folder: &Path, constants: &[File]) -> io::Result<Self> {
        let mut shared = files(&folder.join("shared"))?;
        for file in constants {
            shared.insert(file.name(), File { path: file.path.clone(), text: translate_constants(&file.text) });
        }
        Ok(Self { kernels: files(folder)?, rasters: files(&folder.join("raster"))?, shared })
    }

    /// Puts one kernel together; the errors say which import is unknown, and where.
    pub fn compose(&self, name: &str) -> Result<Composed, Vec<String>> {
        self.compose_file(name, &self.kernels[name])
    }

    /// Puts any file together.
    pub fn compose_file(&self, name: &str, file: &File) -> Result<Composed, Vec<String>> {
        let mut composed = Composed { name: name.into(), source: String::new(), origins: Vec::new() };
        let (mut seen, mut errors) = (Vec::new(), Vec::new());
        self.append(file, &mut composed, &mut seen, &mut errors);
        if errors.is_empty() { Ok(composed) } else { Err(errors) }
    }

    fn append<'a>(&'a self, file: &'a File, out: &mut Composed, seen: &mut Vec<&'a str>, errors: &mut Vec<String>) {
        for (index, text) in file.text.lines().enumerate() {
            let origin = Origin { file: file.path.clone(), line: index + 1 };
            let Some(import) = text.trim().strip_prefix("#import").map(str::trim) else {
                out.source.push_str(text);
                out.source.push('\n');
                out.origins.push(origin);
                continue;
            };
            if seen.contains(&import) {
                continue;
            }
            seen.push(import);
            match self.shared.get(import) {
                Some(module) => self.append(module, out, seen, errors),
                None => {
                    let known: Vec<&str> = self.shared.keys().map(String::as_str).collect();
                    errors.push(format!(
                        "error: unknown import `{import}`\n  --> {}:{}\n  known: {}\n",
                        origin.file,
                        origin.line,
                        known.join(", ")
                    ));
                }
            }
        }
    }
}

fn files(folder: &Path) -> io::Result<BTreeMap<String, File>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|ending| ending == "wgsl") {
            let file = File::read(&path)?;
            files.insert(file.name(), file);
        }
    }
    Ok(files)
}

/// The names, types and values of `pub const NAME: TYPE = VALUE;`.
pub fn rust_constants(source: &str) -> impl Iterator<Item = (&str, &str, &str)> {
    source.split("pub const ").skip(1).filter_map(|rest| {
        let (name, rest) = rest.split_once(':')?;
        let (kind, rest) = rest.split_once('=')?;
        let (value, _) = rest.split_once(';')?;
        Some((name.trim(), kind.trim(), value.trim()))
    })
}

/// The Rust constants in WGSL. Arithmetic is written alike in both; the generated code checks that the values are
/// equal. Lines stay where they are, so that errors point into the Rust file.
fn translate_constants(source: &str) -> String {
    let mut out = String::new();
    for (name, kind, value) in rust_constants(source) {
        let Some(at) = source.find(&format!("pub const {name}:")) else { continue };
        let line = source[..at].matches('\n').count();
        out.extend(std::iter::repeat_n('\n', line - out.matches('\n').count()));
        let kind = if kind == "usize" { "u32" } else { kind };
        let value: Vec<&str> = value.split_whitespace().collect();
        out.push_str(&format!("const {name}: {kind} = {};\n", value.join(" ")));
    }
    out
}
