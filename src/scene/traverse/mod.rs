//! Rays against a tree: the nearest hit, or any hit.
//!
//! One ray meets eight boxes or eight triangles at a time ([`walk`]); eight rays that go together
//! meet one box at a time ([`Bundle`]).

mod boxes;
mod bundle;
mod nearest;
mod ray;
mod sift;
mod triangles;
mod walk;

pub use walk::TraversalStack;
pub(super) use walk::walk;
pub(super) use {bundle::Bundle, nearest::Nearest, ray::Prepared, sift::near, walk::Beyond};
