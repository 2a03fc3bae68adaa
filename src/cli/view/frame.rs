//! Frame: a picture as the browser receives it.

use std::fs;

use petzval_base::io::Outputs;
use petzval_image::{EncodingOptions, Note, Picture};
use petzval_render::film::Frame;

use crate::cli::Failure;

/// A picture of the view in some state of refinement.
#[derive(Clone, Debug)]
pub(super) struct ViewFrame {
    /// The number of the settings that it shows.
    pub generation: u64,
    pub picture: Picture,
    /// Samples of every pixel.
    pub samples: u32,
    /// Samples of every pixel of the finished picture.
    pub target: u32,
    /// Whether it is a quick look at reduced resolution.
    pub draft: bool,
    /// Whether it is what `petzval render` makes of these settings.
    pub finished: bool,
}

impl ViewFrame {
    /// First bytes of a message.
    const MAGIC: [u8; 4] = *b"PZV1";
    /// Memory of a pixel: in a frame and its message, and in those before (bytes).
    pub const BYTES_PER_PIXEL: u64 = 4 * size_of::<[f32; 3]>() as u64;
    /// Bytes before the pixels.
    const HEADER: usize = 32;

    /// Returns the message: the magic, width, height, samples, target and flags (1 for a draft, 2
    /// for a finished picture) as 32-bit numbers, the generation as a 64-bit number, and linear RGB
    /// as 32-bit floats, row by row from the top. All are little-endian.
    pub fn message(&self) -> Vec<u8> {
        let [width, height] = self.picture.size.map(|n| n as u32);
        let flags = u32::from(self.draft) | u32::from(self.finished) << 1;
        let mut bytes = Vec::with_capacity(Self::HEADER + size_of_val(&self.picture.pixels[..]));
        bytes.extend(Self::MAGIC);
        for number in [width, height, self.samples, self.target, flags] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(self.generation.to_le_bytes());
        for value in self.picture.pixels.as_flattened() {
            bytes.extend(value.to_le_bytes());
        }
        bytes
    }

    /// Returns the picture as an OpenEXR file.
    ///
    /// # Errors
    /// Returns an error if the temporary folder cannot be written.
    pub fn exr(&self) -> Result<Vec<u8>, Failure> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("picture.exr");
        let window = Frame::whole(self.picture.size.map(|n| n as u32)).window();
        let notes = vec![("samplesPerPixel", Note::Number(self.samples.into()))];
        self.picture.write(
            &Outputs::without_inputs().claim(&path)?,
            window,
            EncodingOptions::default(),
            &notes,
        )?;
        Ok(fs::read(&path)?)
    }
}
