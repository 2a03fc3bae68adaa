//! Scene: shapes, rays that meet them, and lights.

#[path = "../support/mod.rs"]
mod support;

mod curves;
mod lights;
mod scale;
mod shapes;
mod watertight;
