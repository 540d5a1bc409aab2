//! Making shapes: read, decompose or take ready-made parts, weigh, measure, and keep the result.

use super::tolerances::build::{ALTERNATIVE_PARTS, UNCOVERED, UP_SNAP};
use super::tolerances::hull::MIN_THICKNESS;
use super::voxels;
use super::{
    Alternative, Cache, MAX_REACH, Mesh, Part, Quality, Shape, ShapeError, ShapeRequest, ShapeSettings,
    cache::Key,
    category::USUAL_BUDGET,
    cover, decompose, divide, hull,
    hull::Hull,
    mass,
    mass::MassProperties,
    measure, padding, part_budget, read_mesh,
    reduce::{Levels, reduce},
    soles,
    solid::Solid,
    typical_mass,
};
use glam::{Quat, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::cell::LazyCell;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Changes whenever the same input would give other parts, so that old cache entries are not found.
const ALGORITHM: &str = "shape 45";
/// What the cache holds of a shape: all but the mass, which depends on the category, and the alternatives, which have
/// an entry of their own.
#[derive(Clone, Serialize, Deserialize)]
struct Entry {
    own: Body,
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
        let mut unit = mass::of_parts(&hulls);
        let volume = unit.volume;
        if pad {
            hulls = soles::flattened(hulls.into_iter().map(padding::padded).collect(), unit.center);
            unit = mass::of_parts(&hulls);
        }
        let parts = hulls.into_iter().map(|hull| hull.vertices).collect();
        Self { parts, volume, center: unit.center, axes: unit.axes, inertia: unit.inertia }
    }

    fn of_mass(self, mass: f32) -> (Vec<Part>, MassProperties) {
        let parts = self.parts.into_iter().map(|vertices| Part { vertices }).collect();
        let Self { volume, center, axes, inertia, .. } = self;
        (parts, MassProperties { mass, volume, center, axes, inertia: inertia * mass })
    }
}

/// Makes the shapes of all requests, in parallel and in order. `progress` is called with (done, total, name) after
/// each, from any thread.
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
    let all = ShapeSettings { alternatives: true, ..settings.clone() };
    let mut key = Key::default();
    key.text(ALGORITHM).text(&format!("{all:?} {up} {}", request.bears));
    key.points(&mesh.vertices).triangles(&mesh.triangles);
    // They do not depend on what follows.
    let alternatives_key = key.finish();
    key.text(&budget.to_string());
    for part in &given {
        key.points(&part.vertices).triangles(&part.triangles);
    }
    let (low, high) = hull::bounds(&corners(&mesh).into_iter().flatten().collect::<Vec<_>>());
    for (part, file) in given.iter().zip(&request.convex_parts) {
        let (part_low, part_high) = hull::bounds(&part.vertices);
        let beyond = (low - part_low).max(part_high - high).max_element();
        if beyond > (high - low).max_element() {
            return Err(ShapeError::Part { object: request.name.clone(), file: file.clone(), beyond });
        }
    }
    let source = Source::new(&mesh, up, request.bears, settings);
    let entry = remembered(cache, &key.finish(), || source.entry(&given, budget));
    if entry.own.parts.is_empty() {
        let field = if given.is_empty() { "mesh" } else { "convex_parts" };
        return Err(ShapeError::Empty { object: request.name.clone(), field });
    }
    let others = match settings.alternatives {
        true => remembered(cache, &alternatives_key, || source.alternatives()),
        false => Vec::new(),
    };
    let others: Vec<Body> = others.into_iter().map(|body| body.unwrap_or_else(|| entry.own.clone())).collect();
    let mass = request.mass.unwrap_or_else(|| typical_mass(&request.category, entry.own.volume));
    let (parts, own) = entry.own.of_mass(mass);
    let alternative = |body: Body| {
        let (parts, mass) = body.of_mass(mass);
        Alternative { parts, mass }
    };
    let alternatives = others.into_iter().map(alternative).collect();
    // It borrows the mesh.
    drop(source);
    Ok(Shape {
        parts,
        mass: own,
        alternatives,
        surface: mesh,
        bounds: [low, high],
        quality: entry.quality,
        notes: entry.notes,
    })
}

/// What the cache has under this key, or else what `compute` gives, which it has from then on.
fn remembered<T: Serialize + DeserializeOwned>(
    cache: Option<&Cache>,
    key: &blake3::Hash,
    compute: impl FnOnce() -> T,
) -> T {
    if let Some(known) = cache.and_then(|cache| cache.load(key)) {
        return known;
    }
    let made = compute();
    // What cannot be stored is made again.
    cache.map(|cache| cache.store(key, &made).ok());
    made
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

/// A mesh to be cut, and how.
struct Source<'a> {
    mesh: &'a Mesh,
    bears: bool,
    settings: &'a ShapeSettings,
    made: LazyCell<Made, Box<dyn FnOnce() -> Made + 'a>>,
}

