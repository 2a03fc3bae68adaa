//! Reader of OSLO lens files (`.len`).
//!
//! A file is a list of commands. `NXT` goes to the next surface; surface 0 is the object, the last
//! one the image. Sources: OSLO Program Reference and Optics Reference (Lambda Research).

mod keyword;
mod surface;

use std::path::Path;

use super::MAX_SURFACES;
use super::glass_name::GlassNames;
use super::report::ReadReport;
use super::text::Line;
use petzval_base::io::ReadContext;
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::Prescription;
use petzval_lens::system::{SequentialSystem, SystemAperture};
use petzval_lens::{Design, FieldKind, Fields, SpectralLine};
use surface::OsloSurface;

/// Commands of a file before they become a system.
struct Reader<'a> {
    report: ReadReport<'a>,
    glasses: GlassNames,
    name: String,
    focal_length: Option<f64>,
    unit: f64,
    aperture: Option<SystemAperture>,
    field: Option<(FieldKind, f64)>,
    wavelengths: Vec<f64>,
    weights: Vec<f64>,
    surfaces: Vec<OsloSurface<'a>>,
    ended: bool,
}

/// Reads a lens.
///
/// # Errors
/// Returns an error with line and column if the file is malformed or states what is not simulated.
pub(super) fn parse(
    path: &Path,
    text: &str,
    context: &ReadContext,
) -> Result<Prescription, LensError> {
    let start = Line { path, number: 1, text: text.lines().next().unwrap_or_default() };
    let mut reader = Reader {
        report: ReadReport::new(context),
        glasses: GlassNames::default(),
        name: String::new(),
        focal_length: None,
        unit: 1.0,
        aperture: None,
        field: None,
        // OSLO's wavelengths, d, F and C, unless the file states others.
        wavelengths: vec![0.587_56, 0.486_13, 0.656_27],
        weights: Vec::new(),
        surfaces: vec![OsloSurface::new(start)],
        ended: false,
    };
    let mut end = start;
    for line in Line::all(path, text) {
        end = line;
        let code = line.text.split("//").next().unwrap_or_default();
        for statement in code.split(';') {
            reader.read(line, statement)?;
        }
    }
    reader.system(&end)?.build(path)
}

impl<'a> Reader<'a> {
    fn read(&mut self, line: Line<'a>, statement: &'a str) -> Result<(), LensError> {
        let mut words = statement.split_whitespace();
        let Some(command) = words.next() else { return Ok(()) };
        let values: Vec<&str> = words.collect();
        let keyword = command.to_ascii_uppercase();
        if self.ended {
            // Tables of variables, operands and rays follow; configurations change the lens.
            if keyword == "CFG" && values.first().is_some_and(|number| *number != "1") {
                self.report.note("the configurations of the file are not read, only the first");
            }
            return Ok(());
        }
        let number = |i: usize| match values.get(i) {
            Some(word) => line.number_of(word),
            None => Err(line.error(command, format!("{keyword} without a value"), "expected one")),
        };
        let all = || values.iter().map(|word| line.number_of(word)).collect::<Result<Vec<_>, _>>();
        match keyword.as_str() {
            "LEN" => {
                let mut quoted = statement.splitn(3, '"').skip(1);
                self.name = quoted.next().unwrap_or_default().trim().to_owned();
                let stated = quoted.next().and_then(|rest| rest.split_whitespace().next());
                self.focal_length = stated.and_then(|word| word.parse().ok());
            }
            "NXT" => {
                if self.surfaces.len() > MAX_SURFACES {
                    let found = format!("more than {MAX_SURFACES} surfaces");
                    return Err(line.error(command, found, "expected a lens of fewer"));
                }
                self.surfaces.push(OsloSurface::new(line));
            }
            "END" => self.ended = true,
            "UNI" => self.unit = number(0)?,
            "EBR" => self.aperture = Some(SystemAperture::EntrancePupil(2.0 * number(0)?)),
            "FNO" => self.aperture = Some(SystemAperture::FNumber(number(0)?)),
            "NAO" => self.aperture = Some(SystemAperture::ObjectNa(number(0)?)),
            "NAP" => self.aperture = Some(SystemAperture::ImageNa(number(0)?)),
            "ANG" => self.field = Some((FieldKind::Angle, number(0)?)),
            "OBH" => self.field = Some((FieldKind::ObjectHeight, number(0)?)),
            "GIH" => self.field = Some((FieldKind::ImageHeight, number(0)?)),
            "WV" => self.wavelengths = all()?,
            "WW" => self.weights = all()?,
            _ => {
                let last = self.surfaces.len() - 1;
                let known = self.surfaces[last].read(line, &keyword, &values, &mut self.report)?;
                if !known && !keyword::changes_no_ray(&keyword) {
                    self.report.unknown(&keyword);
                }
            }
        }
        Ok(())
    }

    /// Converts all commands to a system.
    fn system(mut self, end: &Line<'a>) -> Result<SequentialSystem, LensError> {
        let count = self.surfaces.len();
        if count < 3 {
            let found = format!("{count} surfaces");
            return Err(end.error("", found, "expected object, lens and image, with NXT between"));
        }
        let unit = self.unit;
        if !(unit > 1e-9 && unit < 1e9) {
            let found = format!("a unit of {unit} mm (UNI)");
            return Err(end.error("", found, "expected a positive number"));
        }
        let in_range = |um: &f64| (0.1..=1000.0).contains(um);
        if let Some(um) = self.wavelengths.iter().find(|um| !in_range(um)) {
            let found = format!("a wavelength of {um} um");
            return Err(end.error("", found, "expected 0.1 to 1000 um (WV)"));
        }
        let weight = |i: usize| self.weights.get(i).copied().unwrap_or(1.0);
        let lines = self.wavelengths.iter().enumerate();
        let wavelengths = lines.map(|(i, um)| SpectralLine::from_um(*um, weight(i)));
        let fields = self.field.map(|(kind, value)| {
            let value = if kind == FieldKind::Angle { value } else { value * unit };
            Fields { kind, points: vec![[0.0, 0.0], [0.0, 0.7 * value], [0.0, value]] }
        });
        let mut system = SequentialSystem {
            name: std::mem::take(&mut self.name),
            aperture: self.aperture.map(|aperture| match aperture {
                SystemAperture::EntrancePupil(value) => SystemAperture::EntrancePupil(value * unit),
                other => other,
            }),
            f_number: match self.aperture {
                Some(SystemAperture::FNumber(number)) => Some(number),
                _ => None,
            },
            focal_length: self.focal_length.map(|length| length * unit),
            design: Design { wavelengths: wavelengths.collect(), fields, ..Design::default() },
            ..SequentialSystem::default()
        };
        let object = self.surfaces[0].thickness;
        let near = object.abs() < INFINITE;
        system.design.object_distance = Some(if near { object * unit } else { f64::INFINITY });
        system.object_medium = self.surfaces[0].medium_behind(&self.glasses, &mut self.report)?;
        // The thickness of the image is its distance from the stated place.
        let defocus = self.surfaces[count - 1].thickness;
        self.surfaces[count - 2].thickness += defocus;
        for i in 1..count - 1 {
            let draft = &self.surfaces[i];
            draft.append(i, unit, &self.glasses, &mut system.surfaces, &mut self.report)?;
        }
        system.design.notes = self.report.finish();
        Ok(system)
    }
}
