//! Shading: BSDFs, paths and radiometry.

#[path = "../support/mod.rs"]
mod support;

mod bsdf;
mod light;
mod light_scale;
mod mirrored_textures;
mod path;
mod roulette;
