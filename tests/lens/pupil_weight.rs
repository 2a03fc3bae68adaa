//! Weights of camera rays: no sample becomes a firefly, whatever the bounds of the pupil miss.

use crate::support::reference::by_tier;
use crate::support::{Random, in_parallel, root};
use glam::DAffine3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;
use petzval_lens::{
    ApertureMask, Camera, FilmPlane, Iris, LensColumns, LensModel, Paraxial, Pose, PupilSampling,
    REAR_SHARE, RIM_SHARE, RealLens, Row, VICINITY_SHARE,
};
use petzval_lens_formats::read;

/// Lenses of the repository with the radius of their image circle, mm.
const LENSES: [(&str, f64); 9] = [
    ("dgauss.50mm.dat", 33.0),
    ("fisheye.10mm.dat", 13.0),
    ("telephoto.250mm.dat", 60.0),
    ("triplet.toml", 25.0),
    ("wide.22mm.dat", 24.0),
    ("phone.toml", 3.5),
    ("fisheye.6mm.toml", 11.5),
    ("wide.22mm.pentagon.toml", 24.0),
    ("anamorphic.toml", 22.0),
];

/// Largest weight of a ray over the mean weight in the middle of the film: round lenses.
const ROUND_LIMIT: f64 = 600.0;
/// Largest such weight: shaped stops and cylinders, whose fans are between the corners of a coarse
/// grid. At the end of the image circle only the vicinity finds some of the light, so this is the
/// largest weight that the vicinities of round stops allow.
const SHAPED_LIMIT: f64 = 4000.0;

struct Case {
    name: String,
    limit: f64,
    camera: Camera,
}

/// Returns the directions and the radii at which the light ends on a film.
fn light_ends(camera: &Camera) -> Vec<[f64; 2]> {
    let LensModel::Real(lens) = &camera.model else { unreachable!() };
    let half = camera.film.map(|size| size / 2.0);
    let end = |k: u32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 16.0).sin_cos();
        let reach = (half[0] / cos.abs()).min(half[1] / sin.abs());
        let at = |r: f64| [(r * cos) as f32, (r * sin) as f32];
        let (mut lit, mut dark) = (0.0, reach);
        for _ in 0..20 {
            let middle = (lit + dark) / 2.0;
            let is_lit = lens.pupil_bounds().fan(at(middle)).is_open();
            *(if is_lit { &mut lit } else { &mut dark }) = middle;
        }
        [lit * cos, lit * sin]
    };
    (0..32).map(end).collect()
}

/// Returns the largest and the mean weight of the rays that leave the lens. `film` places a sample
/// on the film and `share` is the share of the pupil samples that are drawn, from the first.
fn weights(
    camera: &Camera,
    random: &mut Random,
    waves: u64,
    share: f32,
    film: impl Fn(&mut Random) -> [f64; 2],
) -> (f64, f64) {
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    let (mut rays, mut columns) = (RayBatch::default(), LensColumns::default());
    let mut stats = LensStats::default();
    let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0);
    for _ in 0..waves {
        for i in 0..WAVE_SIZE {
            let at = film(random);
            for axis in 0..2 {
                samples.film[axis][i] = at[axis] as f32;
            }
            samples.pupil[0][i] = (f64::from(share) * random.next()) as f32;
            samples.pupil[1][i] = random.next() as f32;
        }
        camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        for i in 0..rays.len {
            let weight = f64::from(rays.throughput[0][i]);
            worst = worst.max(weight);
            sum += weight;
        }
        count += rays.len;
    }
    (worst, sum / count.max(1) as f64)
}

/// Returns a case: a lens, stopped down and focused, and a film that its image circle does not fill.
fn case(
    (name, circle): (&str, f64),
    divisor: f64,
    iris: Option<Iris>,
    object: f64,
    pose: Pose,
) -> Case {
    let mut lens = read(&root().join("lenses").join(name)).expect("a lens of the repository");
    let stop = lens.stop();
    if divisor > 1.0 {
        lens.stop_down(lens.rows[stop].diameter / divisor);
    }
    let shape = match &iris {
        None => "own",
        Some(Iris::Mask(_)) => "star",
        Some(_) => "blades",
    };
    if let Some(iris) = iris {
        lens.rows[stop].iris = iris;
    }
    let limit = match lens.rows.iter().all(Row::is_round) {
        true => ROUND_LIMIT,
        false => SHAPED_LIMIT,
    };
    let distance = Paraxial::new(&lens).film_for_focus(object).expect("a focus");
    let radius = 1.1 * circle;
    let half = radius / 2.0f64.sqrt();
    let film = FilmPlane { pose, half: [half; 2], ..FilmPlane::aligned(distance, radius) };
    let lens = RealLens::with_film(lens, &film, PupilSampling::Pupil, 1.0, 0.0);
    let Pose { decentre, tilt } = pose;
    Case {
        name: format!(
            "{name}, stop / {divisor}, {shape}, object {object} mm, {decentre:?} {tilt:?}"
        ),
        limit,
        camera: Camera {
            model: LensModel::Real(Box::new(lens)),
            film: [2.0 * half; 2],
            world_from_camera: DAffine3::IDENTITY,
            imaging_ratio: 1.0,
            depth: [0.0, f64::INFINITY],
        },
    }
}

