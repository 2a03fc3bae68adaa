//! Areas of irises by counting rays along the axis, against formulas.

use std::f64::consts::{PI, TAU};

use petzval_lens::{
    ApertureMask, Iris, LensRay, MaskConvention, Prescription, Side, sequence, trace_one,
};

use crate::support::{Random, row};
use petzval_lens::Row;

fn lens_with_iris(iris: Iris, obstruction: f64) -> Prescription {
    let stop = Row { iris, obstruction, ..row(0.0, 1.0, 1.0, 2.0) };
    let rows = vec![stop, row(f64::INFINITY, 0.0, 1.0, 4.0)];
    Prescription::new("iris", rows).expect("one stop")
}

/// Returns the transmitted area of a stop of semi-diameter 1, by a jittered grid over the square around
/// it.
fn transmitted_area(lens: &Prescription) -> f64 {
    const CELLS: usize = 400;
    let surfaces = sequence::<f32>(lens, Side::Film(1.0));
    let mut random = Random::new(8);
    let mut sum = 0.0;
    for i in 0..CELLS * CELLS {
        let place = |cell: usize, jitter: f64| (cell as f64 + jitter) / CELLS as f64 * 2.0 - 1.0;
        let [x, y] = [place(i % CELLS, random.next()), place(i / CELLS, random.next())];
        let ray = LensRay::new([x as f32, y as f32, 0.0], [0.0, 0.0, 1.0]);
        sum += trace_one::<f32>(ray, &surfaces).map_or(0.0, |ray| f64::from(ray.weight));
    }
    sum * 4.0 / (CELLS * CELLS) as f64
}

/// Returns the area of a polygon with corners on the unit circle and sides of radius 1 / curvature.
fn blades_area(count: u32, curvature: f64) -> f64 {
    let n = f64::from(count);
    let polygon = n / 2.0 * (TAU / n).sin();
    if curvature == 0.0 {
        return polygon;
    }
    let angle = 2.0 * ((PI / n).sin() * curvature).asin();
    polygon + n * (angle - angle.sin()) / (2.0 * curvature * curvature)
}

#[test]
fn blades_have_the_area_of_their_arcs() {
    for (count, curvature, rotation) in [
        (3, 0.0, 0.0),
        (3, 0.9, 17.0),
        (5, 0.3, -100.0),
        (6, 0.0, 30.0),
        (7, 0.5, 5.0),
        (9, 1.0, 0.0),
        (64, 0.0, 1.0),
    ] {
        let iris = Iris::Blades { count, rotation, curvature };
        let (found, expected) =
            (transmitted_area(&lens_with_iris(iris, 0.0)), blades_area(count, curvature));
        // A jittered grid of n^2 points is off by n^-3/2 along an edge of length 4 or so: 5e-4.
        assert!((found - expected).abs() < 1.5e-3, "{count} {curvature}: {found} {expected}");
    }
}

#[test]
fn blades_turn_from_x_towards_y() {
    let through = |rotation: f64, degrees: f64, h: f64| {
        let lens = lens_with_iris(Iris::Blades { count: 3, rotation, curvature: 0.0 }, 0.0);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let ray = LensRay::new([h * cos, h * sin, 0.0], [0.0, 0.0, 1.0]);
        trace_one::<f64>(ray, &sequence::<f64>(&lens, Side::Film(1.0))).is_ok()
    };
    for rotation in [0.0, 10.0, -50.0, 90.0, 400.0] {
        for corner in [0.0, 120.0, 240.0] {
            assert!(through(rotation, rotation + corner, 0.99), "the corner at {rotation}");
            assert!(!through(rotation, rotation + corner + 60.0, 0.51), "the side at {rotation}");
            assert!(through(rotation, rotation + corner + 60.0, 0.49), "the side at {rotation}");
            assert!(!through(rotation, rotation + corner + 10.0, 0.9), "beside it at {rotation}");
        }
    }
}

#[test]
fn a_mask_transmits_its_mean_and_an_obstruction_leaves_a_ring() {
    for name in ["gaussian", "square", "pentagon", "star"] {
        let mask = ApertureMask::named(name).expect("a mask with a name");
        let cells = (mask.size * mask.size) as f64;
        let expected = mask.transmission.iter().map(|&t| f64::from(t)).sum::<f64>() * 4.0 / cells;
        let found = transmitted_area(&lens_with_iris(Iris::Mask(mask), 0.0));
        assert!((found - expected).abs() < 1.5e-3, "{name}: {found} {expected}");
    }
    let found = transmitted_area(&lens_with_iris(Iris::Round, 1.2));
    assert!((found - PI * (1.0 - 0.36)).abs() < 1.5e-3, "ring: {found}");
    let found = transmitted_area(&lens_with_iris(
        Iris::Blades { count: 6, rotation: 0.0, curvature: 0.0 },
        1.0,
    ));
    assert!((found - blades_area(6, 0.0) + PI * 0.25).abs() < 1.5e-3, "hexagon and disk: {found}");
}

#[test]
fn the_first_row_of_a_mask_is_up_as_seen_from_the_film() {
    // Only the cell in the second row from the top and the rightmost column is open.
    let mut transmission = vec![0.0f32; 16];
    transmission[7] = 0.25;
    let mask = ApertureMask {
        name: "cell".into(),
        size: 4,
        transmission: transmission.into(),
        convention: MaskConvention::Physical,
        is_shape: false,
    };
    let lens = lens_with_iris(Iris::Mask(mask), 0.0);
    let weight = |x: f64, y: f64| {
        let ray = LensRay::new([x, y, 0.0], [0.0, 0.0, 1.0]);
        trace_one::<f64>(ray, &sequence::<f64>(&lens, Side::Film(1.0))).map_or(0.0, |r| r.weight)
    };
    assert_eq!(weight(0.75, 0.25), 0.25);
    for [x, y] in [[0.75, -0.25], [-0.75, 0.25], [-0.75, -0.25], [0.25, 0.25], [0.6, 0.6]] {
        assert_eq!(weight(x, y), 0.0, "{x} {y}");
    }
}
