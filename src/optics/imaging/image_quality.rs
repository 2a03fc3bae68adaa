//! Rays of all fields and wavelengths of a lens, from which its image quality is computed.

use super::chief::ChiefRay;
use super::conditions::ImagingConditions;
use super::lens_at_wavelength::LensAtWavelength;
use super::pupil_grid::PupilGrid;
use super::reference_sphere::ReferenceSphere;
use petzval_lens::Prescription;
use petzval_lens::SpectralLine;
use petzval_spectrum::IndexRangeError;

/// Rays of a field point.
#[derive(Clone, Debug)]
pub struct FieldRays {
    /// Field coordinate along y, in the unit of the conditions.
    pub field: f64,
    /// Chief ray of each wavelength; `None` if there is none.
    pub chiefs: Vec<Option<ChiefRay>>,
    /// Reference point and sphere: those of the chief ray at the primary wavelength.
    pub reference: ReferenceSphere,
    /// Rays of each wavelength; `None` if no light passes.
    pub grids: Vec<Option<PupilGrid>>,
}

/// A lens under given conditions, traced for evenly spaced fields.
#[derive(Clone, Debug)]
pub struct ImageQuality {
    /// The conditions.
    pub conditions: ImagingConditions,
    /// Fields from the axis to the edge, without those that have no chief ray at the primary
    /// wavelength.
    pub fields: Vec<FieldRays>,
    /// Even fields that have no chief ray at the primary wavelength.
    pub left_out: Vec<f64>,
    pub(super) lenses: Vec<LensAtWavelength>,
}

/// Numbers of fields and of rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImagingGrid {
    /// Fields from the axis to the edge.
    pub fields: usize,
    /// Rays along each side of the grid over a pupil.
    pub pupil: usize,
    /// Threads that share the work.
    pub threads: usize,
}

impl ImageQuality {
    /// Traces a lens.
    ///
    /// # Errors
    /// Returns an error if a glass has no data at a wavelength.
    pub fn new(
        lens: &Prescription,
        conditions: ImagingConditions,
        grid: ImagingGrid,
    ) -> Result<Self, IndexRangeError> {
        let lenses = (0..conditions.wavelengths.len())
            .map(|i| LensAtWavelength::new(lens, &conditions, i))
            .collect::<Result<Vec<_>, _>>()?;
        let mut quality = Self { conditions, fields: Vec::new(), left_out: Vec::new(), lenses };
        let last = grid.fields.max(2) - 1;
        let coordinates: Vec<f64> =
            (0..=last).map(|i| quality.conditions.largest_field * i as f64 / last as f64).collect();
        let traced = in_parallel(&coordinates, grid.threads, |&field| {
            quality.trace_field(field, grid.pupil)
        });
        for (field, rays) in coordinates.into_iter().zip(traced) {
            match rays {
                Some(rays) => quality.fields.push(rays),
                None => quality.left_out.push(field),
            }
        }
        Ok(quality)
    }

    /// Returns the lens at the primary wavelength.
    pub(super) fn primary(&self) -> &LensAtWavelength {
        &self.lenses[self.conditions.primary]
    }

    /// Returns the reference point and sphere of a chief ray at the primary wavelength.
    pub(super) fn reference(&self, chief: &ChiefRay) -> ReferenceSphere {
        let paraxial = &self.primary().paraxial;
        let film_distance = self.conditions.film_distance;
        let pupil = paraxial.exit_pupil.position * paraxial.travel;
        let along_axis = film_distance - pupil;
        let length = along_axis.hypot(chief.film[0].hypot(chief.film[1]));
        ReferenceSphere { point: chief.film, film_distance, radius: length * along_axis.signum() }
    }

    /// Traces the chief rays and the pupil grids of a field; `None` without a chief ray at the
    /// primary wavelength.
    pub fn trace_field(&self, field: f64, side: usize) -> Option<FieldRays> {
        let primary = self.primary().chief_of_field(&self.conditions, [0.0, field])?;
        Some(self.trace_lenses(&self.lenses, field, &primary, side))
    }

    /// Traces a field in other light: lines in place of those of the conditions, with their weights.
    /// The film stays, and so does the reference point, which is that of the chief ray at the primary
    /// wavelength. Returns `None` without such a ray. `lens` is that which was analysed.
    ///
    /// # Errors
    /// Returns an error if a glass has no data at a wavelength.
    pub fn trace_field_in(
        &self,
        lens: &Prescription,
        light: &[SpectralLine],
        field: f64,
        side: usize,
    ) -> Result<Option<FieldRays>, IndexRangeError> {
        let conditions =
            ImagingConditions { wavelengths: light.to_vec(), ..self.conditions.clone() };
        let lenses = (0..light.len())
            .map(|i| LensAtWavelength::new(lens, &conditions, i))
            .collect::<Result<Vec<_>, _>>()?;
        let primary = self.primary().chief_of_field(&self.conditions, [0.0, field]);
        Ok(primary.map(|primary| self.trace_lenses(&lenses, field, &primary, side)))
    }

    /// Traces the chief rays and the pupil grids of a field through a lens at several wavelengths.
    fn trace_lenses(
        &self,
        lenses: &[LensAtWavelength],
        field: f64,
        primary: &ChiefRay,
        side: usize,
    ) -> FieldRays {
        let reference = self.reference(primary);
        let primary_nm = self.primary().nm;
        let chief = |lens: &LensAtWavelength| match lens.nm == primary_nm {
            true => Some(*primary),
            false => lens.chief_of_object(primary),
        };
        let chiefs: Vec<Option<ChiefRay>> = lenses.iter().map(chief).collect();
        let grids = lenses
            .iter()
            .zip(&chiefs)
            .map(|(lens, chief)| lens.pupil_grid(chief.as_ref()?, &reference, side))
            .collect();
        FieldRays { field, chiefs, reference, grids }
    }

    /// Returns the rays of a field: those of the even fields if it is one of them.
    pub fn field(&self, field: f64, side: usize) -> Option<FieldRays> {
        let near = |traced: &&FieldRays| {
            (traced.field - field).abs() <= 1e-9 * self.conditions.largest_field
        };
        match self.fields.iter().find(near) {
            Some(traced) => Some(traced.clone()),
            None => self.trace_field(field, side),
        }
    }

    /// Returns the number of rays on the grids.
    pub fn rays(&self) -> usize {
        let grids = self.fields.iter().flat_map(|field| field.grids.iter().flatten());
        grids.map(|grid| grid.open().count()).sum()
    }
}

impl FieldRays {
    /// Returns the chief ray at a wavelength.
    pub fn chief(&self, wavelength: usize) -> Option<&ChiefRay> {
        self.chiefs[wavelength].as_ref()
    }

    /// Returns the grids of the wavelengths that have one.
    pub fn open_grids(&self) -> impl Iterator<Item = &PupilGrid> {
        self.grids.iter().flatten()
    }
}

/// Applies a function to all items on several threads, in the order of the items.
pub fn in_parallel<T: Sync, U: Send>(
    items: &[T],
    threads: usize,
    function: impl Fn(&T) -> U + Sync,
) -> Vec<U> {
    let next = std::sync::atomic::AtomicUsize::new(0);
    let mut results: Vec<(usize, U)> = std::thread::scope(|scope| {
        let work = || {
            let mut done = Vec::new();
            loop {
                // The costly items are at the end: the edge of the field.
                let i = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                let Some(item) = items.get(i) else { return done };
                done.push((i, function(item)));
            }
        };
        let workers: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .flat_map(|worker| match worker.join() {
                Ok(done) => done,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    });
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}
