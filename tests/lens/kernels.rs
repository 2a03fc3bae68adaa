//! Lens kernels against the oracle, and one lane against eight.

use crate::support::nasty::NASTY;
use crate::support::{LENSES, Random, lens, oracle, row};
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{LensBatch, WAVE_SIZE};
use petzval_lens::{
    LensRay, Prescription, PupilBounds, PupilSampling, Side, retrace_in_f64, sequence, trace,
    trace_one,
};
use petzval_tools::bench::lens_wave::batch as lens_batch;

/// Returns rays from the film to a disk at the rear vertex, 1.2 times as wide as the rear element.
fn aimed(lens: &Prescription, film: f64, count: usize, seed: u64) -> Vec<[[f64; 3]; 2]> {
    let mut random = Random::new(seed);
    let reach = lens.rear().diameter * 0.6;
    let height = film * 0.9;
    // Rounded to f32, so that both sides trace the same ray.
    let round = |v: f64| f64::from(v as f32);
    (0..count)
        .map(|_| {
            let start = [random.between(-height, height), random.between(-height, height), 0.0];
            let start = start.map(round);
            let (r, phi) = (random.next().sqrt() * reach, random.between(0.0, 6.3));
            let d = [r * phi.cos() - start[0], r * phi.sin() - start[1], film];
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            [start, d.map(|v| round(v / length))]
        })
        .collect()
}

type Traced<T> = (Box<LensBatch<T>>, Vec<u64>);

fn traced<R: Real>(lens: &Prescription, film: f64, rays: &[[[f64; 3]; 2]]) -> Traced<R::Scalar> {
    let surfaces = sequence::<R>(lens, Side::Film(film));
    let mut blocked = vec![0; surfaces.len()];
    let mut batch = lens_batch::<R>(rays);
    trace::<R>(&mut batch, &surfaces, &mut blocked);
    (batch, blocked)
}

#[test]
fn eight_lanes_equal_one_lane_bit_for_bit() {
    for (name, film) in LENSES {
        let lens = lens(name);
        let mut rays = aimed(&lens, film, 4 * WAVE_SIZE, 1);
        for a in NASTY {
            for b in NASTY {
                rays.push([[a, b, 0.0], [0.0, 0.0, 1.0]]);
                rays.push([[1.0, 0.0, 0.0], [a, b, 1.0]]);
                rays.push([[1.0, 2.0, a], [0.1, 0.0, b]]);
            }
        }
        // With an odd count the last packet is not full.
        rays.push([[0.0; 3], [0.0, 0.0, 1.0]]);
        for chunk in rays.chunks(WAVE_SIZE) {
            let (one, one_blocked) = traced::<f32>(&lens, film, chunk);
            let (eight, eight_blocked) = traced::<f32x8>(&lens, film, chunk);
            assert_eq!(one_blocked, eight_blocked, "{name}");
            for i in 0..chunk.len() {
                assert_eq!(one.x[i].is_nan(), eight.x[i].is_nan(), "{name} {:?}", chunk[i]);
                if one.x[i].is_nan() {
                    continue;
                }
                let bits = |b: &LensBatch<f32>| {
                    [b.x[i], b.y[i], b.z[i], b.tx[i], b.ty[i], b.tz[i]].map(f32::to_bits)
                };
                assert_eq!(bits(&one), bits(&eight), "{name} {:?}", chunk[i]);
            }
        }
    }
}

#[test]
fn exit_directions_are_finite_unit_vectors() {
    let mut random = Random::new(5);
    for (name, film) in LENSES {
        let lens = lens(name);
        for _ in 0..200 {
            let rays: Vec<_> = (0..WAVE_SIZE)
                .map(|_| {
                    let mut wild =
                        || random.between(-1.0, 1.0) * 10f64.powf(random.between(-8.0, 8.0));
                    [[wild(), wild(), 0.0], [wild(), wild(), wild()]]
                })
                .map(|[p, d]| {
                    let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
                    [p, d.map(|v| v / length)]
                })
                .collect();
            let (batch, blocked) = traced::<f32x8>(&lens, film, &rays);
            let mut alive = 0;
            for i in (0..rays.len()).filter(|&i| !batch.x[i].is_nan()) {
                let t = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
                let length = t.iter().map(|v| v * v).sum::<f64>().sqrt();
                assert!((length - 1.0).abs() < 1e-5, "{name}: |T| = {length} for {:?}", rays[i]);
                alive += 1;
            }
            let needs_f64 = batch.needs_f64.len() as u64;
            assert_eq!(alive + needs_f64 + blocked.iter().sum::<u64>(), WAVE_SIZE as u64, "{name}");
        }
    }
}

