//! From a mesh to convex parts, mass, centre of mass and inertia.
//!
//! A decomposition error becomes a placement error: parts that bulge make a mug float, parts that cut off feet make it
//! sink. So the surface is cut exactly (`split`), the pieces are merged by the bulge they add (`merge`), the hulls lose
//! vertices where it shows least (`reduce`) and grow until they cover the surface again (`cover`), and both errors are
//! measured (`measure`). In the end every part is padded by less than a tenth of a millimetre (`padding`).

mod bearing;
mod cache;
mod category;
mod convex_hull;
mod cover;
mod decompose;
mod divide;
mod eigen;
mod hull;
mod inside;
mod look;
mod mass;
mod measure;
mod merge;
mod mesh;
mod obj;
mod padding;
mod read;
mod reduce;
mod soles;
mod solid;
mod split;
pub(crate) mod triangle;

pub use cache::{CACHE_VARIABLE, Cache};
pub use category::{part_budget, typical_mass};
pub use convex_hull::convex_hull;
pub use hull::solid_hull;
pub use inside::Inside;
pub use look::{Corner, Look, Pixels, Skin, Wrap};
pub use mass::MassProperties;
pub use measure::Quality;
pub use mesh::{Mesh, MeshError, read_look, read_mesh};
pub use obj::part_obj;
pub use padding::PADDING;

use cache::Key;
use glam::{Quat, Vec3};
use hull::Hull;
use rayon::prelude::*;
use reduce::Levels;
use serde::{Deserialize, Serialize};
use solid::Solid;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Changes whenever the same input would give other parts, so that old cache entries are not found.
const ALGORITHM: &str = "shape 20";
/// Parts of an `Alternative`.
const ALTERNATIVE_PARTS: usize = 16;
/// Vertices farther from the mesh's origin than this lose millimetres to rounding, m.
const MAX_REACH: f32 = 1000.0;
/// Parts that leave more of the mesh than this share of its size uncovered are worth a note.
const UNCOVERED: f32 = 0.1;
/// `up` within this cosine of an axis of the mesh means that axis: input poses are tilted, meshes seldom.
const UP_SNAP: f32 = 0.8;

/// One convex part.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// 4 to 64 vertices in convex position, scaled mesh frame, m.
    pub vertices: Vec<Vec3>,
}

/// Another decomposition of the same mesh, coarser and shrunk onto its vertices as most tools make them: what stands only on
/// the facets of one set of parts does not stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// Convex parts, largest first.
    pub parts: Vec<Part>,
    /// Mass, centre and inertia of their union at uniform density; the mass is the shape's.
    pub mass: MassProperties,
}

/// What stands for a mesh in the simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Convex parts, largest first.
    pub parts: Vec<Part>,
    /// Mass, centre and inertia of the union of the parts at uniform density.
    pub mass: MassProperties,
    /// A second opinion.
    pub alternative: Alternative,
    /// The scaled mesh, m.
    pub surface: Mesh,
    /// Lowest and highest corner of the scaled mesh, m.
    pub bounds: [Vec3; 2],
    /// How well the parts stand for the mesh.
    pub quality: Quality,
    /// What the user should know: thickened, reduced, not convex, no cache.
    pub notes: Vec<String>,
}

/// A mesh to turn into a shape.
#[derive(Clone, Debug)]
pub struct ShapeRequest {
    /// The object's name, for messages.
    pub name: String,
    /// Free text that decides the part budget and the mass class.
    pub category: String,
    /// The mesh file.
    pub mesh: PathBuf,
    /// Metres per mesh unit, all > 0.
    pub scale: Vec3,
    /// kg, if given.
    pub mass: Option<f32>,
    /// Ready-made convex parts in the mesh frame, used instead of a decomposition.
    pub convex_parts: Vec<PathBuf>,
    /// World up in the mesh frame at the input pose. A hint: poses may be tilted.
    pub up: Vec3,
    /// True if something rests on it: its parts follow its tops more closely.
    pub bears: bool,
}

