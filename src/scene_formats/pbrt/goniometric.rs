//! Directional distributions of goniometric lights: pictures of all directions, and IES files.
//!
//! All become a square picture in the equal-area mapping of pbrt-v4. The axis of the mapping is +y of
//! the light's own space.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::{Vec2, Vec3};

use petzval_base::equal_area;
use petzval_image::Picture;

/// Sides of a square that holds a distribution (pixels).
const SIDES: [usize; 2] = [64, 1024];
/// Side of the square for an IES file, whose angles are seldom closer than a degree (pixels).
const IES_SIDE: usize = 512;
/// Most angles along one axis of an IES file.
const MAX_ANGLES: usize = 4096;

/// Returns the square picture of a function of the unit direction.
fn square(side: usize, value: impl Fn(Vec3) -> [f32; 3]) -> Arc<Picture> {
    let centre = |i: usize| (i as f32 + 0.5) / side as f32;
    let pixels = (0..side * side)
        .map(|i| value(equal_area::to_sphere(Vec2::new(centre(i % side), centre(i / side)))))
        .collect();
    Arc::new(Picture { size: [side, side], pixels })
}

/// Returns the angle from the axis and around it, as shares of pi and 2 pi.
fn angles(d: Vec3) -> [f32; 2] {
    let around = d.y.atan2(d.x) / TAU;
    [d.z.clamp(-1.0, 1.0).acos() / PI, if around < 0.0 { around + 1.0 } else { around }]
}

/// Returns the equal-area picture of one in longitude and latitude, as goniometric lights have before
/// pbrt-v4. Both are of any size.
pub(super) fn from_longitude_latitude(picture: &Picture) -> Arc<Picture> {
    let [width, height] = picture.size;
    let [least, most] = SIDES;
    square((2 * height.max(width / 2)).clamp(least, most), |d| {
        let [theta, phi] = angles(d);
        // Between the centres of pixels, around the axis without an end.
        let (x, y) = (phi * width as f32 - 0.5, theta * height as f32 - 0.5);
        let column = |offset: i64| (x.floor() as i64 + offset).rem_euclid(width as i64) as usize;
        let row = |offset: i64| (y.floor() as i64 + offset).clamp(0, height as i64 - 1) as usize;
        let (s, t) = (x - x.floor(), y - y.floor());
        let at = |i: i64, j: i64| picture.pixels[row(j) * width + column(i)];
        std::array::from_fn(|c| {
            let of_row = |j: i64| at(0, j)[c] * (1.0 - s) + at(1, j)[c] * s;
            of_row(0) * (1.0 - t) + of_row(1) * t
        })
    })
}

/// A photometric file (ANSI/IES LM-63) of type C.
#[derive(Debug)]
struct Photometry {
    /// Angles from the nadir (degrees), ascending.
    vertical: Vec<f32>,
    /// Angles around the axis (degrees), ascending.
    horizontal: Vec<f32>,
    /// Luminous intensities (cd), all of a horizontal angle in a row.
    candela: Vec<f32>,
}

/// Returns the distribution of an IES file in cd. Its nadir is -y, and its angle of 0 around the axis
/// is +x.
///
/// # Errors
/// Returns what is wrong with the text.
pub(super) fn from_ies(bytes: &[u8]) -> Result<Arc<Picture>, String> {
    let photometry = Photometry::read(&String::from_utf8_lossy(bytes))?;
    Ok(square(IES_SIDE, |d| {
        let [theta, phi] = angles(d);
        [photometry.intensity(180.0 * (1.0 - theta), 360.0 * phi); 3]
    }))
}