/// Returns the largest deviation of exit points (um) and directions [urad] from the oracle, and the
/// numbers of rays that both and that only one let through.
fn errors<R: Real>(lens: &Prescription, film: f64, count: usize) -> ([f64; 2], usize, usize) {
    let (mut worst, mut both, mut one) = ([0.0f64; 2], 0, 0);
    let surfaces = sequence::<R>(lens, Side::Film(film));
    for [p, d] in aimed(lens, film, count, 2) {
        let exact = oracle::trace_spheres(lens, film, p, d);
        // In air the kernel takes directions of unit length, as the oracle does.
        let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        let splat = |v: f64| R::splat(R::from_f64(v));
        let ray = LensRay::new(p.map(splat), d.map(|v| splat(v / length)));
        let ours = trace_one::<R>(ray, &surfaces);
        match (exact, ours) {
            (Ok([p, d]), Ok(ray)) => {
                both += 1;
                let number = |v: R| {
                    let mut lanes = [R::from_f64(0.0); 8];
                    v.store(&mut lanes);
                    R::to_f64(lanes[0])
                };
                let off = |a: [f64; 3], b: [R; 3]| {
                    let d: [f64; 3] = [0, 1, 2].map(|i| a[i] - number(b[i]));
                    d.iter().map(|v| v * v).sum::<f64>().sqrt()
                };
                worst = [worst[0].max(off(p, ray.p) * 1e3), worst[1].max(off(d, ray.t) * 1e6)];
            }
            (Err(_), Err(_)) => {}
            _ => one += 1,
        }
    }
    (worst, both, one)
}

#[test]
fn the_course_lenses_agree_with_the_oracle() {
    for (name, film) in LENSES {
        let lens = lens(name);
        let ([um, urad], both, one) = errors::<f32>(&lens, film, 400_000);
        println!("{name}: f32 {um:.4} um, {urad:.3} urad over {both} rays, {one} at rims");
        // Twice the measured 0.03 um and 2 urad, and twice that for the fisheye.
        let bound = if name.starts_with("fisheye") { [0.12, 14.0] } else { [0.06, 4.0] };
        assert!(both > 10_000, "{name}: too few rays leave the lens");
        assert!(um < bound[0] && urad < bound[1], "{name}: {um} um, {urad} urad");
        assert!(one < 20, "{name}: {one} rays pass in one only");
        let ([um, urad], _, one) = errors::<f64>(&lens, film, 400_000);
        println!("{name}: f64 {um:.2e} um, {urad:.2e} urad");
        assert!(um < 1e-8 && urad < 1e-6 && one == 0, "{name}: f64 is off by {um} um, {urad} urad");
    }
}

#[test]
fn planes_and_huge_radii_lose_no_accuracy() {
    for radius in [1e4, 1e6, 1e7, 1e9, f64::INFINITY] {
        let rows = vec![
            row(radius, 4.0, 1.6, 30.0),
            row(-60.0, 2.0, 1.0, 30.0),
            row(0.0, 3.0, 1.0, 16.0),
            row(-radius, 3.0, 1.5, 30.0),
            row(radius, 0.0, 1.0, 30.0),
        ];
        let lens = Prescription::new("flat", rows).expect("one stop");
        let ([um, urad], both, one) = errors::<f32>(&lens, 60.0, 100_000);
        println!("R = {radius:e}: {um:.4} um, {urad:.3} urad over {both} rays");
        // Beyond 1e6 mm the rounding of the sphere centre costs the oracle up to 1e-7 mm.
        assert!(both > 10_000 && one < 20, "R = {radius:e}: {both} through, {one} disagree");
        assert!(um < 0.06 && urad < 2.0, "R = {radius:e}: {um} um, {urad} urad");
    }
}

