//! The report as one HTML page without scripts or other files.
//!
//! The page is well-formed XML, so that tests and tools can read it.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::inputs::{ReportInputs, rounded};
use super::section::{ReportSection, Table};
use crate::cli::report::lens_drawing::draw;
use crate::cli::report::svg::escape;

const STYLE: &str = "
:root { color-scheme: light dark; }
body { font: 16px/1.5 Helvetica, Arial, sans-serif; max-width: 64rem; margin: 2rem auto; \
padding: 0 1rem; color: CanvasText; background: Canvas; }
h1 { font-size: 1.6rem; margin-bottom: 0.2rem; } h2 { font-size: 1.2rem; margin-top: 2.4rem; }
p { max-width: 46rem; } .note { font-size: 0.85rem; opacity: 0.8; }
nav { display: flex; flex-wrap: wrap; gap: 0.2rem 1rem; font-size: 0.9rem; }
svg { width: 100%; height: auto; }
.drawing { background: #fff; padding: 0.5rem; }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(22rem, 1fr)); gap: 1rem; }
.square { grid-template-columns: repeat(auto-fill, minmax(14rem, 1fr)); }
.narrow { max-width: 20rem; }
.plots figure { margin: 0; } .plots img { width: 100%; image-rendering: pixelated; }
figcaption { font-size: 0.85rem; }
.scroll { overflow-x: auto; max-height: 30rem; }
table { border-collapse: collapse; font-size: 0.8rem; font-variant-numeric: tabular-nums; \
margin: 0.8rem 0; }
th, td { text-align: right; padding: 0.15rem 0.6rem; \
border-bottom: 1px solid color-mix(in srgb, currentColor 25%, transparent); }
th { vertical-align: bottom; } th:first-child, td:first-child { text-align: left; }
";

/// Most rows of a table on the page.
const ROWS: usize = 60;

/// Returns the page.
pub(super) fn page(inputs: &ReportInputs, sections: &[ReportSection]) -> String {
    let name = escape(&inputs.lens.name);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>Lens report: {name}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{name}</h1>\n"
    );
    if let Some(source) = &inputs.lens.source {
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escape(source));
    }
    let _ = writeln!(page, "<p>{}</p>", escape(&conditions(inputs)));
    for note in &inputs.lens.design.notes {
        let _ = writeln!(page, "<p class=\"note\">Note: {}</p>", escape(note));
    }
    page.push_str("<nav>\n");
    for section in sections {
        let _ = writeln!(page, "<a href=\"#{}\">{}</a>", section.name, escape(section.title));
    }
    page.push_str("</nav>\n");
    let quality = &inputs.quality;
    let height = quality.largest_image_height();
    let drawing = draw(&inputs.lens, Some(quality.conditions.film_distance), height);
    let _ = writeln!(page, "<div class=\"drawing\">{drawing}</div>");
    for section in sections {
        write_section(&mut page, section);
    }
    page.push_str("</body>\n</html>\n");
    page
}

/// Describes the conditions in words.
fn conditions(inputs: &ReportInputs) -> String {
    let conditions = &inputs.quality.conditions;
    let object = match conditions.object_distance.is_finite() {
        true => {
            format!("object {} mm before the front vertex", rounded(conditions.object_distance))
        }
        false => "distant object".to_owned(),
    };
    let lines: Vec<String> = conditions
        .wavelengths
        .iter()
        .enumerate()
        .map(|(i, line)| {
            let primary = if i == conditions.primary { " (primary)" } else { "" };
            format!("{} nm{primary}", rounded(line.nm))
        })
        .collect();
    format!(
        "Real rays: {object}; film {:.4} mm behind the rear vertex; fields up to {}; {}.",
        conditions.film_distance,
        inputs.field_name(conditions.largest_field),
        lines.join(", ")
    )
}

fn write_section(page: &mut String, section: &ReportSection) {
    let _ = writeln!(page, "<h2 id=\"{}\">{}</h2>", section.name, escape(section.title));
    if !section.note.is_empty() {
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escape(&section.note));
    }
    for (text, _) in section.missing.iter().filter(|(_, usual)| !usual) {
        let _ = writeln!(page, "<p class=\"note\">Missing: {}</p>", escape(text));
    }
    if !section.figures.is_empty() {
        page.push_str("<table>\n");
        for (name, value, unit) in &section.figures {
            let words = escape(&name.replace('_', " "));
            let unit = unit.replace("um", "µm");
            let _ = writeln!(page, "<tr><td>{words}</td><td>{} {unit}</td></tr>", shown(*value));
        }
        page.push_str("</table>\n");
    }
    if !section.plots.is_empty() || !section.pictures.is_empty() {
        let narrow = section.plots.iter().all(|plot| plot.square);
        let _ = writeln!(page, "<div class=\"plots{}\">", if narrow { " square" } else { "" });
        for plot in &section.plots {
            let class = if plot.square { " class=\"narrow\"" } else { "" };
            let _ = writeln!(page, "<figure{class}>{}</figure>", plot.inline());
        }
        for picture in &section.pictures {
            let caption = escape(&picture.caption);
            let _ = writeln!(
                page,
                "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{}\"/>\
                 <figcaption>{caption}</figcaption></figure>",
                STANDARD.encode(&picture.png)
            );
        }
        page.push_str("</div>\n");
    }
    for table in section.tables.iter().filter(|table| table.shown) {
        write_table(page, table);
    }
}

fn write_table(page: &mut String, table: &Table) {
    page.push_str("<div class=\"scroll\"><table>\n<tr>");
    for column in &table.columns {
        let _ = write!(page, "<th>{}</th>", escape(&column.replace('_', " ")));
    }
    page.push_str("</tr>\n");
    for row in table.rows.iter().take(ROWS) {
        page.push_str("<tr>");
        for value in row {
            let _ = write!(page, "<td>{}</td>", shown(*value));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</table></div>\n");
    if table.rows.len() > ROWS {
        let left = table.rows.len() - ROWS;
        let _ = writeln!(page, "<p class=\"note\">{left} more rows are in the files.</p>");
    }
}

/// Returns a number with about six digits.
fn shown(value: f64) -> String {
    if value.is_nan() {
        return String::new();
    }
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if value == value.round() && value.abs() < 1e6 {
        return format!("{:.0}", value + 0.0);
    }
    // Below is rounding.
    if value.abs() < 1e-11 {
        return "0".to_owned();
    }
    if value.abs() < 1e-4 || value.abs() >= 1e7 {
        return format!("{value:.4e}");
    }
    let digits = (5 - value.abs().log10().floor() as i32).clamp(0, 7) as usize;
    format!("{value:.digits$}")
}
