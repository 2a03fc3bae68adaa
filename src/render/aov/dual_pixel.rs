//! Layers of a dual-pixel sensor: the pictures that the two photodiodes of each photosite see.

use super::colour_layer;
use crate::film::FilmSums;
use petzval_image::ImageLayer;

/// Returns the layers `left` and `right`, given the number of samples of each pixel; `None` if the film
/// does not know the halves of the pupil.
pub(super) fn dual_pixel(film: &FilmSums, samples: u32) -> Option<[ImageLayer; 2]> {
    let left = film.left_half(samples)?;
    let whole = film.picture(samples);
    let halves = left.pixels.iter().zip(&whole.pixels);
    let right: Vec<_> = halves.map(|(left, whole)| [0, 1, 2].map(|c| whole[c] - left[c])).collect();
    Some([colour_layer("left", &left.pixels), colour_layer("right", &right)])
}
