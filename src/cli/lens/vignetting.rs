//! `petzval lens --vignetting`: table of relative illumination, and of the light that surfaces
//! block.

use std::fmt::Write as _;

use petzval_lens::{LightBudget, Normalization, Prescription, Vignetting};

use crate::cli::Failure;
use crate::cli::progress::StepBar;

/// Number of field zones besides the middle of the film.
const ZONES: u32 = 10;
/// Rays per field zone, which give shares to 0.03 %.
const RAYS: u32 = 1 << 18;
/// Least number of rays per field zone, for lenses of very many surfaces: they give shares to 0.3 %.
const FEWEST_RAYS: u32 = 1 << 14;
/// Crossings of surfaces per field zone from which on fewer rays are traced.
const CROSSINGS: u32 = 1 << 27;
/// A surface that blocks less than this share everywhere has no column.
const MIN_SHARE: f64 = 5e-4;
/// Most surfaces with a column, so that the table fits into 80 columns.
const MAX_COLUMNS: usize = 7;

/// A line of the table: the light at one height on the film.
struct Zone {
    height: f64,
    angle: Option<f64>,
    budget: Option<LightBudget>,
}

/// Returns the table for a film with this diagonal, `distance` behind the rear vertex (mm).
///
/// # Errors
/// Returns an error if the film would stand inside the lens.
pub(super) fn table(
    lens: &Prescription,
    distance: f64,
    diagonal: f64,
    bar: &StepBar,
) -> Result<String, Failure> {
    let rim = lens.rear_reach();
    if distance <= rim {
        return Err(format!(
            "the film, {distance:.4} mm behind the rear vertex, would stand inside the lens, which \
             reaches {rim:.4} mm behind it"
        )
        .into());
    }
    let rays = rays(lens.rows.len());
    let vignetting = Vignetting::new(lens, distance, rays);
    let zone = |height: f64| {
        let angle = vignetting.field_angle(height);
        let budget = vignetting.budget([height, 0.0], Normalization::Stop);
        bar.advance();
        Zone { height, angle, budget }
    };
    bar.begin("vignetting: end of the light", 0);
    let half = diagonal / 2.0;
    // Beyond the end of the light there is nothing to tell.
    let end = vignetting.light_radius(half);
    let reach = end.unwrap_or(half);
    let zones: Vec<u32> = (0..=ZONES).filter(|&i| i == 0 || i < ZONES || end.is_none()).collect();
    bar.begin("vignetting: heights on the film", zones.len());
    let zones: Vec<Zone> =
        zones.into_iter().map(|i| zone(reach * f64::from(i) / f64::from(ZONES))).collect();
    let mut text = heading(lens, distance, diagonal, rays);
    body(lens, &zones, end, &mut text);
    Ok(text)
}

/// Returns the number of rays per field zone for a lens of so many surfaces. With a quarter of the
/// rays the error grows less than threefold.
fn rays(surfaces: usize) -> u32 {
    let surfaces = u32::try_from(surfaces.max(1)).unwrap_or(u32::MAX);
    1 << (CROSSINGS / surfaces).clamp(FEWEST_RAYS, RAYS).ilog2()
}

/// Explains the numbers.
fn heading(lens: &Prescription, distance: f64, diagonal: f64, rays: u32) -> String {
    let (stop, last) = (lens.stop() + 1, lens.rows.len());
    let along = match lens.is_round() {
        true => "",
        false => "The lens is not rotationally symmetric: this is along its x axis.\n",
    };
    let error = match rays < RAYS {
        true => format!(
            "The lens has {last} surfaces: {rays} rays for each height give the shares to\n\
             about {} %.\n",
            if rays <= FEWEST_RAYS { "0.3" } else { "0.1" }
        ),
        false => String::new(),
    };
    format!(
        "{}\n\
         vignetting on a film of {diagonal} mm diagonal, {distance:.4} mm behind the rear vertex\n\
         {along}\n\
         100 % is the light that would pass the stop, surface {stop}, with all other rims\n\
         open. \"pass\" is the share that leaves the lens. The rest is blocked at the\n\
         surfaces under their numbers; a ray counts at the first that blocks it on its\n\
         way from the film, from surface {last} to 1. \"light\" is the illumination relative\n\
         to the middle of the film; \"cos^4\" is what the field angle alone would leave.\n\
         The field angle is that of the chief ray, or of the ray in the middle of the\n\
         light where rims leave no chief ray.\n{error}\n",
        lens.name
    )
}

fn body(lens: &Prescription, zones: &[Zone], end: Option<f64>, text: &mut String) {
    let lost = |zone: &Zone, row: usize| {
        zone.budget.as_ref().map_or(0.0, |budget| budget.rows[row].share())
    };
    let most = |row: usize| zones.iter().map(|zone| lost(zone, row)).fold(0.0, f64::max);
    let blocking: Vec<usize> = (0..lens.rows.len()).filter(|&row| most(row) > 0.0).collect();
    let mut shown: Vec<usize> =
        blocking.iter().copied().filter(|&row| most(row) > MIN_SHARE).collect();
    shown.sort_by(|&a, &b| most(b).total_cmp(&most(a)));
    shown.truncate(MAX_COLUMNS);
    shown.sort_unstable();
    let others: Vec<usize> = blocking.into_iter().filter(|row| !shown.contains(row)).collect();

    let mut line = |cells: &[String]| {
        let [height, rest @ ..] = cells else { return };
        let _ = write!(text, "{height:>7}");
        rest.iter().for_each(|cell| {
            let _ = write!(text, "{cell:>6}");
        });
        text.push('\n');
    };
    let mut names = ["height", "field", "light", "cos^4", "pass"].map(str::to_owned).to_vec();
    names.extend(shown.iter().map(|row| format!("{}", row + 1)));
    names.extend((!others.is_empty()).then(|| "other".to_owned()));
    let mut units = vec!["%".to_owned(); names.len()];
    ["mm", "deg"].iter().zip(&mut units).for_each(|(unit, cell)| (*unit).clone_into(cell));
    line(&names);
    line(&units);

    let irradiance = |zone: &Zone| zone.budget.as_ref().map_or(0.0, |budget| budget.irradiance);
    let centre = irradiance(&zones[0]);
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    for zone in zones {
        let mut cells = vec![format!("{:.2}", zone.height)];
        cells.push(zone.angle.map_or_else(none, |angle| format!("{angle:.1}")));
        cells.push(if centre > 0.0 { percent(irradiance(zone) / centre) } else { none() });
        let seen = zone.angle.filter(|angle| *angle < 90.0);
        cells.push(seen.map_or_else(none, |angle| percent(angle.to_radians().cos().powi(4))));
        match &zone.budget {
            // The stop is invisible from here, even without other rims.
            None => cells.resize_with(names.len(), none),
            Some(budget) => {
                cells.push(percent(budget.pass));
                cells.extend(shown.iter().map(|&row| percent(lost(zone, row))));
                if !others.is_empty() {
                    cells.push(percent(others.iter().map(|&row| lost(zone, row)).sum()));
                }
            }
        }
        line(&cells);
    }
    if let Some(radius) = end {
        line(&[format!("{radius:.2}"), "  the light ends here".to_owned()]);
    }
}

fn none() -> String {
    "-".to_owned()
}
