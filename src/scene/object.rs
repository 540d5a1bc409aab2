//! One entry of `objects`: every field checked, the support tree not yet.

use super::fields::{Fields, finite, found, numbers};
use super::frame::{Frame, is_near};
use super::{MASSES, Object, Parent, Pose, Relation, Root, SceneError};
use glam::{DQuat, DVec3};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const KNOWN: [&str; 11] = [
    "name",
    "category",
    "mesh",
    "position",
    "rotation_xyzw",
    "scale",
    "parent",
    "relation",
    "movable",
    "mass",
    "convex_parts",
];
/// A quaternion whose length is farther from 1 than this is reported: it may be meant differently.
const UNIT_TOLERANCE: f64 = 1e-3;

/// What reading an object needs to know and gathers.
pub(super) struct Context<'a> {
    pub file: &'a Path,
    pub folder: &'a Path,
    pub frame: Frame,
    pub unknown: BTreeSet<String>,
    pub warnings: Vec<String>,
}

/// Reads entry `i`. Gives the object, its parent still open, and the parent's name.
pub(super) fn read<'a>(context: &mut Context<'a>, i: usize, value: &'a Value) -> Result<(Object, &'a str), SceneError> {
    let fields = Fields::of_object(context.file, format!("objects[{i}]"), value)?;
    let name = fields.text("name")?.ok_or_else(|| fields.missing("name", "give each object a unique name"))?;
    if name.trim().is_empty() {
        return Err(fields.error("name", "it is empty", "give each object a unique name"));
    }
    let fields = fields.named(name);
    if Root::from_name(name).is_some() {
        let remark = "as a parent it means a part of the room, not this object";
        let warning = fields.error("name", remark, "rename the object if anything rests on it").to_string();
        context.warnings.push(warning);
    }
    fields.unknown("objects[].", &KNOWN, &mut context.unknown);
    let mesh = fields.text("mesh")?.ok_or_else(|| fields.missing("mesh", "name a GLB, glTF, OBJ, PLY or STL file"))?;
    let object = Object {
        name: name.to_owned(),
        category: fields.text("category")?.unwrap_or_default().to_owned(),
        mesh: resolve(context, &fields, "mesh", mesh)?,
        pose: pose(context, &fields)?,
        scale: scale(context, &fields)?,
        parent: Parent::Root(Root::Ground),
        relation: relation(&fields)?,
        movable: fields.flag("movable")?.unwrap_or(true),
        mass: mass(&fields)?,
        convex_parts: convex_parts(context, &fields)?,
    };
    Ok((object, fields.text("parent")?.unwrap_or("ground")))
}

fn relation(fields: &Fields<'_>) -> Result<Relation, SceneError> {
    let name = fields.text("relation")?.unwrap_or("on");
    let wrong = || fields.wrong("relation", "\"on\", \"inside\", \"hanging\" or \"attached\"");
    Relation::from_name(name).ok_or_else(wrong)
}

fn pose(context: &mut Context<'_>, fields: &Fields<'_>) -> Result<Pose, SceneError> {
    let position = fields.numbers::<3>("position")?.unwrap_or_default();
    let [x, y, z, w] = fields.numbers::<4>("rotation_xyzw")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    // The largest component is divided out first, so that neither huge nor tiny quaternions lose their direction.
    let largest = x.abs().max(y.abs()).max(z.abs()).max(w.abs());
    if largest == 0.0 {
        return Err(fields.error(
            "rotation_xyzw",
            "a quaternion of zeros is not a rotation",
            "write [0, 0, 0, 1] for no rotation",
        ));
    }
    let scaled = DQuat::from_xyzw(x / largest, y / largest, z / largest, w / largest);
    let length = scaled.length() * largest;
    if (length - 1.0).abs() > UNIT_TOLERANCE {
        let remark = format!("the quaternion's length is {length:.4}, not 1");
        context.warnings.push(fields.error("rotation_xyzw", remark, "it is read as a direction").to_string());
    }
    let pose = context.frame.pose(scaled.normalize(), DVec3::from(position));
    match is_near(pose.translation) {
        true => Ok(pose),
        false => Err(fields.too_far("position")),
    }
}

/// Metres per mesh unit.
fn scale(context: &Context<'_>, fields: &Fields<'_>) -> Result<DVec3, SceneError> {
    let wanted = "a number or a list of 3 numbers, all finite and above 0";
    let Some(value) = fields.get("scale") else { return Ok(DVec3::splat(context.frame.meters_per_unit)) };
    let axes = finite(value).map(DVec3::splat).or_else(|| numbers(value).map(DVec3::from));
    let scale = axes.ok_or_else(|| fields.wrong("scale", wanted))?;
    if scale.min_element() <= 0.0 {
        return Err(fields.wrong("scale", wanted));
    }
    let metres = scale * context.frame.meters_per_unit;
    // What the simulator's single precision cannot hold is no size of anything.
    if !metres.to_array().iter().all(|&x| (x as f32).is_normal()) {
        let problem = format!("{} times \"meters_per_unit\" is out of range", found(value));
        return Err(fields.error("scale", problem, "correct \"scale\" or \"frame\".\"meters_per_unit\""));
    }
    Ok(metres)
}

fn mass(fields: &Fields<'_>) -> Result<Option<f64>, SceneError> {
    let mass = fields.positive("mass")?;
    match mass {
        Some(kilograms) if !MASSES.contains(&kilograms) => {
            let problem = format!("{kilograms:e} kg is out of range ({:e} to {:e} kg)", MASSES.start(), MASSES.end());
            Err(fields.error("mass", problem, "write the mass in kilograms"))
        }
        _ => Ok(mass),
    }
}

fn convex_parts(context: &Context<'_>, fields: &Fields<'_>) -> Result<Vec<PathBuf>, SceneError> {
    let entries = fields.list("convex_parts")?.unwrap_or_default().iter().enumerate();
    entries
        .map(|(i, value)| {
            let field = format!("convex_parts[{i}]");
            let part = value.as_str().ok_or_else(|| {
                fields.error(&field, format!("{} is not a text in quotes", found(value)), "name a mesh file")
            })?;
            resolve(context, fields, &field, part)
        })
        .collect()
}

/// The file that a path of the scene names, checked to be one.
fn resolve(context: &Context<'_>, fields: &Fields<'_>, field: &str, path: &str) -> Result<PathBuf, SceneError> {
    let resolved = context.folder.join(path);
    match std::fs::metadata(&resolved) {
        Ok(data) if data.is_file() => Ok(resolved),
        Ok(_) => Err(fields.error(field, format!("{} is not a file", resolved.display()), "name a mesh file")),
        Err(error) => Err(fields.error(
            field,
            format!("{} cannot be found ({error})", resolved.display()),
            "put the file there, or correct the path, which is relative to the scene's folder",
        )),
    }
}
