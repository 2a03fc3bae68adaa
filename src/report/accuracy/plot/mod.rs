//! Plot of error over time, both logarithmic, with a line for each rung.

mod axis;
mod labels;

use petzval_tools::accuracy::Point;

use axis::Axis;
use labels::apart;

use super::AccuracyReport;
use super::advice::two_digits;
use crate::svg::{Position, Sheet};

/// Width and height of the sheet [px].
const SHEET: Position = [880.0, 500.0];
/// Left, top, right and bottom of the plot area [px].
const AREA: [f64; 4] = [62.0, 44.0, 560.0, 440.0];
/// Type sizes of labels and of titles [px].
const TYPE: [f64; 2] = [12.5, 14.0];
/// Distance between labels [px].
const LINE: f64 = 17.0;

/// Colours that colour-blind readers can tell apart (Okabe & Ito 2008), on white and on black.
const COLOURS: [&str; 7] =
    ["#d55e00", "#e69f00", "#cc79a7", "#009e73", "#56b4e9", "#0072b2", "#8c8c8c"];
/// Dash patterns for rungs that repeat a colour.
const DASHES: [&str; 3] = ["", "stroke-dasharray=\"7 3\"", "stroke-dasharray=\"2 2\""];

/// Returns the plot as a file for papers: black on white.
pub(super) fn file(report: &AccuracyReport) -> String {
    draw(report).finish(SHEET, &title(report))
}

/// Returns the plot as a part of a page, in the page's colours.
pub(super) fn inline(report: &AccuracyReport) -> String {
    draw(report).inline(SHEET, &title(report))
}

fn title(report: &AccuracyReport) -> String {
    format!("{}: time against error by camera model", report.scene)
}

/// Returns the colour of a rung; the richest has the colour of the text.
pub(super) fn colour(report: &AccuracyReport, rung: usize) -> &'static str {
    match rung + 1 == report.ladder.rungs.len() {
        true => "currentColor",
        false => COLOURS[rung % COLOURS.len()],
    }
}

fn dashes(report: &AccuracyReport, rung: usize) -> &'static str {
    match rung + 1 == report.ladder.rungs.len() {
        true => "",
        false => DASHES[rung / COLOURS.len() % DASHES.len()],
    }
}

/// Returns a point's relative error, root mean square (%).
fn error(point: &Point) -> f64 {
    100.0 * point.error.max(0.0).sqrt()
}

fn draw(report: &AccuracyReport) -> Sheet {
    let mut sheet = Sheet::default();
    let points = &report.run.points;
    let drawn: Vec<&Point> =
        points.iter().filter(|point| point.seconds > 0.0 && error(point) > 0.0).collect();
    let Some(axes) = axes(report, &drawn) else {
        let words = "The budget was over before the first measurement.";
        sheet.text([AREA[0], SHEET[1] / 2.0], TYPE[1], "", words);
        return sheet;
    };
    let position =
        |point: &Point| [axes[0].position(point.seconds), axes[1].position(error(point))];
    frame(&mut sheet, &axes);
    noise_floor(&mut sheet, report, &axes[1]);

    let best: Vec<Position> = drawn.iter().filter(|p| p.on_frontier).map(|p| position(p)).collect();
    let best = sorted(best);
    let wide = "fill=\"none\" stroke=\"currentColor\" stroke-width=\"9\" stroke-opacity=\"0.13\" \
                stroke-linejoin=\"round\" stroke-linecap=\"round\"";
    if best.len() > 1 {
        sheet.path(&best, false, wide);
    }
    let mut ends = Vec::new();
    for rung in 0..report.ladder.rungs.len() {
        let line: Vec<Position> =
            drawn.iter().filter(|p| p.rung == rung).map(|p| position(p)).collect();
        let Some(&end) = line.last() else { continue };
        let (colour, dashes) = (colour(report, rung), dashes(report, rung));
        let stroke = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\" {dashes}");
        sheet.path(&line, false, &stroke);
        for (at, point) in line.iter().zip(drawn.iter().filter(|p| p.rung == rung)) {
            let (radius, ring) = match point.on_frontier {
                true => (4.2, "stroke=\"currentColor\" stroke-width=\"1.2\""),
                false => (2.4, "stroke=\"none\""),
            };
            sheet.circle(*at, radius, &format!("fill=\"{colour}\" {ring}"));
        }
        ends.push((rung, end));
    }
    names(&mut sheet, report, ends);
    sheet
}

fn sorted(mut positions: Vec<Position>) -> Vec<Position> {
    positions.sort_by(|a, b| a[0].total_cmp(&b[0]));
    positions
}

