//! The `stage2` folder of the released REST3D pipeline: a support tree in `scene_tree.json`, and one OBJ per object in
//! `scene_canon/obj_files` whose vertices are in the world frame (metres, Y up), so that every pose is the identity.

use crate::scene::{Relation, Root, Scene, SceneError};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Name of the file that holds the tree.
pub const TREE: &str = "scene_tree.json";
const MESHES: &str = "scene_canon/obj_files";

/// The tree's file, if `folder` is a `stage2` folder or holds one.
pub fn find(folder: &Path) -> Option<PathBuf> {
    [folder.join(TREE), folder.join("stage2").join(TREE)].into_iter().find(|file| file.is_file())
}

/// Reads the scene of a tree's file.
///
/// # Errors
/// A tree that is not one, or an object that the document does not allow.
pub fn read(file: &Path) -> Result<Scene, SceneError> {
    Scene::read_as(file, |tree| document(file, tree))
}

/// The `scene.json` document that says the same as a tree, and what the user should know about it.
///
/// # Errors
/// A tree that is not one: no list of nodes, a node without a name, an edge without child or parent.
pub fn document(file: &Path, tree: &Value) -> Result<(Value, Vec<String>), SceneError> {
    let mut nodes = Nodes::default();
    let mut warnings = Vec::new();
    for (i, entry) in list(file, tree, "nodes")?.iter().enumerate() {
        let name = entry.as_str().or_else(|| text(entry, "name")).or_else(|| text(entry, "id"));
        let name = name.filter(|name| !name.trim().is_empty()).ok_or_else(|| {
            SceneError::new(file, "the node has no name", "write its name, or an object with a \"name\"")
                .field(&format!("nodes[{i}]"))
        })?;
        if Root::from_name(name).is_none() {
            nodes.get(name).movable = movable(entry);
        }
    }
    for (i, edge) in list(file, tree, "edges")?.iter().enumerate() {
        let end = |key: &str| {
            let missing = || SceneError::new(file, "it is missing or not a text", "name the object");
            text(edge, key).ok_or_else(|| missing().field(&format!("edges[{i}].{key}")))
        };
        let (child, parent) = (end("child")?, end("parent")?);
        if Root::from_name(child).is_some() {
            continue;
        }
        let node = nodes.get(child);
        if let Some((first, _)) = &node.support {
            let remark = SceneError::new(file, format!("its parent is \"{first}\" already"), "this edge is ignored");
            warnings.push(remark.object(child).field(&format!("edges[{i}]")).to_string());
            continue;
        }
        node.support = Some((parent.to_owned(), text(edge, "relation").unwrap_or("on").to_owned()));
        node.movable = movable(edge).or(node.movable);
    }
    let objects: Vec<Value> = nodes.list.iter().map(|node| object(file, node, &mut warnings)).collect();
    Ok((json!({"format": "rest3d-scene", "version": 1, "objects": objects}), warnings))
}

/// One object of the tree, as far as the file tells.
#[derive(Default)]
struct Node {
    name: String,
    movable: Option<bool>,
    /// Parent and relation.
    support: Option<(String, String)>,
}

/// Nodes in the order in which the file first names them.
#[derive(Default)]
struct Nodes {
    list: Vec<Node>,
    index: HashMap<String, usize>,
}

impl Nodes {
    fn get(&mut self, name: &str) -> &mut Node {
        let i = *self.index.entry(name.to_owned()).or_insert(self.list.len());
        if i == self.list.len() {
            self.list.push(Node { name: name.to_owned(), ..Node::default() });
        }
        &mut self.list[i]
    }
}

fn object(file: &Path, node: &Node, warnings: &mut Vec<String>) -> Value {
    let (parent, relation) = match &node.support {
        Some((parent, relation)) => (parent.as_str(), relation.as_str()),
        None => {
            let remark = SceneError::new(file, "no edge says what it stands on", "it is put on the ground");
            warnings.push(remark.object(&node.name).to_string());
            ("ground", "on")
        }
    };
    json!({
        "name": node.name,
        "category": category(&node.name),
        "mesh": mesh(file, &node.name),
        "parent": Root::from_name(parent).map_or(parent, |root| root.name()),
        "relation": Relation::from_name(relation).map_or(relation, |relation| relation.name()),
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

fn text<'a>(value: &'a Value, key: &str) -> Option<&'a str> {
    value.get(key)?.as_str()
}

/// What a node or an edge says of it: a flag, or a type.
fn movable(value: &Value) -> Option<bool> {
    let flag = |key| value.get(key).and_then(Value::as_bool);
    flag("movable").or_else(|| flag("fixed").map(|fixed| !fixed)).or_else(|| match text(value, "type")? {
        "movable" => Some(true),
        "fixed" => Some(false),
        _ => None,
    })
}
