//! Everything that a picture of a scene shows, as triangles.

use super::layout::{Vertex, pack_normal};
use super::model::{Model, Models};
use super::normals::area;
use super::texture::{Texture, to_byte};
use super::{RenderError, palette, room};
use crate::scene::{Object, Parent, Relation, Root, Scene};
use glam::{DVec3, Vec2, Vec3, Vec4, Vec4Swizzles};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most triangles of a scene.
const MAX_TRIANGLES: usize = 1 << 23;
/// An object so many times farther from the middle than most is left out of the frame.
const FAR: f64 = 8.0;
/// Half side of the drawn ground over the scene's half extent. It has faded into the background there.
const GROUND: f32 = 3.4;
/// How far below its height the ground is drawn over the scene's half extent.
const SUNK: f32 = 1e-4;
/// About the longest edge of the triangles of a wall over the scene's half extent, and how often an edge may be halved
/// for that.
const WALL_CELL: f32 = 0.04;
const MAX_HALVINGS: f32 = 6.0;
/// Opacity of objects that stand for walls.
const GLASS: f32 = 0.35;
/// Words of names and categories by which a held object is taken for a part of the room.
const ROOM_WORDS: [&str; 5] = ["wall", "walls", "ceiling", "room", "window"];

/// Triangles of one kind, with one texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batch {
    /// How they are shaded.
    pub kind: Kind,
    /// Index into the stage's textures.
    pub texture: Option<usize>,
    /// First triangle.
    pub first: usize,
    /// Triangles.
    pub count: usize,
}

/// How triangles are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// With their colour.
    Solid,
    /// As the background, with shadows and a grid.
    Ground,
    /// As glass: what is behind is seen.
    Glass,
    /// Lightly, and barely at all from behind.
    Wall,
}

/// What casts shadows.
#[derive(Clone, Debug, Default)]
pub struct Casters {
    /// m from the origin; w is 1.
    pub positions: Vec<Vec4>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
}

