//! Reader of Zemax lens files (`.zmx`), sequential mode.
//!
//! A file is a list of lines, each a keyword and its values; those between `SURF n` and the next one
//! describe surface n. Surface 0 is the object, the last one the image. Values of pickups and solves
//! are stored as they were when the file was written. Sources: OpticStudio Help, "The Lens Data
//! Editor" and "Surface Types", and files of several versions from 2003 on.

mod aperture;
mod configuration;
mod keyword;
mod surface;
mod surface_type;
pub(super) mod write;

use std::path::Path;

use super::glass_name::GlassNames;
use super::report::ReadReport;
use super::text::Line;
use super::{MAX_SURFACES, WAVELENGTHS};
use configuration::Operand;
use petzval_base::io::{ReadContext, excerpt};
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::Prescription;
use petzval_lens::system::{SequentialSystem, SystemAperture, SystemSurface};
use petzval_lens::{Design, FieldKind, Fields, SpectralLine};
use surface::ZemaxSurface;

/// Statements of a file before they become a system.
struct Reader<'a> {
    report: ReadReport<'a>,
    glasses: GlassNames,
    name: String,
    notes: Vec<String>,
    /// Length of a unit of the file (mm).
    unit: f64,
    aperture: Option<SystemAperture>,
    /// Whether the f-number is that at the stated conjugates.
    working: bool,
    field_kind: FieldKind,
    field_count: Option<usize>,
    wavelength_count: Option<usize>,
    fields: [Vec<f64>; 2],
    wavelengths: Vec<SpectralLine>,
    primary: usize,
    surfaces: Vec<ZemaxSurface<'a>>,
    configurations: usize,
    /// Configuration in which the file was written, from 1; none if it states no configurations.
    current: Option<usize>,
    operands: Vec<Operand<'a>>,
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
        notes: Vec::new(),
        unit: 1.0,
        aperture: None,
        working: false,
        field_kind: FieldKind::Angle,
        field_count: None,
        wavelength_count: None,
        fields: [Vec::new(), Vec::new()],
        wavelengths: Vec::new(),
        primary: 0,
        surfaces: Vec::new(),
        configurations: 1,
        current: None,
        operands: Vec::new(),
    };
    let mut end = start;
    for line in Line::all(path, text) {
        end = line;
        reader.read(line)?;
    }
    reader.system(&end)?.build(path)
}

impl<'a> Reader<'a> {
    fn read(&mut self, line: Line<'a>) -> Result<(), LensError> {
        let mut words = line.words();
        let Some(keyword) = words.next() else { return Ok(()) };
        let values: Vec<&str> = words.collect();
        if keyword == "SURF" {
            if self.surfaces.len() > MAX_SURFACES {
                let found = format!("more than {MAX_SURFACES} surfaces");
                return Err(line.error(keyword, found, "expected a lens of fewer"));
            }
            self.surfaces.push(ZemaxSurface::new(line));
            return Ok(());
        }
        if let Some(surface) = self.surfaces.last_mut()
            && surface.read(line, keyword, &values, &mut self.report)?
        {
            return Ok(());
        }
        if self.current.is_some() && configuration::is_operand(keyword) {
            self.operands.extend(Operand::read(line, keyword, &values)?);
            return Ok(());
        }
        self.read_system(line, keyword, &values)
    }