#[test]
fn a_ball_lens_agrees_with_the_oracle() {
    let rows = vec![row(5.0, 10.0, 1.5, 8.0), row(-5.0, 0.5, 1.0, 8.0), row(0.0, 0.0, 1.0, 6.0)];
    let lens = Prescription::new("ball", rows).expect("one stop");
    let ([um, urad], both, one) = errors::<f32>(&lens, 4.0, 200_000);
    println!("ball: {um:.4} um, {urad:.3} urad over {both} rays, {one} disagree");
    assert!(both > 10_000 && one < 60, "{both} through, {one} disagree");
    // The published worst case of the curvature form is 892 urad, for grazing rays close to total internal
    // reflection. Exit points have no such exception.
    assert!(um < 0.1 && urad < 892.0, "{um} um, {urad} urad");
}

/// Returns the direction from a film point to a random point of its pupil.
fn into_pupil(bound: &PupilBounds, film: [f64; 2], random: &mut Random) -> Option<[f64; 3]> {
    let point = film.map(|v| v as f32);
    let fan = bound.fan(point);
    if !fan.is_open() {
        return None;
    }
    let k = (random.next() * 32.0) as usize;
    let (t, s) = (random.next(), random.next().sqrt());
    let [u, v] = [0, 1].map(|axis| {
        let [a, b] = [fan.corners[k][axis], fan.corners[k + 1][axis]].map(f64::from);
        f64::from(fan.centre[axis]) + s * (a + t * (b - a))
    });
    let r = film[0].hypot(film[1]);
    let (cos, sin) = (film[0] / r, film[1] / r);
    Some([cos * u - sin * v - film[0], sin * u + cos * v - film[1], 0.0])
}

#[test]
fn a_million_rays_of_each_lens_stay_within_the_published_errors() {
    for (name, film) in LENSES {
        let lens = lens(name);
        let bound = PupilBounds::new(&lens, film, 35.0, PupilSampling::Pupil);
        let surfaces = sequence::<f32x8>(&lens, Side::Film(film));
        let exact = sequence::<f64>(&lens, Side::Film(film));
        let mut random = Random::new(8);
        let mut blocked = vec![0; lens.rows.len()];
        let mut batch = Box::<LensBatch<f32>>::default();
        let (mut count, mut redone, mut um, mut urad) = (0u32, 0, 0.0f64, 0.0f64);
        while count < 1_000_000 {
            let mut starts = Vec::with_capacity(WAVE_SIZE);
            while starts.len() < WAVE_SIZE {
                let at = [0, 1].map(|_| f64::from(random.between(-24.7, 24.7) as f32));
                let Some([dx, dy, _]) = into_pupil(&bound, at, &mut random) else { continue };
                let length = (dx * dx + dy * dy + film * film).sqrt();
                let t = [dx, dy, film].map(|d| (d / length) as f32);
                let i = starts.len();
                [batch.x[i], batch.y[i], batch.z[i]] = [at[0] as f32, at[1] as f32, 0.0];
                [batch.tx[i], batch.ty[i], batch.tz[i]] = t;
                let t = t.map(f64::from);
                let length = t.iter().map(|v| v * v).sum::<f64>().sqrt();
                starts.push(LensRay::new([at[0], at[1], 0.0], t.map(|v| v / length)));
            }
            batch.resize::<f32x8>(WAVE_SIZE);
            trace::<f32x8>(&mut batch, &surfaces, &mut blocked);
            redone += batch.needs_f64.len();
            retrace_in_f64::<f32x8>(&mut batch, &exact, &mut blocked, |i| starts[i]);
            for (i, start) in starts.iter().enumerate() {
                let truth = trace_one::<f64>(*start, &exact);
                // At rims the two may disagree. The test against the oracle limits how often.
                let (Ok(truth), false) = (truth, batch.x[i].is_nan()) else { continue };
                count += 1;
                let p = [batch.x[i], batch.y[i], batch.z[i]].map(f64::from);
                let t = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
                let length = t.iter().map(|v| v * v).sum::<f64>().sqrt();
                let off = |a: [f64; 3], b: [f64; 3]| {
                    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
                };
                um = um.max(1e3 * off(p, truth.p));
                urad = urad.max(1e6 * off(t.map(|v| v / length), truth.t));
            }
        }
        println!("{name}: {um:.4} um, {urad:.3} urad over {count} rays, {redone} retraced");
        // Measured: 0.028 um (telephoto) and 1.9 urad (fisheye). A portable build has no
        // fused multiplication, so every product is rounded once more.
        let bound = if cfg!(target_feature = "fma") { [0.03, 2.0] } else { [0.04, 3.0] };
        assert!(um <= bound[0] && urad <= bound[1], "{name}: {um} um, {urad} urad");
    }
}
