//! The report as one HTML page without scripts or other files.
//!
//! The page is well-formed XML, so that tests and tools can read it.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use petzval_image::Picture;
use petzval_tools::accuracy::{QUARTERS, Reference, Rung};

use super::advice::{Verdict, two_digits};
use super::crops::{GAIN, Region, crops, regions};
use super::{AccuracyReport, plot};
use crate::date::now;
use crate::svg::escape;

/// Factor on the size of crops.
const ENLARGED: usize = 4;
/// Longest side of the whole picture (pixels).
const MAX_SIDE: usize = 480;
/// JPEG quality of the whole picture, of 100.
const QUALITY: u8 = 85;

const STYLE: &str = "
:root { color-scheme: light dark; }
body { font: 16px/1.5 Helvetica, Arial, sans-serif; max-width: 62rem; margin: 2rem auto; \
padding: 0 1rem; color: CanvasText; background: Canvas; }
h1 { font-size: 1.6rem; margin-bottom: 0.2rem; } h2 { font-size: 1.2rem; margin-top: 2rem; }
p, li { max-width: 46rem; } .answer { font-size: 1.25rem; font-weight: bold; } .note { font-size: 0.85rem; opacity: 0.8; }
.partial { border-left: 4px solid #d55e00; padding-left: 0.8rem; }
svg { width: 100%; height: auto; } .whole { position: relative; display: inline-block; }
.whole svg { position: absolute; inset: 0; height: 100%; } img { display: block; }
.crops { display: flex; flex-wrap: wrap; gap: 0.8rem; }
figure { margin: 0; } .crops img { image-rendering: pixelated; margin-bottom: 3px; \
outline: 1px solid color-mix(in srgb, currentColor 30%, transparent); }
figcaption { font-size: 0.85rem; max-width: 160px; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.85rem; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 0.25rem 0.6rem; \
border-bottom: 1px solid color-mix(in srgb, currentColor 25%, transparent); }
th:first-child, td:first-child { text-align: left; white-space: nowrap; }
.swatch { display: inline-block; width: 0.7em; height: 0.7em; margin-right: 0.4em; }
";

/// Returns the page.
pub(super) fn page(
    report: &AccuracyReport,
    verdicts: &[Verdict],
    recommendation: Option<&str>,
) -> std::io::Result<String> {
    let scene = escape(&report.scene);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>What accuracy costs: {scene}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
    );
    answer(&mut page, report, &scene, recommendation);
    page += &plot::inline(report);
    let _ = writeln!(
        page,
        "<p class=\"note\">Each line is a model through its ladder of samples, from {} to as many as \
         the time allowed; each point has twice the samples of the one before. Ringed points, on \
         the grey band, are the frontier: nothing faster is as exact. A line becomes flat when \
         only the model's own error is left.</p>",
        QUARTERS
    );
    models(&mut page, report, verdicts);
    if let Some(reference) = &report.run.reference {
        pictures(&mut page, report, reference)?;
    }
    table(&mut page, report, verdicts);
    method(&mut page, report);
    page += "</body>\n</html>\n";
    Ok(page)
}

/// Adds the title and the answer: the recommendation, or why there is none.
fn answer(page: &mut String, report: &AccuracyReport, scene: &str, recommendation: Option<&str>) {
    let _ = writeln!(page, "<h1>What accuracy costs: {scene}</h1>");
    if let Some(recommendation) = recommendation {
        let (answer, remarks) = match recommendation.split_once(". ") {
            Some((answer, remarks)) => (format!("{answer}."), remarks),
            None => (recommendation.to_owned(), ""),
        };
        let _ = writeln!(page, "<p class=\"answer\">{}</p>", escape(&answer));
        if !remarks.is_empty() {
            let _ = writeln!(page, "<p>{}</p>", escape(remarks));
        }
    }
    if let Some(words) = report.partial() {
        let _ = writeln!(page, "<p class=\"partial\"><strong>{words}</strong></p>");
    }
}

/// Adds the verdict on every model.
fn models(page: &mut String, report: &AccuracyReport, verdicts: &[Verdict]) {
    page.push_str("<h2>The models</h2>\n<ul>\n");
    for verdict in verdicts {
        let rung = &report.ladder.rungs[verdict.rung];
        let _ = writeln!(
            page,
            "<li><strong>{}</strong>: {}. <span class=\"note\">{}</span></li>",
            escape(&rung.name),
            escape(&verdict.sentence),
            escape(&rung.sentence)
        );
    }
    if verdicts.is_empty() {
        page.push_str("<li>None: there are no measurements.</li>\n");
    }
    page.push_str("</ul>\n");
    if let Some(words) = report.not_compared() {
        let _ = writeln!(page, "<p class=\"note\">{words}</p>");
    }
}

