//! Layers of a dual-pixel sensor: the pictures that the two photodiodes of each photosite see.

use super::colour_layer;
use petzval_image::{ImageLayer, Picture};

/// Names of the layers.
pub(crate) const HALVES: [&str; 2] = ["left", "right"];

/// Returns the layers `left` and `right` of the pictures of both halves of the exit pupil. Mosaics have one channel.
pub(crate) fn half_layers(halves: &[Picture; 2], mosaic: bool) -> Vec<ImageLayer> {
    let layer = |(name, picture): (&str, &Picture)| {
        let mut layer = colour_layer(name, &picture.pixels);
        if mosaic {
            layer.channels.truncate(1);
            "Y".clone_into(&mut layer.channels[0].0);
        }
        layer
    };
    HALVES.into_iter().zip(halves).map(layer).collect()
}
