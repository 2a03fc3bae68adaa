//! Surface of an OSLO file.

use super::super::axis::{decentre_then_tilt, tilt_then_decentre};
use super::super::glass_name::{GlassNames, ModelFigures};
use super::super::report::ReadReport;
use super::super::text::Line;
use super::super::{MAX_POWER, MIN_RADIUS};
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::RayTransferMatrix;
use petzval_lens::Row;
use petzval_lens::system::{MediumBehind, SystemSurface};

/// Commands that change rays and are not simulated.
const UNSIMULATED: [&str; 18] = [
    "CVX", "RDX", "GOR", "DOE", "DFX", "GSP", "GC", "RCO", "TOX", "TOY", "TOZ", "GRD", "GDT",
    "ATP", "AX1", "AY1", "HOR", "EIK",
];

/// Commands about one surface, in units of the file.
pub(super) struct OsloSurface<'a> {
    line: Line<'a>,
    curvature: f64,
    pub thickness: f64,
    medium: OsloMedium<'a>,
    aperture: Option<f64>,
    checked: bool,
    stop: bool,
    conic: f64,
    /// Powers and coefficients.
    terms: Vec<(u32, f64)>,
    /// Step of the powers of the coefficients AS1, AS2, ...: 2 of `ASR`, 1 of `ARA`.
    step: u32,
    shift: [f64; 3],
    tilt: [f64; 3],
    tilt_first: bool,
    bend: bool,
    focal_length: Option<f64>,
}

/// Medium behind a surface.
enum OsloMedium<'a> {
    Air,
    Mirror,
    Named(Line<'a>, &'a str),
    Model(ModelFigures),
}

impl<'a> OsloSurface<'a> {
    pub fn new(line: Line<'a>) -> Self {
        Self {
            line,
            curvature: 0.0,
            thickness: 0.0,
            medium: OsloMedium::Air,
            aperture: None,
            checked: false,
            stop: false,
            conic: 0.0,
            terms: Vec::new(),
            step: 2,
            shift: [0.0; 3],
            tilt: [0.0; 3],
            tilt_first: false,
            bend: false,
            focal_length: None,
        }
    }