/// Adds the whole picture, and crops of every model's.
fn pictures(
    page: &mut String,
    report: &AccuracyReport,
    reference: &Reference,
) -> std::io::Result<()> {
    let regions = regions(report.run, reference);
    let small = reduced(&reference.picture);
    let [width, height] = reference.picture.size;
    let whole = small.jpeg(reference.exposure, QUALITY)?;
    let _ = writeln!(
        page,
        "<h2>The pictures</h2>\n<div class=\"whole\"><img alt=\"The reference\" width=\"{}\" \
         height=\"{}\" src=\"data:image/jpeg;base64,{}\"/>\n<svg viewBox=\"0 0 {width} {height}\" \
         preserveAspectRatio=\"none\" fill=\"none\" stroke=\"#fff\">",
        small.size[0],
        small.size[1],
        STANDARD.encode(whole)
    );
    for Region { low: [x, y], size: [w, h], .. } in &regions {
        let _ = writeln!(
            page,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" stroke=\"#000\" \
             stroke-width=\"3\"/><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/>"
        );
    }
    let _ = writeln!(
        page,
        "</svg></div>\n<p class=\"note\">The reference: {} samples a pixel of real f64, {:.1} s, its \
         noise {} %. Below are the marked parts by every model. Under each is its difference from \
         real f64 of the same seeds, {GAIN} times as bright; black is no difference. All have the \
         same exposure and are enlarged {ENLARGED} times.</p>",
        reference.samples,
        reference.seconds,
        two_digits(100.0 * reference.noise.max(0.0).sqrt())
    );
    for region in &regions {
        let [[x, y], [w, h]] = [region.low, region.size];
        let _ = writeln!(
            page,
            "<h3>{} <span class=\"note\">({w} x {h} pixels at {x}, {y})</span></h3>\n\
             <div class=\"crops\">",
            region.title
        );
        for (i, rung) in report.ladder.rungs.iter().enumerate() {
            let Some(pair) = report.run.pair(i) else { continue };
            figure(page, rung, pair[0].samples(), region, &crops(pair, region, reference)?);
        }
        page.push_str("</div>\n");
    }
    Ok(())
}

fn figure(page: &mut String, rung: &Rung, samples: u32, region: &Region, files: &[Vec<u8>; 2]) {
    let [width, height] = region.size.map(|n| n * ENLARGED);
    let name = escape(&rung.name);
    page.push_str("<figure>");
    for (file, what) in files.iter().zip(["", ", difference"]) {
        let _ = write!(
            page,
            "<img alt=\"{name}{what}\" width=\"{width}\" height=\"{height}\" \
             src=\"data:image/png;base64,{}\"/>",
            STANDARD.encode(file)
        );
    }
    let _ = writeln!(page, "<figcaption>{name}, {samples} samples</figcaption></figure>");
}

/// Returns the picture with blocks of pixels averaged until it is small enough.
fn reduced(picture: &Picture) -> Picture {
    let [width, height] = picture.size;
    let step = width.max(height).div_ceil(MAX_SIDE).max(1);
    let size = [width, height].map(|n| (n / step).max(1));
    let pixel = |i: usize| {
        let [x, y] = [i % size[0] * step, i / size[0] * step];
        let mut sum = [0.0f32; 3];
        for j in 0..step * step {
            let [u, v] = [(x + j % step).min(width - 1), (y + j / step).min(height - 1)];
            let part = picture.pixels[v * width + u];
            sum = [0, 1, 2].map(|c| sum[c] + part[c]);
        }
        sum.map(|s| s / (step * step) as f32)
    };
    Picture { size, pixels: (0..size[0] * size[1]).map(pixel).collect() }
}

