//! Writing of OpenEXR pictures.

use std::fs::File;
use std::io::{self, BufWriter};

use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::attribute::{Chromaticities, LevelMode};
use exr::meta::header::Header;
use exr::prelude::*;
use glam::DVec3;

use crate::spectral::spectral_notes;
use crate::{
    ALPHA_LAYER, ChannelImage, EncodingOptions, ImageLayer, Note, Notes, Picture, PictureWindow,
    SPECTRAL_LAYER,
};
use petzval_spectrum::Primaries;

/// Largest finite 16-bit float.
const HALF_MAX: f32 = 65504.0;

/// Name of the part of the colours in a file of several parts.
const COLOUR_PART: &str = "rgba";

/// Writes R, G and B, or Y of a grey picture, and the channels of layers as `layer.channel`, where
/// compositors look for layers; that of the opacity is A. Layers always have 32-bit floats, as they may hold
/// counts.
///
/// All channels are in one part or, if so asked, those of each layer in a part with its name. The names of channels
/// are the same, and the opacity stays beside the colours.
pub(crate) fn write(
    picture: &Picture,
    layers: &[ImageLayer],
    window: PictureWindow,
    EncodingOptions { half, multipart, space, grey, .. }: EncodingOptions,
    notes: &Notes,
    file: &mut File,
) -> io::Result<()> {
    let [width, height] = picture.size;
    // Readings of photosites are in no colour space.
    let matrix = space.filter(|_| !grey).and_then(|space| Primaries::SRGB.to(&space));
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let is_spectral = layers.iter().any(|layer| layer.name == SPECTRAL_LAYER);
    let spectral = if is_spectral { spectral_notes() } else { Notes::new() };
    let (mut layer, mut image) = attributes(notes.iter().chain(&spectral));
    // The first part has the metadata of all layers: some programs read no other.
    for extra in layers {
        layer.other.extend(attributes(extra.notes.iter()).1.other);
    }
    if let (Some(space), Some(_)) = (space, &matrix) {
        let [red, green, blue, white] = space.coordinates().map(|[x, y]| Vec2(x as f32, y as f32));
        image.chromaticities = Some(Chromaticities { red, green, blue, white });
    }
    let [x, y] = window.origin.map(|v| v as i32);
    layer.layer_position = Vec2(x, y);
    image.display_window = IntegerBounds::from_dimensions(Vec2::from((
        window.frame[0] as usize,
        window.frame[1] as usize,
    )));
    let out = BufWriter::new(file);
    let failed = |error: Error| match error {
        Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    };
    let colour = |(name, channel)| {
        let row = matrix.map(|matrix| matrix.row(channel));
        AnyChannel::new(name, Values::Colour { pixels: &picture.pixels, channel, row, half })
    };
    let names: &[&str] = if grey { &["Y"] } else { &["R", "G", "B"] };
    let mut parts: Vec<(LayerAttributes, SmallVec<[_; 4]>)> =
        vec![(layer.clone(), names.iter().copied().zip(0..).map(colour).collect())];
    if multipart {
        parts[0].0.layer_name = Some(Text::from(COLOUR_PART));
    }
    for extra in layers {
        if multipart && extra.name != ALPHA_LAYER {
            let (own, shared) = attributes(extra.notes.iter());
            let mut own = LayerAttributes { layer_position: layer.layer_position, ..own };
            own.layer_name = Some(ascii(&extra.name));
            own.other = shared.other;
            parts.push((own, SmallVec::new()));
        }
        for (name, values) in &extra.channels {
            if values.len() != width * height {
                let (found, expected) = (values.len(), width * height);
                let found =
                    format!("{}.{name} has {found} values, expected {expected}", extra.name);
                return Err(io::Error::new(io::ErrorKind::InvalidInput, found));
            }
            let name = match extra.name == ALPHA_LAYER {
                true => ascii(name),
                false => ascii(&format!("{}.{name}", extra.name)),
            };
            let place = if extra.name == ALPHA_LAYER { 0 } else { parts.len() - 1 };
            parts[place].1.push(AnyChannel::new(name, Values::Layer(values)));
        }
    }
    let parts = parts.into_iter().map(|(attributes, list)| {
        Layer::new((width, height), attributes, encoding, AnyChannels::sort(list))
    });
    let parts: Layers<_> = parts.collect();
    Image::from_layers(image, parts).write().to_buffered(out).map_err(failed)
}

