//! Losses of rays through lenses against the product of their surfaces.

use petzval_base::lanes::{Real, f32x8};
use petzval_lens::{Coating, Prescription, Side, retrace_in_f64_lossy, sequence_at, trace_lossy};
use petzval_spectrum::D_LINE;
use petzval_tools::bench::lens_wave::batch as lens_batch;

use super::all;
use super::surface::naive_transmittance;
use crate::support::{LENSES, Random, lens, oracle, row};

/// Traces rays with losses at the d line. Returns the weights of the rays that leave the lens.
fn weights_with_losses<R: Real>(
    lens: &Prescription,
    film: f64,
    rays: &[[[f64; 3]; 2]],
) -> Vec<Option<f64>> {
    weights_at::<R>(lens, film, D_LINE, rays)
}

/// Traces rays with losses at a wavelength (nm). Returns the weights of the rays that leave the lens.
pub fn weights_at<R: Real>(
    lens: &Prescription,
    film: f64,
    nm: f64,
    rays: &[[[f64; 3]; 2]],
) -> Vec<Option<f64>> {
    let mut batch = lens_batch::<R>(rays);
    let mut blocked = vec![0; lens.rows.len()];
    let side = Side::Film(film);
    trace_lossy::<R>(&mut batch, &sequence_at::<R>(lens, side, nm), &mut blocked);
    let exact = sequence_at::<f64>(lens, side, nm);
    retrace_in_f64_lossy::<R>(&mut batch, &exact, &mut blocked, |i| {
        let [p, t] = rays[i];
        petzval_lens::LensRay::new(p, t)
    });
    let came = |i: usize| !R::to_f64(batch.x[i]).is_nan();
    (0..rays.len()).map(|i| came(i).then(|| R::to_f64(batch.weight[i]))).collect()
}

#[test]
fn a_plate_loses_at_both_faces() {
    // A stop and a plate of glass at normal incidence.
    let plate = |coating| {
        let mut rows =
            vec![row(0.0, 1.0, 1.0, 10.0), row(1e9, 3.0, 1.5, 20.0), row(1e9, 0.0, 1.0, 20.0)];
        rows[1].coating = coating;
        Prescription::new("test", rows).expect("one stop")
    };
    let straight = [[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]];
    let share = |lens: &Prescription| {
        weights_with_losses::<f64>(lens, 10.0, &straight)[0].expect("it passes")
    };
    assert!((share(&plate(None)) - 0.96f64.powi(2)).abs() < 1e-12);
    let perfect = share(&plate(Some(Coating::Perfect)));
    assert!((perfect - 0.96).abs() < 1e-12, "one face is perfect: {perfect}");
    let mut coated = plate(Some(Coating::Perfect));
    coated.coat(&Coating::Broadband);
    let both = share(&coated);
    assert!((both - 0.9975).abs() < 1e-12, "the coating of the row is not kept: {both}");
}

#[test]
fn an_axial_ray_loses_the_product_of_its_surfaces() {
    for (name, film) in LENSES {
        for coating in &all() {
            let mut lens = lens(name);
            lens.coat(coating);
            let straight = [[[0.0, 0.0, 0.0], [0.0, 0.0, lens.rear().index]]];
            let found =
                weights_with_losses::<f64>(&lens, film, &straight)[0].expect("the axis is free");
            let (mut expected, mut n) = (1.0, 1.0);
            for row in &lens.rows {
                expected *= naive_transmittance(
                    coating_of(coating, [n, row.index]),
                    [n, row.index],
                    1.0,
                    D_LINE,
                );
                n = row.index;
            }
            assert!((found - expected).abs() < 1e-6, "{name} {coating:?}: {found}, {expected}");
        }
    }
}

