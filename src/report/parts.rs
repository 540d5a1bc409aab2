//! The convex parts as OBJ files with names that every file system takes.

use crate::scene::Scene;
use crate::shape::{Part, part_obj};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Longest part of a file name that comes from an object's name.
const MAX_STEM: usize = 80;

/// One file a part, `parts/<object>_<i>.obj`, in the mesh's own frame; a list for each object, in the scene's order.
pub fn part_files(scene: &Scene, parts: &[Vec<Part>]) -> Vec<Vec<(PathBuf, Vec<u8>)>> {
    let stems = stems(scene.objects.iter().map(|object| object.name.as_str()));
    (scene.objects.iter().zip(parts).zip(stems))
        .map(|((object, parts), stem)| {
            (parts.iter().enumerate())
                .map(|(i, part)| {
                    (PathBuf::from(format!("parts/{stem}_{i}.obj")), part_obj(part, object.scale.as_vec3()))
                })
                .collect()
        })
        .collect()
}

/// A file name's stem for every name: letters, digits, dot, dash and underscore, unique even where case does not count.
fn stems<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = BTreeSet::new();
    names
        .map(|name| {
            let keep = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
            let plain: String = name.chars().take(MAX_STEM).map(keep).collect();
            let plain = format!("{}{}", if plain.starts_with('.') { "_" } else { "" }, plain);
            let mut stem = plain.clone();
            let mut number = 2;
            while !taken.insert(stem.to_ascii_lowercase()) {
                stem = format!("{plain}-{number}");
                number += 1;
            }
            stem
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::stems;

    #[test]
    fn stems_are_plain_and_unique() {
        let names = ["mug", "Mug", "my mug", "my/mug", "../mug", "テーブル", "mug-2"];
        let stems = stems(names.into_iter());
        assert_eq!(stems, ["mug", "Mug-2", "my_mug", "my_mug-2", "_.._mug", "____", "mug-2-2"]);
    }

    #[test]
    fn a_long_name_is_cut() {
        let long = "x".repeat(300);
        let stems = stems([long.as_str(), long.as_str()].into_iter());
        assert_eq!(stems[0].len(), super::MAX_STEM);
        assert_ne!(stems[0], stems[1]);
    }
}
