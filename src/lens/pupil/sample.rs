//! Sampling of pupil points from the pupil bounds.

use super::RINGS;
use super::bounds::{FanTable, PupilBounds, integer_part, ring, ring_position};
use super::fan::{TRIANGLES, Triangle};
use super::target::{DENSITY, PupilTarget, PupilTargets, TriangleSteps, point_target};
use petzval_base::rays::{Column, WAVE_SIZE};
use petzval_base::sampler::concentric_disk;

/// Columns that are computed in SIMD before the fans are looked up.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lookup {
    /// Row of [`TriangleSteps`], and the interpolation weight of its step.
    step: Column<u32>,
    step_weight: Column<f32>,
    rear: Column<u32>,
    /// Position of a sample along the outer side of its triangle, 0 to 1.
    pub(crate) along: Column<f32>,
}

impl PupilBounds {
    /// Samples pupil points: for every entry of the columns from its film point and the two random
    /// numbers of its pupil point.
    pub(crate) fn targets(
        &self,
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        lookup: &mut Lookup,
        targets: &mut PupilTargets,
    ) {
        match &self.table {
            FanTable::RearOnly => self.rear_only_targets(film, pupil, targets),
            FanTable::Round { steps, per_end, .. } => {
                self.round_targets((steps, *per_end), film, pupil, lookup, targets);
            }
            FanTable::Polar(_) | FanTable::Grid { .. } => {
                self.lens_frame_targets(film, pupil, lookup, targets);
            }
        }
    }

    #[inline(always)]
    fn round_targets(
        &self,
        (TriangleSteps(steps), per_end): (&TriangleSteps, f32),
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        lookup: &mut Lookup,
        targets: &mut PupilTargets,
    ) {
        let count = film[0].len().min(WAVE_SIZE);
        let (x, y) = (&film[0][..count], &film[1][..count]);
        let (u, v) = (&pupil[0][..count], &pupil[1][..count]);
        let share = self.shares.outside();
        let per_triangle = TRIANGLES as f32 / (1.0 - share);
        // Two loops: this one is arithmetic over whole columns and vectorizes.
        for i in 0..count {
            let radius = (x[i] * x[i] + y[i] * y[i]).sqrt();
            let position = ring_position(radius * per_end);
            let ring = ring(position);
            lookup.step_weight[i] = position - ring as i32 as f32;
            lookup.rear[i] = self.rear_ring(radius);
            let place = (u[i] - share).max(0.0) * per_triangle;
            let triangle = integer_part(place).min(TRIANGLES as u32 - 1);
            lookup.step[i] = ring * TRIANGLES as u32 + triangle;
            lookup.along[i] = place - triangle as i32 as f32;
        }
        // A row is eight lanes.
        for i in 0..count {
            let [near, step] = &steps[lookup.step[i] as usize];
            let s = lookup.step_weight[i];
            for k in 0..8 {
                targets[i][k] = near[k] + s * step[k];
            }
        }
        let density = &self.rear_density[..RINGS];
        for i in 0..count {
            targets[i][DENSITY] += density[lookup.rear[i] as usize % RINGS];
            if u[i] < share {
                targets[i] = self.outside_target([x[i], y[i]], [u[i], v[i]]);
            }
        }
    }

    #[inline(never)]
    fn lens_frame_targets(
        &self,
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        lookup: &mut Lookup,
        targets: &mut PupilTargets,
    ) {
        let share = self.shares.outside();
        for i in 0..film[0].len() {
            let (point, u, v) = ([film[0][i], film[1][i]], pupil[0][i], pupil[1][i]);
            if u < share {
                targets[i] = self.outside_target(point, [u, v]);
                continue;
            }
            let place = (u - share) * (TRIANGLES as f32 / (1.0 - share));
            let k = (place as usize).min(TRIANGLES - 1);
            lookup.along[i] = place - k as f32;
            let mut target = match &self.table {
                FanTable::Polar(polar) => polar.target(point, k),
                _ => self.grid_target(point, k),
            };
            // All light lies in both regions, so that the weight matters nowhere else.
            target[DENSITY] = self.rear_density[self.cell(point)] + self.vicinity_density(point);
            targets[i] = target;
        }
    }

    /// Returns one triangle of [`PupilBounds::fan`] over a grid, as a target without the density.
    fn grid_target(&self, film: [f32; 2], k: usize) -> PupilTarget {
        let mut target = [0.0; 8];
        let FanTable::Grid { fans } = &self.table else { return target };
        for (corner, weight) in self.cells.corners(film) {
            let Triangle { centre, corners: [a, b] } = fans[corner].triangle(k);
            let row = [centre[0], centre[1], a[0], a[1], b[0] - a[0], b[1] - a[1]];
            for (sum, value) in target.iter_mut().zip(row) {
                *sum += weight * value;
            }
        }
        target
    }

    #[inline(never)]
    fn rear_only_targets(&self, film: [&[f32]; 2], pupil: [&[f32]; 2], targets: &mut PupilTargets) {
        for i in 0..film[0].len() {
            targets[i] = self.outside_target([film[0][i], film[1][i]], [pupil[0][i], pupil[1][i]]);
        }
    }

    /// Returns a sample that is not drawn from a triangle. The first random number is below the share
    /// of these samples; it chooses the region in the order of [`Shares`](super::density::Shares).
    #[inline(never)]
    fn outside_target(&self, film: [f32; 2], [u, v]: [f32; 2]) -> PupilTarget {
        let (shares, regions) = (&self.shares, self.regions(film));
        let beyond_rear = u - shares.rear;
        let beyond_vicinity = beyond_rear - shares.vicinity;
        let point = if beyond_rear < 0.0 {
            Some(regions.rear.at(concentric_disk(u / shares.rear, v)))
        } else if beyond_vicinity < 0.0 {
            regions.vicinity.point([beyond_rear / shares.vicinity, v])
        } else {
            regions.fan.rim_point([beyond_vicinity / shares.rim, v])
        };
        match point {
            Some(point) => point_target(point, self.mixture_density(&regions, point)),
            None => point_target([0.0; 2], 0.0),
        }
    }
}
