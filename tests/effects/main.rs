//! Effects: each against a direct computation, and the plan that chooses them.

#[path = "../support/mod.rs"]
mod support;

mod aov;
mod camera_filters;
mod caustics;
mod diffraction;
mod dispersion;
mod dual_pixel;
mod emva;
mod ghosts;
mod hero;
mod light_paths;
mod motion;
mod photosites;
mod plan;
mod sensor;
mod spectra;
mod spectral_film;
mod spectral_light_paths;
