//! Plots of measurements.

use petzval_tools::chart_analysis::{
    ColourPatches, DotGrid, EdgeResponse, GreySteps, Shading, ShadingZone, StarResponse, StarRing,
    TextureResponse,
};
use petzval_tools::sensor_analysis::ChannelTransfer;

use super::MeasurementReport;
use crate::plot::{Plot, Series, Style};

/// Frequency of the pixels (cycles a pixel).
const NYQUIST: f64 = 0.5;
/// Number of the colours for red and for blue, and for what is neither.
const RED: usize = 4;
const BLUE: usize = 0;
const GREEN: usize = 2;
const GREY: usize = 6;

fn axes(x: &str, y: &str) -> [String; 2] {
    [x, y].map(str::to_owned)
}

fn series(name: &str, colour: usize, style: Style, points: Vec<[f64; 2]>) -> Series {
    Series { name: name.to_owned(), colour, style, points }
}

/// Returns a plot of spatial frequency responses, with the limit of the pixels.
fn responses(mut curves: Vec<Series>, end: f64) -> Plot {
    let most = curves.iter().flat_map(|curve| &curve.points).map(|p| p[1]).fold(1.0, f64::max);
    curves.push(series(
        "Nyquist",
        GREY,
        Style::Dashed,
        vec![[NYQUIST, 0.0], [NYQUIST, 1.05 * most]],
    ));
    Plot {
        name: "response".into(),
        title: "Spatial frequency response".into(),
        axes: axes("cycles/pixel", "response"),
        series: curves,
        ranges: [Some([0.0, end]), Some([0.0, 1.05 * most])],
        ..Plot::default()
    }
}

impl MeasurementReport {
    /// Reports responses of slanted edges.
    pub fn of_edges(title: String, edges: &[EdgeResponse], text: String) -> Self {
        let curve = |(i, edge): (usize, &EdgeResponse)| {
            let points = EdgeResponse::frequencies().map(|f| [f, edge.at(f)]).collect();
            series(&format!("edge {}", i + 1), i, Style::Line, points)
        };
        let curves = edges.iter().enumerate().map(curve).collect();
        Self { title, plots: vec![responses(curves, 1.0)], text }
    }

    /// Reports the response of a star.
    pub fn of_star(title: String, star: &StarResponse, text: String) -> Self {
        let points = |of: &dyn Fn(&StarRing) -> f64| {
            star.rings.iter().map(|ring| [ring.frequency, of(ring)]).collect()
        };
        let curves = vec![
            series("mean", 0, Style::Line, points(&StarRing::mean)),
            series("segments: least", 1, Style::Dashed, points(&|ring| ring.range()[0])),
            series("most", 1, Style::Dashed, points(&|ring| ring.range()[1])),
        ];
        Self { title, plots: vec![responses(curves, 0.55)], text }
    }

    /// Reports the response to texture.
    pub fn of_texture(title: String, texture: &TextureResponse, text: String) -> Self {
        let curve = series("texture", 0, Style::Line, texture.response.clone());
        Self { title, plots: vec![responses(vec![curve], 0.55)], text }
    }

