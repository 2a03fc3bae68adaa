//! Aperture masks that pbrt-v4 knows by name.

use std::f64::consts::TAU;

use super::iris::{ApertureMask, MaskConvention};

/// Names of the masks: those of pbrt-v4 except its circle, which needs no mask.
pub const MASK_NAMES: &[&str] = &["gaussian", "square", "pentagon", "star"];

/// Number of rows and of columns of a named mask.
const NAMED_SIZE: usize = 256;

/// Number of samples per pixel and axis.
const SUBSAMPLES: usize = 4;

impl ApertureMask {
    /// Returns a mask of pbrt-v4 by its name, on 256 by 256 pixels. With r in units of the radius
    /// of the stop, "gaussian" is exp(-r^2) - exp(-1) scaled to 1 in the middle, "square" extends
    /// to half the radius, and "pentagon" has its corners at 0.8 and "star" at 1, one of them
    /// upwards.
    pub fn named(name: &str) -> Option<Self> {
        let opening: fn(f64, f64) -> f64 = match name {
            "gaussian" => gaussian,
            "square" => square,
            "pentagon" => pentagon,
            "star" => star,
            _ => return None,
        };
        Some(Self::drawn(name, opening))
    }

    /// Returns the same mask as pbrt-v4's camera has it: normalised to the light of the round
    /// opening, the pentagon with a corner downwards, the star with a tip to the left, seen from
    /// the film.
    pub fn named_by_pbrt(name: &str) -> Option<Self> {
        let mask = match name {
            "pentagon" => Self::drawn(name, |x, y| pentagon(x, -y)),
            "star" => Self::drawn(name, |x, y| star(y, -x)),
            _ => Self::named(name)?,
        };
        Some(mask.normalized())
    }

    /// Samples a shape on 256 by 256 pixels.
    fn drawn(name: &str, opening: impl Fn(f64, f64) -> f64) -> Self {
        let fine = NAMED_SIZE * SUBSAMPLES;
        let place = |i: usize| (2 * i + 1) as f64 / fine as f64 - 1.0;
        let point = |row: usize, column: usize| {
            let samples = (0..SUBSAMPLES * SUBSAMPLES).map(|i| {
                let x = place(column * SUBSAMPLES + i % SUBSAMPLES);
                let y = -place(row * SUBSAMPLES + i / SUBSAMPLES);
                opening(x, y)
            });
            (samples.sum::<f64>() / (SUBSAMPLES * SUBSAMPLES) as f64) as f32
        };
        let points = (0..NAMED_SIZE * NAMED_SIZE).map(|i| point(i / NAMED_SIZE, i % NAMED_SIZE));
        Self {
            name: name.to_owned(),
            size: NAMED_SIZE,
            transmission: points.collect(),
            convention: MaskConvention::Physical,
            is_shape: name != "gaussian",
        }
    }
}

fn gaussian(x: f64, y: f64) -> f64 {
    let rim = (-1.0f64).exp();
    ((-(x * x + y * y)).exp() - rim).max(0.0) / (1.0 - rim)
}

fn square(x: f64, y: f64) -> f64 {
    f64::from(x.abs().max(y.abs()) <= 0.5)
}

/// Returns how many of five lines at this distance from the centre a point lies beyond. The lines
/// are rotated so that a corner between two of them points along `-sign` y.
fn lines_crossed(x: f64, y: f64, distance: f64, sign: f64) -> usize {
    let outside = |k: i32| {
        let (sin, cos) = (f64::from(k) * TAU / 5.0).sin_cos();
        sign * (x * sin + y * cos) > distance
    };
    (0..5).filter(|&k| outside(k)).count()
}

fn pentagon(x: f64, y: f64) -> f64 {
    f64::from(lines_crossed(x, y, 0.8 * (TAU / 10.0).cos(), -1.0) == 0)
}

/// The tips of a pentagram lie beyond one of its five lines, points outside beyond two or more.
fn star(x: f64, y: f64) -> f64 {
    f64::from(lines_crossed(x, y, (TAU / 5.0).cos(), 1.0) <= 1)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    fn mask(name: &str) -> ApertureMask {
        ApertureMask::named(name).expect("a name of MASK_NAMES")
    }

    /// Returns the area of the opening over that of the square around the stop.
    fn share(mask: &ApertureMask) -> f64 {
        let sum: f64 = mask.transmission.iter().map(|&t| f64::from(t)).sum();
        sum / (mask.size * mask.size) as f64
    }

    #[test]
    fn the_named_masks_have_the_areas_of_their_shapes() {
        let sine = |degrees: f64| degrees.to_radians().sin();
        let pentagon = 5.0 / 2.0 * 0.8 * 0.8 * sine(72.0) / 4.0;
        let inner = sine(18.0) / sine(54.0);
        let star = 5.0 * inner * sine(36.0) / 4.0;
        let e = 1.0f64.exp().recip();
        let gaussian = std::f64::consts::PI * (1.0 - 2.0 * e) / (1.0 - e) / 4.0;
        for (name, expected) in
            [("square", 0.25), ("pentagon", pentagon), ("star", star), ("gaussian", gaussian)]
        {
            let mask = mask(name);
            // The tolerance is a tenth of a pixel along the whole edge.
            assert!((share(&mask) - expected).abs() < 5e-4, "{name}: {}", share(&mask));
            assert!(mask.transmission.iter().all(|t| (0.0..=1.0).contains(t)));
        }
    }

    #[test]
    fn pentagon_and_star_point_up() {
        let top = |name: &str| mask(name).transmission.iter().position(|&t| t > 0.0).expect("open");
        for (name, radius) in [("pentagon", 0.8), ("star", 1.0)] {
            let (row, column) = (top(name) / 256, top(name) % 256);
            assert!((column as f64 - 127.5).abs() < 2.0, "{name}: column {column}");
            assert!((row as f64 - 128.0 * (1.0 - radius)).abs() < 3.0, "{name}: row {row}");
        }
    }

    #[test]
    fn masks_by_pbrt_have_the_light_of_the_round_opening_and_the_orientation_of_pbrt() {
        let mask = |name: &str| ApertureMask::named_by_pbrt(name).expect("a name of MASK_NAMES");
        for name in MASK_NAMES {
            assert!(
                (share(&mask(name)) - FRAC_PI_4).abs() < 1e-6,
                "{name}: {}",
                share(&mask(name))
            );
        }
        let open = |name: &str, x: f64, y: f64| mask(name).at(x, y, 1.0) > 0.0;
        assert!(open("pentagon", 0.0, -0.78) && !open("pentagon", 0.0, 0.78));
        assert!(open("star", -0.96, 0.0) && !open("star", 0.96, 0.0) && !open("star", 0.0, 0.96));
    }

    #[test]
    fn an_unknown_name_has_no_mask() {
        assert!(ApertureMask::named("circular").is_none() && ApertureMask::named("").is_none());
        assert!((mask("gaussian").transmission[128 * 256 + 128] - 1.0).abs() < 1e-3);
    }
}
