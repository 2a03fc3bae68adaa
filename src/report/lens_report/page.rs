//! The report as one HTML page without scripts or other files.
//!
//! The page is well-formed XML, so that tests and tools can read it.

use std::fmt::Write as _;

use super::files::PageText;
use super::heading::{heading, in_words};
use super::inputs::ReportInputs;
use super::section::{ReportSection, Table, WAVELENGTH_COLUMN};
use crate::lens_drawing::draw;
use crate::number::rounded;
use crate::page::{begin, end};
use crate::plot::Plot;
use crate::svg::escape;

/// Most rows of a table on the page.
const ROWS: usize = 60;

/// Returns the page.
pub(super) fn page(inputs: &ReportInputs, sections: &[ReportSection], text: &PageText) -> String {
    let name = escape(&inputs.lens.name);
    let mut page = begin(&format!("Lens report: {}", inputs.lens.name));
    let _ = writeln!(page, "<h1>{name}</h1>");
    if let Some(source) = &inputs.lens.source {
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escape(source));
    }
    let _ = writeln!(page, "<p>{}</p>", escape(&conditions(inputs)));
    for note in &text.notes {
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
        write_section(&mut page, section, inputs);
    }
    end(&mut page, &text.command);
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
        "Real rays: {object}; film {} mm behind the rear vertex; fields up to {}; {}.",
        shown(conditions.film_distance),
        inputs.field_title(conditions.largest_field),
        lines.join(", ")
    )
}

fn write_section(page: &mut String, section: &ReportSection, inputs: &ReportInputs) {
    let _ = writeln!(page, "<h2 id=\"{}\">{}</h2>", section.name, escape(section.title));
    if !section.note.is_empty() {
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escape(&section.note));
    }
    for (text, _) in section.missing.iter().filter(|(_, usual)| !usual) {
        let _ = writeln!(page, "<p class=\"note\">Missing: {}</p>", escape(&in_words(text)));
    }
    if section.name == "prescription" {
        write_prescription(page, inputs);
    }
    if !section.figures.is_empty() {
        page.push_str("<table>\n");
        for (name, value, unit) in &section.figures {
            let (name, unit) = (heading(name), unit.replace("um", "µm").replace("deg", "°"));
            let value = shown(*value);
            let _ = writeln!(page, "<tr><td>{}</td><td>{value} {unit}</td></tr>", escape(&name));
        }
        page.push_str("</table>\n");
    }
    if !section.plots.is_empty() || !section.pictures.is_empty() {
        let narrow = section.plots.iter().all(|plot| plot.square);
        let _ = writeln!(page, "<div class=\"plots{}\">", if narrow { " square" } else { "" });
        for plot in &section.plots {
            let class = match plot {
                Plot { square: true, .. } => " class=\"narrow\"",
                Plot { broad: true, .. } => " class=\"broad\"",
                _ => "",
            };
            let _ = writeln!(page, "<figure{class}>{}</figure>", plot.inline());
        }
        for (i, picture) in section.pictures.iter().enumerate() {
            let caption = escape(&picture.caption);
            let drawing = picture.inline(&format!("{}-colours-{i}", section.name));
            let _ = writeln!(page, "<figure><figcaption>{caption}</figcaption>{drawing}</figure>");
        }
        page.push_str("</div>\n");
    }
    for table in section.tables.iter().filter(|table| table.shown) {
        write_table(page, table);
    }
}

/// Writes the surfaces as a lens designer reads them: with glasses, and with the stop marked.
fn write_prescription(page: &mut String, inputs: &ReportInputs) {
    let lens = &inputs.lens;
    page.push_str(
        "<table>\n<tr><th>surface</th><th>radius (mm)</th><th>thickness (mm)</th><th class=\"words\">glass</th>\
         <th>n</th><th>Abbe number</th><th>semi-diameter (mm)</th><th class=\"words\">shape</th></tr>\n",
    );
    for (i, row) in lens.rows.iter().enumerate() {
        let class = if row.stop { " class=\"stop\"" } else { "" };
        let stop = if row.stop { " stop" } else { "" };
        let last = i + 1 == lens.rows.len();
        let thickness = if last { "to film".to_owned() } else { shown(row.thickness) };
        let glass = if row.mirror { "mirror" } else { row.glass.name().unwrap_or_default() };
        let in_air = row.index == 1.0 && row.glass.name().is_none();
        let index = if in_air { String::new() } else { shown(row.index) };
        let abbe = row.glass.abbe_number().map_or_else(String::new, |vd| format!("{vd:.2}"));
        let shape = row.shape_lines().join(", ");
        let _ = writeln!(
            page,
            "<tr{class}><td>{}{stop}</td><td>{}</td><td>{thickness}</td><td class=\"words\">{}</td>\
             <td>{index}</td><td>{abbe}</td><td>{}</td><td class=\"words\">{}</td></tr>",
            i + 1,
            shown(row.radius),
            escape(glass),
            shown(row.diameter / 2.0),
            escape(&shape)
        );
    }
    page.push_str("</table>\n");
}

fn write_table(page: &mut String, table: &Table) {
    page.push_str("<table>\n<tr>");
    for column in &table.columns {
        let _ = write!(page, "<th>{}</th>", escape(&heading(column)));
    }
    page.push_str("</tr>\n");
    let by_surface = table.columns.first().is_some_and(|column| column == "surface");
    for row in table.rows.iter().take(ROWS) {
        let sum = by_surface && row[0].is_nan();
        page.push_str(if sum { "<tr class=\"sum\">" } else { "<tr>" });
        for (i, value) in row.iter().enumerate() {
            let cell = match table.columns[i] == WAVELENGTH_COLUMN && value.is_nan() {
                _ if sum && i == 0 => "sum".to_owned(),
                true => "all".to_owned(),
                false => shown(*value),
            };
            let _ = write!(page, "<td>{cell}</td>");
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</table>\n");
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
    let text = format!("{value:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}
