//! Ghosts on the axis by first-order optics: where each pair of reflections focuses.

use super::image_quality::ImageQuality;
use crate::lens::prescription::Prescription;

/// The ghost of a point on the axis by two reflections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GhostFocus {
    /// Rows that reflect: that nearer to the film first, as the light meets them (from 0).
    pub rows: [usize; 2],
    /// Position of the ghost's focus behind the film (mm), infinite if there is none.
    pub focus: f64,
    /// Radius of the ghost on the film (mm).
    pub radius: f64,
    /// Share of the light of the point that reaches the film in the ghost, by both reflectances at
    /// normal incidence and the rims.
    pub share: f64,
}

impl GhostFocus {
    /// Returns the irradiance of the ghost: share of the point's light per mm^2 of film.
    pub fn irradiance(&self) -> f64 {
        self.share / (std::f64::consts::PI * self.radius * self.radius)
    }
}

impl ImageQuality {
    /// Returns the ghosts of the axis point at the primary wavelength, the brightest first; none
    /// for a lens with mirrors. The lens is the one at that wavelength.
    pub fn ghost_foci(&self, lens: &Prescription) -> Vec<GhostFocus> {
        if lens.has_mirrors() {
            return Vec::new();
        }
        let reflects = |row: &usize| lens.transmittance(*row) < 1.0;
        let rows: Vec<usize> = (0..lens.rows.len()).filter(reflects).collect();
        let mut ghosts: Vec<GhostFocus> = rows
            .iter()
            .flat_map(|&second| {
                let first = rows.iter().filter(move |first| **first < second);
                first.map(move |&first| self.ghost_focus(lens, [second, first]))
            })
            .collect();
        ghosts.sort_by(|a, b| b.irradiance().total_cmp(&a.irradiance()));
        ghosts
    }

    fn ghost_focus(&self, lens: &Prescription, rows: [usize; 2]) -> GhostFocus {
        let pupil = self.primary().paraxial.entrance_pupil;
        let object = self.conditions.object_distance;
        let (mut y, mut u) = match object.is_finite() {
            true => {
                let slope = pupil.diameter / 2.0 / (object + pupil.position);
                (slope * object, slope)
            }
            false => (pupil.diameter / 2.0, 0.0),
        };
        let radii: Vec<f64> = lens.rows.iter().map(|row| row.diameter / 2.0).collect();
        let mut open = 1.0_f64;
        // Signed indices: negative while the light travels to the scene.
        let mut cross = |row: usize, n: f64, after: f64, y: f64, u: f64| {
            open = open.min(radii[row] / y.abs());
            (n * u - y * lens.rows[row].curvature() * (after - n)) / after
        };
        let index = |row: usize| lens.indices(row);
        let [second, first] = rows;
        for row in 0..second {
            let [n, after] = index(row);
            u = cross(row, n, after, y, u);
            y += lens.rows[row].thickness * u;
        }
        let n = index(second)[0];
        u = cross(second, n, -n, y, u);
        for row in (first + 1..second).rev() {
            y -= lens.rows[row].thickness * u;
            let [before, behind] = index(row);
            u = cross(row, -behind, -before, y, u);
        }
        y -= lens.rows[first].thickness * u;
        let n = index(first)[1];
        u = cross(first, -n, n, y, u);
        for row in first + 1..lens.rows.len() {
            y += lens.rows[row - 1].thickness * u;
            let [n, after] = index(row);
            u = cross(row, n, after, y, u);
        }
        let film = self.conditions.film_distance;
        let at_film = y + film * u;
        let reflectance: f64 = rows.iter().map(|row| 1.0 - lens.transmittance(*row)).product();
        GhostFocus {
            rows,
            focus: -y / u - film,
            radius: (open * at_film).abs(),
            share: reflectance * open * open,
        }
    }
}
