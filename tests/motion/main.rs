//! Motion during the exposure: blur, shutters, rolling shutters.

#[path = "../support/mod.rs"]
mod support;

mod edges;
mod hits;
mod plan;
mod rolling;
mod stills;
mod world;