/// Returns axes that span the drawn points; `None` without points.
fn axes(report: &AccuracyReport, drawn: &[&Point]) -> Option<[Axis; 2]> {
    let floor = report.run.reference.as_ref().map(|reference| 100.0 * reference.noise.sqrt());
    let times = drawn.iter().map(|point| point.seconds);
    let errors = drawn.iter().map(|point| error(point)).chain(floor.filter(|f| *f > 0.0));
    let [left, top, right, bottom] = AREA;
    Some([Axis::new(times, [left, right])?, Axis::new(errors, [bottom, top])?])
}

/// Draws the frame, ticks and titles of the axes.
fn frame(sheet: &mut Sheet, [x, y]: &[Axis; 2]) {
    let [left, top, right, bottom] = AREA;
    let faint = "stroke=\"currentColor\" stroke-opacity=\"0.13\"";
    let (middle, end) = ("text-anchor=\"middle\"", "text-anchor=\"end\"");
    for tick in x.ticks() {
        let at = x.position(tick.value);
        if tick.label.is_some() {
            sheet.path(&[[at, top], [at, bottom]], false, faint);
        }
        let length = if tick.decade { 7.0 } else { 4.0 };
        sheet.path(&[[at, bottom], [at, bottom + length]], false, "stroke=\"currentColor\"");
        if let Some(label) = &tick.label {
            sheet.text([at, bottom + 21.0], TYPE[0], middle, label);
        }
    }
    for tick in y.ticks() {
        let at = y.position(tick.value);
        if tick.label.is_some() {
            sheet.path(&[[left, at], [right, at]], false, faint);
        }
        let length = if tick.decade { 7.0 } else { 4.0 };
        sheet.path(&[[left - length, at], [left, at]], false, "stroke=\"currentColor\"");
        if let Some(label) = &tick.label {
            sheet.text([left - 10.0, at + 4.0], TYPE[0], end, label);
        }
    }
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
    sheet.path(&corners, true, "fill=\"none\" stroke=\"currentColor\"");
    let across = (left + right) / 2.0;
    sheet.text([across, bottom + 44.0], TYPE[1], middle, "time to render, s");
    let words = "error of the picture, %: noise, and the model's own";
    sheet.text([16.0, top - 16.0], TYPE[1], "", words);
}

/// Draws the noise of the reference, below which errors cannot be measured.
fn noise_floor(sheet: &mut Sheet, report: &AccuracyReport, axis: &Axis) {
    let Some(reference) = &report.run.reference else { return };
    let level = 100.0 * reference.noise.max(0.0).sqrt();
    if level <= 0.0 {
        return;
    }
    let at = axis.position(level);
    let dashed = "stroke=\"currentColor\" stroke-width=\"1.2\" stroke-dasharray=\"5 4\"";
    sheet.path(&[[AREA[0], at], [AREA[2], at]], false, dashed);
    let words = format!("noise of the reference, {} samples", reference.samples);
    sheet.text([AREA[0] + 8.0, at - 6.0], TYPE[0], "", &words);
}

/// Writes the names of the rungs beside the ends of their lines, with each model's own error.
fn names(sheet: &mut Sheet, report: &AccuracyReport, ends: Vec<(usize, Position)>) {
    let [_, top, right, bottom] = AREA;
    let wanted: Vec<f64> = ends.iter().map(|(_, end)| end[1]).collect();
    let column = right + 52.0;
    let heading = "model: its own error";
    sheet.text([column, top - 16.0], TYPE[0], "font-weight=\"bold\"", heading);
    for ((rung, end), y) in ends.iter().zip(apart(&wanted, LINE, [top + 4.0, bottom])) {
        let colour = colour(report, *rung);
        // Level as far as the plot's edge, so that leaders cross nothing inside the plot.
        let stroke = format!("fill=\"none\" stroke=\"{colour}\" stroke-opacity");
        let within = format!("{stroke}=\"0.5\" stroke-dasharray=\"1 4\"");
        sheet.path(&[*end, [right, end[1]]], false, &within);
        let gutter = [[right, end[1]], [column - 18.0, y], [column - 8.0, y]];
        sheet.path(&gutter, false, &format!("{stroke}=\"1\""));
        sheet.circle([column - 8.0, y], 3.0, &format!("fill=\"{colour}\""));
        let own = match report.run.last(*rung).and_then(|point| point.bias) {
            Some(bias) if bias.certain() => format!("{} %", two_digits(100.0 * bias.size())),
            Some(bias) => format!("< {} %, if any", two_digits(100.0 * bias.at_most().max(1e-6))),
            None if rung + 1 == report.ladder.rungs.len() => "the measure".to_owned(),
            None => "not known".to_owned(),
        };
        let words = format!("{}: {own}", report.ladder.rungs[*rung].name);
        sheet.text([column, y + 4.0], TYPE[0], "", &words);
    }
}
