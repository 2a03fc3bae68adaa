//! Test charts: what is measured in their pictures is what the lens does.

use std::path::{Path, PathBuf};

use petzval_image::Picture;
use petzval_lens::{FocusModel, Pose, Prescription, RealRayFocus};
use petzval_optics::{Calibration, CalibrationSetup, FieldRay, LateralColour, PixelGrid};
use petzval_render::Backend;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;
use petzval_tools::chart_analysis::{DotGrid, EdgeAxis, EdgeResponse};
use petzval_tools::charts::{Chart, ChartCamera, ChartKind, ChartView};

use crate::support::{LANDSCAPE, folder, picture, root, write};

/// Returns the path of a lens file of the repository.
fn lens_file(name: &str) -> PathBuf {
    root().join("lenses").join(name)
}

fn read(lens: &Path) -> Prescription {
    petzval_lens_formats::read(lens).expect("a lens")
}

/// A chart, how the lens sees it, and its picture.
struct Photograph {
    calibration: Calibration,
    /// Lateral colour of red and of blue, if the lens disperses light.
    colour: Option<[LateralColour; 2]>,
    chart: Chart,
    picture: Picture,
}

/// Returns the camera of a lens that is in focus at a distance (mm), before a film of this width (mm).
fn camera(
    lens: &Prescription,
    focus: f64,
    resolution: [u32; 2],
    width: f64,
) -> CalibrationSetup<'_> {
    let pixels = PixelGrid::new(resolution, width);
    let diagonal = 2.0 * pixels.half_diagonal();
    let film_distance = FocusModel::Sharpest.film(lens, focus, diagonal).expect("a focus");
    let (film_pose, ray) = (Pose::ALIGNED, FieldRay::Centroid);
    CalibrationSetup { lens, film_distance, film_pose, pixels, ray }
}

/// Photographs a chart at 2 m on a film of this width (mm), at f/8.
fn photograph(
    kind: ChartKind,
    (file, width): (&Path, f64),
    resolution: [u32; 2],
    samples: u32,
    effects: &str,
) -> Photograph {
    let mut lens = read(file);
    lens.stop_down(lens.f_number_diameter(8.0).expect("an f-number"));
    let setup = camera(&lens, 2000.0, resolution, width);
    let calibration = setup.calibrate_quickly().expect("a calibration");
    let view = ChartView::new(&calibration).expect("a plane");
    let chart = Chart::new(kind, &view).expect("a chart");
    let description = ChartCamera {
        lens: file,
        stop_diameter: lens.rows[lens.stop()].diameter,
        f_number: RealRayFocus::new(&lens).f_number(),
    };
    let text = chart.scene(&view, &description, "this test", "").expect("a scene");
    let folder = folder();
    let description = pbrt::read(&write(&folder, "chart.pbrt", text)).expect("a scene");
    let effects = effects.parse().expect("a selection");
    let changes = Changes { effects, ..Changes::default() };
    let mut job = prepare(description, &changes).expect("a job").job;
    job.samples = 0..samples;
    let picture = picture(&job, Backend::Simd, 2);
    let channels = setup.channel_fields().expect("glasses");
    let colour = channels.and_then(|channels| calibration.lateral_colour(&channels));
    Photograph { calibration, colour, chart, picture }
}

#[test]
fn distortion_in_a_picture_of_the_grid_is_that_of_the_calibration() {
    for (name, width, resolution) in
        [("dgauss.50mm.dat", 36.0, [720, 480]), ("wide.22mm.dat", 16.0, [480, 720])]
    {
        let Photograph { calibration, chart, picture, .. } =
            photograph(ChartKind::Grid, (&lens_file(name), width), resolution, 128, "none");
        let grid = DotGrid::measure(&picture).expect("a grid");
        let spacing = chart.spacing.expect("dots");
        let view = ChartView::new(&calibration).expect("a plane");
        let middle = view.chart_point(calibration.pixels.centre()).expect("light");
        let beside = calibration.pixels.centre().map(|at| at + 1.0);
        let width = (view.chart_point(beside).expect("light")[0] - middle[0]).abs();
        let mut worst: f64 = 0.0;
        for dot in &grid.dots {
            let [x, y] = view.chart_point(dot.at).expect("light");
            let [column, row] = dot.index.map(f64::from);
            let off = [x - column * spacing, y + row * spacing].map(|off| off / width);
            worst = worst.max(off[0].hypot(off[1]));
        }
        let farthest = grid.farthest();
        println!(
            "{}: {} dots, {:+.3} % at the farthest, off by {worst:.4} pixels, residual {:.4}",
            name,
            grid.dots.len(),
            100.0 * farthest.distortion,
            grid.residual
        );
        assert!(grid.dots.len() >= 150, "{} dots", grid.dots.len());
        assert!(worst < 0.05, "{name}: {worst} pixels");
        assert!(grid.residual < 0.05, "{}", grid.residual);
        assert!((grid.steps[0][0] * width / spacing - 1.0).abs() < 2e-3, "{:?}", grid.steps);
        // The whole chart is lit alike: as much light as the f-number says.
        let white = picture.pixels.iter().map(|pixel| pixel[1]).fold(0.0, f32::max);
        assert!((0.75..1.05).contains(&white), "{white}");
        // Distortion by the calibration, at the farthest dot.
        let [x, y] = farthest.index.map(|n| f64::from(n) * spacing / width);
        let expected = grid.radius(farthest) / x.hypot(y) - 1.0;
        assert!(
            (expected - farthest.distortion).abs() < 1e-3,
            "{expected} {}",
            farthest.distortion
        );
    }
}

