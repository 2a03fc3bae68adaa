//! Spot diagrams.

use super::image_quality::FieldRays;
use super::pupil_grid::PupilGrid;

/// A ray of a spot diagram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotRay {
    /// Point on the film relative to the reference point (mm).
    pub point: [f64; 2],
    /// Slopes of the ray, dx/dz and dy/dz.
    pub slope: [f64; 2],
    /// Standard deviation of the points of the ray's cell of the pupil: of x and of y, each by T_x
    /// and by T_y (mm).
    pub(super) within: [[f64; 2]; 2],
    /// Standard deviation of the slopes of the cell.
    pub(super) slope_within: f64,
    /// Light of the ray: share of the light of all wavelengths.
    pub light: f64,
    /// Index of the wavelength.
    pub wavelength: usize,
}

/// Spot diagram of a field point, in all wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub struct SpotDiagram {
    /// The rays; their light sums to 1.
    pub rays: Vec<SpotRay>,
}

/// Size of a spot (mm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotSize {
    /// Centroid relative to the reference point.
    pub centroid: [f64; 2],
    /// Root mean square distance from the centroid.
    pub rms: f64,
    /// Root mean square distance from the centroid along x and y.
    pub rms_across: [f64; 2],
    /// Largest distance from the centroid.
    pub largest: f64,
}

impl FieldRays {
    /// Returns the spot diagram. Rays carry the light that enters the lens, each wavelength by its
    /// weight.
    pub fn spot(&self) -> SpotDiagram {
        let whole: f64 = self.open_grids().map(PupilGrid::light_of_all).sum();
        let mut rays = Vec::new();
        for (wavelength, grid) in self.grids.iter().enumerate() {
            let Some(grid) = grid else { continue };
            for (i, cell) in grid.open() {
                let t = grid.direction(i);
                // An even distribution over a square has the variance step^2 / 12.
                let deviation = grid.step * (cell.share / 12.0).sqrt();
                rays.push(SpotRay {
                    within: grid.point_gradient(i).map(|row| row.map(|g| g * deviation)),
                    slope_within: deviation / cell.t_z,
                    point: [0, 1].map(|i| cell.point[i] - self.reference.point[i]),
                    slope: t.map(|t| t / cell.t_z),
                    light: grid.weight * grid.step * grid.step * PupilGrid::light(cell) / whole,
                    wavelength,
                });
            }
        }
        SpotDiagram { rays }
    }
}

impl PupilGrid {
    /// Returns the gradient of the point on the film, x and y by T_x and T_y (mm), between the
    /// whole cells next to a cell; 0 where there are none.
    fn point_gradient(&self, i: usize) -> [[f64; 2]; 2] {
        let whole = |j: usize| self.cells.get(j)?.as_ref().filter(|cell| cell.share == 1.0);
        let along = |stride: usize| -> [f64; 2] {
            // Central, or to the side on which cells are whole.
            let pairs = [
                (i.wrapping_sub(stride), i + stride),
                (i, i + stride),
                (i.wrapping_sub(stride), i),
            ];
            let farther = [
                (i + stride, i + 2 * stride),
                (i.wrapping_sub(2 * stride), i.wrapping_sub(stride)),
            ];
            pairs
                .into_iter()
                .chain(farther)
                .find_map(|(from, to)| {
                    let (a, b) = (whole(from)?, whole(to)?);
                    let distance = self.step * (to - from) as f64 / stride as f64;
                    Some([0, 1].map(|k| (b.point[k] - a.point[k]) / distance))
                })
                .unwrap_or_default()
        };
        let [by_x, by_y] = [along(1), along(self.side)];
        [[by_x[0], by_y[0]], [by_x[1], by_y[1]]]
    }

    /// Returns the light of all cells, by the weight of the wavelength.
    pub(super) fn light_of_all(&self) -> f64 {
        let cells: f64 = self.open().map(|(_, cell)| Self::light(cell)).sum();
        self.weight * self.step * self.step * cells
    }

    /// Returns the radius of the Airy disc of a round pupil of the same area (mm): 0.61 wavelengths
    /// over the numerical aperture.
    pub fn airy_radius(&self) -> f64 {
        0.609_835 * self.nm * 1e-6 / (self.area() / std::f64::consts::PI).sqrt()
    }

    /// Returns the working f-number of a round pupil of the same area, 1 / (2 NA).
    pub fn working_f_number(&self) -> f64 {
        0.5 / (self.area() / std::f64::consts::PI).sqrt()
    }
}

impl SpotDiagram {
    /// Returns the size of the spot on a film that is moved back by `defocus` (mm), for one
    /// wavelength or all; `None` without rays.
    pub fn size(&self, defocus: f64, wavelength: Option<usize>) -> Option<SpotSize> {
        let rays = || {
            let of = |ray: &&SpotRay| wavelength.is_none_or(|w| w == ray.wavelength);
            let at = move |ray: &SpotRay| [0, 1].map(|i| ray.point[i] + defocus * ray.slope[i]);
            self.rays.iter().filter(of).map(move |ray| (at(ray), ray.light))
        };
        let light: f64 = rays().map(|(_, light)| light).sum();
        if light <= 0.0 {
            return None;
        }
        let mean = |of: &dyn Fn([f64; 2]) -> f64| {
            rays().map(|(p, light)| light * of(p)).sum::<f64>() / light
        };
        let centroid = [mean(&|p| p[0]), mean(&|p| p[1])];
        let square = |i: usize| mean(&|p: [f64; 2]| (p[i] - centroid[i]) * (p[i] - centroid[i]));
        let within = |i: usize| {
            let variance = |ray: &SpotRay| {
                let own = ray.within[i][i] + defocus * ray.slope_within;
                own * own + ray.within[i][1 - i] * ray.within[i][1 - i]
            };
            let of = |ray: &&SpotRay| wavelength.is_none_or(|w| w == ray.wavelength);
            self.rays.iter().filter(of).map(|ray| ray.light * variance(ray)).sum::<f64>() / light
        };
        let squares = [0, 1].map(|i| square(i) + within(i));
        let largest =
            rays().map(|(p, _)| (p[0] - centroid[0]).hypot(p[1] - centroid[1])).fold(0.0, f64::max);
        Some(SpotSize {
            centroid,
            rms: (squares[0] + squares[1]).sqrt(),
            rms_across: squares.map(f64::sqrt),
            largest,
        })
    }

    /// Returns the defocus (mm) at which the spot is smallest; `None` without light, or if all rays
    /// are parallel.
    pub fn best_defocus(&self) -> Option<f64> {
        let [against, spread] = self.focus_moments();
        (spread > 0.0).then(|| -against / spread)
    }

    /// Returns the covariance of points and slopes and the variance of the slopes: the mean square
    /// radius grows by twice the first times the defocus plus the second times its square.
    pub(crate) fn focus_moments(&self) -> [f64; 2] {
        let mean = |of: &dyn Fn(&SpotRay) -> f64| -> f64 {
            self.rays.iter().map(|ray| ray.light * of(ray)).sum()
        };
        let (mut against, mut spread) = (0.0, 0.0);
        for i in 0..2 {
            let (point, slope) = (mean(&|ray| ray.point[i]), mean(&|ray| ray.slope[i]));
            against += mean(&|ray| (ray.point[i] - point) * (ray.slope[i] - slope));
            spread += mean(&|ray| (ray.slope[i] - slope) * (ray.slope[i] - slope));
        }
        [against, spread]
    }
}
