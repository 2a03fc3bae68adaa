//! Layers of OpenEXR pictures besides colour.

use std::path::Path;

use exr::meta::MetaData;
use exr::meta::header::Header;
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
    /// Reads the layers of an OpenEXR file, of one part or of several: all channels that are called `layer.channel`,
    /// `A`, and the channels of further parts of the same size, which may give the layer's name themselves.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, or if its channels have several resolutions.
    pub fn read(path: &Path, context: &ReadContext) -> std::result::Result<Self, ImageError> {
        let bytes = |parts: &[Header]| {
            2 * parts.iter().map(|part| part.channels.bytes_per_pixel as u64).sum::<u64>()
        };
        let _held = hold_parts(path, context, bytes)?;
        let failed = |error| match error {
            Error::Io(source) => ImageError::Io { verb: "read", path: path.to_owned(), source },
            other => ImageError::Malformed { path: path.to_owned(), found: other.to_string() },
        };
        let reader =
            || exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
        // Parts of deep samples are not read, and flat ones beside them one at a time.
        let has_deep = MetaData::read_from_file(path, false)
            .is_ok_and(|meta| meta.headers.iter().any(|part| part.deep));
        let parts: Layers<_> = match has_deep {
            false => {
                reader().all_layers().all_attributes().from_file(path).map_err(failed)?.layer_data
            }
            true => {
                let image = reader().first_valid_layer().all_attributes().from_file(path);
                std::iter::once(image.map_err(failed)?.layer_data).collect()
            }
        };
        let malformed = |found| ImageError::Malformed { path: path.to_owned(), found };
        let window = |part: &Layer<_>| (part.attributes.layer_position, part.size);
        let Some(largest) = parts.iter().max_by_key(|part| part.size.area()).map(window) else {
            return Err(malformed("the file has no part".to_owned()));
        };
        let (origin, size) = largest;
        let mut found = Self {
            origin: [origin.x(), origin.y()],
            size: [size.width(), size.height()],
            layers: Vec::new(),
        };
        // Smaller parts are no layers of this picture, but previews. The first of the others has its colours.
        let kept = parts.into_iter().filter(|part| window(part) == largest);
        for (number, part) in kept.enumerate() {
            let part_name = part.attributes.layer_name.as_ref().map(Text::to_string);
            for channel in part.channel_data.list {
                let full_name = channel.name.to_string();
                let (layer, name) = match (full_name.rsplit_once('.'), &part_name) {
                    (Some(names), _) => names,
                    (None, Some(part)) if number > 0 => (&part[..], &full_name[..]),
                    (None, _) if full_name == "A" => (ALPHA_LAYER, "A"),
                    (None, _) => continue,
                };
                if channel.sampling != Vec2(1, 1) {
                    return Err(malformed(format!("the channel {full_name} leaves out pixels")));
                }
                let values = (name.to_owned(), channel.sample_data.values_as_f32().collect());
                match found.layers.iter_mut().find(|known| known.name == layer) {
                    Some(known) => known.channels.push(values),
                    None => found.layers.push(ImageLayer::new(layer, vec![values])),
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
    fn parts_of_other_programs_name_layers_and_previews_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let part = |name: &str, size: (usize, usize), channels: &[&str]| {
            let values = |&name: &&str| {
                let values = (0..size.0 * size.1).map(|i| i as f32).collect::<Vec<f32>>();
                AnyChannel::new(name, FlatSamples::F32(values))
            };
            let list = channels.iter().map(values).collect();
            let attributes = LayerAttributes::named(name);
            Layer::new(size, attributes, Encoding::UNCOMPRESSED, AnyChannels::sort(list))
        };
        let parts: Layers<_> = [
            part("preview", (2, 1), &["R", "G", "B"]),
            part("rgba", (4, 3), &["R", "G", "B"]),
            part("depth", (4, 3), &["Z"]),
            part("light", (4, 3), &["key.R"]),
        ]
        .into_iter()
        .collect();
        let image =
            Image::from_layers(ImageAttributes::new(IntegerBounds::from_dimensions((4, 3))), parts);
        image.write().to_file(&path).unwrap();
        let found = PictureLayers::read(&path, &ReadContext::default()).unwrap();
        assert_eq!(found.size, [4, 3]);
        let names: Vec<_> = found
            .layers
            .iter()
            .map(|layer| format!("{}.{}", layer.name, layer.channels[0].0))
            .collect();
        assert_eq!(names, ["depth.Z", "key.R"]);
        // Damage is no layer that is missing.
        let mut bytes = std::fs::read(&path).unwrap();
        bytes.truncate(bytes.len() - 20);
        std::fs::write(&path, &bytes).unwrap();
        assert!(PictureLayers::read(&path, &ReadContext::default()).is_err());
    }

    #[test]
    fn layers_come_back_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let picture = Picture { size: [3, 20], pixels: vec![[1.0; 3]; 60] };
        let channel = |name: &str, scale: f32| {
            (name.to_owned(), (0..60).map(|i| scale * i as f32 - 1.0).collect::<Vec<f32>>())
        };
        let layers = [
            ImageLayer::new(ALPHA_LAYER, vec![channel("A", 0.01)]),
            ImageLayer::new("object", vec![channel("instance", 3.0), channel("shape", 1.0)]),
        ];
        let window = PictureWindow { origin: [5, 7], frame: [30, 40] };
        let to = OutputFile::new(&path, &FileLog::default()).unwrap();
        for multipart in [false, true] {
            let encoding = EncodingOptions { multipart, ..EncodingOptions::default() };
            picture.write_with_layers(&layers, &to, window, encoding, &Vec::new()).unwrap();
            let found = PictureLayers::read(&path, &ReadContext::default()).unwrap();
            assert_eq!((found.origin, found.size), ([5, 7], [3, 20]));
            assert_eq!(found.layers, layers);
            assert_eq!(Picture::read(&path).unwrap(), picture);
            let parts = exr::meta::MetaData::read_from_file(&path, false).unwrap().headers;
            let names = parts.iter().map(|part| part.own_attributes.layer_name.clone());
            let names: Vec<_> = names.map(|name| name.map(|name| name.to_string())).collect();
            let expected = [Some("rgba".to_owned()), Some("object".to_owned())];
            assert_eq!(names, if multipart { expected.to_vec() } else { vec![None] });
        }

        std::fs::write(&path, &std::fs::read(&path).unwrap()[..300]).unwrap();
        let error = PictureLayers::read(&path, &ReadContext::default()).unwrap_err();
        assert!(error.to_string().contains("a.exr"), "{error}");
        let missing = PictureLayers::read(&folder.path().join("b.exr"), &ReadContext::default());
        assert!(matches!(missing, Err(ImageError::Io { .. })));
    }
}
