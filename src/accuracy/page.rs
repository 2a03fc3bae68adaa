//! The report as one page of HTML that needs nothing else: neither scripts nor other files.
//!
//! It is XML, too, so that tests and tools can read it.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::Ended;
use super::advice::{Verdict, two_digits};
use super::crops::{GAIN, Region, crops, regions};
use super::point::{Point, Reference};
use super::report::Report;
use super::{Rung, plot};
use crate::image::Picture;
use crate::plan::Effect;
use crate::svg::escape;

/// Times that a pixel of a crop is shown wide.
const ENLARGED: usize = 4;
/// The widest picture of the whole, pixels.
const WIDEST: usize = 480;
/// Quality of the picture of the whole, of 100.
const QUALITY: u8 = 85;

const STYLE: &str = "
:root { color-scheme: light dark; }
body { font: 16px/1.5 Helvetica, Arial, sans-serif; max-width: 62rem; margin: 2rem auto; \
padding: 0 1rem; color: CanvasText; background: Canvas; }
h1 { font-size: 1.6rem; margin-bottom: 0.2rem; } h2 { font-size: 1.2rem; margin-top: 2rem; }
p, li { max-width: 46rem; } .note { font-size: 0.85rem; opacity: 0.8; }
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

/// The whole page.
pub(super) fn page(
    report: &Report,
    verdicts: &[Verdict],
    choice: Option<&str>,
) -> std::io::Result<String> {
    let scene = escape(&report.scene);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>What accuracy costs: {scene}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
    );
    head(&mut page, report, &scene);
    advice(&mut page, report, verdicts, choice);
    let _ = write!(page, "<h2>Time against error</h2>\n{}", plot::inline(report));
    let _ = writeln!(
        page,
        "<p class=\"note\">A line a model, through its ladder of samples: {} to as many as there \
         was time for, each point twice those of the one before. Ringed points, on the grey band, \
         are the frontier: nothing faster is as exact. Where a line has become flat, the model's \
         own error is all that is left.</p>",
        super::quarters::QUARTERS
    );
    if let Some(reference) = &report.climb.reference {
        pictures(&mut page, report, reference)?;
    }
    table(&mut page, report, verdicts);
    method(&mut page, report);
    page += "</body>\n</html>\n";
    Ok(page)
}

fn head(page: &mut String, report: &Report, scene: &str) {
    let [width, height] = report.ladder.size();
    let machine = &report.machine;
    let _ = writeln!(
        page,
        "<h1>What accuracy costs: {scene}</h1>\n<p class=\"note\">{}; {width} x {height} pixels of \
         {} um; {:.1} s of a budget of {} s; {}, {} threads, {}; petzval {}</p>",
        escape(&report.ladder.lens),
        two_digits(report.ladder.pitch()),
        report.climb.seconds,
        two_digits(report.budget.as_secs_f64()),
        escape(&machine.cpu),
        machine.threads,
        escape(&machine.system),
        machine.version,
    );
    if let Some(words) = report.partial() {
        let _ = writeln!(page, "<p class=\"partial\"><strong>{words}</strong></p>");
    }
    if let Some(words) = report.left_out() {
        let _ = writeln!(page, "<p>{words}</p>");
    }
}

fn advice(page: &mut String, report: &Report, verdicts: &[Verdict], choice: Option<&str>) {
    page.push_str("<h2>Advice</h2>\n");
    if let Some(choice) = choice {
        let _ = writeln!(page, "<p><strong>{}</strong></p>", escape(choice));
    }
    page.push_str("<ul>\n");
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
        page.push_str("<li>None: nothing could be measured.</li>\n");
    }
    page.push_str("</ul>\n");
}

