//! Analyses with known results: a perfect mirror, third-order aberrations, Zernike's polynomials.

use std::f64::consts::PI;

use petzval_lens::{Paraxial, Prescription, Row, SpectralLine};
use petzval_optics::{
    FieldRays, FrequencyAxis, ImagingConditions, ImagingGrid, PointImage, TransferMethod, noll,
    zernike,
};

use super::{conditions, lens, paraboloid, traced};
use crate::support::row;

const AXES: [FrequencyAxis; 2] = [FrequencyAxis::X, FrequencyAxis::Y];

/// sin(theta) of the paraboloid's marginal ray: its height over its distance from the focus,
/// f + h^2 / (4 f).
const SINE: f64 = 20.0 / 101.0;

/// MTF of a round pupil at a share of its cut-off frequency (Hopkins 1953).
fn round_pupil(share: f64) -> f64 {
    2.0 / PI * (share.acos() - share * (1.0 - share * share).sqrt())
}

#[test]
fn a_paraboloid_has_a_perfect_wavefront_on_its_axis() {
    let (lens, conditions) = paraboloid();
    let quality = traced(&lens, conditions, 2);
    let axis = &quality.fields[0];
    let grid = axis.grids[0].as_ref().expect("light");
    for (_, cell) in grid.open() {
        assert!(cell.phase.abs() < 1e-11, "{cell:?}");
        assert!(cell.path_difference.abs() < 1e-11, "{cell:?}");
        assert!(cell.point[0].hypot(cell.point[1]) < 1e-11, "{cell:?}");
    }
    assert!((grid.area() / (PI * SINE * SINE) - 1.0).abs() < 1e-3, "{}", grid.area());
    for point in quality.fans(axis, 1, 20).iter().flat_map(|fan| &fan.points) {
        assert!(point.passes && point.waves.abs() < 1e-7, "{point:?}");
    }
}

#[test]
fn a_perfect_round_pupil_has_the_transfer_function_of_theory() {
    let (lens, conditions) = paraboloid();
    let quality = traced(&lens, conditions, 2);
    let axis = &quality.fields[0];
    let wavelength = quality.conditions.primary_line().nm * 1e-6;
    let cut_off = 2.0 * SINE / wavelength;
    for share in [0.013, 0.1, 0.25, 0.5, 0.77, 0.95] {
        for direction in AXES {
            for method in [TransferMethod::Diffraction, TransferMethod::Limit] {
                let value = axis.modulation(share * cut_off, direction, method, 0.0);
                // A mirror of f/2.5 is brighter at the rim in direction cosines than in the middle.
                let error = value.expect("light") - round_pupil(share);
                assert!(error.abs() < 6e-3, "{share} {direction:?} {method:?}: {error}");
            }
        }
    }
}

#[test]
fn the_airy_disc_holds_84_percent_of_the_light() {
    let (lens, conditions) = paraboloid();
    let quality = traced(&lens, conditions, 2);
    let axis = &quality.fields[0];
    let airy = axis.grids[0].as_ref().expect("light").airy_radius();
    let image = axis.point_image(128, 16.0 * airy).expect("light");
    assert!((image.strehl - 1.0).abs() < 2e-3, "{}", image.strehl);
    let curve = image.encircled_energy(160);
    let within = |radius: f64| curve.iter().find(|(r, _)| *r >= radius).expect("a radius").1;
    // First and second dark ring (Born & Wolf, 8.5.2).
    assert!((within(airy) - 0.838).abs() < 6e-3, "{}", within(airy));
    assert!((within(1.830 * airy) - 0.910).abs() < 6e-3, "{}", within(1.83 * airy));
}

/// A plano-convex singlet at f/20 with a stop in front of it, on its paraxial focus.
fn slow_singlet() -> (Prescription, ImagingConditions) {
    let stop = Row { stop: true, ..row(f64::INFINITY, 20.0, 1.0, 2.5) };
    let rows = vec![stop, row(f64::INFINITY, 3.0, 1.6, 30.0), row(-60.0, 0.0, 1.0, 30.0)];
    let lens = Prescription::new("singlet", rows).expect("one stop");
    let mut conditions = conditions(&lens, 1.0);
    conditions.film_distance = Paraxial::new(&lens).back_focal_distance;
    conditions.wavelengths = vec![SpectralLine { nm: 550.0, weight: 1.0 }];
    conditions.primary = 0;
    (lens, conditions)
}

