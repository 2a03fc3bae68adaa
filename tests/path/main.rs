//! The whole path tracer against a naive one, against closed forms, and in white furnaces.

#[path = "../support/mod.rs"]
mod support;

mod bumps;
mod compare;
mod depth;
mod furnace;
mod language;
mod matter;
mod outdoors;
mod rooms;
mod walk;
mod world;
