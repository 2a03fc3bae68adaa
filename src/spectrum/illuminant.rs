//! The CIE's standard illuminants.

use super::fluorescent::{FIRST_WAVELENGTH, FLUORESCENT, STEP};
use super::{Spectrum, blackbody};

/// Returns the illuminant of a name in pbrt-v4's spelling, with luminance 1.
pub(super) fn illuminant(name: &str) -> Option<Spectrum> {
    let spectrum = match name {
        "stdillum-A" => incandescent(),
        "stdillum-D50" => d_illuminant(5000.0),
        "stdillum-D65" => d65(),
        // The white of ACES is daylight of 6000 K.
        "illum-acesD60" => daylight(6000.0),
        _ => fluorescent(name.strip_prefix("stdillum-F")?.parse().ok()?)?,
    };
    Some(spectrum.with_luminance_one())
}

/// The names that [`illuminant`] knows.
pub(super) const NAMES: [&str; 16] = [
    "stdillum-A",
    "stdillum-D50",
    "stdillum-D65",
    "illum-acesD60",
    "stdillum-F1",
    "stdillum-F2",
    "stdillum-F3",
    "stdillum-F4",
    "stdillum-F5",
    "stdillum-F6",
    "stdillum-F7",
    "stdillum-F8",
    "stdillum-F9",
    "stdillum-F10",
    "stdillum-F11",
    "stdillum-F12",
];

/// Ratio of Planck's second constant today, 0.014388 m K, and when D50 and D65 were named, 0.014380
/// m K.
const C2_RATIO: f64 = 1.4388 / 1.4380;

/// Returns average daylight (D65), the white of sRGB.
pub fn d65() -> Spectrum {
    d_illuminant(6500.0)
}

/// Chromaticities of D50, the white of DNG and of ICC profiles (CIE 15:2018).
pub const D50: [f64; 2] = [0.345_67, 0.358_51];

/// Returns the daylight illuminant of a nominal temperature (K), such as 5000 for D50.
pub fn d_illuminant(kelvin: f64) -> Spectrum {
    daylight(kelvin * C2_RATIO)
}

/// Returns illuminant A, a tungsten filament (CIE 015:2018, eq. 4.1): a black body of 2848 K with
/// the second constant 0.01435 m K, 1 at 560 nm.
fn incandescent() -> Spectrum {
    let c2: f64 = 1.435e7;
    let nms = (300..=830).step_by(5).map(f64::from);
    let planck = |nm: f64| (560.0 / nm).powi(5) / (c2 / (2848.0 * nm)).exp_m1();
    Spectrum::tabulated(nms.map(|nm| [nm, planck(nm) / planck(560.0)]))
}

/// Returns a fluorescent illuminant, FL1 to FL12.
fn fluorescent(number: usize) -> Option<Spectrum> {
    let column = number.checked_sub(1).filter(|&column| column < FLUORESCENT[0].len())?;
    let entry = |(i, row): (usize, &[f64; 12])| {
        [f64::from(FIRST_WAVELENGTH) + f64::from(STEP) * i as f64, row[column]]
    };
    Some(Spectrum::tabulated(FLUORESCENT.iter().enumerate().map(entry)))
}

/// Returns daylight of a correlated colour temperature (K) from 4000 to 25000 (CIE 015:2018,
/// 4.1.2), or a black body below 4000. The coefficients are rounded to three decimals, as in the
/// CIE's tables.
pub fn daylight(kelvin: f64) -> Spectrum {
    if kelvin.is_nan() || kelvin < 4000.0 {
        return blackbody(kelvin);
    }
    let mireds = 1e3 / kelvin.min(25_000.0);
    let x = if kelvin <= 7000.0 {
        ((-4.6070 * mireds + 2.9678) * mireds + 0.09911) * mireds + 0.244063
    } else {
        ((-2.0064 * mireds + 1.9018) * mireds + 0.24748) * mireds + 0.237040
    };
    let y = (-3.0 * x + 2.870) * x - 0.275;
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    let m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / m;
    let m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / m;
    let [m1, m2] = [m1, m2].map(|m| (m * 1e3).round() / 1e3);
    let entry =
        |(i, [s0, s1, s2]): (usize, &[f64; 3])| [350.0 + 10.0 * i as f64, s0 + m1 * s1 + m2 * s2];
    Spectrum::tabulated(DAYLIGHT.iter().enumerate().map(entry))
}

