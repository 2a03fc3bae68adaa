//! Reader of CODE V sequence files (`.seq`).
//!
//! A file is a list of commands. `SO`, `S` and `SI` begin the object, a surface and the image; the
//! commands behind them describe it. Values of solves are stored as they were when the file was
//! written. Source: CODE V Reference Manual, "Lens Data Input".

mod aperture;
mod decentre;
mod glass_table;
mod keyword;
mod statement;
mod surface;
mod zoom;

use std::path::Path;

use super::glass_name::GlassNames;
use super::report::ReadReport;
use super::text::Line;
use super::{MAX_SURFACES, WAVELENGTHS};
use glass_table::GlassTable;
use petzval_base::io::{ReadContext, excerpt};
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::Prescription;
use petzval_lens::system::{SequentialSystem, SystemAperture};
use petzval_lens::{Design, FieldKind, Fields, SpectralLine};
use statement::{CodeVWord, statements};
use surface::{CodeVSurface, Place};
use zoom::ZoomPositions;

/// Commands of a file before they become a system.
struct Reader<'a> {
    report: ReadReport<'a>,
    glasses: GlassNames,
    name: String,
    unit: f64,
    /// Whether surfaces state radii (`RDM`) or curvatures (`RDM N`), once the file says so. CODE V's
    /// own default is curvatures.
    radii: Option<bool>,
    aperture: Option<SystemAperture>,
    field_kind: FieldKind,
    fields: [Vec<f64>; 2],
    wavelengths: Vec<f64>,
    weights: Vec<f64>,
    reference: usize,
    surfaces: Vec<CodeVSurface<'a>>,
    stop: Option<usize>,
    table: Option<GlassTable>,
    zoom: ZoomPositions<'a>,
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
        unit: 1.0,
        radii: None,
        aperture: None,
        field_kind: FieldKind::Angle,
        fields: [Vec::new(), Vec::new()],
        wavelengths: Vec::new(),
        weights: Vec::new(),
        reference: 0,
        surfaces: Vec::new(),
        stop: None,
        table: None,
        zoom: ZoomPositions::default(),
    };
    let statements = statements(path, text);
    for words in &statements {
        reader.read(words)?;
    }
    let end = statements.last().and_then(|words| words.last()).map_or(start, |word| word.line);
    reader.system(&end)?.build(path)
}

