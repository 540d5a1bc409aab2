//! The support tree: parents by name, cycles, order. Nothing here recurses, so that long chains are no danger.

use super::{Object, Parent, Root, SceneError};
use std::collections::HashMap;
use std::path::Path;

/// Longer names, in bytes, are not compared when a near one is looked for: that is quadratic in the length.
const COMPARABLE: usize = 100;

/// Resolves the parents' names (`parents[i]` is that of `names[i]`), in linear time.
pub(super) fn link(file: &Path, names: &[&str], parents: &[&str]) -> Result<Vec<Parent>, SceneError> {
    let mut index = HashMap::with_capacity(names.len());
    for (i, &name) in names.iter().enumerate() {
        if let Some(first) = index.insert(name, i) {
            let problem = format!("objects[{first}] and objects[{i}] have the same name");
            return Err(SceneError::new(file, problem, "rename one of them").object(name).field("name"));
        }
    }
    let mut links = Vec::with_capacity(names.len());
    for (i, &parent) in parents.iter().enumerate() {
        let error = |problem, remedy| SceneError::new(file, problem, remedy).object(names[i]).field("parent");
        links.push(match (Root::from_name(parent), index.get(parent)) {
            (Some(root), _) => Parent::Root(root),
            (None, Some(&j)) if i == j => {
                return Err(error("the object is its own parent".to_owned(), remedy_of_cycle()));
            }
            (None, Some(&j)) => Parent::Object(j),
            (None, None) => {
                let remedy = match nearest(parent, names).filter(|&name| name != names[i]) {
                    Some(name) => format!("did you mean \"{name}\"?"),
                    None => format!("name an object or one of {}", roots().join(", ")),
                };
                return Err(error(format!("there is no \"{parent}\""), remedy));
            }
        });
    }
    match cycle(&links) {
        None => Ok(links),
        Some(members) => {
            let first = names[members[0]];
            let chain: Vec<&str> = members.iter().map(|&i| names[i]).chain([first]).collect();
            let problem = format!("the parents form a cycle: {}", chain.join(" → "));
            Err(SceneError::new(file, problem, remedy_of_cycle()).object(first).field("parent"))
        }
    }
}

/// The children of every object, in the scene's order.
pub(super) fn children(parents: &[Parent]) -> Vec<Vec<usize>> {
    let mut children = vec![Vec::new(); parents.len()];
    for (i, parent) in parents.iter().enumerate() {
        if let Parent::Object(parent) = parent {
            children[*parent].push(i);
        }
    }
    children
}

/// Every object after its children.
pub(super) fn post_order(objects: &[Object], children: &[Vec<usize>]) -> Vec<usize> {
    let mut order = Vec::with_capacity(objects.len());
    let mut path: Vec<(usize, usize)> = Vec::new();
    for top in (0..objects.len()).filter(|&i| matches!(objects[i].parent, Parent::Root(_))) {
        path.push((top, 0));
        while let Some((node, visited)) = path.last_mut() {
            match children[*node].get(*visited) {
                Some(&child) => {
                    *visited += 1;
                    path.push((child, 0));
                }
                None => {
                    order.push(*node);
                    path.pop();
                }
            }
        }
    }
    order
}

fn roots() -> [&'static str; 4] {
    Root::ALL.map(Root::name)
}

fn remedy_of_cycle() -> String {
    format!("let one of them stand on {}", roots().join(", "))
}

/// The members of the first cycle, each followed by its parent.
fn cycle(parents: &[Parent]) -> Option<Vec<usize>> {
    let next = |i: usize| match parents[i] {
        Parent::Object(parent) => Some(parent),
        Parent::Root(_) => None,
    };
    // The walk that reached an object first; a walk that meets its own trace has found a cycle.
    let mut reached = vec![None; parents.len()];
    for start in 0..parents.len() {
        let mut at = Some(start);
        while let Some(i) = at.filter(|&i| reached[i].is_none()) {
            reached[i] = Some(start);
            at = next(i);
        }
        if let Some(first) = at.filter(|&i| reached[i] == Some(start)) {
            let rest = std::iter::successors(next(first), |&i| next(i)).take_while(|&i| i != first);
            return Some(std::iter::once(first).chain(rest).collect());
        }
    }
    None
}

/// The name that is most likely meant, if one is near.
fn nearest<'a>(wanted: &str, names: &[&'a str]) -> Option<&'a str> {
    if wanted.len() > COMPARABLE {
        return None;
    }
    let limit = (wanted.chars().count() / 3).max(2);
    let candidates = names.iter().copied().chain(roots()).filter(|name| name.len() <= COMPARABLE);
    candidates
        .map(|name| (strsim::damerau_levenshtein(wanted, name), name))
        .filter(|&(distance, _)| distance <= limit)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, name)| name)
}
