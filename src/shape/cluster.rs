//! Pieces that share one hull, and their sides at a plane.

use super::hull::Hull;
use super::solid::Solid;
use super::split::Piece;
use glam::Vec3;

/// What becomes one part.
#[derive(Clone)]
pub(super) struct Cluster {
    /// What of the solid it stands for. Its hull may reach across others.
    pieces: Vec<Piece>,
    /// The hull of them all.
    pub hull: Hull,
}

impl Cluster {
    /// These pieces as one.
    pub fn new(pieces: Vec<Piece>) -> Option<Self> {
        let hull = match &pieces[..] {
            [piece] => piece.hull.clone(),
            _ => Hull::new(&pieces.iter().flat_map(|piece| piece.hull.vertices.iter().copied()).collect::<Vec<_>>())?,
        };
        Some(Self { pieces, hull })
    }

    /// Two clusters as one.
    pub fn joined(&self, other: &Self) -> Option<Self> {
        Self::new(self.pieces.iter().chain(&other.pieces).cloned().collect())
    }

    /// Its surface, clipped to its pieces, m.
    pub fn triangles(&self) -> impl Iterator<Item = &[Vec3; 3]> {
        self.pieces.iter().flat_map(|piece| &piece.triangles)
    }

    /// What lies on both sides of the plane `normal · x = offset`.
    pub fn sides(&self, normal: Vec3, offset: f32, solid: &Solid) -> [Option<Self>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        for piece in &self.pieces {
            for (side, piece) in sides.iter_mut().zip(piece.sides(normal, offset, solid)) {
                side.extend(piece);
            }
        }
        sides.map(Self::new)
    }

    /// What lies on both sides of the plane through the middle of its extent along `axis`.
    pub fn halves(&self, axis: Vec3, solid: &Solid) -> [Option<Self>; 2] {
        let (low, high) = self.hull.extent(axis);
        self.sides(axis, 0.5 * (low + high), solid)
    }
}