/// Parameters of the decomposition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShapeSettings {
    /// Cells of the grid on which free space is measured.
    pub cells: usize,
    /// Pieces are cut for each part of the budget, before merging.
    pub oversplit: f32,
    /// Most pieces before merging.
    pub max_pieces: usize,
    /// Depth of a layer of free space, spread over the whole object, that is not worth more parts, m.
    pub accuracy: f32,
    /// Meshes of more connected components are only cut as a whole.
    pub max_components: usize,
    /// Vertices of a part that suffice where they are accurate to 0.6 mm.
    pub soft_vertices: usize,
    /// Most vertices of a part.
    pub max_vertices: usize,
    /// Most parts; the category may say less.
    pub max_parts: usize,
    /// Parts beyond the category's budget that may be used to keep a compartment open (0: the paper's hard budget).
    pub extra_parts: usize,
    /// Parts that an object may have so that they follow the surfaces on which others rest.
    pub bearing_parts: usize,
    /// True: parts grow until they cover the mesh. False: their vertices lie on it.
    pub covering: bool,
}

impl ShapeSettings {
    /// The settings of an `Alternative`.
    fn alternative(&self) -> Self {
        Self { oversplit: 2.0, extra_parts: 0, bearing_parts: 16, covering: false, ..self.clone() }
    }
}

impl Default for ShapeSettings {
    fn default() -> Self {
        Self {
            cells: 500_000,
            oversplit: 4.0,
            max_pieces: 72,
            accuracy: 1e-3,
            max_components: 128,
            soft_vertices: 32,
            max_vertices: 64,
            max_parts: 32,
            extra_parts: 4,
            bearing_parts: 32,
            covering: true,
        }
    }
}

/// Why a shape could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ShapeError {
    /// The mesh or a ready-made part could not be read.
    #[error("object \"{object}\", field \"{field}\": {source}")]
    Read {
        /// Name of the object.
        object: String,
        /// `mesh` or `convex_parts`.
        field: &'static str,
        /// What is wrong with the file.
        source: MeshError,
    },
    /// The scale makes the mesh so large that its coordinates are no numbers any more.
    #[error("object \"{object}\", field \"scale\": {scale} times {} is not finite: use a smaller scale", file.display())]
    Scale {
        /// Name of the object.
        object: String,
        /// Its scale.
        scale: Vec3,
        /// The mesh or part file.
        file: PathBuf,
    },
    /// The mesh lies so far from its own origin that rounding would spoil it.
    #[error(
        "object \"{object}\", field \"{field}\": {} lies up to {reach:.0} m from its own origin, and {MAX_REACH} m are plausible: \
         centre the mesh, or correct \"scale\"",
        file.display()
    )]
    Far {
        /// Name of the object.
        object: String,
        /// `mesh` or `convex_parts`.
        field: &'static str,
        /// The file.
        file: PathBuf,
        /// Distance of its farthest vertex, m.
        reach: f32,
    },
    /// A ready-made part has nothing to do with the mesh.
    #[error(
        "object \"{object}\", field \"convex_parts\": {} reaches {beyond:.3} m beyond the mesh, more than the mesh is long: \
         parts must be in the frame and unit of the mesh",
        file.display()
    )]
    Part {
        /// Name of the object.
        object: String,
        /// The part's file.
        file: PathBuf,
        /// How far it reaches out of the mesh's box, m.
        beyond: f32,
    },
    /// No hull could be made.
    #[error("object \"{object}\", field \"{field}\": no convex part can be made of it: repair the mesh")]
    Empty {
        /// Name of the object.
        object: String,
        /// `mesh` or `convex_parts`.
        field: &'static str,
    },
}

/// What the cache holds of a shape: all but the mass, which depends on the category.
#[derive(Clone, Serialize, Deserialize)]
struct Entry {
    own: Body,
    alternative: Body,
    quality: Quality,
    notes: Vec<String>,
}

/// Parts, and how a mass of 1 kg is spread over them.
#[derive(Clone, Serialize, Deserialize)]
struct Body {
    parts: Vec<Vec<Vec3>>,
    volume: f32,
    center: Vec3,
    axes: Quat,
    inertia: Vec3,
}

impl Body {
    /// The body of these hulls, with all faces of its parts moved outwards a little if they are to be padded.
    fn new(mut hulls: Vec<Hull>, pad: bool) -> Self {
        let (volume, unit) = mass::of_union(&hulls);
        if pad {
            hulls = soles::flattened(hulls.into_iter().map(padding::padded).collect(), unit.center);
        }
        let parts = hulls.into_iter().map(|hull| hull.vertices).collect();
        Self { parts, volume, center: unit.center, axes: unit.axes, inertia: unit.inertia }
    }