    /// Reports distortion and lateral colour.
    pub fn of_grid(title: String, grid: &DotGrid, text: String) -> Self {
        let points = |of: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
            (0..grid.dots.len()).map(|i| [grid.radius(&grid.dots[i]), of(i)]).collect()
        };
        let x = "distance from the middle (pixels)";
        let distortion = Plot {
            name: "distortion".into(),
            title: "Distortion".into(),
            axes: axes(x, "%"),
            series: vec![series("", 0, Style::Marks, points(&|i| 100.0 * grid.dots[i].distortion))],
            ..Plot::default()
        };
        let colour = |c: usize| points(&|i| grid.lateral_colour(&grid.dots[i])[c]);
        let lateral = Plot {
            name: "lateral-colour".into(),
            title: "Lateral colour".into(),
            axes: axes(x, "pixels, outwards from green"),
            series: vec![
                series("red", RED, Style::Marks, colour(0)),
                series("blue", BLUE, Style::Marks, colour(1)),
            ],
            ..Plot::default()
        };
        Self { title, plots: vec![distortion, lateral], text }
    }

    /// Reports colours of a colour checker.
    pub fn of_colours(title: String, colours: &ColourPatches, text: String) -> Self {
        let place = |lab: [f64; 3]| [lab[1], lab[2]];
        let patches = &colours.patches;
        let mut all: Vec<Series> = patches
            .iter()
            .map(|p| series("", GREY, Style::Line, vec![place(p.lab), place(p.expected)]))
            .collect();
        let points = |of: fn(&petzval_tools::chart_analysis::PatchColour) -> [f64; 3]| {
            patches.iter().map(|patch| place(of(patch))).collect()
        };
        all.push(series("chart", GREEN, Style::Marks, points(|patch| patch.expected)));
        all.push(series("picture", RED, Style::Marks, points(|patch| patch.lab)));
        let plane = Plot {
            name: "colours".into(),
            title: "Colours".into(),
            axes: axes("a*", "b*"),
            series: all,
            square: true,
            ..Plot::default()
        };
        let differences = patches.iter().enumerate().flat_map(|(i, patch)| {
            let x = i as f64 + 1.0;
            [[x, 0.0], [x, patch.difference()]]
        });
        let differences = Plot {
            name: "differences".into(),
            title: "Colour differences".into(),
            axes: axes("patch, row after row", "dE2000"),
            series: vec![series("", 0, Style::Bars, differences.collect())],
            ..Plot::default()
        };
        Self { title, plots: vec![plane, differences], text }
    }

    /// Reports tone and noise of steps of grey.
    pub fn of_greys(title: String, greys: &GreySteps, text: String) -> Self {
        let x = "stops, relative to a reflectance of 1";
        let steps = greys.steps.iter().map(|step| (step.reflectance.log2(), step));
        let finite =
            |points: Vec<[f64; 2]>| points.into_iter().filter(|p| p[1].is_finite()).collect();
        let tone = steps.clone().map(|(x, step)| [x, step.value().max(1e-12).log2()]).collect();
        let linear = steps.clone().map(|(x, step)| [x, (greys.scale * step.reflectance).log2()]);
        let noise = steps.map(|(x, step)| [x, 20.0 * step.signal_to_noise().log10()]).collect();
        let curve = Plot {
            name: "tone".into(),
            title: "Opto-electronic conversion".into(),
            axes: axes(x, "value (stops, relative to 1)"),
            series: vec![
                series("linear", GREY, Style::Dashed, linear.collect()),
                series("picture", 0, Style::Marks, finite(tone)),
            ],
            ..Plot::default()
        };
        let ratio = Plot {
            name: "snr".into(),
            title: "Signal-to-noise ratio".into(),
            axes: axes(x, "dB"),
            series: vec![series("", 0, Style::Line, finite(noise))],
            ..Plot::default()
        };
        Self { title, plots: vec![curve, ratio], text }
    }

    /// Reports the shading of a white chart.
    pub fn of_shading(title: String, shading: &Shading, text: String) -> Self {
        let points = |of: &dyn Fn(&ShadingZone) -> Option<f64>| {
            shading.zones.iter().filter_map(|zone| Some([zone.field, of(zone)?])).collect()
        };
        let x = "field (1: corner of the picture)";
        let light = Plot {
            name: "light".into(),
            title: "Light".into(),
            axes: axes(x, "% of the middle"),
            series: vec![series("", 0, Style::Marks, points(&|zone| Some(100.0 * zone.light)))],
            ..Plot::default()
        };
        let colour = Plot {
            name: "colour".into(),
            title: "Colour".into(),
            axes: axes(x, "relative to the middle"),
            series: vec![
                series("red/green", RED, Style::Marks, points(&|zone| Some(zone.colour?[0]))),
                series("blue/green", BLUE, Style::Marks, points(&|zone| Some(zone.colour?[1]))),
            ],
            ..Plot::default()
        };
        Self { title, plots: vec![light, colour], text }
    }

    /// Reports the noise of a sensor: photon transfer and linearity.
    pub fn of_noise(title: String, channels: &[ChannelTransfer], text: String) -> Self {
        let colours = [RED, GREEN, 3, BLUE];
        let all = |of: fn(&ChannelTransfer) -> Vec<[f64; 2]>, style: Style| -> Vec<Series> {
            let one = |(i, channel): (usize, &ChannelTransfer)| {
                series(channel.channel, colours[i % colours.len()], style, of(channel))
            };
            channels.iter().enumerate().map(one).collect()
        };
        let transfer = Plot {
            name: "photon-transfer".into(),
            title: "Photon transfer".into(),
            axes: axes("mean less dark (codes)", "temporal variance less dark (codes²)"),
            series: all(
                |channel| {
                    let exposures = channel.transfer.exposures.iter();
                    let noise = exposures
                        .map(|e| [e.signal(), e.light.temporal.total() - e.dark.temporal.total()]);
                    noise.collect()
                },
                Style::Marks,
            ),
            ..Plot::default()
        };
        Self { title, plots: vec![transfer], text }
    }
}
