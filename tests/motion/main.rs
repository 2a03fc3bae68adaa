//! What moves while the film is exposed.

#[path = "../support/mod.rs"]
mod support;

mod edges;
mod hits;
mod plan;
mod rolling;
mod stills;
mod world;
