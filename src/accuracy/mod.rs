//! What accuracy costs in time: one scene, photographed by a ladder of camera models, each with a
//! ladder of samples, measured against the richest within a budget of time.
//!
//! # What is measured
//!
//! A picture's error has two parts: noise, which falls as samples rise, and that of the model, which
//! stays. [`Point::error`] is both, against a [`Reference`] of the richest model with seeds of its
//! own and most of the time; [`Point::noise`] is the first and [`Point::bias`] the second, told apart
//! by independent quarters of the samples ([`Bias`]). All rungs take the same seeds, so that
//! differences between their pictures are mostly those between their models.
//!
//! What is done with the finished picture, diffraction and the sensor, is left out of all rungs.

mod advice;
mod bias;
mod climb;
mod crops;
mod frontier;
mod machine;
mod pace;
mod page;
mod plot;
mod point;
mod quarters;
mod report;
mod rung;
mod table;
mod watch;

pub use advice::Verdict;
pub use bias::{Bias, bias};
pub use climb::{Budget, Climb, Ended, climb};
pub use frontier::frontier;
pub use machine::Machine;
pub use pace::Pace;
pub use point::{Point, Reference};
pub use report::{FILES, Report};
pub use rung::{Ladder, Rung};
pub use watch::Watch;
