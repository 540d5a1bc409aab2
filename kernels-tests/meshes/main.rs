//! Mesh files: one tetrahedron in every format, the peculiarities of real files, and damage of every kind.
#![allow(clippy::unwrap_used)]

mod damage;
mod fixture;
mod formats;
