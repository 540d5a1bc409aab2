//! Parses and validates composed shaders, and tells errors where their author can mend them.
//!
//! Validation allows what the device is asked for and no more: no optional shader feature at all. Loops other than a
//! bounded `for` are refused, because the device is told not to guard against endless ones.

use crate::compose::Composed;
use naga::front::wgsl;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, Span};
use std::error::Error;
use std::fmt::Write;

/// What shaders may use: the features that `gpu::device` requests.
pub const CAPABILITIES: Capabilities = Capabilities::empty();

/// The shader as naga sees it, or its errors, one text each.
pub fn check(shader: &Composed) -> Result<(Module, ModuleInfo), Vec<String>> {
    let mut errors = endless_loops(shader);
    match parse(shader) {
        Ok(checked) if errors.is_empty() => return Ok(checked),
        Ok(_) => {}
        Err(error) => errors.push(error),
    }
    Err(errors)
}

/// The shader as naga sees it, whatever its loops.
pub fn parse(shader: &Composed) -> Result<(Module, ModuleInfo), String> {
    let module = wgsl::parse_str(&shader.source).map_err(|error| {
        let labels = error.labels().map(|(span, text)| (span, text.to_string()));
        let mut text = report(shader, error.message(), labels);
        for note in error.notes() {
            let _ = writeln!(text, "  note: {note}");
        }
        text
    })?;
    let info = Validator::new(ValidationFlags::all(), CAPABILITIES).validate(&module).map_err(|error| {
        let mut message = error.as_inner().to_string();
        let mut cause = error.as_inner().source();
        while let Some(inner) = cause {
            let _ = write!(message, ": {inner}");
            cause = inner.source();
        }
        report(shader, &message, error.spans().cloned())
    })?;
    Ok((module, info))
}

fn endless_loops(shader: &Composed) -> Vec<String> {
    let mut errors = Vec::new();
    let mut offset = 0;
    for line in shader.source.split_inclusive('\n') {
        let code = line.split("//").next().unwrap_or(line);
        let words = code.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        let endless = words.into_iter().find(|word| matches!(*word, "while" | "loop"));
        if let Some(word) = endless.or(code.contains("for (;").then_some("for")) {
            let at = offset + code.find(word).unwrap_or(0);
            let span = Span::new(at as u32, (at + word.len()) as u32);
            errors.push(report(shader, "only bounded `for` loops", [(span, String::new())]));
        }
        offset += line.len();
    }
    errors
}

/// A message with the place, the line and a mark under what it is about.
pub fn report(shader: &Composed, message: &str, labels: impl IntoIterator<Item = (Span, String)>) -> String {
    let mut out = format!("error: {message}\n");
    let mut any = false;
    for (span, label) in labels {
        if !span.is_defined() {
            continue;
        }
        any = true;
        let place = span.location(&shader.source);
        let index = place.line_number as usize - 1;
        let (Some(origin), Some(line)) = (shader.origins.get(index), shader.source.lines().nth(index)) else {
            continue;
        };
        let column = place.line_position as usize;
        let mark = (place.length as usize).clamp(1, line.len().saturating_sub(column - 1).max(1));
        let _ = write!(
            out,
            "  --> {}:{}:{column}\n   | {line}\n   | {}{} {label}\n",
            origin.file,
            origin.line,
            " ".repeat(column - 1),
            "^".repeat(mark)
        );
    }
    if !any {
        let _ = writeln!(out, "  --> shader `{}`", shader.name);
    }
    out
}
