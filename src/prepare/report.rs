//! Notes for the metadata of a picture and warnings, collected during preparation.

use super::PrepareError;
use crate::film::Frame;
use crate::io::image::{Note, Notes};
use crate::io::{Location, Warning};
use crate::lens::RealLens;
use crate::plan::{Decision, Effect, EffectSelection, Plan};
use crate::spectrum::LightBand;

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
                self.warn(format!("--effects +{effect}: it stays off: {reason}"));
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

    /// Warns if diffraction would need the light around a cropped picture.
    pub fn warn_crop(&mut self, frame: &Frame, plan: &Plan) {
        if frame.size() != frame.resolution && plan.has(Effect::Diffraction) {
            let message = "diffraction takes the light beyond the crop to be like that inside, so the \
                           crop is not exactly that part of the whole picture; with --effects \
                           -diffraction it is";
            self.warn(message.to_owned());
        }
    }
}
