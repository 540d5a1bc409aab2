//! Numbers by which both painters shade: `cpu::raster` and `shaders/raster/picture.wgsl`, which imports them.

/// Light that was found out at half the resolution counts for a pixel as far as it lies in its plane: by half if it is
/// so many pixels off …
pub const OFF_PLANE: f32 = 0.7;

/// … and faces as it does: power of the cosine between the two normals.
pub const ALIKE: i32 = 8;

/// Where all that counts for less than this together, on edges and thin things, the light is found out for the pixel
/// itself …
pub const LEAST_KNOWN: f32 = 0.15;

/// … by every so many-th light, which is enough for them.
pub const SPARSE: usize = 4;

/// Light of surfaces that face none, as a cosine: a little more than nothing, because shares are made of it.
pub const NO_LIGHT: f32 = 1e-6;

/// A point is looked up off its surface by this less the cosine of the light, in `Light::offset`: a little even where
/// the light falls straight onto it.
pub const GRAZING: f32 = 1.15;

/// The ground is lit up to this distance from the scene's middle, in half extents of the scene …
pub const FADE_FROM: f32 = 1.5;

/// … and fades into the background up to this one.
pub const FADE_TO: f32 = 3.2;

/// Half the width of a line on the ground, in half extents of the scene.
pub const LINE: f32 = 0.0015;

/// The edge of a line is soft by so many pixels to either side.
pub const LINE_EDGE: f32 = 0.75;

/// Share of the light that a line takes away.
pub const LINE_SHADE: f32 = 0.16;

/// The ground is taken to be seen from at least this far, m …
pub const LEAST_AWAY: f32 = 1e-6;

/// … and at no smaller angle than of this sine: lines would be soft without bound.
pub const FLATTEST_VIEW: f32 = 0.02;

/// Linear colour of walls.
pub const WALL_RED: f32 = 0.86;
/// See `WALL_RED`.
pub const WALL_GREEN: f32 = 0.85;
/// See `WALL_RED`.
pub const WALL_BLUE: f32 = 0.83;

/// Share of a shadow that is seen on a wall.
pub const WALL_SHADE: f32 = 0.7;

/// Opacity of walls.
pub const WALL_OPACITY: f32 = 0.6;

/// A wall from behind is as bright as this share of the background …
pub const BACK: f32 = 0.5;

/// … and so opaque.
pub const BACK_OPACITY: f32 = 0.06;
