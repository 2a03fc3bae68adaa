//! Layers of a dual-pixel sensor: the pictures that the two photodiodes of each photosite see.

use super::colour_layer;
use petzval_image::{ImageLayer, Picture};

/// Names of the layers.
pub(crate) const HALVES: [&str; 2] = ["left", "right"];

/// Returns the layers `left` and `right` of the pictures of both halves of the exit pupil.
pub(crate) fn half_layers(halves: &[Picture; 2]) -> Vec<ImageLayer> {
    HALVES
        .into_iter()
        .zip(halves)
        .map(|(name, picture)| colour_layer(name, &picture.pixels))
        .collect()
}