    fn of_mass(self, mass: f32) -> (Vec<Part>, MassProperties) {
        let parts = self.parts.into_iter().map(|vertices| Part { vertices }).collect();
        (parts, MassProperties { mass, center: self.center, axes: self.axes, inertia: self.inertia * mass })
    }
}

/// Makes the shapes of all requests, in parallel and in order. `progress` is called with (done, total, name) after each,
/// from any thread.
///
/// # Errors
/// The first request, in order, whose mesh or parts cannot be read or hold nothing.
pub fn build_shapes(
    requests: &[ShapeRequest],
    settings: &ShapeSettings,
    cache: Option<&Cache>,
    progress: &(dyn Fn(usize, usize, &str) + Sync),
) -> Result<Vec<Shape>, ShapeError> {
    let done = AtomicUsize::new(0);
    let shapes: Vec<Result<Shape, ShapeError>> = requests
        .par_iter()
        .map(|request| {
            let shape = build_shape(request, settings, cache);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, requests.len(), &request.name);
            shape
        })
        .collect();
    shapes.into_iter().collect()
}

fn build_shape(request: &ShapeRequest, settings: &ShapeSettings, cache: Option<&Cache>) -> Result<Shape, ShapeError> {
    let mesh = read_scaled(request, "mesh", &request.mesh)?;
    let given: Vec<Mesh> =
        request.convex_parts.iter().map(|file| read_scaled(request, "convex_parts", file)).collect::<Result<_, _>>()?;
    let up = snapped(request.up);
    let budget = part_budget(&request.category).min(settings.max_parts).max(1);
    let mut key = Key::default();
    key.text(ALGORITHM).text(&format!("{settings:?} {budget} {up} {}", request.bears));
    for mesh in std::iter::once(&mesh).chain(&given) {
        key.points(&mesh.vertices).triangles(&mesh.triangles);
    }
    let key = key.finish();
    let (low, high) = hull::bounds(&corners(&mesh).into_iter().flatten().collect::<Vec<_>>());
    for (part, file) in given.iter().zip(&request.convex_parts) {
        let (part_low, part_high) = hull::bounds(&part.vertices);
        let beyond = (low - part_low).max(part_high - high).max_element();
        if beyond > (high - low).max_element() {
            return Err(ShapeError::Part { object: request.name.clone(), file: file.clone(), beyond });
        }
    }
    let mut warning = None;
    let entry = match cache.and_then(|c| c.load::<Entry>(&key)) {
        Some(entry) => entry,
        None => {
            let entry = compute(&mesh, &given, up, budget, request.bears, settings);
            warning = cache.and_then(|c| c.store(&key, &entry).err());
            entry
        }
    };
    if entry.own.parts.is_empty() {
        let field = if given.is_empty() { "mesh" } else { "convex_parts" };
        return Err(ShapeError::Empty { object: request.name.clone(), field });
    }
    let mass = request.mass.unwrap_or_else(|| typical_mass(&request.category, entry.own.volume));
    let (parts, own) = entry.own.of_mass(mass);
    let (other_parts, other) = entry.alternative.of_mass(mass);
    Ok(Shape {
        parts,
        mass: own,
        alternative: Alternative { parts: other_parts, mass: other },
        surface: mesh,
        bounds: [low, high],
        quality: entry.quality,
        notes: entry.notes.into_iter().chain(warning).collect(),
    })
}

/// Reads the mesh of a request and scales it to metres.
///
/// # Errors
/// A mesh that cannot be read, or whose scaled vertices are no plausible numbers.
pub fn scaled_mesh(request: &ShapeRequest) -> Result<Mesh, ShapeError> {
    read_scaled(request, "mesh", &request.mesh)
}

