//! What surfaces let through: one surface against the textbook, a lens against a product of its
//! surfaces, a picture against the estimate.

mod support;

use petzval::image::Picture;
use petzval::job::{Changes, prepare};
use petzval::lanes::{Real, f32x8};
use petzval::lens::{
    Aim, BROADBAND, Coat, Coating, D_LINE, From, MGF2, Model, Prescription, RealLens, TUNED,
    sequence, settle_lossy, trace_lossy,
};
use petzval::rays::LensBatch;
use petzval::render::{Backend, Job};
use petzval::scene::pbrt;
use support::{LENSES, Random, folder, lens, oracle, picture, root, row, write};

const ALL: [Coating; 4] = [Coating::Bare, Coating::Mgf2, Coating::Broadband, Coating::Perfect];

/// A complex number.
type Complex = [f64; 2];

fn product([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

fn quotient(a: Complex, [c, d]: Complex) -> Complex {
    product(a, [c, -d]).map(|v| v / (c * c + d * d))
}

/// What a stack of media reflects, for light across the plane of incidence and in it, by
/// Fresnel's amplitudes and the sum of all reflections in one layer (Airy 1833): the naive twin.
/// `layer` is an index and the thickness in wavelengths in vacuum.
fn reflectances(n: f64, layer: Option<[f64; 2]>, after: f64, angle: f64) -> [f64; 2] {
    let cos = |m: f64| (1.0 - (n / m * angle.sin()).powi(2)).sqrt();
    let amplitudes = |a: f64, b: f64| {
        let (ca, cb) = (cos(a), cos(b));
        [(a * ca - b * cb) / (a * ca + b * cb), (b * ca - a * cb) / (b * ca + a * cb)]
    };
    let Some([middle, thickness]) = layer else {
        return amplitudes(n, after).map(|r| r * r);
    };
    let (first, second) = (amplitudes(n, middle), amplitudes(middle, after));
    let phase = 4.0 * std::f64::consts::PI * middle * thickness * cos(middle);
    [0, 1].map(|i| {
        let there = [second[i] * phase.cos(), second[i] * phase.sin()];
        let top = [first[i] + there[0], there[1]];
        let bottom = product([first[i], 0.0], there);
        let [re, im] = quotient(top, [1.0 + bottom[0], bottom[1]]);
        re * re + im * im
    })
}

/// The same for a coating and unpolarised light.
fn naive(coating: Coating, [n, after]: [f64; 2], cos: f64, nm: f64) -> f64 {
    let angle = cos.acos();
    let unpolarised = |[s, p]: [f64; 2]| 1.0 - (s + p) / 2.0;
    let bare = |angle: f64| unpolarised(reflectances(n, None, after, angle));
    match coating {
        Coating::Perfect => 1.0,
        Coating::Mgf2 if Coating::fits([n, after]) => {
            let layer = [MGF2, TUNED / (4.0 * MGF2) / nm];
            unpolarised(reflectances(n, Some(layer), after, angle))
        }
        Coating::Broadband if Coating::fits([n, after]) => {
            let rise = (bare(0.0) - bare(angle)) / bare(0.0);
            let least = BROADBAND.min(1.0 - bare(0.0));
            // From n = 3.7 on bare glass reflects less at 60 degrees than straight on.
            (1.0 - (least + (1.0 - least) * rise)).min(1.0)
        }
        _ => bare(angle),
    }
}

fn reflected(coating: Coating, indices: [f64; 2], degrees: f64, nm: f64) -> f64 {
    1.0 - coating.transmittance(indices, degrees.to_radians().cos(), nm)
}

#[test]
fn bare_glass_reflects_what_the_textbook_says() {
    // Air to n = 1.5: 0.04 at normal incidence (Hecht, Optics, sec. 4.6); by hand, with Snell's
    // angles of 19.4712 and 35.2644 degrees, Rs = 0.057796 and Rp = 0.025249 at 30 degrees,
    // 0.176571 and 0.001802 at 60.
    for (degrees, expected) in
        [(0.0, 0.04), (30.0, (0.057_796 + 0.025_249) / 2.0), (60.0, (0.176_571 + 0.001_802) / 2.0)]
    {
        let found = reflected(Coating::Bare, [1.0, 1.5], degrees, D_LINE);
        assert!((found - expected).abs() < 1e-6, "{degrees} degrees: {found}, not {expected}");
    }
    // At Brewster's angle nothing in the plane is reflected, and across it ((m^2 - 1)/(m^2 + 1))^2.
    let brewster = 1.5f64.atan().to_degrees();
    let found = reflected(Coating::Bare, [1.0, 1.5], brewster, D_LINE);
    assert!((found - (1.25f64 / 3.25).powi(2) / 2.0).abs() < 1e-12, "{found}");
    assert_eq!(reflected(Coating::Bare, [1.5, 1.0], 45.0, D_LINE), 1.0, "total reflection");
}

#[test]
fn a_quarter_wave_reflects_what_the_textbook_says() {
    let (n0, n2) = (1.0, 1.52);
    let expected = ((n0 * n2 - MGF2 * MGF2) / (n0 * n2 + MGF2 * MGF2)).powi(2);
    assert!((expected - 0.0126).abs() < 5e-5, "1.26 %, as catalogues have it");
    let found = reflected(Coating::Mgf2, [n0, n2], 0.0, TUNED);
    assert!((found - expected).abs() < 1e-8, "{found}, not {expected}");
    // A half wave is as if it were not there.
    let half = reflected(Coating::Mgf2, [n0, n2], 0.0, TUNED / 2.0);
    assert!((half - reflected(Coating::Bare, [n0, n2], 0.0, TUNED)).abs() < 1e-7, "{half}");
    // Off its wavelength and off the normal it reflects more.
    assert!(reflected(Coating::Mgf2, [n0, n2], 0.0, 700.0) > expected);
    assert!(reflected(Coating::Mgf2, [n0, n2], 60.0, TUNED) > 3.0 * expected);
}

#[test]
fn the_ideal_coat_reflects_a_quarter_of_a_percent_and_all_at_grazing() {
    for after in [1.5, 1.7, 1.9] {
        let found = reflected(Coating::Broadband, [1.0, after], 0.0, D_LINE);
        assert!((found - 0.0025).abs() < 1e-12, "{found}");
        assert!(reflected(Coating::Broadband, [1.0, after], 90.0 - 1e-6, D_LINE) > 0.9999);
    }
    // It makes no thin medium worse than it is.
    let thin = reflected(Coating::Broadband, [1.0, 1.05], 0.0, D_LINE);
    assert!((thin - (0.05f64 / 2.05).powi(2)).abs() < 1e-12, "{thin}");
}

const INDICES: [f64; 10] = [1.0, 1.000_001, 1.0003, 1.05, 1.333, 1.379_999, 1.5, 1.9, 4.0, 10.0];
const WAVES: [f64; 6] = [275.0, 380.0, 550.0, D_LINE, 780.0, 2000.0];

/// Cosines of incidence, to the last before grazing.
fn cosines() -> Vec<f64> {
    let even = (0..=40).map(|i| f64::from(i) / 40.0);
    even.chain([1e-9, 1e-6, 1e-3, 1.0 - 1e-9]).collect()
}

/// Whether light passes at all, and not within rounding of where it does not.
fn passes([n, after]: [f64; 2], cos: f64) -> bool {
    (n * cos).powi(2) + (after * after - n * n) > 1e-9
}

#[test]
fn every_coating_agrees_with_the_sum_of_its_reflections() {
    for coating in ALL {
        for n in INDICES {
            for after in INDICES {
                for (cos, nm) in cosines().into_iter().flat_map(|c| WAVES.map(|nm| (c, nm))) {
                    if !passes([n, after], cos) || cos < 1e-3 {
                        continue;
                    }
                    let found = coating.transmittance([n, after], cos, nm);
                    let expected = naive(coating, [n, after], cos, nm);
                    // The sine of the phase is exact to f32; the naive form, which is left alone next
                    // to grazing, loses digits to cancellation.
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
fn no_surface_makes_light_or_less_than_none() {
    for coating in ALL {
        for n in INDICES {
            for after in INDICES {
                for (cos, nm) in cosines().into_iter().flat_map(|c| WAVES.map(|nm| (c, nm))) {
                    let t = coating.transmittance([n, after], cos, nm);
                    assert!((0.0..=1.0).contains(&t), "{coating:?} {n} {after} {cos} {nm}: {t}");
                    let xi2 = (n * cos).powi(2) as f32;
                    let single = Coat::new::<f32>(coating, [n, after], nm).transmittance(xi2);
                    if passes([n, after], cos) {
                        assert!((0.0..=1.0).contains(&single), "{coating:?} {n} {after} {cos}");
                    }
                }
            }
        }
    }
}

#[test]
fn both_ways_through_a_surface_lose_the_same() {
    for coating in ALL {
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
fn eight_lanes_round_like_one_and_near_f64() {
    for coating in ALL {
        for [n, after] in [[1.0, 1.6], [1.6, 1.0], [1.5, 1.7], [1.333, 1.5]] {
            let coat = Coat::new::<f32>(coating, [n, after], D_LINE);
            let exact = Coat::new::<f64>(coating, [n, after], D_LINE);
            let least = (n * n - after * after).max(0.0);
            for i in 1..=1000 {
                let xi2 = least + (n * n - least) * f64::from(i) / 1000.0;
                let one = coat.transmittance::<f32>(xi2 as f32);
                let packet = coat.transmittance::<f32x8>(f32x8::splat(xi2 as f32));
                assert!(packet.to_array().iter().all(|v| v.to_bits() == one.to_bits()));
                // Near total reflection the root of a rounded difference tells f32 from f64.
                let wide = exact.transmittance::<f64>(xi2);
                assert!(
                    (f64::from(one) - wide).abs() < 3e-5,
                    "{coating:?} {n} {xi2}: {one} {wide}"
                );
            }
        }
    }
}

/// A batch of these rays after a trace with losses: positions and weights of what came through.
fn lossy<R: Real>(lens: &Prescription, film: f64, rays: &[[[f64; 3]; 2]]) -> Vec<Option<f64>> {
    let mut batch = Box::<LensBatch<R::Scalar>>::default();
    for (i, [p, t]) in rays.iter().enumerate() {
        [batch.x[i], batch.y[i], batch.z[i]] = p.map(R::scalar);
        [batch.tx[i], batch.ty[i], batch.tz[i]] = t.map(R::scalar);
        batch.weight[i] = R::scalar(1.0);
    }
    batch.resize::<R>(rays.len());
    let mut blocked = vec![0; lens.rows.len()];
    trace_lossy::<R>(&mut batch, &sequence::<R>(lens, From::Film(film)), &mut blocked);
    settle_lossy::<R>(&mut batch, &sequence::<f64>(lens, From::Film(film)), &mut blocked, |i| {
        let [p, t] = rays[i];
        petzval::lens::LensRay::new(p, t)
    });
    let came = |i: usize| !R::to_f64(batch.x[i]).is_nan();
    (0..rays.len()).map(|i| came(i).then(|| R::to_f64(batch.weight[i]))).collect()
}

#[test]
fn a_plate_loses_at_both_faces() {
    // A stop and a plate of glass, straight on.
    let plate = |coating| {
        let mut rows =
            vec![row(0.0, 1.0, 1.0, 10.0), row(1e9, 3.0, 1.5, 20.0), row(1e9, 0.0, 1.0, 20.0)];
        rows[1].coating = coating;
        Prescription { rows, ..Prescription::default() }
    };
    let straight = [[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]];
    let share = |lens: &Prescription| lossy::<f64>(lens, 10.0, &straight)[0].expect("it passes");
    assert!((share(&plate(None)) - 0.96f64.powi(2)).abs() < 1e-12);
    let perfect = share(&plate(Some(Coating::Perfect)));
    assert!((perfect - 0.96).abs() < 1e-12, "one face is perfect: {perfect}");
    let mut coated = plate(Some(Coating::Perfect));
    coated.coat(Coating::Broadband);
    let both = share(&coated);
    assert!((both - 0.9975).abs() < 1e-12, "its own coating stays: {both}");
}

#[test]
fn an_axial_ray_loses_the_product_of_its_surfaces() {
    for (name, film) in LENSES {
        for coating in ALL {
            let mut lens = lens(name);
            lens.coat(coating);
            let straight = [[[0.0, 0.0, 0.0], [0.0, 0.0, lens.rear().index]]];
            let found = lossy::<f64>(&lens, film, &straight)[0].expect("the axis is free");
            let (mut expected, mut n) = (1.0, 1.0);
            for row in &lens.rows {
                expected *= naive(coating_of(coating, [n, row.index]), [n, row.index], 1.0, D_LINE);
                n = row.index;
            }
            assert!((found - expected).abs() < 1e-6, "{name} {coating:?}: {found}, {expected}");
        }
    }
}

/// What a surface wears in a lens whose faces to air have this coating.
fn coating_of(coating: Coating, indices: [f64; 2]) -> Coating {
    if Coating::fits(indices) { coating } else { Coating::Bare }
}

#[test]
fn oblique_rays_lose_what_the_oracle_loses_in_every_precision() {
    for (name, film) in LENSES {
        let mut lens = lens(name);
        lens.coat(Coating::Mgf2);
        let mut random = Random::new(5);
        let rays: Vec<[[f64; 3]; 2]> = (0..1000)
            .map(|_| {
                let mut disk = |r: f64| [random.between(-r, r), random.between(-r, r)];
                let ([x, y], [u, v]) = (disk(12.0), disk(lens.rear().diameter * 0.3));
                let d = [u - x, v - y, film];
                let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
                // As f32 has it, so that both precisions trace the same ray.
                let [x, y] = [x, y].map(|v| f64::from(v as f32));
                [[x, y, 0.0], d.map(|v| f64::from((v / length) as f32))]
            })
            .collect();
        let wide = lossy::<f64>(&lens, film, &rays);
        let packets = lossy::<f32x8>(&lens, film, &rays);
        assert_eq!(packets, lossy::<f32>(&lens, film, &rays), "{name}: the same bits");
        let mut through = 0;
        for (i, [p, t]) in rays.iter().enumerate() {
            let (Some(wide), Some(single)) = (wide[i], packets[i]) else { continue };
            let expected = by_oracle(&lens, film, *p, *t).expect("it comes through");
            assert!((wide - expected).abs() < 1e-6, "{name} ray {i}: {wide}, not {expected}");
            assert!((single - wide).abs() < 1e-5, "{name} ray {i}: {single}, not {wide}");
            through += 1;
        }
        assert!(through > 100, "{name}: only {through} rays come through");
    }
}

/// What is left of a ray by the oracle and the naive reflectances, if it comes through.
fn by_oracle(lens: &Prescription, film: f64, p: [f64; 3], t: [f64; 3]) -> Option<f64> {
    let mut left = 1.0;
    let met = oracle::trace_seeing(lens, film, p, t, |row, cos| {
        let [before, behind] = lens.indices(row);
        let coating = lens.rows[row].coating.unwrap_or_default();
        left *= naive(coating, [behind, before], cos.min(1.0), D_LINE);
    });
    met.ok().map(|_| left)
}

#[test]
fn rays_that_f32_doubts_lose_what_f64_says() {
    // A film in glass looks out through a plane, hardly below the angle of total reflection.
    let rows = vec![row(0.0, 1.0, 1.0, 1e5), row(f64::INFINITY, 0.0, 1.5, 1e5)];
    let lens = Prescription { rows, ..Prescription::default() };
    let rays: Vec<[[f64; 3]; 2]> = (1..=200)
        .map(|i| {
            // n' cos(theta'), small.
            let out = f64::from(i) * 2e-4;
            let across = (1.0 - out * out).sqrt();
            [[0.0; 3], [across, 0.0, (2.25 - across * across).sqrt()]]
        })
        .collect();
    let (wide, packets) = (lossy::<f64>(&lens, 10.0, &rays), lossy::<f32x8>(&lens, 10.0, &rays));
    for (i, ray) in rays.iter().enumerate() {
        let (wide, single) = (wide[i].expect("it passes"), packets[i].expect("it passes"));
        let expected = Coating::Bare.transmittance([1.5, 1.0], ray[1][2] / 1.5, D_LINE);
        assert!((wide - expected).abs() < 1e-6, "{i}: {wide}, not {expected}");
        assert!((single - wide).abs() < 1e-5, "{i}: {single}, not {wide}");
    }
}

/// The middle of the film of a double Gauss under a uniform sky.
fn sky(changes: &Changes) -> Job {
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 16 "integer yresolution" 16 "float diagonal" 2
           Sampler "sobol" "integer pixelsamples" 64
           Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat"
               "float aperturediameter" 100 "float focusdistance" 5
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]"#,
        root().display()
    );
    let description = pbrt::read(&write(&folder, "sky.pbrt", text)).expect("a scene");
    prepare(description, changes).expect("a job").0
}

fn coated(coating: Coating) -> Job {
    sky(&Changes { coating: Some(coating), ..Changes::default() })
}

fn real(job: &Job) -> &RealLens {
    let Model::Real(lens) = &job.camera.model else { panic!("a real lens") };
    lens
}

fn middle(picture: &Picture) -> f64 {
    picture.pixels.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>()
        / picture.pixels.len() as f64
}

#[test]
fn a_picture_darkens_by_the_estimated_share() {
    let clear = sky(&Changes::default());
    assert!(!real(&clear).fresnel, "losses are off unless asked for");
    let clear = middle(&picture(&clear, Backend::Simd, 2));
    for coating in [Coating::Bare, Coating::Mgf2, Coating::Broadband] {
        let job = coated(coating);
        let estimate = real(&job).transmittance([0.0; 2]).expect("light");
        let found = middle(&picture(&job, Backend::Simd, 2)) / clear;
        println!("{coating:?}: {estimate:.5} estimated, {found:.5} of the light in the picture");
        // The same samples with losses and without: what is left is how losses vary in the pupil.
        assert!((found / estimate - 1.0).abs() < 2e-4, "{coating:?}: {found}, not {estimate}");
        let over = real(&job).throughput(1.0).expect("light");
        assert!((over.mean / estimate - 1.0).abs() < 2e-4, "{over:?}");
        assert!(over.range[0] <= over.mean && over.mean <= over.range[1], "{over:?}");
        assert_eq!(over.axis, estimate);
    }
}

#[test]
fn one_lane_and_eight_take_the_same_lossy_picture() {
    let job = coated(Coating::Mgf2);
    assert_eq!(
        picture(&job, Backend::Simd, 2).pixels,
        picture(&job, Backend::Scalar, 1).pixels,
        "bit for bit"
    );
}

#[test]
fn a_lens_that_loses_nothing_takes_the_picture_of_one_without_losses() {
    let off = sky(&Changes::default());
    let mut on = sky(&Changes::default());
    let Model::Real(lens) = &mut on.camera.model else { panic!("a real lens") };
    let mut prescription = lens.prescription.clone();
    prescription.rows.iter_mut().for_each(|row| row.coating = Some(Coating::Perfect));
    let remade = RealLens::new(prescription, lens.film_distance, 1.2, Aim::Pupil, 1e-3, lens.front);
    **lens = remade;
    lens.fresnel = true;
    let mut plain = off;
    let Model::Real(lens) = &mut plain.camera.model else { panic!("a real lens") };
    let prescription = lens.prescription.clone();
    **lens = RealLens::new(prescription, lens.film_distance, 1.2, Aim::Pupil, 1e-3, lens.front);
    let (plain, on) = (picture(&plain, Backend::Simd, 2), picture(&on, Backend::Simd, 2));
    assert_eq!(plain.pixels, on.pixels, "bit for bit");
}

#[test]
fn the_field_of_a_fisheye_loses_more_than_its_middle() {
    let lens = RealLens::new(lens("fisheye.10mm"), 23.192, 21.6, Aim::Pupil, 1e-3, 0.0);
    let over = lens.throughput(21.6).expect("light");
    println!("{over:?}");
    assert!(over.range[0] < 0.99 * over.range[1], "{over:?}");
    assert!(over.range[0] > 0.3 && over.range[1] < 0.8, "{over:?}");
}
