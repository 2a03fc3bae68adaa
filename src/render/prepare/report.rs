//! Notes for the metadata of a picture and warnings, collected during preparation.

use super::PrepareError;
use crate::film::Frame;
use crate::plan::{Decision, Effect, EffectSelection, Plan};
use petzval_base::io::{Location, Warning};
use petzval_image::{Note, Notes};
use petzval_lens::{Camera, LensModel, RealLens};
use petzval_spectrum::LightBand;

/// Steps along the half diagonal of the film in which the end of the light is looked for.
const STEPS: u32 = 200;

/// Share of the film's diagonal below which the circle of light counts as small: a picture of the
/// usual formats then has black corners that no photographer wants, and a fitted film has none.
const SMALL_CIRCLE: f64 = 0.7;

/// Share of the circle of light that the fitted film spans, as the light falls off before its end.
const FITTED: f64 = 0.9;

/// Notes and warnings of a preparation.
pub(super) struct Report {
    /// The place of the camera in the scene file, which all warnings name.
    pub camera_at: Location,
    pub warnings: Vec<Warning>,
    pub notes: Notes,
}

impl Report {
    pub fn warn(&mut self, message: String) {
        self.warnings.push(Warning { at: self.camera_at.clone(), message });
    }

    pub fn text(&mut self, name: &'static str, value: String) {
        self.notes.push((name, Note::Text(value)));
    }

    /// Adds a number, unless it is NaN.
    pub fn number(&mut self, name: &'static str, value: f64) {
        if !value.is_nan() {
            self.notes.push((name, Note::Number(value)));
        }
    }

    /// Warns of effects that the user asks for by name and that stay off.
    pub fn warn_unavailable(&mut self, selection: &EffectSelection, plan: &Plan) {
        let EffectSelection::Overrides(list) = selection else { return };
        for decision in &plan.effects {
            let Decision { effect, on, reason, .. } = decision;
            if !on && list.contains(&(*effect, true)) {
                self.warn(format!("'effects' +{effect}: it stays off: {reason}"));
            }
        }
    }

    /// Checks that the data of the glass cover the wavelengths in use: that of the primary one, by which
    /// the lens is focused, and those of the traced bands and of the ghosts. Warns where they nearly do, and of indices
    /// that are taken to be constant.
    ///
    /// # Errors
    /// Returns an error for the first medium whose data do not.
    pub fn check_indices(
        &mut self,
        lens: &RealLens,
        ghosts: &[LightBand],
    ) -> Result<(), PrepareError> {
        let prescription = &lens.prescription;
        let primary = prescription.design.primary_wavelength();
        let bands = if lens.bands.len() > 1 { &lens.bands[..] } else { &[] };
        let traced = bands.iter().map(|band| band.wavelength);
        // One band of ghosts stands for all light, at the primary wavelength.
        let ghosts = if ghosts.len() > 1 { ghosts } else { &[] };
        let used = traced.chain(ghosts.iter().map(|band| band.wavelength));
        let (low, high) =
            used.fold((primary, primary), |(low, high), nm| (low.min(nm), high.max(nm)));
        prescription.check_wavelengths([low, high]).map_err(|error| {
            PrepareError::Request(format!("lens {}: {error}", prescription.name))
        })?;
        for doubt in prescription.index_warnings([low, high]) {
            self.warn(format!("lens {}: {doubt}", prescription.name));
        }
        Ok(())
    }

    /// Warns if a lens that is not the scene's lights a small part of the film, as that of a phone
    /// does on the film of a full-frame camera.
    pub fn warn_small_circle(&mut self, camera: &Camera) {
        let LensModel::Real(lens) = &camera.model else { return };
        let corner = camera.film.map(|side| side / 2.0);
        // Cells of a grid over the film, along its diagonals from the middle outwards.
        let lit = |step: u32| {
            let sides = [f64::from(STEPS + step), f64::from(STEPS - 1 - step)];
            let cells =
                [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[x, y]: [usize; 2]| [sides[x], sides[y]]);
            cells
                .iter()
                .any(|&[x, y]| camera.sees_light([x, y], [x + 1.0, y + 1.0], [2 * STEPS; 2]))
        };
        let Some(last) = (0..STEPS).rev().find(|&step| lit(step)) else { return };
        let share = f64::from(last + 1) / f64::from(STEPS);
        if share < SMALL_CIRCLE {
            let diagonal = 2.0 * corner[0].hypot(corner[1]);
            let circle = diagonal * share;
            self.warn(format!(
                "lens {}: its light falls on a circle of about {circle:.1} mm, and the diagonal of \
                 the film is {diagonal:.1} mm, so the rest of the picture is black; \
                 'film_diagonal' {:.1}mm fits the film to the lens",
                lens.prescription.name,
                circle * FITTED
            ));
        }
    }

    /// Warns if diffraction would need the light around a cropped picture.
    pub fn warn_crop(&mut self, frame: &Frame, plan: &Plan) {
        if frame.size() != frame.resolution && plan.has(Effect::Diffraction) {
            let message = "diffraction takes the light beyond the crop to be like that inside, so the \
                           crop is not exactly that part of the whole picture; with 'effects' \
                           -diffraction it is";
            self.warn(message.to_owned());
        }
    }
}
