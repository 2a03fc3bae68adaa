//! Spots of many similar lenses, by rays that are chosen once.

use super::chief::ObjectPoint;
use super::conditions::ImagingConditions;
use super::frozen_pupil::{FrozenPupil, fill};
use super::image_quality::in_parallel;
use super::lens_at_wavelength::LensAtWavelength;
use super::spot::{SpotDiagram, SpotRay};
use petzval_base::lanes::{f32x8, f64x8};
use petzval_base::rays::{LensBatch, WAVE_SIZE};
use petzval_lens::FieldKind;
use petzval_lens::LensRay;
use petzval_lens::Prescription;
use petzval_lens::Side;
use petzval_lens::Surface;
use petzval_lens::retrace_in_f64;
use petzval_lens::trace::trace;
use petzval_lens::{open_surfaces, sequence_at};
use petzval_spectrum::IndexRangeError;

/// Rims of a changed lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RimPolicy {
    /// They cut the light of the changed lens.
    Moving,
    /// The light is that of the nominal lens: figures of merit are smooth.
    Frozen,
}

/// Object points and rays for figures of merit of similar lenses.
#[derive(Clone, Debug)]
pub struct FrozenImaging {
    /// The conditions; the field is an angle or an object height.
    pub conditions: ImagingConditions,
    /// Field coordinates along y, in the unit of the conditions.
    pub fields: Vec<f64>,
    pupils: Vec<FrozenPupil>,
}

/// Spot of an object point.
#[derive(Clone, Debug)]
pub struct FieldSpot {
    /// Point of the chief ray at the primary wavelength on the film (mm).
    pub chief: [f64; 2],
    /// Slopes of that ray, dx/dz and dy/dz.
    pub chief_slope: [f64; 2],
    /// The rays, relative to that point.
    pub diagram: SpotDiagram,
}

/// Why the rays of a lens cannot be chosen.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrozenImagingError {
    /// A glass has no data at a wavelength.
    #[error("{0}")]
    Index(#[from] IndexRangeError),
    /// The largest image height has no chief ray.
    #[error(
        "no ray through the middle of the stop reaches the image height {0} mm; give a smaller one \
         with 'image_height'"
    )]
    ImageHeight(f64),
    /// No light of an object point passes the lens.
    #[error(
        "no light passes the lens at the field {field:.4} {unit}; give a smaller field with \
         'image_height', or other shares of it with 'fields'"
    )]
    Dark {
        /// Field coordinate along y.
        field: f64,
        /// Its unit.
        unit: &'static str,
    },
}

impl FrozenImaging {
    /// Chooses the rays of a nominal lens: `rings` hexapolar rings (1 + 3 rings (rings + 1) rays)
    /// over the stop, for fields that are shares of the largest one, of either sign.
    ///
    /// A largest field that is an image height becomes the field angle or object height that has
    /// this image in the nominal lens.
    ///
    /// # Errors
    /// Returns an error if a glass has no data at a wavelength, or if a field is dark.
    pub fn new(
        lens: &Prescription,
        mut conditions: ImagingConditions,
        shares: &[f64],
        rings: u32,
        threads: usize,
    ) -> Result<Self, FrozenImagingError> {
        let primary = LensAtWavelength::new(lens, &conditions, conditions.primary)?;
        if conditions.field_kind == FieldKind::ImageHeight {
            let height = conditions.largest_field;
            let chief = primary
                .chief_of_field(&conditions, [0.0, height])
                .ok_or(FrozenImagingError::ImageHeight(height))?;
            (conditions.field_kind, conditions.largest_field) = match chief.object {
                ObjectPoint::Distant(d) => (FieldKind::Angle, d[1].atan2(d[2]).to_degrees().abs()),
                ObjectPoint::Near(point) => (FieldKind::ObjectHeight, point[1].abs()),
            };
        }
        let fields: Vec<f64> =
            shares.iter().map(|share| share * conditions.largest_field).collect();
        let reach = lens.rows[lens.stop()].iris.reach();
        let pupils = in_parallel(&fields, threads, |&field| {
            let chief = primary.chief_of_field(&conditions, [0.0, field])?;
            primary.freeze(&chief, rings, reach)
        });
        let unit = if conditions.field_kind == FieldKind::Angle { "degrees" } else { "mm" };
        let pupils = pupils
            .into_iter()
            .zip(&fields)
            .map(|(pupil, &field)| pupil.ok_or(FrozenImagingError::Dark { field, unit }))
            .collect::<Result<_, _>>()?;
        Ok(Self { conditions, fields, pupils })
    }