/// What is drawn.
pub struct Stage {
    /// Where the coordinates of everything here count from, in our frame: near the scene, so that they are exact.
    pub origin: DVec3,
    /// Three a triangle.
    pub vertices: Vec<Vertex>,
    /// What covers what: solids first, then the ground, then what is seen through.
    pub batches: Vec<Batch>,
    /// Textures with what is transparent enough in them to be a hole.
    pub textures: Vec<(Arc<Texture>, f32)>,
    /// What casts shadows.
    pub casters: Casters,
    /// First triangle in `casters` of each object, and the end.
    pub objects: Vec<usize>,
    /// What has to be in the picture, in our frame.
    pub framed: Vec<DVec3>,
    /// Middle of that from the origin, and half of its extent, m.
    pub center: Vec3,
    /// See `center`.
    pub radius: f32,
    /// Inward normals of the room's walls, or of those that objects hang on where the scene names none.
    pub walls: Vec<DVec3>,
    /// Height of the ground, in our frame, m.
    pub floor: f64,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl Stage {
    /// The scene as it stands; `models` has its meshes.
    ///
    /// # Errors
    /// Objects that are too small or too large, or too many triangles.
    pub fn new(scene: &Scene, models: &Models) -> Result<Self, RenderError> {
        let found: Option<Vec<&Arc<Model>>> = scene.objects.iter().map(|object| models.get(&object.mesh)).collect();
        let found = found.ok_or_else(|| RenderError::Failed("a mesh was not loaded".into()))?;
        let triangles: usize = found.iter().map(|model| model.mesh.triangles.len()).sum();
        if triangles > MAX_TRIANGLES {
            return Err(RenderError::Input(format!(
                "{}: {triangles} triangles are more than a picture can hold ({MAX_TRIANGLES}); simplify the meshes",
                scene.file.display()
            )));
        }
        let boxes: Vec<[DVec3; 2]> =
            scene.objects.iter().zip(&found).map(|(object, model)| bounds(object, model)).collect();
        for (i, model) in found.iter().enumerate() {
            let corners = model.mesh.triangles.as_flattened();
            let used = corners.iter().map(|&corner| model.mesh.vertices[corner as usize].as_dvec3());
            let (low, high) = used.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
            scene.check_size(i, ((high - low) * scene.objects[i].scale).max_element())?;
        }
        let mut notes = Vec::new();
        let kept = near(&boxes);
        for (object, _) in scene.objects.iter().zip(&kept).filter(|(_, kept)| !**kept) {
            notes.push(format!("object \"{}\" is too far from the others to be in the picture", object.name));
        }
        let framed = boxes.iter().zip(&kept).filter(|(_, kept)| **kept);
        let [low, high] =
            framed.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[l, h], (b, _)| [l.min(b[0]), h.max(b[1])]);
        let [low, high] = if low.is_finite() { [low, high] } else { [DVec3::NEG_ONE, DVec3::ONE] };
        let origin = (0.5 * (low + high)).round();
        let mut stage = Self {
            origin,
            vertices: Vec::with_capacity(3 * triangles),
            batches: Vec::new(),
            textures: Vec::new(),
            casters: Casters::default(),
            objects: vec![0],
            framed: Vec::new(),
            center: (0.5 * (low + high) - origin).as_vec3(),
            radius: (0.5 * (high - low).length()) as f32,
            walls: walls(scene, &boxes, 0.5 * (low + high)),
            floor: 0.0,
            notes,
        };
        stage.add_objects(scene, &found, &kept);
        stage.floor = room::floor_height(boxes.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(b, _)| b));
        if stage.floor != 0.0 {
            let height = stage.floor;
            stage.notes.push(format!("much of the scene is below its ground, which is drawn at {height:.2} m instead"));
        }
        stage.add_ground();
        for wall in room::walls(&scene.room, [low, high], stage.floor) {
            stage.add_wall(&wall);
        }
        Ok(stage)
    }

    /// Corners of a triangle, m from the origin.
    pub fn triangle(&self, number: usize) -> [Vec3; 3] {
        [0, 1, 2].map(|corner| self.vertices[3 * number + corner].position)
    }

    /// The batches that hide what is behind them.
    pub fn opaque(&self) -> impl Iterator<Item = Batch> + '_ {
        self.batches.iter().filter(|batch| matches!(batch.kind, Kind::Solid | Kind::Ground)).copied()
    }

    /// The batches that are seen through, from far to near, walls seen from behind last.
    pub fn blended(&self, eye: Vec3) -> Vec<Batch> {
        let mut blended: Vec<(f32, Batch)> = (self.batches.iter())
            .filter(|batch| matches!(batch.kind, Kind::Glass | Kind::Wall) && batch.count > 0)
            .map(|batch| {
                let corners = &self.vertices[3 * batch.first..3 * (batch.first + batch.count)];
                let middle = corners.iter().map(|v| v.position).sum::<Vec3>() / corners.len() as f32;
                let behind = batch.kind == Kind::Wall && (eye - middle).dot(area(self.triangle(batch.first))) < 0.0;
                (if behind { -1.0 } else { middle.distance(eye) }, *batch)
            })
            .collect();
        blended.sort_by(|a, b| b.0.total_cmp(&a.0));
        blended.into_iter().map(|(_, batch)| batch).collect()
    }

    fn add_objects(&mut self, scene: &Scene, models: &[&Arc<Model>], kept: &[bool]) {
        let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
        let colors = palette::colors(&names);
        // Triangles by what they need to be drawn, so that few batches are left.
        let mut sorted: BTreeMap<(Kind, Option<usize>), Vec<Vertex>> = BTreeMap::new();
        let mut known: BTreeMap<(*const Texture, u32), usize> = BTreeMap::new();
        for (i, (object, model)) in scene.objects.iter().zip(models).enumerate() {
            let glass = is_room(scene, i);
            let first = self.casters.positions.len() as u32;
            let rotation = object.pose.rotation;
            let world = |v: Vec3| rotation * (object.scale * v.as_dvec3()) + object.pose.translation;
            let positions: Vec<DVec3> = model.mesh.vertices.iter().map(|&v| world(v)).collect();
            if !glass {
                let local = positions.iter().map(|p| (*p - self.origin).as_vec3().extend(1.0));
                self.casters.positions.extend(local);
                self.casters.triangles.extend(model.mesh.triangles.iter().map(|t| t.map(|i| i + first)));
            }
            self.objects.push(self.casters.triangles.len());
            if kept[i] {
                let mut used = vec![false; positions.len()];
                model.mesh.triangles.as_flattened().iter().for_each(|&i| used[i as usize] = true);
                self.framed.extend(positions.iter().zip(used).filter(|(_, used)| *used).map(|(p, _)| *p));
            }
            let textures: Vec<Option<usize>> = (model.skins.iter().zip(&model.textures))
                .map(|(skin, texture)| {
                    let texture = texture.as_ref()?;
                    let key = (Arc::as_ptr(texture), skin.cutoff.to_bits());
                    Some(*known.entry(key).or_insert_with(|| {
                        self.textures.push((Arc::clone(texture), skin.cutoff));
                        self.textures.len() - 1
                    }))
                })
                .collect();
            let turn = |normal: Vec3| (rotation * (normal.as_dvec3() / object.scale)).as_vec3().normalize_or(Vec3::Y);
            for ((triangle, corners), &skin) in model.mesh.triangles.iter().zip(&model.corners).zip(&model.skin) {
                let skin = skin as usize;
                let base = model.skins[skin].color.unwrap_or(colors[i]);
                let places = triangle.map(|i| (positions[i as usize] - self.origin).as_vec3());
                let texture = textures[skin];
                let size = texture.map_or(0.0, |texture| self.textures[texture].0.area());
                let detail = detail(places, corners.map(|corner| corner.uv), size);
                let kind = if glass { Kind::Glass } else { Kind::Solid };
                let out = sorted.entry((kind, texture)).or_default();
                out.extend(places.into_iter().zip(corners).map(|(position, corner)| {
                    let mut color = base * corner.color;
                    color.w = if glass { GLASS } else { color.w };
                    let normal = pack_normal(turn(corner.normal));
                    Vertex { position, normal, uv: corner.uv, color: pack_color(color), detail }
                }));
            }
        }
        for ((kind, texture), vertices) in sorted {
            self.add(kind, texture, vertices);
        }
    }

    fn add(&mut self, kind: Kind, texture: Option<usize>, vertices: impl IntoIterator<Item = Vertex>) {
        let first = self.vertices.len() / 3;
        self.vertices.extend(vertices);
        self.batches.push(Batch { kind, texture, first, count: self.vertices.len() / 3 - first });
    }

    fn add_ground(&mut self) {
        let half = GROUND * self.radius;
        // What stands on it is not in the same plane as it.
        let height = (self.floor - self.origin.y) as f32 - SUNK * self.radius;
        let middle = self.center.with_y(height);
        let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]];
        let corners = corners.map(|[x, z]| plain(middle + Vec3::new(x * half, 0.0, z * half), Vec3::Y));
        self.add(Kind::Ground, None, fan(&corners));
    }

    fn add_wall(&mut self, corners: &[DVec3]) {
        let corners: Vec<Vec3> = corners.iter().map(|p| (*p - self.origin).as_vec3()).collect();
        let normal = area([corners[0], corners[1], corners[2]]).normalize_or(Vec3::Y);
        let corners: Vec<Vertex> = corners.into_iter().map(|corner| plain(corner, normal)).collect();
        let longest = corners.iter().map(|corner| corner.position.distance(corners[0].position)).fold(0.0, f32::max);
        let halvings = (longest / (WALL_CELL * self.radius)).log2().round().clamp(0.0, MAX_HALVINGS) as u32;
        let triangles = fan(&corners);
        let cut = triangles.as_chunks::<3>().0.iter().flat_map(|&triangle| subdivided(triangle, halvings));
        self.add(Kind::Wall, None, cut.flatten());
    }
}

