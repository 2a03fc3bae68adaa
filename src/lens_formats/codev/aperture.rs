//! Apertures on surfaces of a CODE V file.

use super::super::report::ReadReport;
use super::CodeVWord;
use petzval_lens::LensError;
use petzval_lens::system::SystemSurface;
use petzval_lens::{ApertureForm, SurfaceAperture};

/// Shape of one kind, in units of the file.
#[derive(Clone, Copy, Default)]
struct Outline<'a> {
    /// Radius of `CIR`.
    circle: Option<f64>,
    /// Form, half-widths and last command of `REX`, `REY`, `ELX`, `ELY`.
    sides: Option<(ApertureForm, [Option<f64>; 2], CodeVWord<'a>)>,
    /// `ADX`, `ADY`.
    centre: [f64; 2],
    /// `ARO`, unless 0.
    turn: Option<CodeVWord<'a>>,
}

/// Apertures of one surface: the clear one, the edge, and what is opaque (`OBS`, `HOL`).
#[derive(Default)]
pub(super) struct Apertures<'a> {
    clear: Outline<'a>,
    edge: Outline<'a>,
    opaque: Outline<'a>,
}

impl<'a> Apertures<'a> {
    /// Reads a command; returns whether it states an aperture.
    pub fn read(
        &mut self,
        command: &CodeVWord<'a>,
        keyword: &str,
        values: &[CodeVWord<'a>],
    ) -> Result<bool, LensError> {
        if !["CIR", "REX", "REY", "ELX", "ELY", "ADX", "ADY", "ARO"].contains(&keyword) {
            return Ok(false);
        }
        let Some(word) = values.last() else {
            let found = format!("{keyword} without a value");
            return Err(command.error(found, "expected a number"));
        };
        let value = word.number()?;
        let is = |kind: &str| values.iter().any(|word| word.text.eq_ignore_ascii_case(kind));
        let outline = match () {
            () if is("EDG") => &mut self.edge,
            () if is("OBS") || is("HOL") => &mut self.opaque,
            () => &mut self.clear,
        };
        match keyword {
            "CIR" => outline.circle = Some(value),
            "ADX" => outline.centre[0] = value,
            "ADY" => outline.centre[1] = value,
            "ARO" => outline.turn = (value != 0.0).then_some(*word),
            _ => {
                if !(1e-9..=1e9).contains(&value) {
                    let found = format!("{keyword} with a half-width of {value}");
                    return Err(word.error(found, "expected 1e-9 to 1e9"));
                }
                let form = match keyword.starts_with('R') {
                    true => ApertureForm::Rectangle,
                    false => ApertureForm::Ellipse,
                };
                let before = outline.sides.filter(|(other, ..)| *other == form);
                let mut half_widths = before.map_or([None; 2], |(_, half_widths, _)| half_widths);
                half_widths[usize::from(keyword.ends_with('Y'))] = Some(value);
                outline.sides = Some((form, half_widths, *word));
            }
        }
        Ok(true)
    }

    /// Applies the apertures to a surface. A circle as the edge clips if no clear aperture is
    /// stated; other edges do not.
    pub fn apply(
        &self,
        number: usize,
        unit: f64,
        surface: &mut SystemSurface,
        report: &mut ReadReport,
    ) -> Result<(), LensError> {
        let clear = self.clear.shape(number, report)?;
        let open = match (clear, self.clear.circle) {
            (None, None) => Outline { sides: None, ..self.edge }.shape(number, report)?,
            _ => clear,
        };
        if let Some(aperture) = open.map(|aperture| scaled(aperture, unit)) {
            surface.semi_diameter = Some(aperture.reach());
            surface.clips = true;
            if !is_centred_circle(&aperture) {
                surface.row.apertures.push(aperture);
            }
        }
        if let Some(aperture) = self.opaque.shape(number, report)?.map(|one| scaled(one, unit)) {
            match is_centred_circle(&aperture) {
                true => surface.row.obstruction = 2.0 * aperture.half_widths[0],
                false => surface.row.apertures.push(aperture.obscuring()),
            }
        }
        Ok(())
    }
}

impl Outline<'_> {
    /// Returns the shape, if one is stated: a rectangle or an ellipse, else the circle.
    fn shape(
        &self,
        number: usize,
        report: &mut ReadReport,
    ) -> Result<Option<SurfaceAperture>, LensError> {
        let circle = self.circle.filter(|radius| *radius > 0.0);
        let circle = circle.map(|radius| SurfaceAperture::circle(radius, self.centre));
        let Some((form, sides, word)) = self.sides else { return Ok(circle) };
        let [Some(x), Some(y)] = sides else {
            let what = format!("an aperture of one half-width (surface {number})");
            report.unsimulated(&word.line, word.text, what, "without it")?;
            return Ok(circle);
        };
        if let Some(turn) = self.turn {
            let what = format!("the rotated aperture of surface {number}");
            report.unsimulated(&turn.line, turn.text, what, "with it not rotated")?;
        }
        let (centre, half_widths) = (self.centre, [x, y]);
        Ok(Some(SurfaceAperture { form, half_widths, centre, rotation: 0.0, obscures: false }))
    }
}

fn scaled(aperture: SurfaceAperture, unit: f64) -> SurfaceAperture {
    SurfaceAperture {
        half_widths: aperture.half_widths.map(|half| half * unit),
        centre: aperture.centre.map(|place| place * unit),
        ..aperture
    }
}

fn is_centred_circle(aperture: &SurfaceAperture) -> bool {
    let [x, y] = aperture.half_widths;
    aperture.form == ApertureForm::Ellipse && x == y && aperture.centre == [0.0; 2]
}
