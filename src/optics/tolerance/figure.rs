//! Figures of merit of a lens: spot radius and MTF at some fields.

use std::f64::consts::TAU;

use crate::imaging::frozen_imaging::FieldSpot;
use crate::imaging::spot::SpotDiagram;

/// Adjustment of the film of each lens that is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refocus {
    /// It stays at its distance behind the rear vertex.
    Off,
    /// It moves to the smallest spot of the field nearest to the axis.
    Axis,
    /// It moves to the smallest mean square radius of the spots of all fields.
    Fields,
}

/// Figures of merit.
#[derive(Clone, Debug, PartialEq)]
pub struct LensFigures {
    /// Root mean square spot radius of each field (mm), infinite without light.
    pub spots: Vec<f64>,
    /// Geometric modulation of each field, along x and along y.
    pub modulations: Vec<[f64; 2]>,
    /// Movement of the film, away from the lens (mm).
    pub defocus: f64,
}

impl LensFigures {
    /// Returns the figures of the spots of all fields.
    pub(super) fn new(
        fields: &[f64],
        spots: &[FieldSpot],
        refocus: Refocus,
        frequency: f64,
    ) -> Self {
        let defocus = best_defocus(fields, spots, refocus);
        let radius = |spot: &FieldSpot| {
            spot.diagram.size(defocus, None).map_or(f64::INFINITY, |size| size.rms)
        };
        let modulation = |spot: &FieldSpot| {
            [0, 1].map(|axis| geometric_modulation(&spot.diagram, frequency, axis, defocus))
        };
        Self {
            spots: spots.iter().map(radius).collect(),
            modulations: spots.iter().map(modulation).collect(),
            defocus,
        }
    }

    /// Returns the figures of a lens that forms no image.
    pub(super) fn dark(fields: usize) -> Self {
        Self {
            spots: vec![f64::INFINITY; fields],
            modulations: vec![[0.0; 2]; fields],
            defocus: 0.0,
        }
    }

    /// Returns the root mean square spot radius of all fields together (mm).
    pub fn spot(&self) -> f64 {
        let squares: f64 = self.spots.iter().map(|spot| spot * spot).sum();
        (squares / self.spots.len() as f64).sqrt()
    }

    /// Returns the lowest modulation of all fields and directions.
    pub fn modulation(&self) -> f64 {
        self.modulations.iter().flatten().copied().fold(f64::INFINITY, f64::min)
    }
}

/// Returns the movement of the film to the best focus (mm).
pub(crate) fn best_defocus(fields: &[f64], spots: &[FieldSpot], refocus: Refocus) -> f64 {
    let moments = |spot: &FieldSpot| spot.diagram.focus_moments();
    let sum = match refocus {
        Refocus::Off => return 0.0,
        Refocus::Axis => {
            let nearest =
                (0..fields.len()).min_by(|&a, &b| fields[a].abs().total_cmp(&fields[b].abs()));
            nearest.map_or([0.0; 2], |i| moments(&spots[i]))
        }
        Refocus::Fields => {
            spots.iter().map(moments).fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
        }
    };
    let defocus = -sum[0] / sum[1];
    if defocus.is_finite() { defocus } else { 0.0 }
}

/// Returns the size of the Fourier transform of a spot at a frequency (cycles / mm) along x (0) or
/// y (1), relative to that of a point.
fn geometric_modulation(spot: &SpotDiagram, frequency: f64, axis: usize, defocus: f64) -> f64 {
    let (mut sum, mut light) = ([0.0; 2], 0.0);
    for ray in &spot.rays {
        let at = ray.point[axis] + defocus * ray.slope[axis];
        let (sin, cos) = (TAU * frequency * at).sin_cos();
        sum = [sum[0] + ray.light * cos, sum[1] + ray.light * sin];
        light += ray.light;
    }
    if light > 0.0 { sum[0].hypot(sum[1]) / light } else { 0.0 }
}
