//! Layers of OpenEXR pictures besides colour.

use std::path::Path;

use exr::prelude::*;

use super::read::hold_parts;
use crate::{ALPHA_LAYER, ImageError, ImageLayer};
use petzval_base::io::ReadContext;

/// Layers of a picture, without its colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureLayers {
    /// Column and row of the first pixel in the whole frame.
    pub origin: [i32; 2],
    /// Width and height.
    pub size: [usize; 2],
    /// The layers and their channels, in alphabetical order, as the file has them.
    pub layers: Vec<ImageLayer>,
}

impl PictureLayers {
    /// Reads the layers of an OpenEXR file: all channels that are called `layer.channel`, and `A`.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, or if its channels have several resolutions.
    pub fn read(path: &Path, context: &ReadContext) -> std::result::Result<Self, ImageError> {
        let bytes = |header: &exr::meta::header::Header| 2 * header.channels.bytes_per_pixel as u64;
        let _held = hold_parts(path, context, bytes)?;
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(path)
            .map_err(|error| match error {
                Error::Io(source) => ImageError::Io { verb: "read", path: path.to_owned(), source },
                other => ImageError::Malformed { path: path.to_owned(), found: other.to_string() },
            })?;
        let part = image.layer_data;
        let origin = part.attributes.layer_position;
        let mut found = Self {
            origin: [origin.x(), origin.y()],
            size: [part.size.width(), part.size.height()],
            layers: Vec::new(),
        };
        for channel in part.channel_data.list {
            let full_name = channel.name.to_string();
            let (layer, name) = match full_name.rsplit_once('.') {
                Some(parts) => parts,
                None if full_name == "A" => (ALPHA_LAYER, "A"),
                None => continue,
            };
            if channel.sampling != Vec2(1, 1) {
                return Err(ImageError::Malformed {
                    path: path.to_owned(),
                    found: format!("the channel {full_name} leaves out pixels"),
                });
            }
            let values = channel.sample_data.values_as_f32().collect();
            let values = (name.to_owned(), values);
            match found.layers.iter_mut().find(|known| known.name == layer) {
                Some(known) => known.channels.push(values),
                None => {
                    found
                        .layers
                        .push(ImageLayer { name: layer.to_owned(), channels: vec![values] });
                }
            }
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EncodingOptions, Picture, PictureWindow};
    use petzval_base::io::{FileLog, OutputFile};

    #[test]
    fn layers_come_back_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let picture = Picture { size: [3, 20], pixels: vec![[1.0; 3]; 60] };
        let channel = |name: &str, scale: f32| {
            (name.to_owned(), (0..60).map(|i| scale * i as f32 - 1.0).collect::<Vec<f32>>())
        };
        let layers = [
            ImageLayer { name: ALPHA_LAYER.into(), channels: vec![channel("A", 0.01)] },
            ImageLayer {
                name: "object".into(),
                channels: vec![channel("instance", 3.0), channel("shape", 1.0)],
            },
        ];
        let window = PictureWindow { origin: [5, 7], frame: [30, 40] };
        let to = OutputFile::new(&path, &FileLog::default()).unwrap();
        let encoding = EncodingOptions::default();
        picture.write_with_layers(&layers, &to, window, encoding, &Vec::new()).unwrap();
        let found = PictureLayers::read(&path, &ReadContext::default()).unwrap();
        assert_eq!((found.origin, found.size), ([5, 7], [3, 20]));
        assert_eq!(found.layers, layers);

        std::fs::write(&path, &std::fs::read(&path).unwrap()[..300]).unwrap();
        let error = PictureLayers::read(&path, &ReadContext::default()).unwrap_err();
        assert!(error.to_string().contains("a.exr"), "{error}");
        let missing = PictureLayers::read(&folder.path().join("b.exr"), &ReadContext::default());
        assert!(matches!(missing, Err(ImageError::Io { .. })));
    }
}
