//! Monte Carlo analysis against direct traces of the changed lens.

use petzval_lens::{Pose, Prescription, TiltDecenter};
use petzval_optics::{
    DeviationShape, ImageQuality, ImagingConditions, ImagingGrid, RadiusLimit, Refocus,
    ToleranceAnalysis, ToleranceGrade, ToleranceKind, ToleranceLimits, ToleranceSettings,
};

use super::{conditions, lens};

fn settings(limits: ToleranceLimits) -> ToleranceSettings {
    ToleranceSettings {
        limits,
        shape: DeviationShape::Normal,
        refocus: Refocus::Off,
        shares: vec![0.0, 0.7, 1.0, -0.7, -1.0],
        rings: 12,
        frequency: 30.0,
        seed: 5,
        threads: 1,
    }
}

fn analysis(lens: &Prescription, height: f64, settings: ToleranceSettings) -> ToleranceAnalysis {
    ToleranceAnalysis::new(lens, conditions(lens, height), settings).expect("light at all fields")
}

/// RMS spot radii of a lens by the dense grid of the report (mm).
fn dense(lens: &Prescription, conditions: &ImagingConditions, fields: &[f64]) -> Vec<f64> {
    let grid = ImagingGrid { fields: 2, pupil: 64, threads: 1 };
    let quality = ImageQuality::new(lens, conditions.clone(), grid).expect("indices");
    let radius = |field: &f64| {
        let rays = quality.field(*field, grid.pupil).expect("a chief ray");
        rays.spot().size(0.0, None).expect("light").rms
    };
    fields.iter().map(radius).collect()
}

/// Figures of the hexapolar rays differ from those of a dense grid by this share.
const QUADRATURE: f64 = 0.02;

#[test]
fn no_error_gives_the_nominal_figures_to_the_last_bit() {
    let limits = ToleranceGrade::Precision.limits();
    let lens = lens("dgauss.50mm.dat");
    let analysis = analysis(&lens, 18.0, settings(limits));
    let none = analysis.figures(&vec![0.0; analysis.parameters.len()]);
    assert_eq!(none, analysis.nominal);
    let alone = self::analysis(&lens, 18.0, settings(ToleranceGrade::None.limits()));
    assert!(alone.parameters.is_empty());
    assert_eq!(alone.nominal, analysis.nominal);
    assert_eq!(alone.trials(1)[0].figures, analysis.nominal);
}

#[test]
fn nominal_spots_are_those_of_the_report() {
    for (file, height) in [("dgauss.50mm.dat", 18.0), ("triplet.toml", 15.0)] {
        let lens = lens(file);
        let settings = ToleranceSettings { rings: 24, ..settings(ToleranceGrade::None.limits()) };
        let analysis = analysis(&lens, height, settings);
        let expected = dense(&lens, analysis.conditions(), analysis.fields());
        for (found, expected) in analysis.nominal.spots.iter().zip(&expected) {
            assert!((found / expected - 1.0).abs() < QUADRATURE, "{file}: {found} {expected}");
        }
    }
}

