//! `petzval measure colours`: colour errors from a picture of a colour checker.

use std::fmt::Write as _;

use petzval_base::io::ReadContext;
use petzval_report::measurement::MeasurementReport;
use petzval_tools::chart_analysis::{ColourPatches, PatchColour};

use super::super::{Failure, Outcome};
use super::region::{ChartRegion, RegionArguments};
use super::results::ResultArguments;
use super::title_of;

/// Mean difference from which the region is probably not that of the patches.
const DOUBTFUL: f64 = 15.0;

/// Arguments of `petzval measure colours`.
#[derive(Debug, clap::Args)]
pub(super) struct ColoursArguments {
    #[command(flatten)]
    region: RegionArguments,
    #[command(flatten)]
    results: ResultArguments,
}

pub(super) fn run(arguments: &ColoursArguments) -> Result<Outcome, Failure> {
    let ColoursArguments { region, results } = arguments;
    let context = ReadContext::default();
    let ChartRegion { picture, place, .. } = region.read(&context)?;
    let colours = ColourPatches::measure(&picture, place).map_err(|error| region.fault(&error))?;
    if colours.mean_difference() > DOUBTFUL {
        say!(
            "petzval: warning: these are probably not the patches: {} is to begin at the upper left of dark skin and to \
             end at the lower right of black",
            region.name()
        );
    }
    let report = MeasurementReport::of_colours(
        title_of("Colours", &region.picture),
        &colours,
        text_of(&colours),
    );
    let json = region.with_source(colours.json());
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
