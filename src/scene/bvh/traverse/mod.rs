//! Traversal of a hierarchy for the nearest hit or for any hit.
//!
//! A single ray tests eight boxes or eight triangles at a time ([`traverse`]). A packet of eight
//! rays tests one box at a time ([`RayPacket`]).

mod boxes;
mod curves;
mod nearest;
mod patches;
mod quadrics;
mod ray;
mod ray_packet;
mod ray_packet_leaves;
mod single_ray;
mod triangles;

pub(crate) use boxes::may_hit_box;
pub(crate) use nearest::NearestHit;
pub(crate) use ray::{RayQueue, TraversalRay};
pub(crate) use ray_packet::RayPacket;
pub use single_ray::TraversalStack;
pub(crate) use single_ray::{LeafIntersector, traverse};
