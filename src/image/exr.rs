//! OpenEXR files. This is the only module that uses the `exr` crate.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::MetaData;
use exr::meta::attribute::{Chromaticities, LevelMode};
use exr::meta::header::Header;
use exr::prelude::*;
use glam::{DMat3, DVec3};

use super::declared::{block_bytes, hold_picture, too_large};
use super::{
    EncodingOptions, ImageError, ImageSamples, Note, Notes, Picture, PictureWindow, Raster,
};
use petzval_base::io::{HeldMemory, ReadContext, machine};
use petzval_spectrum::Primaries;

/// Largest finite 16-bit float.
const HALF_MAX: f32 = 65504.0;

/// Bytes of a pixel of a picture, and of a picture with alpha from which the alpha is removed: four
/// floats, and three.
const PICTURE: u64 = 12;
const RASTER: u64 = 16 + 12;
/// Blocks that are unpacked at once for each core: packed, unpacked, and sorted by channels.
const BLOCK_COPIES: u64 = 3;

/// Reads a picture, and whether it is of luminance alone. Returns also the memory that is held for it.
pub(super) fn read(
    path: &Path,
    context: &ReadContext,
) -> std::result::Result<((Picture, bool), HeldMemory), ImageError> {
    let held = hold_parts(path, context, PICTURE)?;
    Ok((read_held(path)?, held))
}