impl Photometry {
    fn read(text: &str) -> Result<Self, String> {
        // Lines before the one of the tilt are labels.
        let tilt = text.lines().position(|line| line.trim_start().starts_with("TILT"));
        let Some(tilt) = tilt else {
            return Err("there is no line TILT=; expected an IES file".to_owned());
        };
        let mut lines = text.lines().skip(tilt);
        let is_included = lines.next().is_some_and(|line| line.contains("INCLUDE"));
        let body: Vec<&str> = lines.collect();
        let mut values = body
            .iter()
            .flat_map(|line| line.split(|c: char| c.is_whitespace() || c == ','))
            .filter(|word| !word.is_empty());
        let mut next = |what: &str| -> Result<f32, String> {
            let word = values.next().ok_or_else(|| format!("it ends before {what}"))?;
            let number = word.parse::<f32>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| {
                format!("\"{}\" in place of {what}", petzval_base::io::excerpt(word))
            })
        };
        if is_included {
            next("the geometry of the lamp")?;
            for _ in 0..2 * count(next("tilts")?, "tilts")? {
                next("a tilt")?;
            }
        }
        for what in ["the number of lamps", "the lumens of a lamp"] {
            next(what)?;
        }
        let multiplier = next("the multiplier")?;
        let vertical = count(next("the number of vertical angles")?, "vertical angles")?;
        let horizontal = count(next("the number of horizontal angles")?, "horizontal angles")?;
        let kind = next("the photometric type")?;
        if kind != 1.0 {
            return Err(format!("photometry of type {kind}; expected 1, type C"));
        }
        for what in ["the unit of lengths", "the width", "the length", "the height"] {
            next(what)?;
        }
        let factor = multiplier * next("the ballast factor")? * next("the second ballast factor")?;
        next("the input watts")?;
        let mut list = |length: usize, what: &str| -> Result<Vec<f32>, String> {
            (0..length).map(|_| next(what)).collect()
        };
        let (vertical, horizontal) =
            (list(vertical, "a vertical angle")?, list(horizontal, "a horizontal angle")?);
        let ascends = |angles: &[f32]| angles.windows(2).all(|pair| pair[0] < pair[1]);
        if !ascends(&vertical) || !ascends(&horizontal) {
            return Err("angles that do not ascend".to_owned());
        }
        let candela = list(vertical.len() * horizontal.len(), "an intensity")?;
        let candela = candela.into_iter().map(|value| (value * factor).max(0.0)).collect();
        Ok(Self { vertical, horizontal, candela })
    }

    /// Returns the intensity at an angle from the nadir and around the axis (degrees, cd).
    fn intensity(&self, vertical: f32, around: f32) -> f32 {
        const ROUNDING: f32 = 1e-3;
        let inside = self.vertical.first().is_some_and(|&low| vertical >= low - ROUNDING)
            && self.vertical.last().is_some_and(|&high| vertical <= high + ROUNDING);
        if !inside {
            return 0.0;
        }
        let (row, share) = place(&self.horizontal, self.reflected(around));
        let (column, along) = place(&self.vertical, vertical);
        let at = |row: usize, column: usize| {
            let row = row.min(self.horizontal.len() - 1);
            self.candela[row * self.vertical.len() + column.min(self.vertical.len() - 1)]
        };
        let of_row = |row: usize| at(row, column) * (1.0 - along) + at(row, column + 1) * along;
        of_row(row) * (1.0 - share) + of_row(row + 1) * share
    }

    /// Returns the angle around the axis at which the file has the intensity of another: lists that end
    /// at 90 or 180 degrees are symmetric, and so are those from 90 to 270.
    fn reflected(&self, around: f32) -> f32 {
        let half = |angle: f32| if angle > 180.0 { 360.0 - angle } else { angle };
        match (self.horizontal.first(), self.horizontal.last()) {
            (Some(&first), Some(&last)) if first >= 90.0 && last <= 270.0 => {
                if (90.0..=270.0).contains(&around) { around } else { (540.0 - around) % 360.0 }
            }
            (_, Some(&last)) if last <= 90.0 => {
                let angle = half(around);
                if angle > 90.0 { 180.0 - angle } else { angle }
            }
            (_, Some(&last)) if last <= 180.0 => half(around),
            _ => around,
        }
    }
}

/// Returns a number of angles, if it is one.
fn count(number: f32, what: &str) -> Result<usize, String> {
    match number.fract() == 0.0 && (1.0..=MAX_ANGLES as f32).contains(&number) {
        true => Ok(number as usize),
        false => Err(format!("{number} {what}; expected 1 to {MAX_ANGLES}")),
    }
}

