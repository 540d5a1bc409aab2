//! The two narrow phases against each other, against the hulls' extents and against closed forms.
//!
//! `twin` joins nearly coplanar triangles to one face, so its axes may be off by `COPLANAR_DISTANCE` a hull; parry's
//! EPA stops within 1e-5 of the size. Everything random is compared within the sum of the two.
#![allow(clippy::unwrap_used)]

mod by_hand;
#[path = "../common/mod.rs"]
mod common;
mod fixture;
mod random;
mod real;