    fn read_system(
        &mut self,
        line: Line<'a>,
        keyword: &'a str,
        values: &[&'a str],
    ) -> Result<(), LensError> {
        let number = |i: usize| number_at(&line, keyword, values, i);
        let all = || values.iter().map(|word| line.number_of(word)).collect::<Result<Vec<_>, _>>();
        let rest = || line.text.trim_start()[keyword.len()..].trim().trim_matches('"').to_owned();
        match keyword {
            "MODE" if values.first().is_some_and(|mode| *mode != "SEQ") => {
                let found = format!("the mode {}", excerpt(values[0]));
                return Err(line.error(values[0], found, "expected a sequential lens: MODE SEQ"));
            }
            "UNIT" => self.unit = unit(&line, values.first().copied().unwrap_or("MM"))?,
            "NAME" => self.name = rest(),
            "NOTE" => {
                let text = rest();
                let text = text.split_once(' ').map_or("", |(_, text)| text).trim();
                if !text.is_empty() {
                    self.notes.push(text.to_owned());
                }
            }
            "ENPD" => self.aperture = Some(SystemAperture::EntrancePupil(number(0)?)),
            "FNUM" => {
                self.aperture = Some(SystemAperture::FNumber(number(0)?));
                self.working = values.get(1).is_some_and(|flag| *flag == "1");
            }
            "OBNA" => {
                let value = number(0)?;
                let cone = values.get(1).is_some_and(|flag| *flag == "1");
                let na = if cone { value.to_radians().sin() } else { value };
                self.aperture = Some(SystemAperture::ObjectNa(na));
            }
            "FLOA" => self.aperture = None,
            "FTYP" => {
                self.field_kind = match values.first() {
                    Some(&"1") => FieldKind::ObjectHeight,
                    Some(&"2" | &"3") => FieldKind::ImageHeight,
                    _ => FieldKind::Angle,
                };
                let count = |i: usize| values.get(i).and_then(|word| word.parse().ok());
                (self.field_count, self.wavelength_count) = (count(2), count(3));
            }
            "XFLN" | "XFLD" => self.fields[0] = all()?,
            "YFLN" | "YFLD" => self.fields[1] = all()?,
            "WAVM" => {
                self.wavelengths.push(SpectralLine::from_um(number(1)?, number(2).unwrap_or(1.0)));
            }
            "WAVL" | "WAVN" => {
                let lines = all()?.into_iter().map(|um| SpectralLine::from_um(um, 1.0));
                self.wavelengths = lines.collect();
            }
            "WWGT" | "WWGN" => {
                for (line, weight) in self.wavelengths.iter_mut().zip(all()?) {
                    line.weight = weight;
                }
            }
            "PWAV" => self.primary = (number(0)? as usize).saturating_sub(1),
            "GCAT" => self.glasses.prefer(values.iter().copied()),
            "MNUM" => {
                self.configurations = (number(0)? as usize).clamp(1, MAX_SURFACES);
                let current = if values.len() > 1 { number(1)? as usize } else { 1 };
                self.current = Some(current.clamp(1, self.configurations));
            }
            "ENVD" if self.other_environment(values) => {
                self.report.note(
                    "indices are those at 20 degrees C and 1 atm, not those of the environment \
                     that the file states",
                );
            }
            _ if keyword::changes_no_ray(keyword) || !self.surfaces.is_empty() => {}
            _ => self.report.unknown(keyword),
        }
        Ok(())
    }

    /// Returns whether an environment other than 20 degrees C and 1 atm changes the indices.
    fn other_environment(&self, values: &[&str]) -> bool {
        let number = |i: usize| values.get(i).and_then(|word| word.parse::<f64>().ok());
        number(2) == Some(1.0) && (number(0) != Some(20.0) || number(1) != Some(1.0))
    }

    /// Converts all statements to a system.
    fn system(mut self, end: &Line<'a>) -> Result<SequentialSystem, LensError> {
        let count = self.surfaces.len();
        if count < 3 {
            let found = format!("{count} surfaces");
            return Err(end.error("", found, "expected object, lens and image: SURF 0, 1, 2 ..."));
        }
        if let Some(current) = self.current {
            let (operands, surfaces) = (&self.operands, &mut self.surfaces);
            configuration::settle(operands, current, surfaces, &mut self.aperture);
            self.note_current_configuration();
        }
        let mut system = SequentialSystem {
            name: std::mem::take(&mut self.name),
            source: (!self.notes.is_empty()).then(|| self.notes.join(" ")),
            design: self.design(end)?,
            ..SequentialSystem::default()
        };
        let mut places = vec![None; count];
        let image = &self.surfaces[count - 1];
        if image.curvature != 0.0 {
            self.report.note("the image surface is curved; the film is flat");
        }
        let pickups: Vec<_> = self.surfaces.iter().map(|draft| draft.glass.clone()).collect();
        for (i, draft) in self.surfaces[1..count - 1].iter().enumerate() {
            let Some(surface) =
                draft.surface(1 + i, self.unit, &self.glasses, &pickups, &mut self.report)?
            else {
                continue;
            };
            places[1 + i] = Some(system.surfaces.len());
            system.surfaces.push(surface);
        }
        if let Some(axis) = self.surfaces[count - 1].tilted_axis() {
            let line = self.surfaces[count - 1].line.number;
            let coordinate_break = Some(axis);
            system.surfaces.push(SystemSurface { line, coordinate_break, ..Default::default() });
        }
        let object = &self.surfaces[0];
        system.object_medium = object.medium(&self.glasses, &pickups, &mut self.report)?;
        let distance = object.thickness * self.unit;
        system.design.object_distance =
            Some(if object.thickness.abs() < INFINITE { distance } else { f64::INFINITY });
        if self.working && object.thickness.abs() < INFINITE {
            self.report.note("the working f-number of the file is taken as that at infinity");
        }
        system.aperture = self.aperture.map(|aperture| match aperture {
            SystemAperture::EntrancePupil(value) => {
                SystemAperture::EntrancePupil(value * self.unit)
            }
            other => other,
        });
        system.f_number = match self.aperture {
            Some(SystemAperture::FNumber(number)) => Some(number),
            _ => None,
        };
        system.design.configurations = configuration::configurations(
            self.configurations,
            &self.operands,
            &places,
            self.unit,
            self.aperture,
            &mut self.report,
        );
        system.design.notes = self.report.finish();
        Ok(system)
    }

    /// Says which configuration the lens is in, if there are several.
    fn note_current_configuration(&mut self) {
        if let (Some(current), count @ 2..) = (self.current, self.configurations) {
            self.report.note(format!(
                "the lens is in configuration {current} of {count}, the current one of the file; \
                 'zoom' chooses another"
            ));
        }
    }

    /// Returns wavelengths and fields.
    fn design(&mut self, end: &Line) -> Result<Design, LensError> {
        let count = self.wavelength_count.filter(|&count| count > 0);
        self.wavelengths.truncate(count.unwrap_or_else(|| self.wavelengths.len().min(1)));
        if let Some(line) = self.wavelengths.iter().find(|line| !WAVELENGTHS.contains(&line.nm)) {
            let found = format!("a wavelength of {} um", line.nm / 1000.0);
            return Err(end.error("", found, "expected 0.1 to 1000000 um (WAVM)"));
        }
        let [x, y] = &self.fields;
        let count = self.field_count.unwrap_or(x.len().max(y.len())).min(x.len().max(y.len()));
        let at = |column: &[f64], i: usize| column.get(i).copied().unwrap_or(0.0);
        let scale = if self.field_kind == FieldKind::Angle { 1.0 } else { self.unit };
        let points =
            (0..count).map(|i| [at(x, i), at(y, i)].map(|v| v * scale)).collect::<Vec<_>>();
        Ok(Design {
            primary: self.primary.min(self.wavelengths.len().saturating_sub(1)),
            wavelengths: std::mem::take(&mut self.wavelengths),
            fields: (!points.is_empty()).then_some(Fields { kind: self.field_kind, points }),
            ..Design::default()
        })
    }
}

/// Returns the length of a unit (mm).
fn unit(line: &Line, word: &str) -> Result<f64, LensError> {
    Ok(match word {
        "MM" => 1.0,
        "CM" => 10.0,
        "IN" | "INCH" => 25.4,
        "METER" | "M" => 1000.0,
        _ => {
            let found = format!("the unit {}", excerpt(word));
            return Err(line.error(word, found, "expected MM, CM, IN or METER"));
        }
    })
}

/// Returns value `i` of a keyword as a number.
fn number_at(line: &Line, keyword: &str, values: &[&str], i: usize) -> Result<f64, LensError> {
    match values.get(i) {
        Some(word) => line.number_of(word),
        None => {
            let found = format!("{} with {} values", excerpt(keyword), values.len());
            Err(line.error(keyword, found, &format!("expected at least {}", i + 1)))
        }
    }
}
