//! A lens with deviations of its quantities.

use super::grade::FRINGE_WAVELENGTH;
use super::parameter::{ToleranceKind, ToleranceParameter};
use petzval_lens::Prescription;
use petzval_lens::SpectralLine;
use petzval_lens::{Pose, TiltDecenter};
use petzval_spectrum::{D_LINE, Glass};

/// Step of the wavelengths at which a changed glass is written (nm).
const TABLE_STEP: f64 = 5.0;
/// Range of these wavelengths: visible light (nm).
const TABLE_RANGE: [f64; 2] = [380.0, 780.0];

/// Deviations of a medium.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct MediumChange {
    index: f64,
    /// Relative change of the Abbe number.
    abbe: f64,
}

/// A nominal lens with its indices, ready for deviations.
#[derive(Clone, Debug)]
pub(super) struct NominalLens {
    lens: Prescription,
    /// The lens without dispersion: its indices are set.
    bare: Prescription,
    /// Index of each row at the d line, and at each wavelength of the analysis.
    nd: Vec<f64>,
    indices: Vec<Vec<f64>>,
    lines: Vec<SpectralLine>,
}

/// A lens with deviations.
#[derive(Clone, Debug)]
pub(super) struct PerturbedLens<'a> {
    nominal: &'a NominalLens,
    /// The lens with its changed shape, without dispersion.
    shape: Prescription,
    media: Vec<MediumChange>,
}

impl NominalLens {
    pub fn new(lens: &Prescription, lines: &[SpectralLine]) -> Self {
        let at = |nm: f64| -> Vec<f64> {
            lens.rows.iter().map(|row| row.glass.nearest_index(row.index, nm)).collect()
        };
        let mut bare = lens.clone();
        bare.rows.iter_mut().for_each(|row| row.glass = Glass::Constant);
        Self {
            bare,
            nd: at(D_LINE),
            indices: lines.iter().map(|line| at(line.nm)).collect(),
            lines: lines.to_vec(),
            lens: lens.clone(),
        }
    }

    /// Applies deviations, one for each parameter in its unit. A deviation of 0 changes no bit.
    pub fn perturbed(
        &self,
        parameters: &[ToleranceParameter],
        deviations: &[f64],
    ) -> PerturbedLens<'_> {
        let mut shape = self.bare.clone();
        let mut media = vec![MediumChange::default(); shape.rows.len()];
        let mut bodies: Vec<TiltDecenter> = Vec::new();
        for (parameter, &deviation) in parameters.iter().zip(deviations) {
            if deviation == 0.0 {
                continue;
            }
            let [first, last] = parameter.rows;
            let degrees = deviation / 60.0;
            let row = &mut shape.rows[first];
            match parameter.kind {
                ToleranceKind::RadiusPercent => row.radius *= 1.0 + deviation / 100.0,
                ToleranceKind::RadiusFringes => {
                    // Sag c h^2 / 2 changes by half a wavelength a fringe (ISO 10110-5).
                    let half = row.diameter / 2.0;
                    let change = deviation * FRINGE_WAVELENGTH * 1e-6 / (half * half);
                    row.radius = (row.curvature() + change).recip();
                }
                ToleranceKind::Thickness => row.thickness += deviation,
                ToleranceKind::Index => {
                    media[first..=last].iter_mut().for_each(|medium| medium.index = deviation);
                }
                ToleranceKind::Abbe => {
                    let share = deviation / 100.0;
                    media[first..=last].iter_mut().for_each(|medium| medium.abbe = share);
                }
                ToleranceKind::ElementTilt(axis) => {
                    pose(&mut bodies, parameter.rows).tilt[axis] = degrees;
                }
                ToleranceKind::ElementDecentre(axis) => {
                    pose(&mut bodies, parameter.rows).decentre[axis] = deviation;
                }
                ToleranceKind::SurfaceTilt(axis) => row.pose.tilt[axis] += degrees,
            }
        }
        shape.tilt_decenters.extend(bodies);
        PerturbedLens { nominal: self, shape, media }
    }
}

/// Returns the pose of an element, which is appended if it has none.
fn pose(bodies: &mut Vec<TiltDecenter>, rows: [usize; 2]) -> &mut Pose {
    let place = bodies.iter().position(|body| body.rows == rows).unwrap_or(bodies.len());
    if place == bodies.len() {
        bodies.push(TiltDecenter { rows, pose: Pose::ALIGNED });
    }
    &mut bodies[place].pose
}

impl PerturbedLens<'_> {
    /// Returns the lens with its indices at a wavelength of the analysis, by its number.
    pub fn at_wavelength(&self, wavelength: usize) -> Prescription {
        let mut lens = self.shape.clone();
        for (i, row) in lens.rows.iter_mut().enumerate() {
            row.index = self.index(i, self.nominal.indices[wavelength][i]);
        }
        lens
    }

    /// Returns the changed index of a medium, by its nominal one. Its dispersion is scaled, so that
    /// V = (nd - 1) / (nF - nC) becomes the changed Abbe number.
    fn index(&self, row: usize, nominal: f64) -> f64 {
        let MediumChange { index, abbe } = self.media[row];
        if index == 0.0 && abbe == 0.0 {
            return nominal;
        }
        let nd = self.nominal.nd[row];
        let scale = (nd + index - 1.0) / ((nd - 1.0) * (1.0 + abbe));
        nd + index + scale * (nominal - nd)
    }

    /// Returns the lens with its dispersion, for a lens file.
    pub fn prescription(&self) -> Prescription {
        let mut lens = self.shape.clone();
        for (i, row) in lens.rows.iter_mut().enumerate() {
            let nominal = &self.nominal.lens.rows[i];
            let MediumChange { index, abbe } = self.media[i];
            row.glass = nominal.glass.clone();
            if index == 0.0 && abbe == 0.0 {
                continue;
            }
            row.index = self.index(i, self.nominal.nd[i]);
            row.glass = match &nominal.glass {
                Glass::Constant => Glass::Constant,
                Glass::Abbe { nd, vd } => Glass::Abbe { nd: nd + index, vd: vd * (1.0 + abbe) },
                glass => Glass::Table(self.table(i, glass).into()),
            };
        }
        lens
    }

    /// Returns the changed indices of a glass: at the wavelengths of the analysis, the d line and
    /// across the visible range.
    fn table(&self, row: usize, glass: &Glass) -> Vec<[f64; 2]> {
        let [low, high] = glass.usable_range().unwrap_or(TABLE_RANGE);
        let steps = ((TABLE_RANGE[1] - TABLE_RANGE[0]) / TABLE_STEP) as u32;
        let even = (0..=steps).map(|i| TABLE_RANGE[0] + TABLE_STEP * f64::from(i));
        let lines = self.nominal.lines.iter().map(|line| line.nm);
        let mut all: Vec<f64> =
            even.chain([D_LINE]).chain(lines).filter(|nm| (low..=high).contains(nm)).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        let nominal = self.nominal.lens.rows[row].index;
        all.iter().map(|&nm| [nm, self.index(row, glass.nearest_index(nominal, nm))]).collect()
    }
}