/// A mesh's triangles, its heights and its inside; made when they are first asked for.
type Made = (Vec<[Vec3; 3]>, Levels, Solid);

impl<'a> Source<'a> {
    fn new(mesh: &'a Mesh, up: Vec3, bears: bool, settings: &'a ShapeSettings) -> Self {
        let make = move || {
            let triangles = corners(mesh);
            let levels = Levels::new(triangles.iter().flatten().copied(), up);
            let solid = Solid::new(&triangles, up, settings.cells);
            (triangles, levels, solid)
        };
        Self { mesh, bears, settings, made: LazyCell::new(Box::new(make)) }
    }

    fn entry(&self, given: &[Mesh], budget: usize) -> Entry {
        let (triangles, levels, solid) = &*self.made;
        let settings = self.settings;
        let mut notes = Vec::new();
        let mut hulls = if given.is_empty() {
            self.cut(budget, &mut notes)
        } else {
            let points: Vec<Vec<Vec3>> = given.iter().map(|g| corners(g).into_iter().flatten().collect()).collect();
            let ready = |(i, points): (usize, &Vec<Vec3>)| ready_made(i, points, levels, settings, &mut notes);
            points.iter().enumerate().flat_map(ready).collect()
        };
        largest_first(&mut hulls);
        let axes = hull::principal_directions(triangles.as_flattened());
        let extent = |axis: Vec3| {
            let along = Levels::new(triangles.iter().flatten().copied(), axis);
            along.high - along.low
        };
        if axes.into_iter().any(|a| extent(a) < MIN_THICKNESS) {
            notes.push(format!("flat: thickened to {:.1} mm", 1e3 * MIN_THICKNESS));
        }
        let quality = measure::measure(&hulls, triangles, solid, levels);
        let (low, high) = hull::bounds(triangles.as_flattened());
        if 1e-3 * quality.uncovered_max_mm > UNCOVERED * (high - low).max_element() {
            notes.push(format!("the parts leave up to {:.0} mm of the mesh uncovered", quality.uncovered_max_mm));
        }
        Entry { quality, own: Body::new(hulls, given.is_empty()), notes }
    }

    /// Its parts. What few parts stand for so badly that they are cut into more than most objects have is cut into as
    /// many as those from the start, if it then takes fewer and holds less: merged boards that close the slots between
    /// them stay merged, however often they are cut.
    fn cut(&self, budget: usize, notes: &mut Vec<String>) -> Vec<Hull> {
        let (triangles, levels, solid) = &*self.made;
        let cut = |budget: usize| {
            let mut notes = Vec::new();
            let hulls = decompose::decompose(triangles, solid, levels, budget, self.bears, self.settings, &mut notes);
            (hulls, notes)
        };
        let volume = |hulls: &[Hull]| hulls.iter().map(Hull::volume).sum::<f32>();
        let most = USUAL_BUDGET.min(self.settings.max_parts);
        let mut best = cut(budget);
        if best.0.len() > most && budget < most {
            let other = cut(most);
            if other.0.len() < best.0.len() && volume(&other.0) < volume(&best.0) {
                best = other;
            }
        }
        notes.append(&mut best.1);
        best.0
    }

    /// The alternatives: by the same method, and by V-HACD; none where one finds nothing.
    fn alternatives(&self) -> Vec<Option<Body>> {
        let (triangles, levels, solid) = &*self.made;
        let settings = self.settings.alternative();
        let (mesh, bears, most) = (self.mesh, self.bears, settings.max_vertices);
        let (coarse, voxels) = rayon::join(
            || decompose::decompose(triangles, solid, levels, ALTERNATIVE_PARTS, bears, &settings, &mut Vec::new()),
            || voxels::decompose(mesh, ALTERNATIVE_PARTS),
        );
        let voxels = voxels.iter().map(|hull| reduce(hull, levels, most, most)).collect();
        let body = |mut hulls: Vec<Hull>| {
            largest_first(&mut hulls);
            (!hulls.is_empty()).then(|| Body::new(hulls, false))
        };
        [coarse, voxels].map(body).into()
    }
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
    pieces.iter().map(|piece| cover::covering(piece, levels, settings).0).collect()
}
