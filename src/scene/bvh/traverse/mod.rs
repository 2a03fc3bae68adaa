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

pub(in crate::scene) use boxes::may_hit_box;
pub(in crate::scene) use nearest::NearestHit;
pub(in crate::scene) use ray::{RayQueue, TraversalRay};
pub(in crate::scene) use ray_packet::RayPacket;
pub use single_ray::TraversalStack;
pub(in crate::scene) use single_ray::{LeafIntersector, traverse};
