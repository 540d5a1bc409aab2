//! Canonicalization: synthetic rooms whose right layout is known, what must stay the same, bad input, and the shared rooms.
#![allow(clippy::unwrap_used)]

mod command;
mod fixture;
mod rooms;
mod scenes;
