//! Path tracer: agreement with a naive one and with closed forms, and white furnaces.

mod bumps;
mod compare;
mod depth;
mod furnace;
mod language;
mod long_paths;
mod material;
mod matter;
mod media;
mod naive;
mod outdoors;
mod rooms;
mod world;
