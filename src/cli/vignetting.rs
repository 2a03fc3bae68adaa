//! `petzval lens --vignetting`

use std::fmt::Write as _;

use petzval::lens::{Ledger, Of, Prescription, Vignetting};

use super::Failure;

/// Field zones, the middle of the film not counted.
const ZONES: u32 = 10;
/// Rays for a field zone.
const RAYS: u32 = 1 << 18;
/// A surface that takes less than this everywhere has no column.
const LEAST: f64 = 5e-4;
/// How many surfaces have a column, so that the table fits a terminal of 80.
const COLUMNS: usize = 7;

/// A line of the table.
struct Zone {
    height: f64,
    angle: Option<f64>,
    ledger: Option<Ledger>,
}

/// The table for a film of this diagonal, mm, at a distance behind the rear vertex.
pub(super) fn table(lens: &Prescription, distance: f64, diagonal: f64) -> Result<String, Failure> {
    let rim = lens.rear().sag(lens.rear().diameter / 2.0).max(0.0);
    if distance <= rim {
        return Err(format!(
            "the film, {distance:.4} mm behind the rear vertex, would stand inside the lens, which \
             reaches {rim:.4} mm behind it"
        )
        .into());
    }
    let vignetting = Vignetting::new(lens, distance, RAYS);
    let zone = |height: f64| Zone {
        height,
        angle: vignetting.field_angle(height),
        ledger: vignetting.ledger([height, 0.0], Of::Stop),
    };
    let half = diagonal / 2.0;
    let zones: Vec<Zone> =
        (0..=ZONES).map(|i| zone(half * f64::from(i) / f64::from(ZONES))).collect();
    let mut text = heading(lens, distance, diagonal);
    body(lens, &zones, vignetting.end(half), &mut text);
    Ok(text)
}

/// What the numbers mean.
fn heading(lens: &Prescription, distance: f64, diagonal: f64) -> String {
    let (stop, last) = (lens.stop() + 1, lens.rows.len());
    let along = match lens.is_round() {
        true => "",
        false => "The lens is not round: this is along its x axis.\n",
    };
    format!(
        "{}\n\
         vignetting on a film of {diagonal} mm diagonal, {distance:.4} mm behind the rear vertex\n\
         {along}\n\
         All light that would pass the stop, surface {stop}, if all other rims were open is\n\
         100 %. \"pass\" is what leaves the lens. The rest ends at the rims of the surfaces\n\
         under their numbers, a ray counting at the first that it misses on its way from\n\
         the film, from surface {last} to 1. \"light\" is the illumination, of that of the\n\
         middle of the film; \"cos^4\" is what the field angle alone would leave of it. The\n\
         field angle is that of the ray through the middle of the stop.\n\n",
        lens.name
    )
}

fn body(lens: &Prescription, zones: &[Zone], end: Option<f64>, text: &mut String) {
    let lost = |zone: &Zone, row: usize| {
        zone.ledger.as_ref().map_or(0.0, |ledger| ledger.rows[row].share())
    };
    let most = |row: usize| zones.iter().map(|zone| lost(zone, row)).fold(0.0, f64::max);
    let taking: Vec<usize> = (0..lens.rows.len()).filter(|&row| most(row) > 0.0).collect();
    let mut shown: Vec<usize> = taking.iter().copied().filter(|&row| most(row) > LEAST).collect();
    shown.sort_by(|&a, &b| most(b).total_cmp(&most(a)));
    shown.truncate(COLUMNS);
    shown.sort_unstable();
    let others: Vec<usize> = taking.into_iter().filter(|row| !shown.contains(row)).collect();

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

    let irradiance = |zone: &Zone| zone.ledger.as_ref().map_or(0.0, |ledger| ledger.irradiance);
    let centre = irradiance(&zones[0]);
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let mut end = end;
    for zone in zones {
        if let Some(radius) = end.take_if(|radius| *radius < zone.height) {
            line(&[format!("{radius:.2}"), "  the light ends here".to_owned()]);
        }
        let mut cells = vec![format!("{:.2}", zone.height)];
        cells.push(zone.angle.map_or_else(none, |angle| format!("{angle:.1}")));
        cells.push(if centre > 0.0 { percent(irradiance(zone) / centre) } else { none() });
        let seen = zone.angle.filter(|angle| *angle < 90.0);
        cells.push(seen.map_or_else(none, |angle| percent(angle.to_radians().cos().powi(4))));
        match &zone.ledger {
            // The stop is not to be seen from here, whatever the rims.
            None => cells.resize_with(names.len(), none),
            Some(ledger) => {
                cells.push(percent(ledger.pass));
                cells.extend(shown.iter().map(|&row| percent(lost(zone, row))));
                if !others.is_empty() {
                    cells.push(percent(others.iter().map(|&row| lost(zone, row)).sum()));
                }
            }
        }
        line(&cells);
    }
}

fn none() -> String {
    "-".to_owned()
}
