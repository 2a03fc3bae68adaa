//! Curves with a width, such as hairs and blades of grass, with pbrt-v4's definitions.
//!
//! A curve consists of cubic Bezier segments. Rays meet the curve itself; only a curve that emits
//! light becomes a mesh.

mod intersect;
mod piece;
mod set;
mod surface;
mod tessellate;

pub use intersect::{CurveCrossing, CurveRay};
pub use piece::{CurvePiece, PieceBounds};
pub use set::{CubicPoints, CurveKind, CurveSet};
pub use tessellate::{CurveSegment, tessellate_curve};

use glam::DVec3;

/// Interpolates between two directions at a constant angular rate (Shoemake 1985).
fn slerp(from: DVec3, to: DVec3, t: f64) -> DVec3 {
    let angle = from.angle_between(to);
    let sin = angle.sin();
    if sin < 1e-6 {
        return from.lerp(to, t);
    }
    (from * ((1.0 - t) * angle).sin() + to * (t * angle).sin()) / sin
}