/// Writes channels of 32-bit floats whose pixels may lie beyond the frame, as overscan.
pub(crate) fn write_channels(
    channels: &ChannelImage,
    notes: &Notes,
    file: &mut File,
) -> io::Result<()> {
    let ChannelImage { origin: [x, y], size: [width, height], frame, .. } = *channels;
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let (mut layer, mut image) = attributes(notes.iter());
    layer.layer_position = Vec2(x, y);
    image.display_window =
        IntegerBounds::from_dimensions(Vec2(frame[0] as usize, frame[1] as usize));
    let channel = |(name, values): &'_ (&str, Vec<f32>)| match values.len() == width * height {
        true => Ok(name.to_string()),
        false => {
            let problem = format!("channel {name} has {} values", values.len());
            Err(io::Error::new(io::ErrorKind::InvalidInput, problem))
        }
    };
    let names: Vec<String> = channels.channels.iter().map(channel).collect::<io::Result<_>>()?;
    let list: SmallVec<[_; 4]> = names
        .iter()
        .zip(&channels.channels)
        .map(|(name, (_, values))| AnyChannel::new(ascii(name), Values::Layer(values)))
        .collect();
    let layer = Layer::new((width, height), layer, encoding, AnyChannels::sort(list));
    let written = Image::new(image, layer).write().to_buffered(BufWriter::new(file));
    written.map_err(|error| match error {
        Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    })
}

/// Values of a channel, borrowed, as copies would double the memory of the picture and its layers.
#[derive(Clone, Copy, Debug)]
enum Values<'a> {
    /// Linear sRGB, or its product with a row of the matrix to another space.
    Colour {
        pixels: &'a [[f32; 3]],
        channel: usize,
        row: Option<DVec3>,
        half: bool,
    },
    Layer(&'a [f32]),
}

impl<'a> WritableSamples<'_> for Values<'a> {
    type Writer = Lines<'a>;

    fn sample_type(&self) -> SampleType {
        match self {
            Self::Colour { half: true, .. } => SampleType::F16,
            _ => SampleType::F32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&self, header: &Header) -> Lines<'a> {
        Lines { values: *self, width: header.layer_size.width() }
    }
}

/// The rows of a channel.
struct Lines<'a> {
    values: Values<'a>,
    width: usize,
}

impl SamplesWriter for Lines<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let first = line.location.position.y() * self.width + line.location.position.x();
        let written = match self.values {
            Values::Colour { pixels, channel, row: None, half: false } => {
                line.write_samples(|i| pixels[first + i][channel])
            }
            Values::Colour { pixels, channel, row, half } => {
                let value = |i: usize| match row {
                    Some(row) => {
                        row.dot(DVec3::from_array(pixels[first + i].map(f64::from))) as f32
                    }
                    None => pixels[first + i][channel],
                };
                match half {
                    true => {
                        line.write_samples(|i| f16::from_f32(value(i).clamp(-HALF_MAX, HALF_MAX)))
                    }
                    false => line.write_samples(value),
                }
            }
            Values::Layer(values) => line.write_samples(|i| values[first + i]),
        };
        debug_assert!(written.is_ok(), "a line has room for its own samples");
    }
}

/// Converts notes to attributes. OpenEXR's standard attributes get their standard names and types.
fn attributes<'a>(
    notes: impl Iterator<Item = &'a (&'static str, Note)>,
) -> (LayerAttributes, ImageAttributes) {
    let mut layer = LayerAttributes::default();
    let mut image = ImageAttributes::new(IntegerBounds::zero());
    for (name, note) in notes {
        match (*name, note) {
            ("aperture", Note::Number(n)) => layer.aperture = Some(*n as f32),
            ("focus", Note::Number(n)) => layer.focus = Some(*n as f32),
            ("isoSpeed", Note::Number(n)) => layer.iso_speed = Some(*n as f32),
            ("expTime", Note::Number(n)) => layer.exposure = Some(*n as f32),
            ("software", Note::Text(text)) => layer.software_name = Some(ascii(text)),
            (name, Note::Number(n)) => {
                image.other.insert(Text::from(name), AttributeValue::F32(*n as f32));
            }
            (name, Note::Text(text)) => {
                image.other.insert(Text::from(name), AttributeValue::Text(ascii(text)));
            }
        }
    }
    (layer, image)
}

/// Replaces characters other than ASCII by question marks, as EXR texts have single bytes.
fn ascii(text: &str) -> Text {
    let plain: String = text.chars().map(|c| if c.is_ascii() { c } else { '?' }).collect();
    Text::from(plain.as_str())
}
