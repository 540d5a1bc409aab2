//! The `stage2` folder of the released REST3D pipeline: a support tree in `scene_tree.json`, and one OBJ per object in
//! `scene_canon/obj_files` whose vertices are in the world frame (metres, Y up), so that every pose is the identity.

use crate::scene::SceneError;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Name of the file that holds the tree.
pub const TREE: &str = "scene_tree.json";
const MESHES: &str = "scene_canon/obj_files";

/// The tree's file, if `folder` is a `stage2` folder or holds one.
pub fn find(folder: &Path) -> Option<PathBuf> {
    [folder.join(TREE), folder.join("stage2").join(TREE)].into_iter().find(|file| file.is_file())
}

/// One object of the tree, as far as the file tells.
#[derive(Default)]
struct Node {
    movable: Option<bool>,
    edge: Option<(String, String)>,
}

/// The `scene.json` document that says the same as a tree, and what the user should know about it.
///
/// # Errors
/// A tree that is not one: no list of nodes, a node without a name, an edge without child or parent.
pub fn document(file: &Path, tree: &Value) -> Result<(Value, Vec<String>), SceneError> {
    let mut names: Vec<String> = Vec::new();
    let mut nodes: BTreeMap<String, Node> = BTreeMap::new();
    let mut warnings = Vec::new();
    let mut add = |name: &str, nodes: &mut BTreeMap<String, Node>| {
        if !nodes.contains_key(name) {
            nodes.insert(name.to_owned(), Node::default());
            names.push(name.to_owned());
        }
    };
    let roots: BTreeSet<&str> = ["ground", "floor", "wall", "ceiling", "ground-wall", "floor-wall"].into();
    for (i, node) in list(file, tree, "nodes")?.iter().enumerate() {
        let field = format!("nodes[{i}]");
        let name = text(node, &["name", "id"]).or_else(|| node.as_str());
        let name = name.filter(|name| !name.trim().is_empty()).ok_or_else(|| {
            SceneError::new(file, "the node has no name", "write its name, or an object with a \"name\"").field(&field)
        })?;
        if !roots.contains(name) {
            add(name, &mut nodes);
            if let Some(entry) = nodes.get_mut(name) {
                entry.movable = movable(node);
            }
        }
    }
    for (i, edge) in list(file, tree, "edges")?.iter().enumerate() {
        let end = |key: &str| {
            text(edge, &[key]).ok_or_else(|| {
                SceneError::new(file, "it is missing or not a text", "name the object")
                    .field(&format!("edges[{i}].{key}"))
            })
        };
        let (child, parent) = (end("child")?, end("parent")?);
        if roots.contains(child) {
            continue;
        }
        add(child, &mut nodes);
        let Some(node) = nodes.get_mut(child) else { continue };
        if let Some((first, _)) = &node.edge {
            let remark = format!("the object already stands on \"{first}\"");
            warnings.push(
                SceneError::new(file, remark, "this edge is ignored")
                    .object(child)
                    .field(&format!("edges[{i}]"))
                    .to_string(),
            );
            continue;
        }
        node.edge = Some((parent.to_owned(), text(edge, &["relation"]).unwrap_or("on").to_owned()));
        node.movable = movable(edge).or(node.movable);
    }
    let objects: Vec<Value> = names.iter().map(|name| object(file, name, &nodes[name], &mut warnings)).collect();
    Ok((json!({"format": "rest3d-scene", "version": 1, "objects": objects}), warnings))
}

fn object(file: &Path, name: &str, node: &Node, warnings: &mut Vec<String>) -> Value {
    let (parent, relation) = match &node.edge {
        Some((parent, relation)) => (parent.as_str(), relation.as_str()),
        None => {
            let remark = SceneError::new(file, "no edge says what it stands on", "it is put on the ground");
            warnings.push(remark.object(name).to_string());
            ("ground", "on")
        }
    };
    let parent = match parent {
        "floor" => "ground",
        "floor-wall" => "ground-wall",
        other => other,
    };
    let relation = match relation {
        "hang" => "hanging",
        "attach" | "on-attach" => "attached",
        other => other,
    };
    json!({
        "name": name,
        "category": category(name),
        "mesh": mesh(file, name),
        "parent": parent,
        "relation": relation,
        "movable": node.movable.unwrap_or(true),
    })
}

/// The description without the running number: `wooden_chair_on_the_left_000` is a `wooden chair on the left`.
fn category(name: &str) -> String {
    let words = name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end_matches('_');
    words.replace('_', " ")
}

/// The object's mesh, relative to the tree's file.
fn mesh(file: &Path, name: &str) -> String {
    let path = |name: &str| format!("{MESHES}/scene_canon_{name}.obj");
    let exists = |path: &String| file.parent().unwrap_or(Path::new("")).join(path).is_file();
    [path(name), path(&name.replace(' ', "_"))].into_iter().find(exists).unwrap_or_else(|| path(name))
}

/// The list in a field; an absent one is an error only for nodes.
fn list<'a>(file: &Path, tree: &'a Value, field: &str) -> Result<&'a [Value], SceneError> {
    match tree.get(field) {
        Some(Value::Array(list)) => Ok(list),
        None if field == "edges" => Ok(&[]),
        _ => Err(SceneError::new(file, "it is missing or not a list", "name a scene_tree.json of REST3D's stage2")
            .field(field)),
    }
}

fn text<'a>(value: &'a Value, keys: &[&str]) -> Option<&'a str> {
    keys.iter().find_map(|key| value.get(key)?.as_str())
}

/// What a node or an edge says of it: a flag, or a type.
fn movable(value: &Value) -> Option<bool> {
    let flag = |key| value.get(key).and_then(Value::as_bool);
    flag("movable").or_else(|| flag("fixed").map(|fixed| !fixed)).or_else(|| match value.get("type")?.as_str()? {
        "movable" => Some(true),
        "fixed" => Some(false),
        _ => None,
    })
}
