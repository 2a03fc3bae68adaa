//! First-order data and focus: by paraxial optics, and by real rays.

pub mod focus_model;
pub mod paraxial;
pub mod real_ray;
pub mod stop_diameter;
