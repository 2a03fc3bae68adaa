//! Reading of OpenEXR pictures.

use std::path::Path;

use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::*;
use glam::{DMat3, DVec3};

use crate::declared::{block_bytes, hold_picture, too_large};
use crate::{ImageError, ImageSamples, Picture, Raster};
use petzval_base::io::{HeldMemory, ReadContext, machine};
use petzval_spectrum::Primaries;

/// Bytes of a pixel of a picture, and of a picture with alpha from which the alpha is removed: four
/// floats, and three.
const PICTURE: u64 = 12;
const RASTER: u64 = 16 + 12;
/// Blocks that are unpacked at once for each core: packed, unpacked, and sorted by channels.
const BLOCK_COPIES: u64 = 3;

/// Reads a picture, and whether it is of luminance alone. Returns also the memory that is held for it.
pub(crate) fn read(
    path: &Path,
    context: &ReadContext,
) -> std::result::Result<((Picture, bool), HeldMemory), ImageError> {
    let held = hold_parts(path, context, |_| PICTURE)?;
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
pub(super) fn hold_parts(
    path: &Path,
    context: &ReadContext,
    pixel: impl Fn(&[Header]) -> u64,
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
        held = hold_picture(context, path, size(largest), pixel(&meta.headers))?.with(held);
    }
    Ok(held)
}

/// Reads a picture with its alpha, or with luminance alone. Returns also the memory that is held for it.
pub(crate) fn read_raster(
    path: &Path,
    context: &ReadContext,
) -> std::result::Result<(Raster, HeldMemory), ImageError> {
    let held = hold_parts(path, context, |_| RASTER)?;
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

pub(super) fn convert(matrix: &DMat3, pixel: [f32; 3]) -> [f32; 3] {
    (*matrix * DVec3::from_array(pixel.map(f64::from))).to_array().map(|c| c as f32)
}