/// Returns the index of the last of ascending values that is not above `x`, and the share of the way to
/// the next; the nearest end outside them.
fn place(values: &[f32], x: f32) -> (usize, f32) {
    let above = values.partition_point(|&value| value <= x);
    match (above.checked_sub(1), values.get(above)) {
        (None, _) => (0, 0.0),
        (Some(last), None) => (last, 0.0),
        (Some(low), Some(&high)) => (low, (x - values[low]) / (high - values[low])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAMP: &str = "IESNA:LM-63-2002\n[TEST] none\nTILT=NONE\n1 1000 2 3 1 1 2 0 0 0\n\
        1 1 50\n0 45 90\n0\n100, 50\n0\n";

    #[test]
    fn an_ies_file_shines_down_with_its_candela() {
        let lamp = Photometry::read(LAMP).unwrap();
        for (vertical, expected) in
            [(0.0, 200.0), (22.5, 150.0), (45.0, 100.0), (67.5, 50.0), (90.0, 0.0), (120.0, 0.0)]
        {
            for around in [0.0, 77.0, 200.0, 359.0] {
                assert!((lamp.intensity(vertical, around) - expected).abs() < 1e-3, "{vertical}");
            }
        }
        // Down is -y of the light, which is -z in the mapping.
        let picture = from_ies(LAMP.as_bytes()).unwrap();
        let towards = |d: Vec3| {
            let at = equal_area::from_sphere(d) * (IES_SIDE as f32 - 1.0);
            picture.pixels[at.y as usize * IES_SIDE + at.x as usize][0]
        };
        assert!(towards(Vec3::NEG_Z) > 198.0 && towards(Vec3::Z) == 0.0);
    }

    #[test]
    fn symmetric_files_are_unfolded() {
        let with = |angles: &str, count: usize, rows: &str| {
            let text = format!(
                "TILT=INCLUDE\n1 2 0 90 1 1\n1 -1 1 2 {count} 1 1 0 0 0 1 1 9\n\
                0 180\n{angles}\n{rows}"
            );
            Photometry::read(&text).unwrap()
        };
        let quadrant = with("0 90", 2, "1 1 3 3");
        for (around, expected) in
            [(0.0, 1.0), (90.0, 3.0), (180.0, 1.0), (270.0, 3.0), (135.0, 2.0)]
        {
            assert!((quadrant.intensity(90.0, around) - expected).abs() < 1e-5, "{around}");
        }
        let half = with("0 180", 2, "1 1 3 3");
        assert!((half.intensity(90.0, 270.0) - 2.0).abs() < 1e-5);
        let whole = with("0 180 360", 3, "1 1 3 3 1 1");
        assert!((whole.intensity(90.0, 270.0) - 2.0).abs() < 1e-5);
        let other_half = with("90 270", 2, "1 1 3 3");
        assert!((other_half.intensity(90.0, 0.0) - 2.0).abs() < 1e-5);
        assert!((other_half.intensity(90.0, 90.0) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn broken_ies_files_are_refused() {
        for end in 0..LAMP.len() - 2 {
            assert!(Photometry::read(&LAMP[..end]).is_err(), "{end} bytes");
        }
        for (from, to) in
            [("0 45 90", "0 90 45"), ("3 1 1 2", "3 1 2 2"), ("100,", "x"), ("3 1 1", "1e9 1 1")]
        {
            assert!(Photometry::read(&LAMP.replace(from, to)).is_err(), "{to}");
        }
    }

    #[test]
    fn a_picture_in_longitude_and_latitude_keeps_its_directions() {
        // Four columns around the axis, two rows from +z to -z.
        let pixels = (0..8).map(|i| [i as f32; 3]).collect();
        let found = from_longitude_latitude(&Picture { size: [4, 2], pixels });
        let side = found.size[0] as f32;
        for (i, phi) in [45f32, 135.0, 225.0, 315.0].into_iter().enumerate() {
            for (row, z) in [0.7f32, -0.7].into_iter().enumerate() {
                let (sin, cos) = phi.to_radians().sin_cos();
                let d = Vec3::new(cos * 0.714, sin * 0.714, z).normalize();
                let at = equal_area::from_sphere(d) * side;
                let pixel = found.pixels[at.y as usize * found.size[0] + at.x as usize][0];
                assert!((pixel - (4 * row + i) as f32).abs() < 0.15, "{i} {row}: {pixel}");
            }
        }
    }
}