    /// Reads a command; returns whether it belongs to a surface.
    pub fn read(
        &mut self,
        line: Line<'a>,
        keyword: &str,
        values: &[&'a str],
        report: &mut ReadReport,
    ) -> Result<bool, LensError> {
        let last = || match values.last() {
            Some(word) => line.number_of(word),
            None => Err(line.error("", format!("{keyword} without a value"), "expected a number")),
        };
        let reciprocal = |radius: f64| if radius == 0.0 { 0.0 } else { radius.recip() };
        match keyword {
            "RD" | "RDF" => self.curvature = reciprocal(last()?),
            "CV" | "CVF" => self.curvature = last()?,
            "TH" | "THF" => self.thickness = last()?,
            "AP" | "APF" => {
                self.aperture = Some(last()?);
                self.checked = values.first().is_some_and(|word| word.eq_ignore_ascii_case("CHK"));
            }
            "AIR" | "AIF" => self.medium = OsloMedium::Air,
            "RFL" | "RFH" => self.medium = OsloMedium::Mirror,
            "GLA" | "GLF" => self.medium = glass(line, values, report)?,
            "AST" => self.stop = true,
            "CC" => self.conic = last()?,
            "AD" | "AE" | "AF" | "AG" => {
                let order = u32::from(keyword.as_bytes()[1] - b'D');
                self.terms.push((4 + 2 * order, last()?));
            }
            "ASP" => match values.first().copied().unwrap_or("ADO") {
                "ADO" | "ASR" => self.step = 2,
                "ARA" => self.step = 1,
                kind => {
                    let what = format!("the asphere ASP {kind}");
                    report.unsimulated(&line, kind, what, "without it")?;
                    self.step = 0;
                }
            },
            "TLA" => self.tilt[0] = last()?,
            "TLB" => self.tilt[1] = last()?,
            "TLC" => self.tilt[2] = last()?,
            "DCX" => self.shift[0] = last()?,
            "DCY" => self.shift[1] = last()?,
            "DCZ" => self.shift[2] = last()?,
            "DT" => self.tilt_first = last()? < 0.0,
            "BEN" => self.bend = true,
            "PFL" => self.focal_length = Some(last()?),
            _ if UNSIMULATED.contains(&keyword) => {
                if values.iter().any(|word| word.parse::<f64>() != Ok(0.0)) {
                    let what = format!("the command {keyword}");
                    report.unsimulated(&line, values.first().unwrap_or(&""), what, "without it")?;
                }
            }
            _ => {
                let Some(index) = keyword.strip_prefix("AS").and_then(|n| n.parse::<u32>().ok())
                else {
                    return Ok(false);
                };
                self.terms.push((self.step * index.min(1000), last()?));
            }
        }
        Ok(true)
    }

    /// Returns the medium behind the surface.
    ///
    /// # Errors
    /// Returns an error if its glass is not known.
    pub fn medium_behind(
        &self,
        glasses: &GlassNames,
        report: &mut ReadReport,
    ) -> Result<MediumBehind, LensError> {
        Ok(match &self.medium {
            OsloMedium::Air => MediumBehind::Air,
            OsloMedium::Mirror => MediumBehind::Mirror,
            OsloMedium::Named(line, name) => glasses.resolve(line, name, None, report)?,
            OsloMedium::Model(figures) => figures.medium(),
        })
    }

    /// Appends the surface to a system, with the changes of the axis around it.
    pub fn append(
        &self,
        number: usize,
        unit: f64,
        glasses: &GlassNames,
        surfaces: &mut Vec<SystemSurface>,
        report: &mut ReadReport,
    ) -> Result<(), LensError> {
        let line = &self.line;
        if self.thickness.abs() >= INFINITE {
            let found = format!("surface {number} has the thickness {}", self.thickness);
            return Err(line.error("", found, "expected a distance below 1e9"));
        }
        let mut row = Row { stop: self.stop, conic: self.conic, ..Row::default() };
        if self.curvature != 0.0 {
            row.radius = unit / self.curvature;
            if row.radius.abs() < MIN_RADIUS {
                let found = format!("surface {number} has the radius {} mm", row.radius);
                return Err(line.error("", found, "expected one above 1e-6 mm"));
            }
        }
        for &(power, coefficient) in self.terms.iter().filter(|(_, value)| *value != 0.0) {
            if !(2..=MAX_POWER).contains(&power) {
                let what = format!("the term r^{power} of surface {number}");
                report.unsimulated(line, "", what, "without it")?;
                continue;
            }
            row.asphere.retain(|(other, _)| *other != power);
            row.asphere.push((power, coefficient * unit.powi(1 - power as i32)));
        }
        if let Some(focal_length) = self.focal_length.filter(|length| *length != 0.0) {
            let c = -(focal_length * unit).recip();
            row.ideal = Some([RayTransferMatrix { a: 1.0, b: 0.0, c, d: 1.0 }; 2]);
        }
        let medium = self.medium_behind(glasses, report)?;
        let [a, b, c] = self.tilt;
        let (shift, tilt) = (self.shift.map(|v| v * unit), [-a, -b, c]);
        let moved = self.shift != [0.0; 3] || self.tilt != [0.0; 3];
        let axis = |coordinate_break| SystemSurface {
            line: line.number,
            coordinate_break: Some(coordinate_break),
            ..SystemSurface::default()
        };
        if moved {
            surfaces.push(axis(match self.tilt_first {
                true => tilt_then_decentre(shift, tilt),
                false => decentre_then_tilt(shift, tilt),
            }));
        }
        surfaces.push(SystemSurface {
            line: line.number,
            row,
            medium,
            semi_diameter: self.aperture.filter(|&radius| radius > 0.0).map(|radius| radius * unit),
            clips: self.checked,
            coordinate_break: None,
        });
        if moved && self.bend {
            surfaces.push(axis(decentre_then_tilt([0.0; 3], tilt)));
        }
        if let Some(last) = surfaces.last_mut() {
            last.row.thickness = self.thickness * unit;
        }
        Ok(())
    }
}

/// Reads a glass: its name, its index, or a model with index and Abbe number.
fn glass<'a>(
    line: Line<'a>,
    values: &[&'a str],
    report: &mut ReadReport,
) -> Result<OsloMedium<'a>, LensError> {
    let number = |i: usize| values.get(i).and_then(|word| word.parse::<f64>().ok());
    let Some(&name) = values.first() else {
        return Err(line.error("", "GLA without a value", "expected a glass or an index"));
    };
    let stated = |from: usize| {
        let nd = number(from)?;
        // Further values above 5 are Abbe numbers, others indices at further wavelengths.
        let vd = number(from + 1).filter(|&vd| vd > 5.0).unwrap_or(0.0);
        Some(ModelFigures { nd, vd, dpgf: 0.0 })
    };
    let figures = match name.eq_ignore_ascii_case("MOD") {
        true => stated(1).or_else(|| stated(2)),
        false => stated(0),
    };
    if figures.is_some_and(|figures| figures.vd == 0.0 && values.len() > 3) {
        report.note(format!("line {}: of a model glass only the first index is read", line.number));
    }
    Ok(match figures {
        Some(figures) if figures.nd >= 1.0 && figures.nd < petzval_lens::MAX_INDEX => {
            OsloMedium::Model(figures)
        }
        Some(figures) => {
            let found = format!("a glass of index {}", figures.nd);
            return Err(line.error(name, found, "expected 1 to 10"));
        }
        None => OsloMedium::Named(line, name),
    })
}