    /// Returns the number of rays of all fields and wavelengths in the nominal lens.
    pub fn rays(&self) -> usize {
        let lit = |pupil: &FrozenPupil| pupil.rays.iter().filter(|ray| ray.light > 0.0).count();
        let fields: usize = self.pupils.iter().map(lit).sum();
        fields * self.conditions.wavelengths.len()
    }

    /// Traces a lens that is similar to the nominal one to a film at this distance (mm), and returns
    /// the spot of each field. `at_wavelength` returns the lens with its indices at a wavelength of
    /// the conditions, by its number. `None` if a field has no chief ray, or an index no value.
    pub fn spots(
        &self,
        film_distance: f64,
        rims: RimPolicy,
        at_wavelength: impl Fn(usize) -> Option<Prescription>,
    ) -> Option<Vec<FieldSpot>> {
        let conditions = &ImagingConditions { film_distance, ..self.conditions.clone() };
        let mut sequences = Vec::with_capacity(conditions.wavelengths.len());
        let mut primary = None;
        for (i, line) in conditions.wavelengths.iter().enumerate() {
            let lens = at_wavelength(i)?;
            if i == conditions.primary {
                let rims = sequence_at::<f32x8>(&lens, Side::Scene(0.0), line.nm);
                primary = Some((LensAtWavelength::new(&lens, conditions, i).ok()?, rims));
            }
            let mut surfaces = sequence_at::<f64>(&lens, Side::Scene(0.0), line.nm);
            open_surfaces(&mut surfaces);
            sequences.push((line.weight, surfaces));
        }
        let (primary, primary_rims) = primary?;
        let mut batch = Box::<LensBatch<f64>>::default();
        let mut rim_batch = Box::<LensBatch<f32>>::default();
        let mut blocked = vec![0; self.rows(&sequences)];
        let mut spots = Vec::with_capacity(self.pupils.len());
        for pupil in &self.pupils {
            let chief = primary.chief_of_object(&pupil.chief)?;
            let map = pupil.carried(&primary, &chief)?;
            let lit = match rims {
                RimPolicy::Frozen => pupil.rays.iter().map(|ray| (ray.pupil, ray.light)).collect(),
                RimPolicy::Moving => {
                    let start = |pupil: [f64; 2]| primary.start(&chief, &map, pupil);
                    pupil.lit(&primary_rims, &mut rim_batch, &mut blocked, start)
                }
            };
            let lit: Vec<([f64; 2], f64)> =
                lit.into_iter().filter(|(_, light)| *light > 0.0).collect();
            let starts: Vec<LensRay<f64>> = lit
                .iter()
                .map(|(pupil, _)| primary.start(&chief, &map, *pupil))
                .collect::<Option<_>>()?;
            let middle = primary.traced(&chief, [0.0; 2])?.t;
            let mut rays = Vec::with_capacity(starts.len() * sequences.len());
            for (wavelength, (weight, surfaces)) in sequences.iter().enumerate() {
                for (starts, lit) in starts.chunks(WAVE_SIZE).zip(lit.chunks(WAVE_SIZE)) {
                    fill::<f64x8>(&mut batch, starts.len(), |i| starts[i]);
                    trace::<f64x8>(&mut batch, surfaces, &mut blocked);
                    retrace_in_f64::<f64x8>(&mut batch, surfaces, &mut blocked, |i| starts[i]);
                    for (i, (_, light)) in lit.iter().enumerate() {
                        let s = (film_distance - batch.z[i]) / batch.tz[i];
                        let x = batch.x[i] + s * batch.tx[i] - chief.film[0];
                        let y = batch.y[i] + s * batch.ty[i] - chief.film[1];
                        if x.is_finite() && y.is_finite() {
                            rays.push(SpotRay {
                                point: [x, y],
                                slope: [batch.tx[i] / batch.tz[i], batch.ty[i] / batch.tz[i]],
                                // The rings are dense where the spread within a cell matters.
                                within: [[0.0; 2]; 2],
                                slope_within: 0.0,
                                light: weight * light,
                                wavelength,
                            });
                        }
                    }
                }
            }
            let light: f64 = rays.iter().map(|ray| ray.light).sum();
            rays.iter_mut().for_each(|ray| ray.light /= light);
            spots.push(FieldSpot {
                chief: chief.film,
                chief_slope: [middle[0] / middle[2], middle[1] / middle[2]],
                diagram: SpotDiagram { rays },
            });
        }
        Some(spots)
    }

    fn rows(&self, sequences: &[(f64, Vec<Surface<f64>>)]) -> usize {
        let rows = sequences.iter().flat_map(|(_, surfaces)| surfaces);
        rows.map(|surface| surface.row + 1).max().unwrap_or(0)
    }
}
