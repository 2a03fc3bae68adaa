//! Notes for the metadata of a picture and warnings, collected during preparation.

use crate::film::Frame;
use crate::io::image::{Note, Notes};
use crate::io::{Location, Warning};
use crate::lens::{D_LINE, RealLens};
use crate::plan::{Decision, Effect, EffectSelection, Plan};

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

    /// Warns of glass whose data do not cover the wavelengths in use: that of the d line, by which
    /// the lens is focused, and those of the traced bands.
    pub fn warn_extrapolated_indices(&mut self, lens: &RealLens) {
        let used = lens.bands.iter().map(|band| band.wavelength);
        let (low, high) =
            used.fold((D_LINE, D_LINE), |(low, high), nm| (low.min(nm), high.max(nm)));
        for doubt in lens.prescription.index_warnings([low, high]) {
            self.warn(format!("lens {}: {doubt}", lens.prescription.name));
        }
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
