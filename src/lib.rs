//! Petzval photographs 3-D scenes through real, multi-element camera lenses.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod film;
pub mod image;
pub mod job;
pub mod lanes;
pub mod lens;
pub mod rays;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod shade;
pub mod source;
pub mod stats;
