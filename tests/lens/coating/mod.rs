//! Reflection losses: one surface against the textbook, a lens against the product of its surfaces, a
//! picture against the estimate.

mod picture;
mod rays;
mod surface;

use petzval_lens::Coating;

const ALL: [Coating; 4] = [Coating::Bare, Coating::Mgf2, Coating::Broadband, Coating::Perfect];
