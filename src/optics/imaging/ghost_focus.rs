//! Ghosts on the axis by first-order optics: where each pair of reflections focuses.

use super::image_quality::ImageQuality;
use petzval_lens::Prescription;

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

/// Most reflecting surfaces of which all pairs are computed: a hundred thousand pairs, each with a ray
/// through the whole lens.
pub const MOST_GHOST_SURFACES: usize = 512;

/// A marginal ray by first-order optics on its way through a lens, and the narrowest rim so far.
#[derive(Clone, Copy)]
struct GhostRay {
    y: f64,
    u: f64,
    /// Least ratio of a rim to the height of the ray there, at most 1.
    open: f64,
}

/// The lens of ghosts, as their rays need it.
struct GhostLens<'a> {
    lens: &'a Prescription,
    /// Radius of the rim (mm) and curvature (1/mm) of each row.
    rims: Vec<[f64; 2]>,
    film_distance: f64,
}

impl GhostLens<'_> {
    /// Crosses a row from one index to another: negative while the light travels to the scene.
    fn cross(&self, ray: &mut GhostRay, row: usize, [n, after]: [f64; 2]) {
        let [rim, curvature] = self.rims[row];
        ray.open = ray.open.min(rim / ray.y.abs());
        ray.u = (n * ray.u - ray.y * curvature * (after - n)) / after;
    }

    /// Returns the ghosts by the reflections at a row and at each of these before it, given the ray
    /// before that row.
    fn with_second(&self, mut ray: GhostRay, second: usize, firsts: &[usize]) -> Vec<GhostFocus> {
        let (lens, mut ghosts) = (self.lens, Vec::with_capacity(firsts.len()));
        let n = lens.indices(second)[0];
        self.cross(&mut ray, second, [n, -n]);
        let mut row = second;
        for &first in firsts.iter().rev() {
            while row > first + 1 {
                row -= 1;
                ray.y -= lens.rows[row].thickness * ray.u;
                let [before, behind] = lens.indices(row);
                self.cross(&mut ray, row, [-behind, -before]);
            }
            let mut reflected = ray;
            reflected.y -= lens.rows[first].thickness * ray.u;
            let n = lens.indices(first)[1];
            self.cross(&mut reflected, first, [-n, n]);
            ghosts.push(self.at_film(reflected, [second, first]));
        }
        ghosts.reverse();
        ghosts
    }

    /// Follows a ray from its second reflection to the film.
    fn at_film(&self, mut ray: GhostRay, rows: [usize; 2]) -> GhostFocus {
        let lens = self.lens;
        for row in rows[1] + 1..lens.rows.len() {
            ray.y += lens.rows[row - 1].thickness * ray.u;
            self.cross(&mut ray, row, lens.indices(row));
        }
        let GhostRay { y, u, open } = ray;
        let reflectance: f64 = rows.iter().map(|row| 1.0 - lens.transmittance(*row)).product();
        GhostFocus {
            rows,
            focus: -y / u - self.film_distance,
            radius: (open * (y + self.film_distance * u)).abs(),
            share: reflectance * open * open,
        }
    }
}

impl ImageQuality {
    /// Returns the ghosts of the axis point at the primary wavelength, the brightest first; none
    /// for a lens with mirrors, and `None` for one of more than [`MOST_GHOST_SURFACES`] surfaces that
    /// reflect. The lens is the one at that wavelength.
    pub fn ghost_foci(&self, lens: &Prescription) -> Option<Vec<GhostFocus>> {
        if lens.has_mirrors() {
            return Some(Vec::new());
        }
        let reflects = |row: &usize| lens.transmittance(*row) < 1.0;
        let rows: Vec<usize> = (0..lens.rows.len()).filter(reflects).collect();
        if rows.len() > MOST_GHOST_SURFACES {
            return None;
        }
        let ghost_lens = GhostLens {
            lens,
            rims: lens.rows.iter().map(|row| [row.diameter / 2.0, row.curvature()]).collect(),
            film_distance: self.conditions.film_distance,
        };
        let mut ray = self.axis_ray();
        let (mut ghosts, mut crossed) = (Vec::new(), 0);
        for (i, &second) in rows.iter().enumerate() {
            for row in crossed..second {
                ghost_lens.cross(&mut ray, row, lens.indices(row));
                ray.y += lens.rows[row].thickness * ray.u;
            }
            crossed = second;
            ghosts.extend(ghost_lens.with_second(ray, second, &rows[..i]));
        }
        ghosts.sort_by(|a: &GhostFocus, b| b.irradiance().total_cmp(&a.irradiance()));
        Some(ghosts)
    }

    /// Returns the marginal ray of the axis point at the front vertex.
    fn axis_ray(&self) -> GhostRay {
        let pupil = self.primary().paraxial.entrance_pupil;
        let object = self.conditions.object_distance;
        let (y, u) = match object.is_finite() {
            true => {
                let slope = pupil.diameter / 2.0 / (object + pupil.position);
                (slope * object, slope)
            }
            false => (pupil.diameter / 2.0, 0.0),
        };
        GhostRay { y, u, open: 1.0 }
    }
}
