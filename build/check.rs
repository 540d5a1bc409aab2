//! Parses and validates composed shaders, and tells errors where their author can mend them.
//!
//! Validation allows what the device is asked for and no more: no optional shader feature at all. Loops other than a
//! bounded `for` are refused, as far as that can be seen, because the device is told not to guard against endless ones.

use crate::compose::Composed;
use naga::front::wgsl;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Block, Expression, Function, Module, Span, Statement};
use std::error::Error;
use std::fmt::Write;

/// What shaders may use: the features that `gpu::device` requests.
pub const CAPABILITIES: Capabilities = Capabilities::empty();

/// The shader as naga sees it, or its errors, one text each.
pub fn check(shader: &Composed) -> Result<(Module, ModuleInfo), Vec<String>> {
    let (module, info) = parse(shader).map_err(|error| vec![error])?;
    match endless_loops(shader, &module) {
        errors if errors.is_empty() => Ok((module, info)),
        errors => Err(errors),
    }
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

/// Complaints about loops that nothing is seen to end: those whose update computes no variable anew, from itself, that
/// their condition reads and their body leaves alone, as in `while`, `loop`, and a `for` that lacks one of both. That a
/// counter goes the right way is for the author to see.
fn endless_loops(shader: &Composed, module: &Module) -> Vec<String> {
    let mut errors = Vec::new();
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    for function in module.functions.iter().map(|(_, function)| function).chain(entries) {
        visit(&function.body, &mut |statement, span| {
            if let Statement::Loop { body, continuing, .. } = statement
                && !is_bounded(function, body, continuing)
            {
                errors.push(report(
                    shader,
                    "only bounded `for` loops, whose update counts what their condition reads",
                    [(span, String::new())],
                ));
            }
        });
    }
    errors
}

/// True if the condition of a loop, which is what comes before its first `if` that breaks, reads what its update
/// changes.
fn is_bounded(function: &Function, body: &Block, update: &Block) -> bool {
    let local = |pointer| match function.expressions[pointer] {
        Expression::LocalVariable(local) => Some(local),
        _ => None,
    };
    let reads_itself = |value, counter| match function.expressions[value] {
        Expression::Binary { left, .. } => {
            matches!(function.expressions[left], Expression::Load { pointer } if local(pointer) == Some(counter))
        }
        _ => false,
    };
    let mut changed = Vec::new();
    visit(update, &mut |statement, _| {
        if let Statement::Store { pointer, value } = statement
            && let Some(counter) = local(*pointer)
            && reads_itself(*value, counter)
        {
            changed.push(counter);
        }
    });
    visit(body, &mut |statement, _| {
        if let Statement::Store { pointer, .. } = statement {
            changed.retain(|counter| local(*pointer) != Some(*counter));
        }
    });
    let breaks = |block: &Block| matches!(block.last(), Some(Statement::Break));
    let ends = |statement: &Statement| match statement {
        Statement::If { accept, reject, .. } => breaks(accept) || breaks(reject),
        _ => false,
    };
    let Some(end) = body.iter().position(ends) else { return false };
    let mut reads = false;
    let mut look = |statement: &Statement, _| {
        let Statement::Emit(range) = statement else { return };
        reads |= range.clone().any(|expression| match function.expressions[expression] {
            Expression::Load { pointer } => local(pointer).is_some_and(|local| changed.contains(&local)),
            _ => false,
        });
    };
    for (statement, span) in body.span_iter().take(end) {
        visit_one(statement, *span, &mut look);
    }
    reads
}

/// Calls `look` with every statement, those inside others after them.
fn visit(block: &Block, look: &mut dyn FnMut(&Statement, Span)) {
    block.span_iter().for_each(|(statement, span)| visit_one(statement, *span, look));
}

fn visit_one(statement: &Statement, span: Span, look: &mut dyn FnMut(&Statement, Span)) {
    look(statement, span);
    match statement {
        Statement::Block(block) => visit(block, look),
        Statement::If { accept, reject, .. } => [accept, reject].into_iter().for_each(|block| visit(block, look)),
        Statement::Loop { body, continuing, .. } => [body, continuing].into_iter().for_each(|block| visit(block, look)),
        Statement::Switch { cases, .. } => cases.iter().for_each(|case| visit(&case.body, look)),
        _ => {}
    }
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
