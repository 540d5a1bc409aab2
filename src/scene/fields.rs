//! Typed access to JSON objects, with errors that say where the value stands.

use super::SceneError;
use super::frame::MAX_DISTANCE;
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::path::Path;

/// Longest excerpt of a wrong value in a message, characters.
const EXCERPT: usize = 40;

/// One JSON object of a scene file. A field that is `null` counts as absent.
pub(super) struct Fields<'a> {
    file: &'a Path,
    object: Option<String>,
    /// What stands before the names of its fields: `""`, `"frame."`, `"room.walls[0]."`.
    prefix: String,
    map: &'a Map<String, Value>,
}

impl<'a> Fields<'a> {
    /// The document itself.
    pub fn of_document(file: &'a Path, value: &'a Value) -> Result<Self, SceneError> {
        let map = value.as_object().ok_or_else(|| {
            SceneError::new(file, format!("{} is not a JSON object", found(value)), "start the file with \"{\"")
        })?;
        Ok(Self { file, object: None, prefix: String::new(), map })
    }

    /// An entry of `objects`; `label` stands for the object until its name is known.
    pub fn of_object(file: &'a Path, label: String, value: &'a Value) -> Result<Self, SceneError> {
        let map = value.as_object().ok_or_else(|| {
            SceneError::new(file, format!("{} is not a JSON object", found(value)), "write {\"name\": …, \"mesh\": …}")
                .object(&label)
        })?;
        Ok(Self { file, object: Some(label), prefix: String::new(), map })
    }

    /// The same fields under the object's name.
    pub fn named(self, name: &str) -> Self {
        Self { object: Some(name.to_owned()), ..self }
    }

    /// An error at one field.
    pub fn error(&self, field: &str, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        let error = SceneError::new(self.file, problem, remedy).field(&format!("{}{field}", self.prefix));
        match &self.object {
            Some(object) => error.object(object),
            None => error,
        }
    }

    /// An error for a required field.
    pub fn missing(&self, field: &str, remedy: &str) -> SceneError {
        self.error(field, "it is missing", remedy)
    }

    /// An error for a value that is not what the field holds.
    pub fn wrong(&self, field: &str, wanted: &str) -> SceneError {
        let value = self.map.get(field).map_or_else(|| "nothing".to_owned(), found);
        self.error(field, format!("{value} is not {wanted}"), format!("write {wanted}"))
    }

    /// An error for a place that is out of reach.
    pub fn too_far(&self, field: &str) -> SceneError {
        self.error(
            field,
            format!("it lies more than {MAX_DISTANCE:e} m from the origin"),
            "correct it, \"room\".\"ground\" or \"frame\".\"meters_per_unit\"",
        )
    }

    /// The value of a field, if it is there.
    pub fn get(&self, field: &str) -> Option<&'a Value> {
        self.map.get(field).filter(|value| !value.is_null())
    }

    /// A text.
    pub fn text(&self, field: &str) -> Result<Option<&'a str>, SceneError> {
        self.typed(field, "a text in quotes", Value::as_str)
    }

    /// `true` or `false`.
    pub fn flag(&self, field: &str) -> Result<Option<bool>, SceneError> {
        self.typed(field, "true or false", Value::as_bool)
    }

    /// A finite number.
    pub fn number(&self, field: &str) -> Result<Option<f64>, SceneError> {
        self.typed(field, "a finite number", finite)
    }

    /// A number above zero.
    pub fn positive(&self, field: &str) -> Result<Option<f64>, SceneError> {
        self.typed(field, "a finite number above 0", |value| finite(value).filter(|&x| x > 0.0))
    }

    /// `N` finite numbers.
    pub fn numbers<const N: usize>(&self, field: &str) -> Result<Option<[f64; N]>, SceneError> {
        self.typed(field, &format!("a list of {N} finite numbers"), numbers)
    }

    /// A list of anything.
    pub fn list(&self, field: &str) -> Result<Option<&'a [Value]>, SceneError> {
        self.typed(field, "a list", |value| value.as_array().map(Vec::as_slice))
    }

    /// A JSON object within this one.
    pub fn nested(&self, field: &str) -> Result<Option<Self>, SceneError> {
        let map = self.typed(field, "a JSON object", Value::as_object)?;
        let prefix = format!("{}{field}.", self.prefix);
        Ok(map.map(|map| Self { file: self.file, object: self.object.clone(), prefix, map }))
    }

    /// The JSON objects of a list within this one.
    pub fn nested_list(&self, field: &str) -> Result<Vec<Self>, SceneError> {
        let entries = self.list(field)?.unwrap_or_default().iter().enumerate();
        entries
            .map(|(i, value)| {
                let map = value.as_object().ok_or_else(|| {
                    let problem = format!("{} is not a JSON object", found(value));
                    self.error(&format!("{field}[{i}]"), problem, "write {…}")
                })?;
                let prefix = format!("{}{field}[{i}].", self.prefix);
                Ok(Self { file: self.file, object: self.object.clone(), prefix, map })
            })
            .collect()
    }

    /// Adds the fields that are not among `known` to `unknown`, as `kind` and name.
    pub fn unknown(&self, kind: &str, known: &[&str], unknown: &mut BTreeSet<String>) {
        unknown.extend(self.map.keys().filter(|key| !known.contains(&key.as_str())).map(|key| format!("{kind}{key}")));
    }

    fn typed<T>(
        &self,
        field: &str,
        wanted: &str,
        read: impl FnOnce(&'a Value) -> Option<T>,
    ) -> Result<Option<T>, SceneError> {
        match self.get(field) {
            None => Ok(None),
            Some(value) => read(value).map(Some).ok_or_else(|| self.wrong(field, wanted)),
        }
    }
}

/// A finite number, if the value is one.
pub(super) fn finite(value: &Value) -> Option<f64> {
    value.as_f64().filter(|x| x.is_finite())
}

/// Exactly `N` finite numbers, if the value holds them.
pub(super) fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let list: Vec<f64> = value.as_array()?.iter().map(finite).collect::<Option<_>>()?;
    list.try_into().ok()
}

/// A value as a message shows it.
pub(super) fn found(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(EXCERPT) {
        None => text,
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}