fn read_held(path: &Path) -> std::result::Result<(Picture, bool), ImageError> {
    let create = |size: Vec2<usize>| Picture {
        size: [size.width(), size.height()],
        pixels: vec![[0.0; 3]; size.area()],
    };
    let rgb = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("R")
        .required("G")
        .required("B")
        .collect_pixels(
            move |size, _| create(size),
            |picture: &mut Picture, at, (r, g, b): (f32, f32, f32)| {
                picture.pixels[at.y() * picture.size[0] + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path);
    match rgb {
        Ok(image) => {
            let mut picture = image.layer_data.channel_data.pixels;
            if let Some(matrix) = to_srgb(&image.attributes, Primaries::to) {
                picture.pixels.iter_mut().for_each(|pixel| *pixel = convert(&matrix, *pixel));
            }
            return Ok((picture, false));
        }
        Err(Error::Io(source)) => {
            return Err(ImageError::Io { verb: "read", path: path.to_owned(), source });
        }
        Err(_) => {}
    }
    // Without red, green and blue, the file may have luminance.
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("Y")
        .collect_pixels(
            move |size, _| create(size),
            |picture: &mut Picture, at, (y,): (f32,)| {
                picture.pixels[at.y() * picture.size[0] + at.x()] = [y; 3];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map(|image| (image.layer_data.channel_data.pixels, true))
        .map_err(|error| ImageError::Malformed {
            path: path.to_owned(),
            found: format!("no layer with channels R, G, B or Y ({error})"),
        })
}

/// Holds the memory that the reading of a file takes, with this many bytes per pixel: those of the first
/// picture that is valid, thus of the largest part, and the blocks in work. A header that cannot be read is
/// left to the reader's error.
fn hold_parts(
    path: &Path,
    context: &ReadContext,
    pixel: u64,
) -> std::result::Result<HeldMemory, ImageError> {
    let refused = |found| too_large(path, found);
    let mut held = context.hold(0).map_err(refused)?;
    let Ok(meta) = MetaData::read_from_file(path, false) else { return Ok(held) };
    let size = |header: &Header| [header.layer_size.width(), header.layer_size.height()];
    for header in &meta.headers {
        let block = header.max_block_pixel_size();
        let bytes = header.channels.bytes_per_pixel as u64;
        let block = block_bytes(path, [block.width(), block.height()], bytes)?;
        // There are no more blocks in work than in the picture.
        let all = (size(header)[0] as u64 * bytes).saturating_mul(size(header)[1] as u64);
        let blocks = block.saturating_mul(machine::cores() as u64).min(all.max(block));
        held.add(blocks.saturating_mul(BLOCK_COPIES)).map_err(refused)?;
    }
    let area = |header: &&Header| header.layer_size.area();
    if let Some(largest) = meta.headers.iter().max_by_key(area) {
        held = hold_picture(context, path, size(largest), pixel)?.with(held);
    }
    Ok(held)
}

/// Reads a picture with its alpha, or with luminance alone. Returns also the memory that is held for it.
pub(super) fn read_raster(
    path: &Path,
    context: &ReadContext,
) -> std::result::Result<(Raster, HeldMemory), ImageError> {
    let held = hold_parts(path, context, RASTER)?;
    Ok((read_raster_held(path)?, held))
}

fn read_raster_held(path: &Path) -> std::result::Result<Raster, ImageError> {
    type Pixels = (Vec2<usize>, Vec<f32>);
    let rgba = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("R")
        .required("G")
        .required("B")
        .optional("A", 1.0)
        .collect_pixels(
            |size, _| (size, vec![0.0; 4 * size.area()]),
            |(size, all): &mut Pixels, at, (r, g, b, a): (f32, f32, f32, f32)| {
                let first = 4 * (at.y() * size.width() + at.x());
                all[first..first + 4].copy_from_slice(&[r, g, b, a]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path);
    match rgba {
        Ok(image) => {
            let (size, mut floats) = image.layer_data.channel_data.pixels;
            if let Some(matrix) = to_srgb(&image.attributes, Primaries::adapted_to) {
                for [r, g, b, _] in floats.as_chunks_mut::<4>().0 {
                    [*r, *g, *b] = convert(&matrix, [*r, *g, *b]);
                }
            }
            let size = [size.width(), size.height()];
            return Ok(Raster { size, channels: 4, samples: ImageSamples::Floats(floats) });
        }
        Err(Error::Io(source)) => {
            return Err(ImageError::Io { verb: "read", path: path.to_owned(), source });
        }
        Err(_) => {}
    }
    let (Picture { size, pixels }, _) = read_held(path)?;
    let samples = ImageSamples::Floats(pixels.iter().map(|[y, _, _]| *y).collect());
    Ok(Raster { size, channels: 1, samples })
}

/// Returns the matrix from the space of a file to sRGB, if the file declares another.
fn to_srgb(
    attributes: &ImageAttributes,
    matrix: fn(&Primaries, &Primaries) -> Option<DMat3>,
) -> Option<DMat3> {
    let found = attributes.chromaticities?;
    let point = |Vec2(x, y): Vec2<f32>| [f64::from(x), f64::from(y)];
    let space = Primaries {
        red: point(found.red),
        green: point(found.green),
        blue: point(found.blue),
        white: point(found.white),
    };
    matrix(&space, &Primaries::SRGB).filter(|_| !space.is_near(&Primaries::SRGB))
}

fn convert(matrix: &DMat3, pixel: [f32; 3]) -> [f32; 3] {
    (*matrix * DVec3::from_array(pixel.map(f64::from))).to_array().map(|c| c as f32)
}

/// Writes one part: R, G and B, or Y of a grey picture, and the channels of layers as `layer.channel`, where
/// compositors look for layers; that of the opacity is A. Layers always have 32-bit floats, as they may hold
/// counts.
pub(super) fn write(
    picture: &Picture,
    layers: &[super::ImageLayer],
    window: PictureWindow,
    EncodingOptions { half, space, grey, .. }: EncodingOptions,
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
    let (mut layer, mut image) = attributes(notes);
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
    let mut list: SmallVec<[_; 4]> = names.iter().copied().zip(0..).map(colour).collect();
    for extra in layers {
        for (name, values) in &extra.channels {
            if values.len() != width * height {
                let (found, expected) = (values.len(), width * height);
                let found =
                    format!("{}.{name} has {found} values, expected {expected}", extra.name);
                return Err(io::Error::new(io::ErrorKind::InvalidInput, found));
            }
            let name = match extra.name == super::ALPHA_LAYER {
                true => ascii(name),
                false => ascii(&format!("{}.{name}", extra.name)),
            };
            list.push(AnyChannel::new(name, Values::Layer(values)));
        }
    }
    let layer = Layer::new((width, height), layer, encoding, AnyChannels::sort(list));
    Image::new(image, layer).write().to_buffered(out).map_err(failed)
}

/// Writes channels of 32-bit floats whose pixels may lie beyond the frame, as overscan.
pub(super) fn write_channels(
    channels: &super::ChannelImage,
    notes: &Notes,
    file: &mut File,
) -> io::Result<()> {
    let super::ChannelImage { origin: [x, y], size: [width, height], frame, .. } = *channels;
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let (mut layer, mut image) = attributes(notes);
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
fn attributes(notes: &Notes) -> (LayerAttributes, ImageAttributes) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::io::ReadContext;
    use petzval_base::io::{FileLog, OutputFile};

    /// ACES2065-1 (SMPTE ST 2065-1).
    const ACES: Primaries = Primaries {
        red: [0.7347, 0.2653],
        green: [0.0, 1.0],
        blue: [0.0001, -0.077],
        white: [0.32168, 0.33767],
    };

    fn written(space: Option<Primaries>, half: bool) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let picture = Picture { size: [2, 1], pixels: vec![[1.0; 3], [0.6, 0.3, 0.1]] };
        let window = PictureWindow { origin: [0, 0], frame: [2, 1] };
        let encoding = EncodingOptions { space, half, ..EncodingOptions::default() };
        let to = OutputFile::new(&path, &FileLog::default()).unwrap();
        picture.write(&to, window, encoding, &Vec::new()).unwrap();
        (folder, path)
    }

    #[test]
    fn a_file_in_another_space_says_so_and_is_read_back_as_srgb() {
        for half in [false, true] {
            let (_folder, path) = written(Some(ACES), half);
            let meta = MetaData::read_from_file(&path, false).unwrap();
            let found = meta.headers[0].shared_attributes.chromaticities.expect("an attribute");
            assert_eq!(found.white, Vec2(0.32168, 0.33767));
            let picture = Picture::read(&path).unwrap();
            for (found, expected) in picture.pixels.iter().zip([[1.0; 3], [0.6, 0.3, 0.1]]) {
                let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
                assert!(off < if half { 2e-3 } else { 1e-5 }, "{found:?}");
            }
        }
    }

    #[test]
    fn a_texture_of_another_space_is_adapted_from_white_to_white() {
        let (_folder, path) = written(Some(ACES), false);
        let raster = Raster::read(&path, Default::default(), &ReadContext::default()).unwrap();
        let found = raster.into_picture().pixels[1];
        let to_file = Primaries::SRGB.to(&ACES).unwrap();
        let matrix = ACES.adapted_to(&Primaries::SRGB).unwrap() * to_file;
        let expected = convert(&matrix, [0.6, 0.3, 0.1]);
        let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{found:?}, expected {expected:?}");
        assert!((found[2] / 0.1 - 1.0).abs() > 0.02, "{found:?}");
    }

    #[test]
    fn a_file_in_srgb_has_no_attribute() {
        let (_folder, path) = written(None, false);
        let meta = MetaData::read_from_file(&path, false).unwrap();
        assert!(meta.headers[0].shared_attributes.chromaticities.is_none());
        assert_eq!(Picture::read(&path).unwrap().pixels[1], [0.6, 0.3, 0.1]);
    }
}