impl<'a> Reader<'a> {
    fn read(&mut self, words: &[CodeVWord<'a>]) -> Result<(), LensError> {
        let [command, values @ ..] = words else { return Ok(()) };
        let keyword = command.text.to_ascii_uppercase();
        if let Some(table) = &mut self.table {
            if keyword == "END" {
                self.table = None;
                return Ok(());
            }
            return table.read(command, values, &mut self.glasses, &mut self.report);
        }
        let place = surface_place(&keyword);
        if place.is_some() && values.len() >= 2 {
            return self.begin_surface(command, values);
        }
        let short: String = keyword.chars().take(3).collect();
        // A qualifier such as S3, SO, SI or SS names the surface of a command.
        let (target, values) = match values {
            [first, rest @ ..] if surface_place(&first.text.to_ascii_uppercase()).is_some() => {
                let place = surface_place(&first.text.to_ascii_uppercase()).flatten();
                (place.or(self.surfaces.len().checked_sub(1)), rest)
            }
            _ => (self.surfaces.len().checked_sub(1), values),
        };
        if short == "STO" {
            self.stop = target;
            return Ok(());
        }
        let target = target.filter(|&surface| surface < self.surfaces.len());
        if self.zoom.read(&short, target, values)? {
            return Ok(());
        }
        if let Some(surface) = target
            && self.surfaces[surface].read(command, &short, values, &mut self.report)?
        {
            return Ok(());
        }
        self.read_system(command, &short, values)
    }

    fn begin_surface(
        &mut self,
        command: &CodeVWord<'a>,
        values: &[CodeVWord<'a>],
    ) -> Result<(), LensError> {
        if self.surfaces.len() > MAX_SURFACES {
            let found = format!("more than {MAX_SURFACES} surfaces");
            return Err(command.error(found, "expected a lens of fewer"));
        }
        let curvature = match self.radii {
            Some(true) => curvature_of(values[0].length()?),
            Some(false) | None => values[0].number()?,
        };
        let medium = values.get(2).copied();
        let mut surface = CodeVSurface::new(command.line, curvature, values[1].length()?, medium);
        surface.by_default = self.radii.is_none();
        self.surfaces.push(surface);
        Ok(())
    }

    /// Reads the numbers of a file without `RDM` as radii if they cannot be curvatures: the radii
    /// that they would mean are all smaller than the beam.
    fn read_unlikely_curvatures(&mut self) {
        let reach = match self.aperture {
            Some(SystemAperture::EntrancePupil(diameter)) if diameter > 0.0 => diameter / 2.0,
            _ => 1.0,
        };
        let mut stated: Vec<&mut CodeVSurface<'a>> = self
            .surfaces
            .iter_mut()
            .filter(|surface| surface.by_default && surface.curvature != 0.0)
            .collect();
        if stated.is_empty() || stated.iter().any(|s| s.curvature.abs() * reach <= 1.0) {
            return;
        }
        for surface in &mut stated {
            surface.curvature = curvature_of(surface.curvature);
        }
        self.report.note(
            "the file has no RDM, so its surfaces state curvatures; as curvatures all of them \
             would be smaller than the beam, and they are read as radii",
        );
    }

    fn read_system(
        &mut self,
        command: &CodeVWord<'a>,
        keyword: &str,
        values: &[CodeVWord<'a>],
    ) -> Result<(), LensError> {
        let numbers = || values.iter().map(CodeVWord::number).collect::<Result<Vec<f64>, _>>();
        let number = || match values.first() {
            Some(word) => word.number(),
            None => Err(command.error(format!("{keyword} without a value"), "expected a number")),
        };
        let text = || values.first().map_or("", |word| word.text);
        match keyword {
            "RDM" => self.radii = Some(!text().to_ascii_uppercase().starts_with('N')),
            "TIT" => self.name = text().trim_matches(['\'', '"']).trim().to_owned(),
            "DIM" => {
                self.unit = match text().to_ascii_uppercase().chars().next() {
                    Some('M') => 1.0,
                    Some('C') => 10.0,
                    Some('I') => 25.4,
                    _ => {
                        let found = format!("the unit \"{}\"", excerpt(text()));
                        return Err(command.error(found, "expected M, C or I"));
                    }
                }
            }
            "EPD" => self.aperture = Some(SystemAperture::EntrancePupil(number()?)),
            "FNO" => self.aperture = Some(SystemAperture::FNumber(number()?)),
            "NA" => self.aperture = Some(SystemAperture::ImageNa(number()?)),
            "NAO" => self.aperture = Some(SystemAperture::ObjectNa(number()?)),
            "XAN" | "YAN" | "XOB" | "YOB" | "XIM" | "YIM" | "XRI" | "YRI" => {
                self.field_kind = match &keyword[1..] {
                    "AN" => FieldKind::Angle,
                    "OB" => FieldKind::ObjectHeight,
                    _ => FieldKind::ImageHeight,
                };
                self.fields[usize::from(keyword.starts_with('Y'))] = numbers()?;
            }
            "WL" => self.wavelengths = numbers()?,
            "WTW" => self.weights = numbers()?,
            "REF" => self.reference = (number()? as usize).saturating_sub(1),
            "PRV" => self.table = Some(GlassTable::default()),
            _ if keyword::changes_no_ray(keyword) => {}
            _ => self.report.unknown(keyword),
        }
        Ok(())
    }

    /// Converts all commands to a system.
    fn system(mut self, end: &Line<'a>) -> Result<SequentialSystem, LensError> {
        let count = self.surfaces.len();
        if count < 3 {
            let found = format!("{count} surfaces");
            return Err(end.error("", found, "expected object, lens and image: SO, S ... SI"));
        }
        self.read_unlikely_curvatures();
        if let Some(stop) = self.stop.and_then(|stop| self.surfaces.get_mut(stop)) {
            stop.stop = true;
        }
        let mut system = SequentialSystem {
            name: std::mem::take(&mut self.name),
            design: self.design(end)?,
            ..SequentialSystem::default()
        };
        let defocus = self.surfaces[count - 1].thickness;
        let mut places = vec![None; count];
        let mut returns = decentre::Frames::default();
        for i in 1..count {
            let draft = &mut self.surfaces[i];
            if i + 2 == count {
                draft.thickness += defocus;
            }
            places[i] = draft.append(
                Place { number: i, image: i + 1 == count, unit: self.unit },
                &self.glasses,
                &mut returns,
                &mut system.surfaces,
                &mut self.report,
            )?;
        }
        let object = &self.surfaces[0];
        system.object_medium = object.medium_behind(&self.glasses, &mut self.report)?;
        let near = object.thickness.abs() < INFINITE;
        let distance = if near { object.thickness * self.unit } else { f64::INFINITY };
        system.design.object_distance = Some(distance);
        system.aperture = self.aperture.map(|aperture| match aperture {
            SystemAperture::EntrancePupil(value) => {
                SystemAperture::EntrancePupil(value * self.unit)
            }
            other => other,
        });
        if let Some(SystemAperture::FNumber(number)) = self.aperture {
            system.f_number = Some(number);
        }
        system.design.configurations =
            self.zoom.configurations(&places, self.unit, &mut self.report)?;
        system.design.notes = self.report.finish();
        Ok(system)
    }

    /// Returns wavelengths and fields.
    fn design(&self, end: &Line) -> Result<Design, LensError> {
        if let Some(nm) = self.wavelengths.iter().find(|nm| !WAVELENGTHS.contains(*nm)) {
            let found = format!("a wavelength of {nm} nm");
            return Err(end.error("", found, "expected 100 to 1000000000 nm (WL)"));
        }
        let weight = |i: usize| self.weights.get(i).copied().unwrap_or(1.0);
        let lines = self.wavelengths.iter().enumerate();
        let wavelengths: Vec<SpectralLine> =
            lines.map(|(i, &nm)| SpectralLine { nm, weight: weight(i) }).collect();
        let [x, y] = &self.fields;
        let at = |column: &[f64], i: usize| column.get(i).copied().unwrap_or(0.0);
        let scale = if self.field_kind == FieldKind::Angle { 1.0 } else { self.unit };
        let points: Vec<[f64; 2]> = (0..x.len().max(y.len()))
            .map(|i| [at(x, i), at(y, i)].map(|value| value * scale))
            .collect();
        Ok(Design {
            primary: self.reference.min(wavelengths.len().saturating_sub(1)),
            wavelengths,
            fields: (!points.is_empty()).then_some(Fields { kind: self.field_kind, points }),
            ..Design::default()
        })
    }
}

/// Returns the curvature of a radius; 0 and infinity mean a plane.
fn curvature_of(radius: f64) -> f64 {
    if radius == 0.0 { 0.0 } else { radius.recip() }
}

/// Returns whether a word names a surface (S, SO, SI, S12), and its number if it has one.
fn surface_place(word: &str) -> Option<Option<usize>> {
    match word {
        "S" | "SI" => Some(None),
        "SO" => Some(Some(0)),
        _ => word.strip_prefix('S')?.parse().ok().map(Some),
    }
}
