//! Merit of a lens: the residuals whose squares an optimization sums.

use super::constraint::EdgeConstraint;
use super::target::{DesignTarget, TargetKind};
use crate::imaging::frozen_imaging::{FieldSpot, FrozenImaging, RimPolicy};
use crate::tolerance::figure::{Refocus, best_defocus};
use petzval_lens::FieldKind;
use petzval_lens::Paraxial;
use petzval_lens::Prescription;

/// A lens and the distance of its film (mm).
#[derive(Clone, Debug)]
pub(super) struct FilmedLens {
    pub lens: Prescription,
    pub film: f64,
}

/// Residuals and the values of the targets.
#[derive(Clone, Debug)]
pub(super) struct MeritValue {
    /// Residuals (mm).
    pub residuals: Vec<f64>,
    /// Value of each target, in its unit.
    pub values: Vec<f64>,
    /// Distance of the film after refocus (mm).
    pub film: f64,
}

/// Merit function.
#[derive(Clone, Debug)]
pub(super) struct DesignMerit {
    pub imaging: FrozenImaging,
    pub targets: Vec<DesignTarget>,
    pub refocus: Refocus,
    pub edges: EdgeConstraint,
}

impl DesignMerit {
    /// Evaluates a lens; `None` if it forms no image or a ray of it is lost.
    pub fn evaluate(&self, design: &FilmedLens) -> Option<MeritValue> {
        let FilmedLens { lens, film } = design;
        let conditions = &self.imaging.conditions;
        let at = |i: usize| lens.at_wavelength(conditions.wavelengths[i].nm).ok();
        let spots = self.imaging.spots(*film, RimPolicy::Frozen, at)?;
        if spots.iter().map(|spot| spot.diagram.rays.len()).sum::<usize>() != self.imaging.rays() {
            return None;
        }
        let paraxial = Paraxial::new(&at(conditions.primary)?);
        let defocus = best_defocus(&self.imaging.fields, &spots, self.refocus);
        let film = film + defocus;
        let (mut residuals, mut values) = (Vec::new(), Vec::new());
        for target in &self.targets {
            let scale = target.weight.sqrt();
            let value = match target.kind {
                TargetKind::Spot => {
                    let first = residuals.len();
                    spots.iter().for_each(|spot| spread(spot, defocus, &mut residuals));
                    let share = (spots.len() as f64).sqrt().recip();
                    residuals[first..].iter_mut().for_each(|residual| *residual *= share);
                    let square: f64 = residuals[first..].iter().map(|r| r * r).sum();
                    residuals[first..].iter_mut().for_each(|residual| *residual *= scale);
                    values.push(square.sqrt());
                    continue;
                }
                TargetKind::Distortion => {
                    let (height, ideal) = self.heights(&paraxial, &spots, defocus)?;
                    let wanted = ideal * (1.0 + target.value / 100.0);
                    residuals.push(scale * (height - wanted));
                    values.push(100.0 * (height / ideal - 1.0));
                    continue;
                }
                TargetKind::FocalLength => paraxial.focal_length,
                TargetKind::BackFocalDistance => paraxial.back_focal_distance,
                TargetKind::FilmDistance => film,
            };
            residuals.push(scale * (value - target.value));
            values.push(value);
        }
        residuals.extend(self.edges.residuals(lens));
        residuals.iter().all(|r| r.is_finite()).then_some(MeritValue { residuals, values, film })
    }

    /// Returns the image height of the largest field, and that without distortion (mm).
    fn heights(
        &self,
        paraxial: &Paraxial,
        spots: &[FieldSpot],
        defocus: f64,
    ) -> Option<(f64, f64)> {
        let fields = &self.imaging.fields;
        let largest =
            (0..fields.len()).max_by(|&a, &b| fields[a].abs().total_cmp(&fields[b].abs()))?;
        let conditions = &self.imaging.conditions;
        let ideal = match conditions.field_kind {
            FieldKind::Angle => paraxial.focal_length * fields[largest].to_radians().tan(),
            _ => paraxial.magnification(conditions.object_distance) * fields[largest],
        };
        let spot = &spots[largest];
        let height = spot.chief[1] + defocus * spot.chief_slope[1];
        (ideal != 0.0).then_some((height, ideal))
    }
}

/// Appends the distances of the rays of a spot from its centroid, weighted by their light, so that
/// the squares sum to the mean square radius.
fn spread(spot: &FieldSpot, defocus: f64, residuals: &mut Vec<f64>) {
    let at = |i: usize| {
        spot.diagram.rays.iter().map(move |ray| (ray.point[i] + defocus * ray.slope[i], ray.light))
    };
    for axis in 0..2 {
        let centroid: f64 = at(axis).map(|(x, light)| x * light).sum();
        residuals.extend(at(axis).map(|(x, light)| light.sqrt() * (x - centroid)));
    }
}