#[test]
fn each_kind_of_error_alone_agrees_with_a_direct_trace_of_the_changed_lens() {
    let limits = ToleranceLimits {
        radius: RadiusLimit::Percent(1.0),
        thickness: 0.2,
        index: 5e-3,
        abbe: 5.0,
        tilt: 20.0,
        decentre: 0.2,
        wedge: 20.0,
    };
    let nominal = lens("triplet.toml");
    let analysis = analysis(&nominal, 15.0, settings(limits));
    let wanted = [
        ToleranceKind::RadiusPercent,
        ToleranceKind::Thickness,
        ToleranceKind::ElementTilt(0),
        ToleranceKind::ElementDecentre(1),
        ToleranceKind::SurfaceTilt(0),
    ];
    for kind in wanted {
        let number = analysis.parameters.iter().position(|one| one.kind == kind).expect("a kind");
        let parameter = analysis.parameters[number];
        let mut deviations = vec![0.0; analysis.parameters.len()];
        deviations[number] = parameter.limit;
        let mut changed = nominal.clone();
        let [first, last] = parameter.rows;
        let row = &mut changed.rows[first];
        let body = |pose| TiltDecenter { rows: [first, last], pose };
        match kind {
            ToleranceKind::RadiusPercent => row.radius *= 1.01,
            ToleranceKind::Thickness => row.thickness += 0.2,
            ToleranceKind::SurfaceTilt(_) => row.pose.tilt[0] = 20.0 / 60.0,
            ToleranceKind::ElementTilt(_) => {
                let pose = Pose { tilt: [20.0 / 60.0, 0.0], ..Pose::ALIGNED };
                changed.tilt_decenters.push(body(pose));
            }
            _ => {
                let pose = Pose { decentre: [0.0, 0.2], ..Pose::ALIGNED };
                changed.tilt_decenters.push(body(pose));
            }
        }
        let found = analysis.figures(&deviations);
        let expected = dense(&changed, analysis.conditions(), analysis.fields());
        let without = settings(ToleranceGrade::None.limits());
        let same_rays = ToleranceAnalysis::new(&changed, analysis.conditions().clone(), without)
            .expect("light at all fields");
        let nominal = &analysis.nominal;
        let moved = found.spots.iter().zip(&nominal.spots).any(|(a, b)| (a / b - 1.0).abs() > 0.05);
        assert!(moved, "{parameter} changes a spot");
        for (found, expected) in found.spots.iter().zip(&expected) {
            let off = (found / expected - 1.0).abs();
            assert!(off < 1.5 * QUADRATURE, "{parameter}: {found} {expected}");
        }
        // The same cells of the stop, aimed exactly instead of to first order.
        for (found, expected) in found.spots.iter().zip(&same_rays.nominal.spots) {
            let off = (found / expected - 1.0).abs();
            assert!(off < 0.003, "{parameter}: {found} {expected}");
        }
    }
}

#[test]
fn a_trial_depends_on_seed_and_number_alone() {
    let lens = lens("triplet.toml");
    let of = |threads: usize, seed: u64| {
        let settings = ToleranceSettings {
            threads,
            seed,
            rings: 4,
            ..settings(ToleranceGrade::Commercial.limits())
        };
        analysis(&lens, 15.0, settings).trials(24)
    };
    let one = of(1, 5);
    assert_eq!(one, of(3, 5));
    assert_ne!(one[0].deviations, of(1, 6)[0].deviations);
    assert_ne!(one[0].deviations, one[1].deviations);
}

#[test]
fn refocus_never_makes_the_spots_larger_and_undoes_a_moved_film() {
    let lens = lens("triplet.toml");
    let mut moved = conditions(&lens, 15.0);
    let limits = ToleranceLimits { thickness: 0.1, ..ToleranceGrade::None.limits() };
    let with = |refocus| ToleranceSettings { refocus, rings: 6, ..settings(limits) };
    let of = |conditions: &ImagingConditions, refocus| {
        ToleranceAnalysis::new(&lens, conditions.clone(), with(refocus)).expect("light")
    };
    let [off, fields] = [Refocus::Off, Refocus::Fields].map(|refocus| of(&moved, refocus));
    for (off, fields) in off.trials(20).iter().zip(fields.trials(20)) {
        assert!(fields.figures.spot() <= off.figures.spot() * (1.0 + 1e-12));
    }
    let best = fields.nominal.clone();
    // The same field angles.
    moved = fields.conditions().clone();
    moved.film_distance += 0.3;
    let again = of(&moved, Refocus::Fields);
    assert!((again.nominal.spot() / best.spot() - 1.0).abs() < 1e-9);
    assert!((again.nominal.defocus - (best.defocus - 0.3)).abs() < 1e-9);
}

#[test]
fn a_fringe_is_half_a_wavelength_of_sag() {
    let limits =
        ToleranceLimits { radius: RadiusLimit::Fringes(4.0), ..ToleranceGrade::None.limits() };
    let lens = lens("dgauss.50mm.dat");
    let analysis = analysis(&lens, 18.0, settings(limits));
    let mut deviations = vec![0.0; analysis.parameters.len()];
    deviations[0] = 4.0;
    let mut trial = analysis.trials(1).remove(0);
    trial.deviations = deviations;
    let changed = analysis.lens(&trial);
    let (before, after) = (&lens.rows[0], &changed.rows[0]);
    let half = before.diameter / 2.0;
    let sag = (after.curvature() - before.curvature()) * half * half / 2.0;
    assert!((sag - 4.0 * 546.074e-6 / 2.0).abs() < 1e-9, "{sag}");
}
