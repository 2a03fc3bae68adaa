//! Optimization of lenses: damped least squares over named variables.

mod constraint;
pub(crate) mod design_optimization;
mod merit;
pub(crate) mod target;
pub(crate) mod variable;
