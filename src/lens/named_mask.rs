//! The masks that pbrt knows by name.

use std::f64::consts::TAU;

use super::iris::{Convention, Mask};

/// The masks with a name; pbrt's, but for its circle, which needs none.
pub const MASKS: &[&str] = &["gaussian", "square", "pentagon", "star"];

/// Rows and columns of a mask with a name.
const NAMED_SIZE: usize = 256;

/// A point of a named mask is the mean of this many by this many.
const SUBSAMPLES: usize = 4;

impl Mask {
    /// The masks that pbrt knows by name, on 256 by 256 points. With r in units of the stop's
    /// radius: "gaussian" is exp(-r^2) - exp(-1) scaled to 1 in the middle, "square" reaches to
    /// half the radius, "pentagon" has its corners at 0.8 and "star" at 1, one upwards.
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

    /// The same masks as pbrt-v4's camera has them: as bright as the round opening, the pentagon
    /// with a corner downwards, the star with a tip to the left, seen from the film.
    pub fn named_by_pbrt(name: &str) -> Option<Self> {
        let mask = match name {
            "pentagon" => Self::drawn(name, |x, y| pentagon(x, -y)),
            "star" => Self::drawn(name, |x, y| star(y, -x)),
            _ => Self::named(name)?,
        };
        Some(mask.normalized())
    }

    /// A shape on 256 by 256 points.
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
            convention: Convention::Physical,
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

/// How many of the five lines at this distance from the middle a point lies beyond. The lines
/// are turned so that a corner between two of them points along `-sign` y.
fn beyond(x: f64, y: f64, distance: f64, sign: f64) -> usize {
    let outside = |k: i32| {
        let (sin, cos) = (f64::from(k) * TAU / 5.0).sin_cos();
        sign * (x * sin + y * cos) > distance
    };
    (0..5).filter(|&k| outside(k)).count()
}

fn pentagon(x: f64, y: f64) -> f64 {
    f64::from(beyond(x, y, 0.8 * (TAU / 10.0).cos(), -1.0) == 0)
}

/// The five lines of a pentagram: its tips lie beyond one of them, what is outside beyond two.
fn star(x: f64, y: f64) -> f64 {
    f64::from(beyond(x, y, (TAU / 5.0).cos(), 1.0) <= 1)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;

    fn mask(name: &str) -> Mask {
        Mask::named(name).expect("a name of MASKS")
    }

    /// Area of the opening over that of the square around the stop.
    fn share(mask: &Mask) -> f64 {
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
            // A tenth of a pixel all along the edge.
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
    fn the_masks_of_pbrt_are_as_bright_as_the_round_opening_and_turned_as_pbrt_turns_them() {
        let mask = |name: &str| Mask::named_by_pbrt(name).expect("a name of MASKS");
        for name in MASKS {
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
    fn a_mask_without_a_name_is_none() {
        assert!(Mask::named("circular").is_none() && Mask::named("").is_none());
        assert!((mask("gaussian").transmission[128 * 256 + 128] - 1.0).abs() < 1e-3);
    }
}
