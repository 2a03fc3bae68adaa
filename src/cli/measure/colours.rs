//! `petzval measure colours`: colour errors from a picture of a colour checker.

use std::fmt::Write as _;
use std::path::PathBuf;

use petzval_base::io::{ReadContext, path_excerpt};
use petzval_image::{Picture, Transfer};
use petzval_render::prepare::settings;
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::{ColourPatches, PatchColour};

use super::super::arguments::values::typed;
use super::super::{Failure, Outcome};
use super::results::ResultArguments;
use super::{divide, region_text, region_within, title_of, with_source};

/// Mean difference from which the region is probably not that of the patches.
const DOUBTFUL: f64 = 15.0;

/// Arguments of `petzval measure colours`.
#[derive(Debug, clap::Args)]
pub(super) struct ColoursArguments {
    /// Picture: .exr, .hdr, .pfm, .png, .jpg, .tif
    picture: PathBuf,
    /// Region that the patches fill, without the frame of the chart, in pixels of the file; X1 and Y1 are not included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = typed(settings::crop))]
    region: [[u32; 2]; 2],
    /// Picture of a white chart, by which the picture is divided: the light of the lens falls off to the corners
    #[arg(long, value_name = "PICTURE")]
    flat: Option<PathBuf>,
    #[command(flatten)]
    results: ResultArguments,
}

pub(super) fn run(arguments: &ColoursArguments) -> Result<Outcome, Failure> {
    let ColoursArguments { picture: path, region, flat, results } = arguments;
    let context = ReadContext::default();
    let mut picture = Picture::read_with(path, Transfer::Srgb, &context)?;
    let name = format!("--region {}", region_text(*region));
    let place = region_within(&name, *region, &picture, path)?;
    if let Some(flat) = flat {
        divide(&mut picture, flat, &[(name.clone(), place)], &context)?;
    }
    let colours = ColourPatches::measure(&picture, place)
        .map_err(|error| format!("{name} of {}: {error}", path_excerpt(path)))?;
    if colours.mean_difference() > DOUBTFUL {
        say!(
            "petzval: warning: these are probably not the patches: {name} is to begin at the upper left of dark skin and to \
             end at the lower right of black"
        );
    }
    let report =
        MeasurementReport::of_colours(title_of("Colours", path), &colours, text_of(&colours));
    let json = with_source(colours.json(), path, Some(*region));
    results.finish(&context, &table(&colours), &report, &json)
}

fn table(colours: &ColourPatches) -> String {
    let mut text =
        "patch,red,green,blue,noise,L,a,b,expected_L,expected_a,expected_b,dE2000\n".to_owned();
    for patch in &colours.patches {
        let PatchColour { name, mean, noise, lab, expected } = patch;
        let numbers = [&mean[..], &[*noise], lab, expected, &[patch.difference()]].concat();
        let numbers: Vec<String> = numbers.iter().map(|number| format!("{number:.6}")).collect();
        let _ = writeln!(text, "{name},{}", numbers.join(","));
    }
    text
}

fn text_of(colours: &ColourPatches) -> String {
    let [a, b] = colours.white_balance_error();
    let worst = colours.worst();
    let mut text = format!(
        "mean dE2000 {:.2}, largest {:.2} ({})\nbrightness {:.4} ({:+.2} EV) of that of the chart, white balance off by \
         {a:+.2} in a* and {b:+.2} in b*\n",
        colours.mean_difference(),
        worst.difference(),
        worst.name,
        1.0 / colours.scale,
        -colours.scale.log2(),
    );
    let _ = writeln!(
        text,
        "\n{:<14}{:>24}{:>24}{:>8}{:>8}",
        "patch", "L* a* b*", "expected", "dE2000", "noise"
    );
    let cells = |lab: [f64; 3]| lab.map(|value| format!("{value:8.2}")).concat();
    for patch in &colours.patches {
        let _ = writeln!(
            text,
            "{:<14}{}{}{:>8.2}{:>7.2}%",
            patch.name,
            cells(patch.lab),
            cells(patch.expected),
            patch.difference(),
            100.0 * patch.noise
        );
    }
    text
}
