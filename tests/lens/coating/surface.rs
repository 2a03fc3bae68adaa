//! One coated surface against the textbook and naive formulas.

use petzval_base::lanes::f32x8;
use petzval_lens::{BROADBAND_REFLECTANCE, Coating, CoatingModel, DESIGN_WAVELENGTH, MGF2_INDEX};
use petzval_spectrum::D_LINE;

use super::all;
use crate::support::thin_film::{films, reflectances};

/// Returns the transmittance of a coated surface for unpolarised light by naive formulas.
pub fn naive_transmittance(coating: &Coating, [n, after]: [f64; 2], cos: f64, nm: f64) -> f64 {
    let angle = cos.acos();
    let unpolarised = |[s, p]: [f64; 2]| 1.0 - (s + p) / 2.0;
    let bare = |angle: f64| unpolarised(reflectances(n, &[], after, angle));
    match coating {
        Coating::Perfect => 1.0,
        Coating::Mgf2 if Coating::applies_to([n, after]) => {
            let layer = [MGF2_INDEX, DESIGN_WAVELENGTH / (4.0 * MGF2_INDEX) / nm];
            unpolarised(reflectances(n, &[layer], after, angle))
        }
        Coating::Stack(stack) if Coating::applies_to([n, after]) => {
            unpolarised(reflectances(n, &films(stack, [n, after], nm), after, angle))
        }
        Coating::Broadband if Coating::applies_to([n, after]) => {
            let rise = (bare(0.0) - bare(angle)) / bare(0.0);
            let least = BROADBAND_REFLECTANCE.min(1.0 - bare(0.0));
            // From n = 3.7 bare glass reflects less at 60 degrees than at normal incidence.
            (1.0 - (least + (1.0 - least) * rise)).min(1.0)
        }
        _ => bare(angle),
    }
}

pub fn reflected(coating: &Coating, indices: [f64; 2], degrees: f64, nm: f64) -> f64 {
    1.0 - coating.transmittance(indices, degrees.to_radians().cos(), nm)
}

#[test]
fn bare_glass_reflects_as_in_the_textbook() {
    // Air to n = 1.5: 0.04 at normal incidence (Hecht, Optics, sec. 4.6). With angles of refraction of
    // 19.4712 and 35.2644 degrees: Rs = 0.057796 and Rp = 0.025249 at 30 degrees, 0.176571 and
    // 0.001802 at 60.
    for (degrees, expected) in
        [(0.0, 0.04), (30.0, (0.057_796 + 0.025_249) / 2.0), (60.0, (0.176_571 + 0.001_802) / 2.0)]
    {
        let found = reflected(&Coating::Bare, [1.0, 1.5], degrees, D_LINE);
        assert!((found - expected).abs() < 1e-6, "{degrees} degrees: {found}, not {expected}");
    }
    // At Brewster's angle Rp is 0 and Rs is ((m^2 - 1) / (m^2 + 1))^2.
    let brewster = 1.5f64.atan().to_degrees();
    let found = reflected(&Coating::Bare, [1.0, 1.5], brewster, D_LINE);
    assert!((found - (1.25f64 / 3.25).powi(2) / 2.0).abs() < 1e-12, "{found}");
    assert_eq!(reflected(&Coating::Bare, [1.5, 1.0], 45.0, D_LINE), 1.0, "total reflection");
}

#[test]
fn a_quarter_wave_layer_reflects_as_in_the_textbook() {
    let (n0, n2) = (1.0, 1.52);
    let expected =
        ((n0 * n2 - MGF2_INDEX * MGF2_INDEX) / (n0 * n2 + MGF2_INDEX * MGF2_INDEX)).powi(2);
    assert!((expected - 0.0126).abs() < 5e-5, "1.26 % in catalogues");
    let found = reflected(&Coating::Mgf2, [n0, n2], 0.0, DESIGN_WAVELENGTH);
    assert!((found - expected).abs() < 1e-8, "{found}, not {expected}");
    // A half-wave layer has no effect.
    let half = reflected(&Coating::Mgf2, [n0, n2], 0.0, DESIGN_WAVELENGTH / 2.0);
    assert!(
        (half - reflected(&Coating::Bare, [n0, n2], 0.0, DESIGN_WAVELENGTH)).abs() < 1e-7,
        "{half}"
    );
    // At other wavelengths and angles it reflects more.
    assert!(reflected(&Coating::Mgf2, [n0, n2], 0.0, 700.0) > expected);
    assert!(reflected(&Coating::Mgf2, [n0, n2], 60.0, DESIGN_WAVELENGTH) > 3.0 * expected);
}

