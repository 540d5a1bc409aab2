//! Why a scene cannot be used, always in the shape `FILE: object "x", field "y": problem; remedy`.

use std::fmt;
use std::path::{Path, PathBuf};

/// What is wrong with a scene, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}:{} {problem}; {remedy}", file.display(), Place(self))]
pub struct SceneError {
    /// The file that has to be changed.
    pub file: PathBuf,
    /// Name of the object, or `objects[i]` while it has none.
    pub object: Option<String>,
    /// The JSON field, within the object if there is one.
    pub field: Option<String>,
    /// What was found.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

impl SceneError {
    /// An error that concerns a whole file.
    pub fn new(file: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { file: file.to_path_buf(), object: None, field: None, problem: problem.into(), remedy: remedy.into() }
    }

    /// Names the object.
    #[must_use]
    pub fn object(mut self, name: &str) -> Self {
        self.object = Some(name.to_owned());
        self
    }

    /// Names the field.
    #[must_use]
    pub fn field(mut self, name: &str) -> Self {
        self.field = Some(name.to_owned());
        self
    }
}

/// The middle of the message: ` object "x", field "y":`, or as much of it as is known.
struct Place<'a>(&'a SceneError);

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.0.object, &self.0.field) {
            (Some(object), Some(field)) => write!(f, " object \"{object}\", field \"{field}\":"),
            (Some(object), None) => write!(f, " object \"{object}\":"),
            (None, Some(field)) => write!(f, " field \"{field}\":"),
            (None, None) => Ok(()),
        }
    }
}