fn cases() -> Vec<Case> {
    let round = &LENSES[..7];
    let blades = Iris::Blades { count: 5, rotation: 20.0, curvature: 0.0 };
    let star = Iris::Mask(ApertureMask::named("star").expect("a shape"));
    let tilted = Pose { decentre: [0.0; 2], tilt: [4.0, -3.0] };
    let far = f64::INFINITY;
    let mut cases = Vec::new();
    for divisor in [1.0, 2.0, 4.0, 16.0] {
        for &lens in round {
            for object in [far, 20.0 * lens.1] {
                cases.push(case(lens, divisor, None, object, Pose::ALIGNED));
            }
        }
    }
    for (lens, divisor) in LENSES.into_iter().zip([1.0, 4.0, 16.0].into_iter().cycle()) {
        let round = lens.0 != "anamorphic.toml" && lens.0 != "wide.22mm.pentagon.toml";
        cases.push(case(lens, divisor, round.then(|| blades.clone()), far, Pose::ALIGNED));
    }
    for (lens, divisor) in [(LENSES[0], 1.0), (LENSES[1], 2.0), (LENSES[3], 4.0)] {
        cases.push(case(lens, divisor, Some(star.clone()), far, Pose::ALIGNED));
    }
    cases.push(case(LENSES[8], 1.0, None, far, Pose::ALIGNED));
    for &lens in &LENSES[..4] {
        let decentred = Pose { decentre: [0.1 * lens.1, 0.05 * lens.1], tilt: [0.0; 2] };
        for (divisor, pose) in [(1.0, tilted), (4.0, tilted), (2.0, decentred)] {
            cases.push(case(lens, divisor, None, far, pose));
        }
    }
    cases
}

/// Returns the largest weight of a lens that its construction allows, whatever the light.
fn limit_by_construction(camera: &Camera) -> f64 {
    let LensModel::Real(lens) = &camera.model else { unreachable!() };
    let [x, y] = camera.film.map(|size| size / 2.0);
    let corners = [[x, y], [x, -y], [-x, y], [-x, -y]];
    let nearest = corners.map(|at| lens.film_distance - lens.film_pose.film_point(at)[2]);
    let nearest = nearest.into_iter().fold(f64::INFINITY, f64::min);
    f64::from(lens.pupil_bounds().largest_area()) / (nearest * nearest)
}

/// Returns the largest weight of a case, and that which the construction allows, over the mean
/// weight in the middle of the film.
fn worst_weight(case: &Case, waves: u64, seed: u64) -> [f64; 2] {
    let camera = &case.camera;
    let mut random = Random::new(seed);
    let ends = light_ends(camera);
    let (_, usual) = weights(camera, &mut random, 4, 1.0, |_| [0.0; 2]);
    let anywhere = |random: &mut Random| {
        let [x, y] = ends[(random.next() * 32.0) as usize];
        let share = random.next().sqrt();
        [x * share, y * share]
    };
    // Ever closer to the edge.
    let edge = |random: &mut Random| {
        let [x, y] = ends[(random.next() * 32.0) as usize];
        let share = 1.0 - 0.3 * (-10.0 * random.next()).exp();
        [x * share, y * share]
    };
    let outside = REAR_SHARE + VICINITY_SHARE + RIM_SHARE;
    let quarter = waves / 4;
    let (a, _) = weights(camera, &mut random, quarter, 1.0, anywhere);
    let (b, _) = weights(camera, &mut random, quarter, 1.0, edge);
    let (c, _) = weights(camera, &mut random, quarter, outside, anywhere);
    let (d, _) = weights(camera, &mut random, quarter, outside, edge);
    [a.max(b).max(c).max(d), limit_by_construction(camera)].map(|weight| weight / usual)
}

/// Asserts that no weight exceeds the limit among this many waves of each case. Half of the samples
/// are drawn from the rim and the rear element.
fn assert_no_firefly(waves: u64) {
    let cases = cases();
    let numbered: Vec<(u64, &Case)> = (1..).zip(&cases).collect();
    let worst = in_parallel(&numbered, |&(seed, case)| worst_weight(case, waves, seed));
    println!("{:e} samples", (waves * WAVE_SIZE as u64 * cases.len() as u64) as f32);
    for (case, [worst, allowed]) in cases.iter().zip(&worst) {
        println!(
            "{}: at most {worst:.2} times the usual weight, {allowed:.0} by construction",
            case.name
        );
    }
    for (Case { name, limit, .. }, [worst, allowed]) in cases.iter().zip(worst) {
        assert!(worst < *limit, "{name}: a weight of {worst} times the usual one, limit {limit}");
        assert!(worst < allowed, "{name}: a weight of {worst}, allowed {allowed}");
    }
}

#[test]
fn no_sample_is_a_firefly() {
    assert_no_firefly(by_tier(16, 40));
}

#[test]
#[ignore = "takes a thousand million samples; .ci/long runs it"]
fn none_of_a_thousand_million_samples_is_a_firefly() {
    assert_no_firefly(12_500);
}
