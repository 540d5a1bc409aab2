//! Pictures of scenes: what a painter is given, and the [`Painter`] trait.
//!
//! A [`Stage`] is everything that is seen, as triangles; a [`Camera`] says from where; `light` says from where they are
//! lit. Both painters, `gpu::GpuPainter` and `cpu::CpuPainter`, shade them by the same formulas. Nothing here prints.

mod camera;
mod choose;
mod layout;
mod light;
mod model;
mod normals;
mod palette;
mod room;
mod scan;
pub(crate) mod shading;
mod sheet;
mod stage;
mod text;
mod texture;

pub use camera::{Camera, Size, Viewpoint};
pub use layout::{Light, Vertex, View, pack_normal, unpack_normal};
pub use light::{SKIES, SKY_SIDE, SUN_SIDE, SUNS, lights};
pub use model::Models;
pub use scan::{Screen, project};
pub use sheet::{Cell, Sheet, sheet, size as sheet_size};
pub use stage::{Batch, Casters, Kind, Stage};
pub use texture::{Texture, byte_to_linear, to_byte};

use crate::scene::{Scene, SceneError};
use glam::{DVec3, Vec2, Vec3};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// What is seen where nothing is, linear.
pub const BACKGROUND: Vec3 = Vec3::new(0.80, 0.81, 0.82);
/// From light to brightness.
const EXPOSURE: f32 = 1.45;
/// See [`share_a_view`].
const MUCH_LARGER: f64 = 1.25;
/// Share of the scene's half extent within which nothing is drawn before the eye.
const NEAR: f32 = 1e-3;

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// The user can mend it.
    #[error("{0}")]
    Input(String),
    /// Anything else.
    #[error("{0}")]
    Failed(String),
}

impl From<SceneError> for RenderError {
    fn from(error: SceneError) -> Self {
        Self::Input(error.to_string())
    }
}

/// A picture: rows from the top, three bytes of sRGB a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns and rows.
    pub size: Size,
    /// `3 · width · height` bytes.
    pub rgb: Vec<u8>,
}

impl Picture {
    /// All of one colour.
    pub fn filled(size: Size, color: [u8; 3]) -> Self {
        Self { size, rgb: color.repeat(size.width as usize * size.height as usize) }
    }

    /// As a PNG file. The same picture gives the same bytes.
    ///
    /// # Errors
    /// If the picture has fewer bytes than its size says.
    pub fn png(&self) -> Result<Vec<u8>, RenderError> {
        let mut bytes = Vec::new();
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
            .write_image(&self.rgb, self.size.width, self.size.height, ExtendedColorType::Rgb8)
            .map_err(|error| RenderError::Failed(format!("PNG: {error}")))?;
        Ok(bytes)
    }
}

/// What draws.
pub trait Painter {
    /// Name of the processor.
    fn describe(&self) -> String;

    /// Draws a stage.
    ///
    /// # Errors
    /// A size that it cannot do, or a fault of the device.
    fn paint(&self, stage: &Stage, camera: &Camera, size: Size) -> Result<Picture, RenderError>;
}

/// Reads the meshes of a scene and sets it up. What the user should know is in the stage's notes.
///
/// # Errors
/// A mesh that cannot be read, or what [`Stage::new`] says.
pub fn stage(scene: &Scene, models: &mut Models) -> Result<Stage, RenderError> {
    let notes = models.load(scene).map_err(|(object, error)| {
        RenderError::Input(format!("{}: object \"{object}\", field \"mesh\": {error}", scene.file.display()))
    })?;
    let mut stage = Stage::new(scene, models)?;
    stage.notes.splice(0..0, notes);
    Ok(stage)
}

/// The camera for pictures of all these stages, of which the first decides what a good view is. `scene` is the first
/// one's, in whose frame an exact viewpoint is given.
pub fn camera(viewpoint: Viewpoint, scene: &Scene, stages: &[&Stage], size: Size) -> Camera {
    let points: Vec<DVec3> = stages.iter().flat_map(|stage| stage.framed.iter().copied()).collect();
    match viewpoint {
        Viewpoint::Auto => {
            let azimuth = stages.first().map_or(0.0, |stage| choose::azimuth(stage));
            Camera::framing(azimuth, camera::AUTO_ELEVATION, &points, size.aspect())
        }
        Viewpoint::Toward { azimuth, elevation } => Camera::framing(azimuth, elevation, &points, size.aspect()),
        Viewpoint::Exact { eye, target } => {
            Camera::exact(scene.point_of_file(eye), scene.point_of_file(target), size.aspect())
        }
    }
}

/// True if one camera does for all stages: together they are not much larger than the largest of them. A raw
/// reconstruction lies somewhere else than what was made of it.
pub fn share_a_view(stages: &[&Stage]) -> bool {
    let bounds = |points: &mut dyn Iterator<Item = DVec3>| {
        let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        (high - low).max(DVec3::ZERO).length()
    };
    let largest = stages.iter().map(|stage| bounds(&mut stage.framed.iter().copied())).fold(0.0, f64::max);
    bounds(&mut stages.iter().flat_map(|stage| stage.framed.iter().copied())) <= MUCH_LARGER * largest
}

/// What shaders are told of a picture.
pub fn view(stage: &Stage, camera: &Camera, size: Size, lights: &[Light]) -> View {
    let near = near(stage);
    let [sun, sky] = light::intensities(lights);
    let grid = f64::from(grid(stage.radius));
    let line = |at: f64| (-at.rem_euclid(grid)) as f32;
    View {
        clip: camera.clip(stage.origin, f64::from(near)).as_mat4(),
        eye: (camera.eye - stage.origin).as_vec3(),
        pixel: (2.0 * camera.slope / f64::from(size.height)) as f32,
        background: BACKGROUND,
        exposure: EXPOSURE,
        bounce: light::BOUNCE,
        grid: grid as f32,
        center: stage.center,
        radius: stage.radius,
        suns: SUNS,
        skies: SKIES,
        grid_at: Vec2::new(line(stage.origin.x), line(stage.origin.z)),
        forward: camera.forward.as_vec3(),
        width: size.width as f32,
        across: (camera.right * camera.slope * camera.aspect).as_vec3(),
        height: size.height as f32,
        upward: (camera.up * camera.slope).as_vec3(),
        padding: 0.0,
        sun,
        padding_2: 0.0,
        sky,
        padding_3: 0.0,
        open: light::open(lights),
    }
}

/// Nearer to the eye than this, nothing is drawn, m.
pub fn near(stage: &Stage) -> f32 {
    (NEAR * stage.radius).max(1e-6)
}

/// Distance of the lines on the ground, m: 1 or 5 times a power of ten, a few of them along the scene.
fn grid(radius: f32) -> f32 {
    let wanted = (radius / 2.5).max(1e-6);
    let power = 10.0_f32.powf(wanted.log10().floor());
    if wanted >= 3.0 * power { 5.0 * power } else { power }
}
