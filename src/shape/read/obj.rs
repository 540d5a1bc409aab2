//! Wavefront OBJ: positions and faces; where the look is wanted, also normals, colours, materials and textures.
//!
//! Our own reader, because the `tobj` crate refuses whole files over things that do not matter here (a texture
//! coordinate out of range, colours on some of the vertices, a comment that is not UTF-8) and overflows on an index
//! near the end of the number range.

use super::image::decode;
use super::{Source, bytes_of, three_numbers, to_linear};
use crate::shape::{Corner, Look, Mesh, MeshError, Pixels, Skin};
use glam::{Vec2, Vec3};
use std::path::Path;
use std::sync::Arc;

pub(super) fn read(source: &Source<'_>, look: Option<&mut Look>) -> Result<Mesh, MeshError> {
    let mut mesh = Mesh::default();
    let mut looks = look.map(Looks::new);
    let mut corners = Vec::new();
    let text = source.text();
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let damaged = |what: &str| source.damaged(format!("line {}: {what}", number + 1));
        // A backslash at its end continues a line.
        let mut joined;
        let mut line = line.trim_end();
        while let Some(start) = line.strip_suffix('\\') {
            joined = format!("{start} {}", lines.next().map_or("", |(_, next)| next.trim_end()));
            line = &joined;
        }
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let position = three_numbers(&mut words).ok_or_else(|| damaged("a vertex needs three numbers"))?;
                mesh.vertices.push(position);
                if let Some(looks) = &mut looks {
                    looks.colors.push(three_numbers(&mut words).filter(|color| color.is_finite()));
                }
            }
            Some("f") => {
                corners.clear();
                for word in words.clone() {
                    let corner = index(word.split('/').next(), mesh.vertices.len());
                    corners.push(corner.ok_or_else(|| damaged("a corner of the face is not a vertex number"))?);
                }
                if corners.len() < 3 {
                    return Err(damaged("a face needs three corners"));
                }
                let triangles = mesh.add_polygon(&corners);
                if let Some(looks) = &mut looks {
                    looks.face(&corners, words, &triangles);
                }
            }
            Some(key) => {
                if let Some(looks) = &mut looks {
                    looks.line(source, key, words);
                }
            }
            None => {}
        }
    }
    Ok(mesh)
}

/// The element that a number names, counted from 1, or back from the last one if negative.
fn index(word: Option<&str>, count: usize) -> Option<u32> {
    let number: i64 = word?.parse().ok()?;
    let index = if number < 0 { i64::try_from(count).ok()?.checked_add(number)? } else { number - 1 };
    u32::try_from(index).ok()
}

/// Collects the look. Nothing here is an error: what cannot be read is drawn without.
struct Looks<'a> {
    look: &'a mut Look,
    colors: Vec<Option<Vec3>>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// Materials by name, and the one that holds.
    materials: Vec<(String, Skin)>,
    current: Option<usize>,
    /// Index in the look of each material, plain and with colours of vertices.
    used: Vec<[Option<u32>; 2]>,
}

impl<'a> Looks<'a> {
    fn new(look: &'a mut Look) -> Self {
        let (materials, current) = (vec![(String::new(), Skin::default())], Some(0));
        Self { look, colors: Vec::new(), uvs: Vec::new(), normals: Vec::new(), materials, current, used: Vec::new() }
    }

