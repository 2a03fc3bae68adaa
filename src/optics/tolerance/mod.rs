//! Tolerances: image quality of lenses as they are made, with small errors of every quantity.

pub(crate) mod distribution;
mod element;
pub(crate) mod figure;
pub(crate) mod grade;
pub(crate) mod monte_carlo;
pub(crate) mod parameter;
mod perturbed_lens;
mod random_deviation;