/// The whole picture, and parts of all.
fn pictures(page: &mut String, report: &Report, reference: &Reference) -> std::io::Result<()> {
    let regions = regions(report.climb, reference);
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
         noise {} %. Below, the marked parts as every model has them, and under each its \
         difference from real f64 of the same seeds, {GAIN} times as bright; where that is black, \
         there is none. All are exposed the same and {ENLARGED} times as large.</p>",
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
            let Some(pair) = report.climb.pair(i) else { continue };
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

/// The picture, every so many pixels taken together until it is small.
fn reduced(picture: &Picture) -> Picture {
    let [width, height] = picture.size;
    let step = width.max(height).div_ceil(WIDEST).max(1);
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

/// The last point of every rung.
fn table(page: &mut String, report: &Report, verdicts: &[Verdict]) {
    page.push_str(
        "<h2>Numbers</h2>\n<div class=\"scroll\"><table>\n<tr><th>model</th><th>samples</th>\
         <th>time, s</th><th>times real f32</th><th>in the lens</th><th>M rays/s</th>\
         <th>on film, um</th><th>corner, um</th><th>MSE</th><th>relMSE</th><th>FLIP</th>\
         <th>error, %</th><th>noise, %</th><th>own, %</th></tr>\n",
    );
    for (i, rung) in report.ladder.rungs.iter().enumerate() {
        let Some(point) = report.climb.last(i) else { continue };
        let lens = 100.0 * point.lens_seconds() / point.seconds.max(1e-9);
        let times = verdicts.iter().find(|verdict| verdict.rung == i).and_then(|v| v.pace);
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
            times.map_or_else(|| "-".to_owned(), |pace| format!("{:.2}", pace.times)),
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
        "</table></div>\n<p class=\"note\">The last point of every model; accuracy.csv has all. \
         Times are by the clock, on all threads, four times the median of the quarters of the \
         samples, which models render in turns. Own, with a +: no error but what an effect adds that \
         the reference lacks, and that is in its MSE, relMSE, FLIP and error too. On film: how far rays are from where those of \
         real f64 are, root mean square over film and pupil, and over the outermost part of the \
         picture. MSE, relMSE, FLIP and error are of the picture against the reference, noise and all.</p>\n",
    );
}

fn method(page: &mut String, report: &Report) {
    let _ = writeln!(
        page,
        "<h2>Method</h2>\n<p>Every model photographs the same scene through the same film and pupil \
         samples. Its error has two parts. Noise falls as samples rise; the model's own error \
         stays. They are told apart by four quarters of the samples with seeds of their own: \
         the differences D of two models in different quarters are independent, so that the mean \
         of D<sub>i</sub>D<sub>j</sub> is the squared error of the model without bias, and \
         (D<sub>i</sub> - D<sub>j</sub>)(D<sub>k</sub> - D<sub>l</sub>)/4 is what noise alone would \
         do. An error is called one from four standard errors on, by blocks of pixels: noise comes \
         that far in fewer than one of a thousand comparisons. A change is called visible if the \
         error is 1 % root mean square or more (Weber's fraction), or rays at the corner are half \
         a pixel off.</p>\n\
         <p>Both models of a comparison take the same seeds, so that most of their noise cancels. \
         The reference takes others, and about half of the time: its noise is part of every \
         error that is not told apart, and is the dashed line.</p>\n\
         <p>Errors in percent are root mean squares over pixels and channels, each over the root of \
         v<sup>2</sup> + m<sup>2</sup>, of the reference's value v there and its mean m: a share of \
         the light, but in the dark of the picture's. relMSE is the mean of the squared difference over the square of the reference and 0.01 \
         (Rousselle, Knaus &amp; Zwicker 2011); FLIP is that of Andersson et al. 2020, of the \
         pictures as they are shown here. Points on the frontier are those that none beats in both \
         time and error, errors within 1 % and times within 5 % taken for the same. The real lens \
         is traced surface by surface (Kolb, Mitchell &amp; Hanrahan 1995); the polynomial is after Hullin, Hanika &amp; \
         Heidrich 2012.</p>\n<p class=\"note\">The command: {}</p>",
        escape(&report.command)
    );
}

impl Report<'_> {
    /// What is to be said where it is not the whole report.
    pub fn partial(&self) -> Option<&'static str> {
        match self.climb.ended {
            Ended::Planned => None,
            Ended::Early => Some(
                "This report is partial: the budget was over before every model had a picture.",
            ),
            Ended::Interrupted => Some("This report is partial: it was interrupted."),
        }
    }

    /// A model's own error of this point, or what it adds, %, with two digits that count.
    pub fn own(&self, point: &Point) -> String {
        let sign = if self.ladder.rungs[point.rung].adds.is_some() { "+" } else { "" };
        match point.bias {
            Some(bias) if bias.certain() => format!("{sign}{}", two_digits(100.0 * bias.size())),
            Some(bias) => format!("<{}", two_digits(100.0 * bias.at_most())),
            None => "-".to_owned(),
        }
    }

    /// What is to be said of effects that no rung tells about.
    pub fn left_out(&self) -> Option<String> {
        let one = |(effect, why): &(Effect, &str)| format!("{} ({why})", effect.name());
        let words: Vec<String> = self.ladder.aside.iter().map(one).collect();
        (!words.is_empty()).then(|| format!("Effects not compared: {}.", words.join(", ")))
    }
}
