//! Lens: prescriptions, traces, pupils and cameras, against formulas, an independent oracle and brute force.

#[path = "../support/mod.rs"]
mod support;

mod absorption;
mod apertures;
mod biradial;
mod cameras;
mod coating;
mod fisheye;
mod glass;
mod kernels;
mod known;
mod mirrors;
mod pupil;
mod pupil_density;
mod pupil_weight;
mod stability;
mod stop;
mod tilt;
mod trace;
mod zoom;
