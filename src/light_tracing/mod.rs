//! Light tracing: paths that start at the lights of a scene and end on the film.
//!
//! Camera paths hardly ever hit a small light, and by a reflection inside the lens never. Three
//! strategies start at the lights instead: images of lamps, caustics and ghosts. Each traces waves of
//! light paths, and one stage splats them on the film.

pub mod caustics;
pub mod ghosts;
pub mod lamp_images;
pub mod light_paths;
mod splat_stage;
mod strategy;

pub use splat_stage::SplatStage;
pub use strategy::Strategy;
