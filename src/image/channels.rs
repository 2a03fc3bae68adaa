//! Images of numbers that are not colours, such as maps of coordinates, with pixels beyond the frame.

use super::{ImageError, Notes, exr};
use petzval_base::io::OutputFile;

/// Channels of 32-bit floats. In an EXR, `origin` and `size` are the data window and `frame` is the
/// display window: pixels of the data window beyond the frame are overscan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelImage {
    /// First pixel relative to the frame, x and y; negative beyond its left and upper edges.
    pub origin: [i32; 2],
    /// Width and height (pixels).
    pub size: [usize; 2],
    /// Width and height of the frame (pixels).
    pub frame: [u32; 2],
    /// Channels: a name, and a value for each pixel, row after row from the top.
    pub channels: Vec<(&'static str, Vec<f32>)>,
}

impl ChannelImage {
    /// Writes the channels as EXR.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written or a channel has another size. The previous
    /// file of that name is then unchanged.
    pub fn write(&self, to: &OutputFile, notes: &Notes) -> Result<(), ImageError> {
        let io = |source| ImageError::Io { verb: "write", path: to.path().to_owned(), source };
        to.write(|file| exr::write_channels(self, notes, file)).map_err(io)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Picture;
    use petzval_base::io::FileLog;

    #[test]
    fn overscan_is_a_data_window_beyond_the_display_window() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.exr");
        let values = |c: usize| (0..12).map(|i| (10 * c + i) as f32).collect();
        let image = ChannelImage {
            origin: [-1, -1],
            size: [4, 3],
            frame: [2, 1],
            channels: vec![("R", values(0)), ("G", values(1)), ("B", values(2))],
        };
        image.write(&OutputFile::new(&path, &FileLog::default()).unwrap(), &Notes::new()).unwrap();
        let picture = Picture::read(&path).unwrap();
        assert_eq!(picture.size, [4, 3]);
        assert_eq!(picture.pixels[5], [5.0, 15.0, 25.0]);
        // Windows in the header: two corners of four 32-bit numbers each.
        let bytes = std::fs::read(&path).unwrap();
        let window = |name: &[u8]| {
            let at = bytes.windows(name.len()).position(|found| found == name).unwrap();
            let number = |i: usize| {
                let first = at + name.len() + 4 + 4 * i;
                i32::from_le_bytes(bytes[first..first + 4].try_into().unwrap())
            };
            [0, 1, 2, 3].map(number)
        };
        assert_eq!(window(b"dataWindow\0box2i\0"), [-1, -1, 2, 1]);
        assert_eq!(window(b"displayWindow\0box2i\0"), [0, 0, 1, 0]);
    }

    #[test]
    fn a_channel_of_another_size_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let image = ChannelImage {
            size: [2, 2],
            frame: [2, 2],
            channels: vec![("R", vec![0.0; 3])],
            ..ChannelImage::default()
        };
        let to = OutputFile::new(folder.path().join("map.exr"), &FileLog::default()).unwrap();
        let error = image.write(&to, &Notes::new()).unwrap_err();
        assert!(error.to_string().contains("channel R has 3 values"), "{error}");
    }
}