/// Reads a mesh and scales it to metres.
fn read_scaled(request: &ShapeRequest, field: &'static str, file: &Path) -> Result<Mesh, ShapeError> {
    let mut mesh =
        read_mesh(file).map_err(|source| ShapeError::Read { object: request.name.clone(), field, source })?;
    for v in &mut mesh.vertices {
        *v *= request.scale;
    }
    if !mesh.vertices.iter().all(|v| v.is_finite()) {
        return Err(ShapeError::Scale { object: request.name.clone(), scale: request.scale, file: file.to_path_buf() });
    }
    let reach = mesh.vertices.iter().map(|v| v.length()).fold(0.0, f32::max);
    if reach > MAX_REACH {
        return Err(ShapeError::Far { object: request.name.clone(), field, file: file.to_path_buf(), reach });
    }
    Ok(mesh)
}

fn corners(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect()
}

/// The axis of the mesh nearest to `up` if it is near, else `up` itself.
fn snapped(up: Vec3) -> Vec3 {
    let up = up.try_normalize().unwrap_or(Vec3::Y);
    let nearest = Vec3::AXES
        .into_iter()
        .flat_map(|a| [a, -a])
        .fold(Vec3::Y, |best, a| if a.dot(up) > best.dot(up) { a } else { best });
    if nearest.dot(up) >= UP_SNAP { nearest } else { up }
}

fn compute(mesh: &Mesh, given: &[Mesh], up: Vec3, budget: usize, bears: bool, settings: &ShapeSettings) -> Entry {
    let triangles = corners(mesh);
    let levels = Levels::new(triangles.iter().flatten().copied(), up);
    let solid = Solid::new(&triangles, up, settings.cells);
    let mut notes = Vec::new();
    let mut hulls = if given.is_empty() {
        decompose::decompose(&triangles, &solid, &levels, budget, bears, settings, &mut notes)
    } else {
        let points: Vec<Vec<Vec3>> = given.iter().map(|g| corners(g).into_iter().flatten().collect()).collect();
        points.iter().enumerate().flat_map(|(i, points)| ready_made(i, points, &levels, settings, &mut notes)).collect()
    };
    largest_first(&mut hulls);
    let axes = hull::principal_directions(triangles.as_flattened());
    let extent = |axis: Vec3| {
        let along = Levels::new(triangles.iter().flatten().copied(), axis);
        along.high - along.low
    };
    if axes.into_iter().any(|a| extent(a) < hull::MIN_THICKNESS) {
        notes.push(format!("flat: thickened to {:.1} mm", 1e3 * hull::MIN_THICKNESS));
    }
    let quality = measure::measure(&hulls, &triangles, &solid, &levels);
    let (low, high) = hull::bounds(triangles.as_flattened());
    if 1e-3 * quality.uncovered_max_mm > UNCOVERED * (high - low).max_element() {
        notes.push(format!("the parts leave up to {:.0} mm of the mesh uncovered", quality.uncovered_max_mm));
    }
    let other = settings.alternative();
    let mut others =
        decompose::decompose(&triangles, &solid, &levels, ALTERNATIVE_PARTS, bears, &other, &mut Vec::new());
    largest_first(&mut others);
    Entry { quality, own: Body::new(hulls, given.is_empty()), alternative: Body::new(others, false), notes }
}

fn largest_first(hulls: &mut [Hull]) {
    hulls.sort_by(|a, b| b.volume().total_cmp(&a.volume()));
}

/// The hull of a ready-made part, in pieces if it has too many vertices, with notes on what had to be changed.
fn ready_made(
    number: usize,
    points: &[Vec3],
    levels: &Levels,
    settings: &ShapeSettings,
    notes: &mut Vec<String>,
) -> Vec<Hull> {
    let Some(hull) = Hull::new(points) else { return Vec::new() };
    let size = (levels.high - levels.low).max(hull.bounds().1.distance(hull.bounds().0));
    let depth = points.iter().map(|&p| -hull.excess(p)).fold(0.0, f32::max);
    if depth > 1e-3 * size {
        notes.push(format!("convex_parts[{number}] is not convex: its hull is used"));
    }
    let (most, corners) = (settings.max_vertices, hull.vertices.len());
    if corners <= most {
        return vec![hull];
    }
    let pieces = divide::divide(hull, most);
    if pieces.iter().all(|piece| piece.vertices.len() <= most) {
        notes.push(format!("convex_parts[{number}] has {corners} vertices: cut into {} parts", pieces.len()));
        return pieces;
    }
    notes.push(format!("convex_parts[{number}] has {corners} vertices: {} parts cover it", pieces.len()));
    cover::fit(pieces, levels, 0, settings)
}