/// A triangle in 4ⁿ parts.
fn subdivided([a, b, c]: [Vertex; 3], halvings: u32) -> Vec<[Vertex; 3]> {
    if halvings == 0 {
        return vec![[a, b, c]];
    }
    let middle = |p: Vertex, q: Vertex| Vertex { position: p.position.midpoint(q.position), ..p };
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        .into_iter()
        .flat_map(|t| subdivided(t, halvings - 1))
        .collect()
}

fn plain(position: Vec3, normal: Vec3) -> Vertex {
    Vertex { position, normal: pack_normal(normal), uv: Vec2::ZERO, color: u32::MAX, detail: 0.0 }
}

/// The triangles of a convex polygon.
fn fan(corners: &[Vertex]) -> Vec<Vertex> {
    corners[1..].array_windows().flat_map(|&[a, b]| [corners[0], a, b]).collect()
}

fn pack_color(color: Vec4) -> u32 {
    let [r, g, b] = color.xyz().to_array().map(to_byte);
    u32::from_le_bytes([r, g, b, (255.0 * color.w.clamp(0.0, 1.0)).round() as u8])
}

/// Pixels of a texture of `size` pixels per m of the surface.
fn detail(places: [Vec3; 3], uvs: [Vec2; 3], size: f32) -> f32 {
    let covered = (uvs[1] - uvs[0]).perp_dot(uvs[2] - uvs[0]).abs() * size;
    let surface = area(places).length();
    if surface > 0.0 { (covered / surface).sqrt() } else { 0.0 }
}