/// The mean and the first two principal components of daylight (Judd, MacAdam & Wyszecki 1964; CIE
/// 015:2018, table 6) from 350 to 830 nm in steps of 10 nm; linear between.
#[rustfmt::skip]
const DAYLIGHT: [[f64; 3]; 49] = [
    [61.8, 41.6, 6.7],
    [61.5, 38.0, 5.3],
    [68.8, 42.4, 6.1],
    [63.4, 38.5, 3.0],
    [65.8, 35.0, 1.2],
    [94.8, 43.4, -1.1],
    [104.8, 46.3, -0.5],
    [105.9, 43.9, -0.7],
    [96.8, 37.1, -1.2],
    [113.9, 36.7, -2.6],
    [125.6, 35.9, -2.9],
    [125.5, 32.6, -2.8],
    [121.3, 27.9, -2.6],
    [121.3, 24.3, -2.6],
    [113.5, 20.1, -1.8],
    [113.1, 16.2, -1.5],
    [110.8, 13.2, -1.3],
    [106.5, 8.6, -1.2],
    [108.8, 6.1, -1.0],
    [105.3, 4.2, -0.5],
    [104.4, 1.9, -0.3],
    [100.0, 0.0, 0.0],
    [96.0, -1.6, 0.2],
    [95.1, -3.5, 0.5],
    [89.1, -3.5, 2.1],
    [90.5, -5.8, 3.2],
    [90.3, -7.2, 4.1],
    [88.4, -8.6, 4.7],
    [84.0, -9.5, 5.1],
    [85.1, -10.9, 6.7],
    [81.9, -10.7, 7.3],
    [82.6, -12.0, 8.6],
    [84.9, -14.0, 9.8],
    [81.3, -13.6, 10.2],
    [71.9, -12.0, 8.3],
    [74.3, -13.3, 9.6],
    [76.4, -12.9, 8.5],
    [63.3, -10.6, 7.0],
    [71.7, -11.6, 7.6],
    [77.0, -12.2, 8.0],
    [65.2, -10.2, 6.7],
    [47.7, -7.8, 5.2],
    [68.6, -11.2, 7.4],
    [65.0, -10.4, 6.8],
    [66.0, -10.6, 7.0],
    [61.0, -9.7, 6.4],
    [53.3, -8.3, 5.5],
    [58.9, -9.3, 6.1],
    [61.9, -9.8, 6.5],
];

#[cfg(test)]
mod tests {
    use super::super::observer::tests::assert_chromaticity;
    use crate::{VISIBLE, colour_matching, d65, named_spectrum};

    #[test]
    fn illuminants_have_their_published_chromaticities() {
        // CIE 015:2018, tables 3 and 10.2; the Academy's white (SMPTE ST 2065-1).
        let published = [
            ("stdillum-A", [0.44758, 0.40745]),
            ("stdillum-D50", [0.34567, 0.35851]),
            ("stdillum-D65", [0.31272, 0.32903]),
            ("illum-acesD60", [0.32168, 0.33767]),
            ("stdillum-F1", [0.3131, 0.3371]),
            ("stdillum-F2", [0.3721, 0.3751]),
            ("stdillum-F3", [0.4091, 0.3941]),
            ("stdillum-F4", [0.4402, 0.4031]),
            ("stdillum-F5", [0.3138, 0.3452]),
            ("stdillum-F6", [0.3779, 0.3882]),
            ("stdillum-F7", [0.3129, 0.3292]),
            ("stdillum-F8", [0.3458, 0.3586]),
            ("stdillum-F9", [0.3741, 0.3727]),
            ("stdillum-F10", [0.3458, 0.3588]),
            ("stdillum-F11", [0.3805, 0.3769]),
            ("stdillum-F12", [0.4370, 0.4042]),
        ];
        for (name, xy) in published {
            let spectrum = named_spectrum(name).unwrap();
            // The CIE sums in steps of 5 nm, which matters for the lines of fluorescent
            // illuminants.
            let mut sums = [0.0; 3];
            for nm in (VISIBLE[0]..=VISIBLE[1]).step_by(5).map(f64::from) {
                let weights = colour_matching(nm);
                (0..3).for_each(|i| sums[i] += weights[i] * spectrum.at(nm));
            }
            let off = |i: usize| (sums[i] / sums.iter().sum::<f64>() - xy[i]).abs();
            assert!(off(0).max(off(1)) < 2e-4, "{name}: {sums:?}");
            assert_chromaticity(&spectrum, xy, 1e-3, name);
            assert!((spectrum.to_xyz()[1] - 1.0).abs() < 1e-9, "{name}");
        }
    }

    #[test]
    fn d65_is_the_published_table() {
        // CIE 015:2018, table 5.
        for (nm, value) in
            [(400.0, 82.7549), (450.0, 117.008), (560.0, 100.0), (600.0, 90.0062), (700.0, 71.6091)]
        {
            assert!((d65().at(nm) - value).abs() < 1e-3, "{nm}: {}", d65().at(nm));
        }
    }
}