    fn line<'w>(&mut self, source: &Source<'_>, key: &str, mut words: impl Iterator<Item = &'w str>) {
        match key {
            "vt" => {
                let mut next = || words.next().and_then(|word| word.parse::<f32>().ok()).filter(|x| x.is_finite());
                let (u, v) = (next().unwrap_or(0.0), next().unwrap_or(0.0));
                // Rows count from the bottom in this format.
                self.uvs.push(Vec2::new(u, 1.0 - v));
            }
            "vn" => self.normals.push(three_numbers(&mut words).and_then(Vec3::try_normalize).unwrap_or(Vec3::ZERO)),
            "usemtl" => {
                let name = words.collect::<Vec<_>>().join(" ");
                self.current = self.materials.iter().position(|(known, _)| *known == name);
            }
            "mtllib" => {
                let name = words.collect::<Vec<_>>().join(" ");
                self.library(&source.path.parent().unwrap_or(Path::new("")).join(name));
            }
            _ => {}
        }
    }

    fn face<'w>(&mut self, vertices: &[u32], words: impl Iterator<Item = &'w str>, triangles: &[[usize; 3]]) {
        let tinted = vertices.iter().all(|&v| self.colors.get(v as usize).is_some_and(Option::is_some));
        let skin = self.skin(self.current.unwrap_or(0), tinted);
        let corners: Vec<Corner> = vertices.iter().zip(words).map(|(&v, word)| self.corner(v, word)).collect();
        triangles.iter().for_each(|triangle| self.look.push(triangle.map(|i| corners[i]), skin));
    }

    fn corner(&self, vertex: u32, word: &str) -> Corner {
        let mut parts = word.split('/').skip(1);
        let uv = index(parts.next(), self.uvs.len()).and_then(|i| self.uvs.get(i as usize));
        let normal = index(parts.next(), self.normals.len()).and_then(|i| self.normals.get(i as usize));
        let color = self.colors.get(vertex as usize).copied().flatten().map(to_linear);
        Corner {
            normal: normal.copied().unwrap_or_default(),
            uv: uv.copied().unwrap_or_default(),
            color: color.unwrap_or(Vec3::ONE).extend(1.0),
        }
    }

    fn skin(&mut self, material: usize, tinted: bool) -> u32 {
        self.used.resize(self.materials.len(), [None; 2]);
        *self.used[material][usize::from(tinted)].get_or_insert_with(|| {
            self.look.skins.push(Skin { tinted, ..self.materials[material].1.clone() });
            self.look.skins.len() as u32 - 1
        })
    }

    /// Reads a file of materials: diffuse colour and texture.
    fn library(&mut self, path: &Path) {
        let text = match bytes_of(path) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(error) => return self.look.notes.push(format!("{error}; drawn in plain colour")),
        };
        for line in text.lines() {
            let mut words = line.split_ascii_whitespace();
            match words.next() {
                Some("newmtl") => self.materials.push((words.collect::<Vec<_>>().join(" "), Skin::default())),
                Some("Kd") => {
                    let color = three_numbers(&mut words).filter(|color| color.is_finite());
                    if let (Some((_, skin)), Some(color)) = (self.materials.last_mut(), color) {
                        skin.color = Some(to_linear(color).extend(1.0));
                    }
                }
                Some("map_Kd") => {
                    let name = file_name(words).replace('\\', "/");
                    if name.is_empty() {
                        continue;
                    }
                    let texture = self.image(&path.parent().unwrap_or(Path::new("")).join(name));
                    if let (Some((_, skin)), Some(texture)) = (self.materials.last_mut(), texture) {
                        // Many writers leave the colour black or grey where a texture is.
                        *skin = Skin { color: None, texture: Some((texture, Default::default())), ..skin.clone() };
                    }
                }
                _ => {}
            }
        }
    }

    fn image(&mut self, path: &Path) -> Option<Arc<Pixels>> {
        let decoded = bytes_of(path).map_err(|error| error.problem).and_then(|bytes| decode(&bytes));
        match decoded {
            Ok(image) => Some(Arc::new(image)),
            Err(problem) => {
                self.look.notes.push(format!("{}: {problem}; drawn in plain colour", path.display()));
                None
            }
        }
    }
}

/// The name of a file behind options, such as `-s 1 1 1 -clamp on my wood.png`.
fn file_name<'w>(words: impl Iterator<Item = &'w str>) -> String {
    let mut words = words.peekable();
    let is_value = |word: &str| matches!(word, "on" | "off") || word.len() == 1 || word.parse::<f32>().is_ok();
    while words.next_if(|word| word.starts_with('-')).is_some() {
        while words.next_if(|word| is_value(word)).is_some() {}
    }
    words.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_textures_stand_behind_options_and_may_have_spaces() {
        let name = |line: &str| file_name(line.split_ascii_whitespace());
        assert_eq!(name("my red wood.png"), "my red wood.png");
        assert_eq!(name("-s 1 1.5 1 -o 0.1 -clamp on -imfchan r woods.png"), "woods.png");
        assert_eq!(name("-bm 0.2"), "");
    }
}