/// Returns rays from the film to the rear of a lens.
pub fn oblique_rays(lens: &Prescription, film: f64, seed: u64) -> Vec<[[f64; 3]; 2]> {
    let mut random = Random::new(seed);
    (0..1000)
        .map(|_| {
            let mut disk = |r: f64| [random.between(-r, r), random.between(-r, r)];
            let ([x, y], [u, v]) = (disk(12.0), disk(lens.rear().diameter * 0.3));
            let d = [u - x, v - y, film];
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            // Rounded to f32, so that both precisions trace the same ray.
            let [x, y] = [x, y].map(|v| f64::from(v as f32));
            [[x, y, 0.0], d.map(|v| f64::from((v / length) as f32))]
        })
        .collect()
}

/// Returns the coating of a surface in a lens whose faces to air have this coating.
fn coating_of(coating: &Coating, indices: [f64; 2]) -> &Coating {
    if Coating::applies_to(indices) { coating } else { &Coating::Bare }
}

#[test]
fn oblique_rays_lose_as_much_as_in_the_oracle_in_every_precision() {
    for (name, film) in LENSES {
        let mut lens = lens(name);
        let faces = (0..lens.rows.len()).filter(|&i| Coating::applies_to(lens.indices(i)));
        for (i, coating) in
            faces.collect::<Vec<_>>().into_iter().zip(all().into_iter().cycle().skip(1))
        {
            lens.rows[i].coating = Some(coating);
        }
        let rays = oblique_rays(&lens, film, 5);
        let wide = weights_with_losses::<f64>(&lens, film, &rays);
        let packets = weights_with_losses::<f32x8>(&lens, film, &rays);
        assert_eq!(
            packets,
            weights_with_losses::<f32>(&lens, film, &rays),
            "{name}: one lane and eight differ"
        );
        let mut through = 0;
        for (i, [p, t]) in rays.iter().enumerate() {
            let (Some(wide), Some(single)) = (wide[i], packets[i]) else { continue };
            let expected = oracle_weight(&lens, film, *p, *t).expect("the ray leaves the lens");
            assert!((wide - expected).abs() < 1e-6, "{name} ray {i}: {wide}, not {expected}");
            assert!((single - wide).abs() < 1e-5, "{name} ray {i}: {single}, not {wide}");
            through += 1;
        }
        assert!(through > 100, "{name}: only {through} rays leave the lens");
    }
}

/// Returns the weight of a ray by the oracle and naive formulas, if it leaves the lens.
fn oracle_weight(lens: &Prescription, film: f64, p: [f64; 3], t: [f64; 3]) -> Option<f64> {
    let mut left = 1.0;
    let met = oracle::trace_spheres_visiting(lens, film, p, t, |row, cos, _| {
        let [before, behind] = lens.indices(row);
        let coating = lens.rows[row].coating.as_ref().unwrap_or(&Coating::Bare);
        left *= naive_transmittance(coating, [behind, before], cos.min(1.0), D_LINE);
    });
    met.ok().map(|_| left)
}

#[test]
fn retraced_rays_have_the_losses_of_f64() {
    // Rays from a film in glass meet a plane just below the critical angle.
    let rows = vec![row(0.0, 1.0, 1.0, 1e5), row(f64::INFINITY, 0.0, 1.5, 1e5)];
    let lens = Prescription::new("test", rows).expect("one stop");
    let rays: Vec<[[f64; 3]; 2]> = (1..=200)
        .map(|i| {
            // A small n' cos(theta').
            let out = f64::from(i) * 2e-4;
            let across = (1.0 - out * out).sqrt();
            [[0.0; 3], [across, 0.0, (2.25 - across * across).sqrt()]]
        })
        .collect();
    let (wide, packets) = (
        weights_with_losses::<f64>(&lens, 10.0, &rays),
        weights_with_losses::<f32x8>(&lens, 10.0, &rays),
    );
    for (i, ray) in rays.iter().enumerate() {
        let (wide, single) = (wide[i].expect("it passes"), packets[i].expect("it passes"));
        let expected = Coating::Bare.transmittance([1.5, 1.0], ray[1][2] / 1.5, D_LINE);
        assert!((wide - expected).abs() < 1e-6, "{i}: {wide}, not {expected}");
        assert!((single - wide).abs() < 1e-5, "{i}: {single}, not {wide}");
    }
}
