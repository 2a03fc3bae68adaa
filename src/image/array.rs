//! Pictures as arrays of NumPy.

use std::io::{self, Write};

use crate::{ImageLayer, Picture};
use petzval_base::io::npy;

/// Writes an array of 32-bit floats: height x width x channels of a layer, or height x width x 3 of the
/// colours, or height x width of a grey picture.
pub(crate) fn write(
    picture: &Picture,
    layer: Option<&ImageLayer>,
    grey: bool,
    mut to: impl Write,
) -> io::Result<()> {
    let [width, height] = picture.size;
    let channels = match (layer, grey) {
        (Some(layer), _) => Some(layer.channels.len()),
        (None, false) => Some(3),
        (None, true) => None,
    };
    let shape: Vec<usize> = [height, width].into_iter().chain(channels).collect();
    to.write_all(&npy::header(&shape))?;
    let mut put = |value: f32| to.write_all(&value.to_le_bytes());
    match layer {
        Some(ImageLayer { name, channels, .. }) => {
            if channels.iter().any(|(_, values)| values.len() != width * height) {
                let found = format!("a channel of {name} has another size than the picture");
                return Err(io::Error::new(io::ErrorKind::InvalidInput, found));
            }
            (0..width * height).try_for_each(|pixel| {
                channels.iter().try_for_each(|(_, values)| put(values[pixel]))
            })?;
        }
        None => {
            let kept = channels.unwrap_or(1);
            picture.pixels.iter().flat_map(|pixel| &pixel[..kept]).try_for_each(|&v| put(v))?;
        }
    }
    to.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(layer: Option<&ImageLayer>, grey: bool) -> (String, Vec<f32>) {
        let picture = Picture { size: [2, 1], pixels: vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]] };
        let mut file = Vec::new();
        write(&picture, layer, grey, &mut file).expect("a vector takes every byte");
        let length = 10 + usize::from(u16::from_le_bytes([file[8], file[9]]));
        let values = file[length..].as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        (String::from_utf8_lossy(&file[10..length]).into_owned(), values.collect())
    }

    #[test]
    fn colours_and_spectra_have_the_last_axis_fastest() {
        let (header, values) = written(None, false);
        assert!(header.contains("'shape': (1, 2, 3,)"), "{header}");
        assert_eq!(values, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let (header, values) = written(None, true);
        assert!(header.contains("'shape': (1, 2,)"), "{header}");
        assert_eq!(values, [1.0, 4.0]);
        let spectrum = crate::spectral_layer(&[400.0, 500.0], |i| vec![i as f32, i as f32 + 7.0]);
        let (header, values) = written(Some(&spectrum), false);
        assert!(header.contains("'shape': (1, 2, 2,)"), "{header}");
        assert_eq!(values, [0.0, 1.0, 7.0, 8.0]);
        let short = crate::spectral_layer(&[400.0], |_| vec![0.0]);
        assert!(write(&Picture::default(), Some(&short), false, io::sink()).is_err());
    }
}
