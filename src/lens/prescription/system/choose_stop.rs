//! Choice of the stop in tables that mark it only by its shape.

use super::{MediumBehind, SystemSurface};

/// Makes the plane with air on both sides the stop: of several the smallest. Nothing changes if
/// there is none.
pub fn choose_stop(surfaces: &mut [SystemSurface]) {
    let is_air =
        |i: Option<usize>| i.is_none_or(|i| matches!(surfaces[i].medium, MediumBehind::Air));
    let size = |i: usize| surfaces[i].semi_diameter.unwrap_or(f64::INFINITY);
    let stop = (0..surfaces.len())
        .filter(|&i| surfaces[i].row.is_plane() && is_air(Some(i)) && is_air(i.checked_sub(1)))
        .min_by(|&i, &j| size(i).total_cmp(&size(j)));
    if let Some(stop) = stop {
        surfaces[stop].row.stop = true;
    }
}