#[test]
fn lateral_colour_in_a_picture_of_the_grid_is_that_of_the_lens() {
    let folder = folder();
    let lens = write(&folder, "landscape.toml", LANDSCAPE);
    let Photograph { calibration, colour, picture, .. } =
        photograph(ChartKind::Grid, (&lens, 24.0), [480, 320], 512, "+dispersion");
    let colour = colour.expect("a glass that disperses");
    let grid = DotGrid::measure(&picture).expect("a grid");
    // Radii of the polynomial are over half of the shorter side.
    let half = f64::from(calibration.pixels.resolution[1]) / 2.0;
    for channel in 0..2 {
        let (mut product, mut square, mut largest) = (0.0, 0.0, 0.0_f64);
        for dot in &grid.dots {
            let r = grid.radius(dot) / half;
            let [v, c, b] = colour[channel].terms;
            let expected = half * r * (v - 1.0 + c * r + b * r * r);
            product += grid.lateral_colour(dot)[channel] * expected;
            square += expected * expected;
            largest = largest.max(expected.abs());
        }
        let ratio = product / square;
        println!("lateral colour up to {largest:.3} pixels: {ratio:.4} of it measured");
        assert!(largest > 0.2, "{largest}");
        assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    }
}

#[test]
fn squares_of_the_edge_chart_lie_where_it_says() {
    let lens = lens_file("dgauss.50mm.dat");
    let Photograph { chart, picture, .. } =
        photograph(ChartKind::Edges, (&lens, 36.0), [600, 400], 64, "none");
    assert_eq!(chart.edges.len(), 18);
    for (i, region) in chart.edges.iter().enumerate() {
        let region = region.map(|at| at.map(|n| n as usize));
        let edge = EdgeResponse::measure(&picture, region, |pixel| f64::from(pixel[1]));
        let edge = edge.unwrap_or_else(|error| panic!("edge {i}, {region:?}: {error}"));
        // Left edges, whose column falls with the row, and upper ones, whose row rises with the column.
        let (axis, degrees) = if i % 2 == 0 { (EdgeAxis::X, -5.0) } else { (EdgeAxis::Y, 5.0) };
        assert_eq!(edge.axis, axis, "edge {i}");
        assert!((edge.angle - degrees).abs() < 0.3, "edge {i}: {}", edge.angle);
        assert!((edge.contrast() - 0.6).abs() < 0.03, "edge {i}: {}", edge.contrast());
    }
}

#[test]
fn charts_that_cannot_fill_the_picture_are_refused() {
    let refused = |name: &str, focus: f64, resolution: [u32; 2], kind| {
        let lens = read(&lens_file(name));
        let calibration = camera(&lens, focus, resolution, 36.0).calibrate_quickly();
        let calibration = calibration.expect("a calibration");
        let chart =
            ChartView::new(&calibration).and_then(|view| Chart::new(kind, &view).map(|_| ()));
        chart.expect_err("no chart").to_string()
    };
    let infinite = refused("dgauss.50mm.dat", f64::INFINITY, [600, 400], ChartKind::Flat);
    assert!(infinite.contains("expected a finite 'focus'"), "{infinite}");
    let fisheye = refused("fisheye.10mm.dat", 2000.0, [600, 400], ChartKind::Grid);
    assert!(
        fisheye.contains("no chart fills the picture: no light reaches pixel 0,0"),
        "{fisheye}"
    );
    let grid = refused("dgauss.50mm.dat", 2000.0, [150, 100], ChartKind::Grid);
    assert!(grid.contains("at least 120 x 120 pixels; found 150 x 100"), "{grid}");
    let small = refused("dgauss.50mm.dat", 2000.0, [300, 200], ChartKind::Edges);
    assert!(small.contains("at least 400 x 400 pixels; found 300 x 200"), "{small}");
}