/// Box of an object in our frame.
fn bounds(object: &Object, model: &Model) -> [DVec3; 2] {
    let world = |i: u32| {
        let vertex = model.mesh.vertices[i as usize].as_dvec3();
        object.pose.rotation * (object.scale * vertex) + object.pose.translation
    };
    let corners = model.mesh.triangles.as_flattened().iter().map(|&i| world(i));
    corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Inward normals of the walls. What hangs on a wall that the scene does not name has it behind, seen from the middle.
fn walls(scene: &Scene, boxes: &[[DVec3; 2]], middle: DVec3) -> Vec<DVec3> {
    if !scene.room.walls.is_empty() {
        return scene.room.walls.iter().map(|wall| wall.normal).collect();
    }
    let hanging =
        scene.objects.iter().zip(boxes).filter(|(object, _)| matches!(object.parent, Parent::Root(Root::Wall)));
    let inward = hanging.map(|(_, [low, high])| (middle - 0.5 * (*low + *high)).with_y(0.0).normalize_or_zero());
    let sum: DVec3 = inward.sum();
    sum.try_normalize().into_iter().collect()
}

/// Which boxes belong to the scene: one that was thrown far away would make all others too small to be seen.
fn near(boxes: &[[DVec3; 2]]) -> Vec<bool> {
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let middles: Vec<DVec3> = boxes.iter().map(|[low, high]| 0.5 * (*low + *high)).collect();
    let middle = DVec3::from_array([0, 1, 2].map(|axis| median(middles.iter().map(|m| m[axis]).collect())));
    let reach = |([low, high], m): (&[DVec3; 2], &DVec3)| m.distance(middle) + 0.5 * (*high - *low).length();
    let usual = median(boxes.iter().zip(&middles).map(reach).collect());
    boxes.iter().zip(&middles).map(|b| b.1.distance(middle) <= FAR * usual + reach((b.0, &middle))).collect()
}

/// True for a mesh that stands for a wall or the whole room, which would hide what is in it.
fn is_room(scene: &Scene, i: usize) -> bool {
    let object = &scene.objects[i];
    let text = format!("{} {}", object.category, object.name).to_lowercase();
    let mut words = text.split(|c: char| !c.is_alphabetic());
    // "wall light" and "picture on the wall" hang there; a wall itself is held, and called so.
    let named = object.category.to_lowercase();
    let is_one = ROOM_WORDS.contains(&named.trim())
        || (named.is_empty() && words.all(|w| w.is_empty() || ROOM_WORDS.contains(&w)));
    is_one && scene.is_static(i) && object.relation != Relation::Hanging
}