/// Adds the table of the last point of every rung.
fn table(page: &mut String, report: &AccuracyReport, verdicts: &[Verdict]) {
    page.push_str(
        "<h2>Numbers</h2>\n<div class=\"scroll\"><table>\n<tr><th>model</th><th>samples</th>\
         <th>time, s</th><th>times real f32</th><th>in the lens</th><th>M rays/s</th>\
         <th>on film, um</th><th>corner, um</th><th>MSE</th><th>relMSE</th><th>FLIP</th>\
         <th>error, %</th><th>noise, %</th><th>own, %</th></tr>\n",
    );
    for (i, rung) in report.ladder.rungs.iter().enumerate() {
        let Some(point) = report.run.last(i) else { continue };
        let lens = 100.0 * point.lens_seconds() / point.seconds.max(1e-9);
        let times = verdicts.iter().find(|verdict| verdict.rung == i).and_then(|v| v.time);
        let own = escape(&report.own(point));
        let _ = writeln!(
            page,
            "<tr><td><span class=\"swatch\" style=\"background: {}\"></span>{}</td><td>{}</td>\
             <td>{:.2}</td><td>{}</td><td>{lens:.1} %</td><td>{:.1}</td><td>{}</td><td>{}</td>\
             <td>{:.2e}</td><td>{:.2e}</td><td>{:.4}</td><td>{}</td><td>{}</td><td>{own}</td></tr>",
            plot::colour(report, i),
            escape(&rung.name),
            point.samples,
            point.seconds,
            super::times(times),
            point.rays / 1e6,
            two_digits(rung.film.rms_um),
            two_digits(rung.film.corner_um),
            point.mse,
            point.relmse,
            point.flip,
            two_digits(100.0 * point.error.max(0.0).sqrt()),
            two_digits(100.0 * point.noise.max(0.0).sqrt()),
        );
    }
    page.push_str(
        "</table></div>\n<p class=\"note\">The last point of every model; accuracy.csv has all points. \
         Times are wall-clock times on all threads: four times the median over the quarters of the \
         samples, which models render in turns. A time with a ? is not reliable: run again. Own with a + is no error but the change by an \
         effect that the reference lacks; MSE, relMSE, FLIP and error contain it too. On film is \
         the distance of rays from those of real f64, root mean square over film and pupil, and \
         over the outermost part of the picture. MSE, relMSE, FLIP and error compare the picture \
         with the reference, including noise.</p>\n",
    );
}

fn method(page: &mut String, report: &AccuracyReport) {
    let _ = writeln!(
        page,
        "<h2>Method</h2>\n<p>Every model photographs the same scene through the same film and pupil \
         samples. Its error has two parts. Noise falls as samples rise; the model's own error \
         stays. Four quarters of the samples, with seeds of their own, tell them apart: the \
         differences D of two models in different quarters are independent, so the mean of \
         D<sub>i</sub>D<sub>j</sub> is an unbiased estimate of the model's squared error, and \
         (D<sub>i</sub> - D<sub>j</sub>)(D<sub>k</sub> - D<sub>l</sub>)/4 is noise alone. An error \
         counts from four standard errors on, by blocks of pixels: noise alone reaches that in \
         fewer than one of a thousand comparisons. A change is called visible if the error is 1 % \
         root mean square or more (Weber's fraction), or if rays at the corner are half a pixel \
         off.</p>\n\
         <p>Both models of a comparison take the same seeds, so that most of their noise cancels. \
         The reference takes others, and about half of the time. Its noise is part of every \
         error that compares with it; the dashed line shows that noise.</p>\n\
         <p>Errors in percent are root mean squares over pixels and channels, each divided by the \
         root of v<sup>2</sup> + m<sup>2</sup>, with the reference's value v there and its mean m: \
         relative to the light of the pixel, and in the dark to that of the picture. relMSE is the \
         mean of the squared difference over the square of the reference and 0.01 (Rousselle, \
         Knaus &amp; Zwicker 2011); FLIP is that of Andersson et al. 2020, of the pictures as they \
         are shown here. The frontier has the points that no other beats in both \
         time and error; errors within 1 % and times within 5 % count as the same. The real lens \
         is traced surface by surface (Kolb, Mitchell &amp; Hanrahan 1995); the polynomial is \
         after Hullin, Hanika &amp; Heidrich 2012.</p>",
    );
    let [width, height] = report.ladder.size();
    let machine = &report.machine;
    let _ = writeln!(
        page,
        "<p class=\"note\">{}; {width} x {height} pixels of {} um; {:.1} s of a budget of {} s; {}, \
         {} threads, {}; petzval {}, {}<br/>The command: {}</p>",
        escape(&report.ladder.lens),
        two_digits(report.ladder.pitch()),
        report.run.seconds,
        two_digits(report.budget.as_secs_f64()),
        escape(&machine.cpu),
        machine.threads,
        escape(&machine.system),
        machine.version,
        now(),
        escape(&report.command)
    );
}
