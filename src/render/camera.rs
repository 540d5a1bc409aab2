//! Where a picture is taken from.

use super::RenderError;
use glam::{DMat4, DVec3, DVec4};
use std::str::FromStr;

/// Height of the picture's field of view, degrees: as wide as a photograph of a room, narrow enough to keep verticals.
const FIELD: f64 = 32.0;
/// Share of the picture that stays free around the scene on each side.
const MARGIN: f64 = 0.05;
/// Height angle of the views from a side and of those that are chosen, degrees.
const SIDE_ELEVATION: f64 = 12.0;
pub(super) const AUTO_ELEVATION: f64 = 27.0;
/// Steepest height angle: straight down would leave open what is up in the picture.
const STEEPEST: f64 = 89.9;

/// What the user wants to look from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Viewpoint {
    /// From where most is seen.
    #[default]
    Auto,
    /// From a direction, near enough that the scene fills the picture: degrees around the vertical, 0 from +Z (in a
    /// file with Z up: from −Y), 90 from +X, and degrees above the horizon.
    Toward {
        /// Any finite number.
        azimuth: f64,
        /// −89 to 90.
        elevation: f64,
    },
    /// From a point to a point, in the frame and unit of the scene's file.
    Exact {
        /// The eye.
        eye: DVec3,
        /// What is in the middle of the picture; not the eye.
        target: DVec3,
    },
}

impl FromStr for Viewpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |azimuth, elevation| Ok(Self::Toward { azimuth, elevation });
        match text.trim().to_lowercase().as_str() {
            "auto" => return Ok(Self::Auto),
            "top" => return side(0.0, 90.0),
            "front" => return side(0.0, SIDE_ELEVATION),
            "right" => return side(90.0, SIDE_ELEVATION),
            "back" => return side(180.0, SIDE_ELEVATION),
            "left" => return side(270.0, SIDE_ELEVATION),
            _ => {}
        }
        let numbers: Option<Vec<f64>> =
            text.split(',').map(|word| word.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
        match numbers.as_deref() {
            Some(&[azimuth, elevation]) if (-89.0..=90.0).contains(&elevation) => side(azimuth, elevation),
            Some(&[_, elevation]) => Err(format!("{elevation}° above the horizon is not from -89 to 90")),
            Some(&[a, b, c, d, e, f]) => match (DVec3::new(a, b, c), DVec3::new(d, e, f)) {
                (eye, target) if eye != target => Ok(Self::Exact { eye, target }),
                _ => Err("eye and target are the same point; move one of them".into()),
            },
            _ => {
                Err("write auto, top, front, back, left, right, two numbers (degrees around and above, such as 30,25) \
                      or six (x,y,z of the eye and of the target)"
                    .into())
            }
        }
    }
}

/// A pinhole camera in our frame: metres, Y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// m.
    pub eye: DVec3,
    /// Unit vector to the right of the picture, horizontal.
    pub right: DVec3,
    /// Unit vector to its top.
    pub up: DVec3,
    /// Unit vector into it.
    pub forward: DVec3,
    /// Half of the picture's height at distance 1.
    pub slope: f64,
    /// Width of the picture over its height.
    pub aspect: f64,
}

impl Camera {
    /// Looks along a direction, such that all `points` just fit in.
    pub fn framing(azimuth: f64, elevation: f64, points: &[DVec3], aspect: f64) -> Self {
        let mut camera = Self::from_direction(azimuth, elevation, aspect);
        // Each side of the picture is a plane through the eye; the point that is farthest out decides where it lies.
        let slope = camera.slope * (1.0 - 2.0 * MARGIN);
        let slopes = [slope * aspect, slope];
        let mut bounds = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
        let mut nearest = f64::INFINITY;
        for &p in points {
            let depth = p.dot(camera.forward);
            nearest = nearest.min(depth);
            for ((bound, slope), across) in bounds.iter_mut().zip(slopes).zip([p.dot(camera.right), p.dot(camera.up)]) {
                bound[0] = bound[0].max(across - slope * depth);
                bound[1] = bound[1].min(across + slope * depth);
            }
        }
        if nearest.is_finite() {
            let depth = bounds.iter().zip(slopes).map(|([low, high], slope)| 0.5 * (high - low) / slope);
            let depth = depth.fold(f64::INFINITY, f64::min).min(nearest - 1e-3);
            let [x, y] = bounds.map(|[low, high]| 0.5 * (low + high));
            camera.eye = camera.right * x + camera.up * y + camera.forward * depth;
        }
        camera
    }

    /// Looks from a point to another one.
    pub fn exact(eye: DVec3, target: DVec3, aspect: f64) -> Self {
        let back = (eye - target).normalize_or(DVec3::Z);
        let (azimuth, elevation) = (back.x.atan2(back.z).to_degrees(), back.y.clamp(-1.0, 1.0).asin().to_degrees());
        Self { eye, ..Self::from_direction(azimuth, elevation, aspect) }
    }

    /// The eye at the origin.
    fn from_direction(azimuth: f64, elevation: f64, aspect: f64) -> Self {
        let (sin, cos) = azimuth.to_radians().sin_cos();
        let (high, level) = elevation.clamp(-STEEPEST, STEEPEST).to_radians().sin_cos();
        let forward = -DVec3::new(sin * level, high, cos * level);
        let right = DVec3::new(cos, 0.0, -sin);
        let slope = (0.5 * FIELD).to_radians().tan();
        Self { eye: DVec3::ZERO, right, up: right.cross(forward), forward, slope, aspect }
    }

    /// From our frame, `origin` subtracted, to clip space: x to the right, y up, z the nearer the larger, 0 at infinity
    /// and `near` over distance elsewhere; w the distance.
    pub fn clip(&self, origin: DVec3, near: f64) -> DMat4 {
        let eye = self.eye - origin;
        let row = |axis: DVec3, scale: f64| (axis * scale).extend(-axis.dot(eye) * scale);
        let x = row(self.right, 1.0 / (self.slope * self.aspect));
        let y = row(self.up, 1.0 / self.slope);
        let w = row(self.forward, 1.0);
        DMat4::from_cols(x, y, DVec4::W * near, w).transpose()
    }

    /// Unit vector at a right angle to the vertical, towards the viewer.
    pub fn toward_viewer(&self) -> DVec3 {
        self.right.cross(DVec3::Y)
    }
}

/// Width and height of a picture, px, written `1600x1200`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Size {
    /// Largest width and height.
    pub const MOST: u32 = 8192;

    /// Width over height.
    pub fn aspect(self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }

    /// Checks that a picture can have this size.
    ///
    /// # Errors
    /// A side of less than 16 or more than [`Size::MOST`] pixels.
    pub fn check(self) -> Result<(), RenderError> {
        let sides = 16..=Self::MOST;
        if sides.contains(&self.width) && sides.contains(&self.height) {
            return Ok(());
        }
        let Self { width, height } = self;
        Err(RenderError::Input(format!("a picture of {width}x{height}: sides are from 16 to {} pixels", Self::MOST)))
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides = text.split_once(['x', 'X', '×']);
        let sides =
            sides.and_then(|(w, h)| Some(Self { width: w.trim().parse().ok()?, height: h.trim().parse().ok()? }));
        let size = sides.ok_or("write columns x rows, such as 1600x1200")?;
        size.check().map_err(|error| error.to_string())?;
        Ok(size)
    }
}
