//! Motion during the exposure: blur, shutters, rolling shutters.

mod edges;
mod hits;
mod plan;
mod rolling;
mod stills;
mod vectors;
mod world;