#[test]
fn a_slow_lens_has_the_aberrations_of_its_seidel_sums() {
    let (lens, conditions) = slow_singlet();
    let quality = traced(&lens, conditions, 3);
    let seidel = quality.seidel(&lens).expect("glasses with data");
    let [w040, w131, w222, w220, w311, ..] = seidel.total.wavefront().map(|w| w / 550e-6);
    let waves = |field: usize, axis: usize, index: usize| {
        let fans = quality.fans(&quality.fields[field], axis, 10);
        fans[0].points[index].waves
    };
    // The edge of the stop on the axis.
    let spherical = waves(0, 1, 20);
    assert!((spherical / w040 - 1.0).abs() < 0.006, "{spherical} {w040}");
    // Odd part of the tangential fan at the edge of the field: coma.
    let edge = quality.fields.len() - 1;
    let coma = (waves(edge, 1, 20) - waves(edge, 1, 0)) / 2.0;
    assert!((coma / w131 - 1.0).abs() < 0.006, "{coma} {w131}");
    // Even parts: spherical aberration, astigmatism and field curvature.
    let tangential = (waves(edge, 1, 20) + waves(edge, 1, 0)) / 2.0 - spherical;
    let sagittal = (waves(edge, 0, 20) + waves(edge, 0, 0)) / 2.0 - spherical;
    let expected = w220 + w222 / 2.0;
    assert!((sagittal / expected - 1.0).abs() < 0.006, "{sagittal} {expected}");
    assert!(((tangential - sagittal) / w222 - 1.0).abs() < 0.006, "{tangential} {sagittal} {w222}");
    // Distortion: a tilt of W311 moves the chief ray's point by 2 N W311.
    let point = quality.field_curve(0, 1).pop().expect("the edge");
    let f_number = Paraxial::new(&lens).f_number();
    let height = -2.0 * f_number * w311 * 550e-6;
    let real = point.height - point.linear_height;
    assert!((real / height - 1.0).abs() < 0.006, "{real} {height}");
}

#[test]
fn chromatic_sums_are_the_focal_shift_of_first_order() {
    let lens = lens("triplet.toml");
    let quality = traced(&lens, conditions(&lens, 10.0), 2);
    let [short, long] = quality.conditions.spectral_ends();
    let seidel = quality.seidel(&lens).expect("glasses with data");
    // C_L = -n' u'^2 times the longitudinal shift; a thick triplet agrees to a percent of its parts.
    let shift = quality.paraxial_focus(short) - quality.paraxial_focus(long);
    let slope = 1.0 / (2.0 * Paraxial::new(&lens).f_number());
    let parts: f64 = seidel.rows.iter().map(|row| row.chromatic[0].abs()).sum();
    let error = seidel.total.chromatic[0] - shift * slope * slope;
    assert!(error.abs() < 0.02 * parts, "{} {shift} {parts}", seidel.total.chromatic[0]);
}

#[test]
fn zernike_polynomials_are_orthonormal_in_the_order_of_noll() {
    let known =
        [[0, 0], [1, 1], [1, -1], [2, 0], [2, -2], [2, 2], [3, -1], [3, 1], [3, -3], [3, 3]];
    for (i, pair) in known.into_iter().enumerate() {
        assert_eq!(noll(i + 1), pair, "{}", i + 1);
    }
    assert_eq!(noll(11), [4, 0]);
    assert_eq!(noll(37), [8, 0]);
    let side = 400;
    let place = |i: usize| 2.0 * (i as f64 + 0.5) / side as f64 - 1.0;
    let points: Vec<[f64; 2]> = (0..side * side)
        .map(|i| [place(i % side), place(i / side)])
        .filter(|[x, y]| x.hypot(*y) < 1.0)
        .collect();
    for a in 1..=15 {
        for b in 1..=a {
            let sum: f64 = points.iter().map(|at| zernike(a, *at) * zernike(b, *at)).sum();
            let mean = sum / points.len() as f64;
            let expected = if a == b { 1.0 } else { 0.0 };
            assert!((mean - expected).abs() < 5e-3, "{a} {b}: {mean}");
        }
    }
}

