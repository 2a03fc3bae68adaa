//! Film sizes and cameras by name.

/// A film or a sensor of published size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSize {
    /// Name: lower case, without spaces.
    pub name: &'static str,
    /// Width and height (mm).
    pub size: [f64; 2],
    /// Columns and rows of a sensor.
    pub pixels: Option<[u32; 2]>,
    /// Published source of the size.
    pub source: &'static str,
}

const fn film(name: &'static str, size: [f64; 2], source: &'static str) -> FilmSize {
    FilmSize { name, size, pixels: None, source }
}

const fn sensor(name: &'static str, size: [f64; 2], pixels: [u32; 2]) -> FilmSize {
    FilmSize { name, size, pixels: Some(pixels), source: "specifications of the maker" }
}

/// All sizes that are known by name.
pub const FILM_SIZES: [FilmSize; 22] = [
    film("35mm", [36.0, 24.0], "ISO 1007"),
    film("half-frame", [24.0, 18.0], "ISO 1007"),
    film("645", [56.0, 41.5], "ISO 732"),
    film("6x6", [56.0, 56.0], "ISO 732"),
    film("6x7", [70.0, 56.0], "ISO 732, nominal"),
    film("6x9", [84.0, 56.0], "ISO 732, nominal"),
    film("four-thirds", [17.3, 13.0], "Four Thirds standard"),
    film("super-35", [24.89, 18.66], "SMPTE ST 59, full aperture"),
    film("academy", [21.95, 16.0], "SMPTE ST 59, nominal"),
    film("super-16", [12.52, 7.41], "SMPTE ST 201"),
    sensor("nikon-d850", [35.9, 23.9], [8256, 5504]),
    sensor("nikon-z50", [23.5, 15.7], [5568, 3712]),
    sensor("canon-r5", [36.0, 24.0], [8192, 5464]),
    sensor("canon-r7", [22.3, 14.8], [6960, 4640]),
    sensor("sony-a7r5", [35.7, 23.8], [9504, 6336]),
    sensor("sony-rx100", [13.2, 8.8], [5472, 3648]),
    sensor("fujifilm-x-t5", [23.5, 15.6], [7728, 5152]),
    sensor("fujifilm-gfx100", [43.8, 32.9], [11648, 8736]),
    sensor("hasselblad-x2d", [43.8, 32.9], [11656, 8742]),
    sensor("om-1", [17.4, 13.0], [5184, 3888]),
    sensor("alexa-mini-lf", [36.70, 25.54], [4448, 3096]),
    sensor("alexa-35", [27.99, 19.22], [4608, 3164]),
];

/// Returns the size of this name, in any case and with either dash.
///
/// ```
/// let size = petzval_lens::film_size("35mm").expect("a known size");
/// assert_eq!(size.size, [36.0, 24.0]);
/// ```
pub fn film_size(name: &str) -> Option<&'static FilmSize> {
    let name = name.trim().replace('_', "-");
    FILM_SIZES.iter().find(|size| size.name.eq_ignore_ascii_case(&name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_square() {
        for FilmSize { name, size, pixels, .. } in FILM_SIZES {
            let Some(pixels) = pixels else { continue };
            let [across, down] = [0, 1].map(|i| size[i] / f64::from(pixels[i]));
            assert!((across / down - 1.0).abs() < 0.015, "{name}: {across} x {down} mm");
            assert!((0.002..0.009).contains(&across), "{name}");
        }
    }

    #[test]
    fn names_are_unique_and_found_in_any_case() {
        for (i, size) in FILM_SIZES.iter().enumerate() {
            assert_eq!(FILM_SIZES.iter().position(|other| other.name == size.name), Some(i));
            assert_eq!(film_size(&size.name.to_uppercase()), Some(size));
        }
        assert_eq!(film_size("nikon_d850"), film_size("nikon-d850"));
        assert_eq!(film_size("36x24"), None);
    }
}
