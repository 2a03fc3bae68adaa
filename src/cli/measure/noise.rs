//! `petzval measure noise`: parameters of a sensor from pictures of uniform light.

use std::fmt::Write as _;
use std::path::PathBuf;

use petzval_base::io::ReadContext;
use petzval_render::sensor::Components;
use petzval_report::measurement::MeasurementReport;
use petzval_tools::sensor_analysis::{
    ChannelTransfer, Deviation, Exposure, PhotonTransfer, evaluate_file,
};
use serde_json::{Value, json};

use super::super::{Failure, Outcome};
use super::results::ResultArguments;
use super::title_of;

/// Arguments of `petzval measure noise`.
#[derive(Debug, clap::Args)]
pub(super) struct NoiseArguments {
    /// List of pictures in the format of EMVA 1288: lines "b NS PHOTONS" and "d NS" begin exposures with and without
    /// light, "i FILE" adds a picture (.dng, or the codes as grey .png or .tif)
    list: PathBuf,
    #[command(flatten)]
    results: ResultArguments,
}

pub(super) fn run(arguments: &NoiseArguments) -> Result<Outcome, Failure> {
    let NoiseArguments { list, results } = arguments;
    let context = ReadContext::default();
    let channels = evaluate_file(list, &context)?;
    let report =
        MeasurementReport::of_noise(title_of("Noise", list), &channels, text_of(&channels));
    let of_channels: Vec<Value> = channels.iter().map(ChannelTransfer::json).collect();
    let json = json!({ "list": list.display().to_string(), "channels": of_channels });
    results.finish(&context, &curve(&channels), &report, &json)
}

/// Returns the photon transfer curve of each channel as a table.
fn curve(channels: &[ChannelTransfer]) -> String {
    let mut text =
        "channel,photons,pictures,mean,dark mean,variance,dark variance,spatial variance,dark spatial variance\n"
            .to_owned();
    for ChannelTransfer { channel, transfer, .. } in channels {
        for Exposure { photons, light, dark } in &transfer.exposures {
            let photons = photons.map(|photons| photons.to_string()).unwrap_or_default();
            let pictures = light.pictures;
            let numbers = [
                light.mean,
                dark.mean,
                light.temporal.total(),
                dark.temporal.total(),
                light.spatial.total(),
                dark.spatial.total(),
            ];
            let numbers = numbers.map(|number| format!("{number:.6}")).join(",");
            let _ = writeln!(text, "{channel},{photons},{pictures},{numbers}");
        }
    }
    text
}

fn text_of(channels: &[ChannelTransfer]) -> String {
    let mut text = String::new();
    if let Some(ChannelTransfer { size: [width, height], transfer, .. }) = channels.first() {
        let exposures = transfer.exposures.len();
        let s = if exposures == 1 { "" } else { "s" };
        let _ =
            writeln!(text, "{exposures} exposure{s} of {width} x {height} photosites a channel\n");
    }
    let decibels = |ratio: f64| format!("{ratio:.0} ({:.1} dB)", 20.0 * ratio.log10());
    let by_parts = |of: Deviation, unit: f64| {
        let Components { pixel, row, column } = of.parts.scaled(unit);
        format!("{pixel:.2}/{row:.2}/{column:.2}")
    };
    type Cell<'a> = &'a dyn Fn(&PhotonTransfer) -> String;
    let known = |value: Option<String>, unknown: &str| value.unwrap_or_else(|| unknown.to_owned());
    let not_reached = "not reached";
    let rows: [(&str, Cell<'_>); 15] = [
        ("gain K (codes/e-)", &|t| format!("{:.4}", t.gain)),
        ("mean of the dark (codes)", &|t| format!("{:.2}", t.dark.mean)),
        ("noise of the dark (e-)", &|t| {
            let hidden = if t.is_dark_noise_resolved { "" } else { "below " };
            format!("{hidden}{:.3}", t.dark_noise.total)
        }),
        ("  pixel/row/column", &|t| by_parts(t.dark_noise, 1.0)),
        ("DSNU (e-)", &|t| format!("{:.3}", t.dsnu.total)),
        ("  pixel/row/column", &|t| by_parts(t.dsnu, 1.0)),
        ("PRNU (%)", &|t| format!("{:.3}", 100.0 * t.prnu.total)),
        ("  pixel/row/column", &|t| by_parts(t.prnu, 100.0)),
        ("  measured at (e-)", &|t| format!("{:.0}", t.prnu_signal)),
        ("saturation (e-)", &|t| known(t.saturation.map(|n| format!("{n:.0}")), not_reached)),
        ("full well (e-)", &|t| known(t.full_well.map(|n| format!("{n:.0}")), not_reached)),
        ("SNR at saturation", &|t| known(t.saturation.map(|n| decibels(n.sqrt())), not_reached)),
        ("threshold (e-)", &|t| format!("{:.2}", t.threshold())),
        ("dynamic range", &|t| {
            known(t.saturation.map(|n| decibels(n / t.threshold())), not_reached)
        }),
        ("quantum efficiency", &|t| {
            known(t.quantum_efficiency.map(|n| format!("{n:.4}")), "no photons given")
        }),
    ];
    let mut row = |name: &str, cell: &dyn Fn(&ChannelTransfer) -> String| {
        let cells: String = channels.iter().map(|c| format!("{:>20}", cell(c))).collect();
        let _ = writeln!(text, "{name:<26}{cells}");
    };
    row("channel", &|c| c.channel.to_owned());
    for (name, cell) in rows {
        row(name, &|c| cell(&c.transfer));
    }
    row("linearity error (%)", &|c| {
        known(c.transfer.linearity_error.map(|n| format!("{:.3}", 100.0 * n)), "not measured")
    });
    text
}