#[test]
fn the_broadband_coating_reflects_a_quarter_of_a_percent_and_all_at_grazing_incidence() {
    for after in [1.5, 1.7, 1.9] {
        let found = reflected(&Coating::Broadband, [1.0, after], 0.0, D_LINE);
        assert!((found - 0.0025).abs() < 1e-12, "{found}");
        assert!(reflected(&Coating::Broadband, [1.0, after], 90.0 - 1e-6, D_LINE) > 0.9999);
    }
    // The coating never reflects more than bare glass of a low index.
    let thin = reflected(&Coating::Broadband, [1.0, 1.05], 0.0, D_LINE);
    assert!((thin - (0.05f64 / 2.05).powi(2)).abs() < 1e-12, "{thin}");
}

const INDICES: [f64; 10] = [1.0, 1.000_001, 1.0003, 1.05, 1.333, 1.379_999, 1.5, 1.9, 4.0, 10.0];

const WAVES: [f64; 6] = [275.0, 380.0, 550.0, D_LINE, 780.0, 2000.0];

/// Returns cosines of incidence, from 1 to just above 0.
fn cosines() -> Vec<f64> {
    let even = (0..=40).map(|i| f64::from(i) / 40.0);
    even.chain([1e-9, 1e-6, 1e-3, 1.0 - 1e-9]).collect()
}

/// Returns whether light passes, farther from total internal reflection than a rounding.
fn passes([n, after]: [f64; 2], cos: f64) -> bool {
    (n * cos).powi(2) + (after * after - n * n) > 1e-9
}

#[test]
fn every_coating_agrees_with_the_sum_over_reflections() {
    for coating in &all() {
        for n in INDICES {
            for after in INDICES {
                for (cos, nm) in cosines().into_iter().flat_map(|c| WAVES.map(|nm| (c, nm))) {
                    if !passes([n, after], cos) || cos < 1e-3 {
                        continue;
                    }
                    let found = coating.transmittance([n, after], cos, nm);
                    let expected = naive_transmittance(coating, [n, after], cos, nm);
                    // The sine of the phase is exact to f32. The naive formula, which is not tested
                    // close to grazing incidence, loses digits by cancellation.
                    assert!(
                        (found - expected).abs() < 1e-6,
                        "{coating:?} {n} to {after}, cos {cos}, {nm} nm: {found}, not {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn transmittances_lie_between_0_and_1() {
    for coating in &all() {
        for n in INDICES {
            for after in INDICES {
                for (cos, nm) in cosines().into_iter().flat_map(|c| WAVES.map(|nm| (c, nm))) {
                    let t = coating.transmittance([n, after], cos, nm);
                    assert!((0.0..=1.0).contains(&t), "{coating:?} {n} {after} {cos} {nm}: {t}");
                    let xi2 = (n * cos).powi(2) as f32;
                    let single =
                        CoatingModel::new::<f32>(coating, [n, after], nm).transmittance(xi2);
                    if passes([n, after], cos) {
                        assert!((0.0..=1.0).contains(&single), "{coating:?} {n} {after} {cos}");
                    }
                }
            }
        }
    }
}

#[test]
fn losses_are_equal_in_both_directions() {
    for coating in &all() {
        for cos in [1.0, 0.9, 0.5, 0.1] {
            let [n, after] = [1.0f64, 1.7];
            let behind = (1.0 - (n / after).powi(2) * (1.0 - cos * cos)).sqrt();
            let there = coating.transmittance([n, after], cos, D_LINE);
            let back = coating.transmittance([after, n], behind, D_LINE);
            assert!((there - back).abs() < 1e-7, "{coating:?} {cos}: {there} {back}");
        }
    }
}

#[test]
fn eight_lanes_equal_one_lane_and_are_close_to_f64() {
    for coating in &all() {
        for [n, after] in [[1.0, 1.6], [1.6, 1.0], [1.5, 1.7], [1.333, 1.5]] {
            let coat = CoatingModel::new::<f32>(coating, [n, after], D_LINE);
            let exact = CoatingModel::new::<f64>(coating, [n, after], D_LINE);
            let least = (n * n - after * after).max(0.0);
            for i in 1..=1000 {
                let xi2 = least + (n * n - least) * f64::from(i) / 1000.0;
                let one = coat.transmittance::<f32>(xi2 as f32);
                let packet = coat.transmittance::<f32x8>(f32x8::splat(xi2 as f32));
                assert!(packet.to_array().iter().all(|v| v.to_bits() == one.to_bits()));
                // Close to total internal reflection the square root of a rounded difference differs
                // between f32 and f64.
                let wide = exact.transmittance::<f64>(xi2);
                assert!(
                    (f64::from(one) - wide).abs() < 3e-5,
                    "{coating:?} {n} {xi2}: {one} {wide}"
                );
            }
        }
    }
}