#[test]
fn a_defocused_paraboloid_has_noll_s_fourth_coefficient() {
    let (lens, mut conditions) = paraboloid();
    conditions.film_distance += 0.01;
    let quality = traced(&lens, conditions, 2);
    let grid = quality.fields[0].grids[0].as_ref().expect("light");
    let fit = grid.zernike(37);
    // A sag of defocus over a sphere of f/2.5, to first order: delta sin^2 / 2 over the wavelength.
    let edge = 0.01 * (1.0 - (1.0 - SINE.powi(2)).sqrt()) / (grid.nm * 1e-6);
    let expected = edge / (2.0 * 3.0_f64.sqrt());
    assert!((fit.coefficients[3].abs() / expected - 1.0).abs() < 0.01, "{fit:?} {expected}");
    assert!(fit.residual < 1e-3, "{}", fit.residual);
}

#[test]
fn the_fourier_transform_of_the_point_image_is_the_transfer_function() {
    let lens = lens("triplet.toml");
    let mut conditions = conditions(&lens, 12.0);
    conditions.wavelengths = vec![conditions.primary_line()];
    conditions.primary = 0;
    let quality = traced(&lens, conditions, 2);
    let edge = quality.field(12.0, 128).expect("light");
    let width = 0.5 * edge.resolved_width();
    let image = edge.point_image(256, width).expect("light");
    let inside: f64 = image.values.iter().sum();
    assert!(inside > 0.98 && inside < 1.001, "{inside}");
    for frequency in [5.0, 20.0, 50.0] {
        for axis in AXES {
            let value =
                edge.modulation(frequency, axis, TransferMethod::Diffraction, 0.0).expect("light");
            let transform = transform(&image, frequency, axis) / inside;
            assert!((value - transform).abs() < 0.02, "{frequency} {axis:?}: {value} {transform}");
        }
    }
}

fn transform(image: &PointImage, frequency: f64, axis: FrequencyAxis) -> f64 {
    let mut sum = [0.0; 2];
    for (i, value) in image.values.iter().enumerate() {
        let place = if axis == FrequencyAxis::X { i % image.side } else { i / image.side };
        let (sin, cos) = (2.0 * PI * frequency * place as f64 * image.pitch).sin_cos();
        sum = [sum[0] + value * cos, sum[1] + value * sin];
    }
    sum[0].hypot(sum[1])
}

#[test]
fn the_same_bits_come_from_any_number_of_threads() {
    let lens = lens("triplet.toml");
    let on = |threads: usize| {
        let grid = ImagingGrid { fields: 5, pupil: 24, threads };
        petzval_optics::ImageQuality::new(&lens, conditions(&lens, 21.0), grid).expect("glasses")
    };
    let (one, three) = (on(1), on(3));
    for (a, b) in one.fields.iter().zip(&three.fields) {
        for (a, b) in a.grids.iter().zip(&b.grids) {
            let (a, b) = (a.as_ref().expect("light"), b.as_ref().expect("light"));
            assert_eq!(a.cells, b.cells);
        }
    }
}

#[test]
fn the_point_image_in_all_light_is_the_sum_of_those_of_its_wavelengths() {
    let lens = lens("triplet.toml");
    let quality = traced(&lens, conditions(&lens, 12.0), 2);
    let lines = quality.conditions.wavelengths.clone();
    let edge = &quality.fields[1];
    let image = |rays: &FieldRays| {
        let side = 64;
        let pitch = 0.5 * edge.resolved_width() / side as f64;
        rays.point_image(side, pitch * side as f64).expect("light")
    };
    let alone = |line: SpectralLine, weight: f64| {
        let line = SpectralLine { weight, ..line };
        quality.trace_field_in(&lens, &[line], edge.field, 64).expect("data").expect("a chief ray")
    };
    let all = quality.trace_field_in(&lens, &lines, edge.field, 64).expect("data").expect("rays");
    assert_eq!(image(&all), image(edge));
    // The weight of a wavelength alone does not count.
    for &line in &lines {
        assert_eq!(image(&alone(line, 1.0)).values, image(&alone(line, 0.25)).values);
    }
    // Lateral colour moves the images apart, from the same reference.
    let [first, last] = [lines[0], lines[lines.len() - 1]].map(|line| image(&alone(line, 1.0)));
    assert!((first.centre[1] - last.centre[1]).abs() > 1e-4, "{first:?}");
    let none = SpectralLine { nm: 2e4, weight: 1.0 };
    assert!(quality.trace_field_in(&lens, &[none], edge.field, 64).is_err());
}
