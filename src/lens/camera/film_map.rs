//! Map between the points of a film and those of the picture on it.

/// Places of the points of a picture (pixels from its upper left corner, x to the right and y down) on
/// the film (mm from its middle, x to the right and y up as seen from behind the camera).
///
/// The image on the film is mirrored and upside down: the right of the picture lies at negative x of
/// the film, its lower edge at positive y.
///
/// ```
/// use petzval_lens::FilmMap;
///
/// let map = FilmMap::new([36.0, 24.0], [600, 400]);
/// assert_eq!(map.film_point([0.0, 0.0]), [18.0, -12.0]);
/// assert_eq!(map.pixel([-18.0, 12.0]), [600.0, 400.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmMap {
    film: [f64; 2],
    resolution: [f64; 2],
}

impl FilmMap {
    /// Direction on the film of x and y of the picture.
    pub const DIRECTIONS: [i8; 2] = [-1, 1];

    /// Returns the map of a picture of this resolution (pixels) on a whole film of this width and height
    /// (mm).
    pub fn new(film: [f64; 2], resolution: [u32; 2]) -> Self {
        Self { film, resolution: resolution.map(f64::from) }
    }

    /// Returns the point of the film (mm) of a point of the picture (pixels).
    #[inline]
    pub fn film_point(&self, pixel: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| {
            let from_edge = pixel[i] * self.film[i] / self.resolution[i];
            f64::from(Self::DIRECTIONS[i]) * (from_edge - self.film[i] / 2.0)
        })
    }

    /// Returns the point of the picture (pixels) of a point of the film (mm).
    #[inline]
    pub fn pixel(&self, film: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| {
            let share = 0.5 + f64::from(Self::DIRECTIONS[i]) * (film[i] / self.film[i]);
            share * self.resolution[i]
        })
    }

    /// Returns the signed distance on the film (mm) of neighbouring pixels along x and y of the picture.
    #[inline]
    pub fn pitch(&self) -> [f64; 2] {
        [0, 1].map(|i| f64::from(Self::DIRECTIONS[i]) * self.film[i] / self.resolution[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_return_to_their_pixels() {
        let map = FilmMap::new([7.3, 4.1], [641, 359]);
        for pixel in [[0.0, 0.0], [640.5, 0.5], [12.25, 358.0], [-3.0, 700.0]] {
            let back = map.pixel(map.film_point(pixel));
            assert!((0..2).all(|i| (back[i] - pixel[i]).abs() < 1e-11), "{pixel:?} {back:?}");
        }
        let [right, below] = [map.film_point([11.0, 20.0]), map.film_point([10.0, 21.0])];
        let origin = map.film_point([10.0, 20.0]);
        let step = [right[0] - origin[0], below[1] - origin[1]];
        assert!((0..2).all(|i| (step[i] - map.pitch()[i]).abs() < 1e-14), "{step:?}");
    }
}
