//! From a path to a scene.

use super::fields::{Fields, found};
use super::frame::{Frame, Up, is_near};
use super::object::Context;
use super::{Object, Room, Scene, SceneError, object, tree};
use glam::DVec3;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Name of the file that tells of a scene.
pub const FILE: &str = "scene.json";

impl Scene {
    /// Reads a `scene.json`, or the one of a folder.
    ///
    /// Meshes are only looked for, not loaded: see [`Scene::check_size`] for the check that needs them.
    ///
    /// # Errors
    /// The first thing that the contract does not allow.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let file = if path.is_dir() { path.join(FILE) } else { path.to_path_buf() };
        Self::read_as(&file, |content| Ok((content.clone(), Vec::new())))
    }

    /// Reads a file of another format, which `convert` turns into a document of ours and what the user should know of
    /// it.
    pub(crate) fn read_as(
        file: &Path,
        convert: impl Fn(&Value) -> Result<(Value, Vec<String>), SceneError>,
    ) -> Result<Self, SceneError> {
        parse(file, &read_text(file)?, |content| {
            let (document, warnings) = convert(content)?;
            from_document(file, &document, warnings)
        })
    }
}

fn read_text(file: &Path) -> Result<String, SceneError> {
    let unreadable =
        |error: std::io::Error| SceneError::new(file, format!("cannot be read: {error}"), "check path and permissions");
    if !std::fs::metadata(file).map_err(unreadable)?.is_file() {
        return Err(SceneError::new(file, "it is not a file", "name a scene.json"));
    }
    let text = String::from_utf8(std::fs::read(file).map_err(unreadable)?)
        .map_err(|_| SceneError::new(file, "it is not JSON text in UTF-8", "name a scene.json"))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// Parses a text and reads the result. JSON has no NaN and no infinity, but many writers emit them: those become texts,
/// so that reading can say which object and field they stand in.
fn parse(file: &Path, text: &str, read: impl Fn(&Value) -> Result<Scene, SceneError>) -> Result<Scene, SceneError> {
    let error = match serde_json::from_str(text) {
        Ok(document) => return read(&document),
        Err(error) => error,
    };
    if let Ok(document) = serde_json::from_str(&quote_non_finite(text)) {
        read(&document)?;
    }
    let (problem, remedy) = match error.is_eof() {
        true => ("it breaks off", "copy or export the file again, it is cut off"),
        false => ("it is not valid JSON", "correct it there; numbers must be finite"),
    };
    Err(SceneError::new(file, format!("{problem}: {error}"), remedy))
}

/// The text with every number in quotes that is not finite (`NaN`, `-Infinity`, `1e999`).
fn quote_non_finite(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len());
    let mut rest = text;
    let in_word = |c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.');
    while let Some(first) = rest.chars().next() {
        let end = if first == '"' {
            end_of_string(rest)
        } else if in_word(first) {
            rest.find(|c| !in_word(c)).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        let (token, after) = rest.split_at(end);
        match token.parse::<f64>() {
            Ok(number) if !number.is_finite() => quoted.extend(["\"", token, "\""]),
            _ => quoted.push_str(token),
        }
        rest = after;
    }
    quoted
}

/// Length of the JSON string that `text` starts with, quotes included.
fn end_of_string(text: &str) -> usize {
    let mut bytes = text.bytes().enumerate().skip(1);
    while let Some((i, byte)) = bytes.next() {
        match byte {
            b'"' => return i + 1,
            b'\\' => _ = bytes.next(),
            _ => {}
        }
    }
    text.len()
}

/// Checks a document and converts it to our frame.
fn from_document(file: &Path, document: &Value, warnings: Vec<String>) -> Result<Scene, SceneError> {
    let fields = Fields::of_document(file, document)?;
    check_format(&fields)?;
    let mut unknown = BTreeSet::new();
    fields.unknown("", &["format", "version", "name", "frame", "room", "objects"], &mut unknown);
    let frame = frame(&fields, &mut unknown)?;
    let room = room(&fields, frame, &mut unknown)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut context = Context { file, folder, frame, unknown, warnings };
    let entries = fields.list("objects")?.ok_or_else(|| fields.missing("objects", "list the scene's objects"))?;
    let mut objects: Vec<Object> = Vec::with_capacity(entries.len());
    let mut parents = Vec::with_capacity(entries.len());
    for (i, entry) in entries.iter().enumerate() {
        let (object, parent) = object::read(&mut context, i, entry)?;
        objects.push(object);
        parents.push(parent);
    }
    let names: Vec<&str> = objects.iter().map(|object| object.name.as_str()).collect();
    let parents = tree::link(file, &names, &parents)?;
    for (object, &parent) in objects.iter_mut().zip(&parents) {
        object.parent = parent;
    }
    let Context { unknown, mut warnings, .. } = context;
    warnings.extend(unknown.into_iter().map(|field| {
        SceneError::new(file, "it is not known", "it is kept and has no effect").field(&field).to_string()
    }));
    if room.ceiling.is_some_and(|height| height <= 0.0) {
        warnings.push(fields.error("room.ceiling", "it is not above the ground", "correct it").to_string());
    }
    Ok(Scene {
        name: fields.text("name")?.map_or_else(|| folder_name(folder), str::to_owned),
        file: file.to_path_buf(),
        original_room: room.clone(),
        room,
        warnings,
        document: document.clone(),
        frame,
        children: tree::children(&parents),
        originals: objects.iter().map(|object| (object.pose, object.convex_parts.clone())).collect(),
        objects,
    })
}

fn check_format(fields: &Fields<'_>) -> Result<(), SceneError> {
    let remedy = "this program reads \"format\": \"rest3d-scene\", \"version\": 1";
    for (field, wanted) in [("format", Value::from("rest3d-scene")), ("version", Value::from(1))] {
        let value = fields.get(field).ok_or_else(|| fields.missing(field, remedy))?;
        let equal = *value == wanted || value.as_f64().is_some_and(|number| Some(number) == wanted.as_f64());
        if !equal {
            return Err(fields.error(field, format!("{} is not {wanted}", found(value)), remedy));
        }
    }
    Ok(())
}

fn frame(fields: &Fields<'_>, unknown: &mut BTreeSet<String>) -> Result<Frame, SceneError> {
    let mut frame = Frame { up: Up::Y, meters_per_unit: 1.0, ground: 0.0 };
    if let Some(fields) = fields.nested("frame")? {
        fields.unknown("frame.", &["up", "meters_per_unit"], unknown);
        frame.up = match fields.text("up")? {
            None | Some("Y" | "y") => Up::Y,
            Some("Z" | "z") => Up::Z,
            Some(_) => return Err(fields.wrong("up", "\"Y\" or \"Z\"")),
        };
        frame.meters_per_unit = fields.positive("meters_per_unit")?.unwrap_or(1.0);
    }
    if let Some(fields) = fields.nested("room")? {
        frame.ground = fields.number("ground")?.unwrap_or(0.0);
        if !is_near(DVec3::Y * frame.lift()) {
            return Err(fields.too_far("ground"));
        }
    }
    Ok(frame)
}

fn room(fields: &Fields<'_>, frame: Frame, unknown: &mut BTreeSet<String>) -> Result<Room, SceneError> {
    let Some(fields) = fields.nested("room")? else { return Ok(Room::default()) };
    fields.unknown("room.", &["ground", "ceiling", "walls"], unknown);
    let mut room = Room { ceiling: fields.number("ceiling")?.map(|h| frame.height(h)), walls: Vec::new() };
    if !room.ceiling.is_none_or(|height| is_near(DVec3::Y * height)) {
        return Err(fields.too_far("ceiling"));
    }
    for wall in fields.nested_list("walls")? {
        wall.unknown("room.walls[].", &["name", "point", "normal"], unknown);
        let remedy = "give each wall a \"point\" and a \"normal\" that points into the room";
        let vector = |field| wall.numbers(field)?.map(DVec3::from).ok_or_else(|| wall.missing(field, remedy));
        let point = vector("point")?;
        let normal = vector("normal")?.try_normalize().ok_or_else(|| {
            wall.error("normal", "a vector of zeros has no direction", "write a vector that points into the room")
        })?;
        if !is_near(frame.point(point)) {
            return Err(wall.too_far("point"));
        }
        room.walls.push(frame.wall(wall.text("name")?.unwrap_or_default().to_owned(), point, normal));
    }
    Ok(room)
}

/// The name of a scene that has none.
fn folder_name(folder: &Path) -> String {
    let folder = std::path::absolute(folder).unwrap_or_default();
    folder.file_name().map_or_else(|| "scene".to_owned(), |name| name.to_string_lossy().into_owned())
}
