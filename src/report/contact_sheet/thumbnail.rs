//! Downscaling of pictures by box averages.

use petzval_image::Picture;

/// Scales a picture to fit into a place, in its own proportions, to at least one pixel. Every pixel
/// is the mean of the light in its part of the picture.
pub(super) fn thumbnail(picture: &Picture, place: [usize; 2]) -> Picture {
    let [width, height] = picture.size;
    if width == 0 || height == 0 {
        return Picture { size: [1, 1], pixels: vec![[0.0; 3]] };
    }
    let scale = [0, 1].map(|i| place[i] as f64 / picture.size[i] as f64);
    let scale = scale[0].min(scale[1]);
    let size =
        [0, 1].map(|i| ((picture.size[i] as f64 * scale).round() as usize).clamp(1, place[i]));
    // Range of source pixels of a pixel, along one side; a single one if the picture is enlarged.
    let part = |at: usize, of: usize, i: usize| {
        let first = at * picture.size[i] / of;
        first..((at + 1) * picture.size[i] / of).max(first + 1)
    };
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for row in 0..size[1] {
        let rows = part(row, size[1], 1);
        for column in 0..size[0] {
            let columns = part(column, size[0], 0);
            let count = (rows.len() * columns.len()) as f32;
            let mut sum = [0.0; 3];
            for line in rows.clone() {
                for pixel in &picture.pixels[line * width..][columns.clone()] {
                    for (sum, light) in sum.iter_mut().zip(pixel) {
                        *sum += light;
                    }
                }
            }
            pixels.push(sum.map(|sum| sum / count));
        }
    }
    Picture { size, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(size: [usize; 2]) -> Picture {
        let pixels = (0..size[0] * size[1]).map(|i| [(i % size[0]) as f32, 1.0, 0.0]).collect();
        Picture { size, pixels }
    }

    #[test]
    fn light_and_proportions_are_kept() {
        let small = thumbnail(&ramp([300, 200]), [60, 60]);
        assert_eq!(small.size, [60, 40]);
        for (i, pixel) in small.pixels.iter().enumerate() {
            assert_eq!(*pixel, [(i % 60) as f32 * 5.0 + 2.0, 1.0, 0.0]);
        }
    }

    #[test]
    fn a_small_picture_is_enlarged_by_its_pixels() {
        let large = thumbnail(&ramp([2, 1]), [60, 60]);
        assert_eq!(large.size, [60, 30]);
        assert!(large.pixels.iter().enumerate().all(|(i, p)| p[0] == (i % 60 / 30) as f32));
        assert_eq!(thumbnail(&ramp([5, 65536]), [30, 60]).size, [1, 60]);
    }
}
