//! Foundation of petzval: lanes, rays, random numbers, statistics and files.
//!
//! It knows no optics and no scene. Kernels are generic over [`lanes::Real`], so one source serves one
//! lane and eight. Rays live in the columns of [`rays`]. Each random number of [`sampler`] is a function
//! of pixel, sample, dimension and seed. [`io`] reads files within a memory budget and replaces them at
//! once.
//!
//! ```
//! use petzval_base::lanes::{Real, f32x8};
//!
//! /// Returns the length of a vector, for one lane or eight.
//! fn length<R: Real>(x: R, y: R) -> R {
//!     (x * x + y * y).sqrt()
//! }
//!
//! assert_eq!(length(3.0f32, 4.0), 5.0);
//! assert_eq!(length(f32x8::splat(3.0), f32x8::splat(4.0)), f32x8::splat(5.0));
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bisection;
pub mod distribution;
pub mod equal_area;
pub mod io;
pub mod lanes;
pub mod least_squares;
pub mod plane_newton;
pub mod rays;
pub mod sampler;
pub mod sinc;
pub mod stats;
