//! `petzval measure grid`: distortion and lateral colour.

use std::fmt::Write as _;
use std::path::PathBuf;

use petzval_base::io::{ReadContext, path_excerpt};
use petzval_image::{Picture, Transfer};
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::{DotGrid, GridDot};

use super::super::{Failure, Outcome};
use super::results::ResultArguments;
use super::{title_of, with_source};

/// Rings of the table, by their distance from the middle.
const RINGS: usize = 8;

/// Arguments of `petzval measure grid`.
#[derive(Debug, clap::Args)]
pub(super) struct GridArguments {
    /// Picture: .exr, .hdr, .pfm, .png, .jpg, .tif
    picture: PathBuf,
    #[command(flatten)]
    results: ResultArguments,
}

pub(super) fn run(arguments: &GridArguments) -> Result<Outcome, Failure> {
    let GridArguments { picture: path, results } = arguments;
    let context = ReadContext::default();
    let picture = Picture::read_with(path, Transfer::Srgb, &context)?;
    let grid =
        DotGrid::measure(&picture).map_err(|error| format!("{}: {error}", path_excerpt(path)))?;
    let report = MeasurementReport::of_grid(title_of("Distortion", path), &grid, text_of(&grid));
    let json = with_source(grid.json(), path, None);
    results.finish(&context, &table(&grid), &report, &json)
}

/// Returns a row for each dot.
fn table(grid: &DotGrid) -> String {
    let mut text = "column,row,x,y,radius,distortion %,red,blue\n".to_owned();
    for dot in &grid.dots {
        let GridDot { index: [column, row], at: [x, y], distortion, .. } = dot;
        let [red, blue] = grid.lateral_colour(dot);
        let radius = grid.radius(dot);
        let _ = writeln!(
            text,
            "{column},{row},{x:.4},{y:.4},{radius:.4},{:.4},{red:.4},{blue:.4}",
            100.0 * distortion
        );
    }
    text
}

/// Returns the dots in rings of equal width about the middle.
fn rings(grid: &DotGrid) -> Vec<Vec<&GridDot>> {
    let largest = grid.radius(grid.farthest()) * (1.0 + 1e-9);
    let mut rings = vec![Vec::new(); RINGS];
    for dot in &grid.dots {
        rings[(grid.radius(dot) / largest * RINGS as f64) as usize].push(dot);
    }
    rings.retain(|ring| !ring.is_empty());
    rings
}

fn text_of(grid: &DotGrid) -> String {
    let farthest = grid.farthest();
    let indices = |axis: usize| grid.dots.iter().map(move |dot| dot.index[axis]);
    let count = |axis| indices(axis).max().unwrap_or(0) - indices(axis).min().unwrap_or(0) + 1;
    let [[x, y], down] = grid.steps;
    let mut text = format!(
        "{} dots in {} columns and {} rows, {:.3} and {:.3} pixels apart in the middle, turned by {:.2} degrees\n\
         distortion {:+.3} % at the farthest dot, {:.1} pixels from the middle\n\
         the polynomial of the distortion fits the dots within {:.3} pixels RMS\n\n",
        grid.dots.len(),
        count(0),
        count(1),
        x.hypot(y),
        down[0].hypot(down[1]),
        y.atan2(x).to_degrees(),
        100.0 * farthest.distortion,
        grid.radius(farthest),
        grid.residual,
    );
    text += "radius (pixels)  dots  distortion (%)  lateral colour (pixels): red      blue\n";
    for ring in rings(grid) {
        let mean = |of: &dyn Fn(&GridDot) -> f64| {
            ring.iter().map(|dot| of(dot)).sum::<f64>() / ring.len() as f64
        };
        let _ = writeln!(
            text,
            "{:>15.1}  {:>4}  {:>+14.3}  {:>+28.3}  {:>+8.3}",
            mean(&|dot| grid.radius(dot)),
            ring.len(),
            mean(&|dot| 100.0 * dot.distortion),
            mean(&|dot| grid.lateral_colour(dot)[0]),
            mean(&|dot| grid.lateral_colour(dot)[1]),
        );
    }
    text
}
