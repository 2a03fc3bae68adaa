//! Surface of a CODE V file.

use glam::{DAffine3, DVec3};

use super::super::MIN_RADIUS;
use super::super::glass_name::GlassNames;
use super::super::report::ReadReport;
use super::super::text::Line;
use super::aperture::Apertures;
use super::decentre::{Decentre, Frames};
use super::{CodeVWord, curvature_of, surface_place};
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::RayTransferMatrix;
use petzval_lens::Row;
use petzval_lens::system::{MediumBehind, SystemSurface};

/// Coefficients of r^4 to r^20.
const COEFFICIENTS: [&str; 9] = ["A", "B", "C", "D", "E", "F", "G", "H", "J"];

/// Shapes and properties that are not simulated.
const UNSIMULATED: [&str; 22] = [
    "CYL", "XTO", "YTO", "AAS", "SPL", "ODD", "ZRN", "ZFR", "SCN", "ASC", "DIF", "DOE", "HOE",
    "GRT", "GRS", "GRI", "UDS", "SPS", "XYP", "QBF", "QCN", "GLB",
];

/// Commands about one surface, in units of the file.
pub(super) struct CodeVSurface<'a> {
    line: Line<'a>,
    pub curvature: f64,
    /// Whether the curvature is a number of the surface's line, read by CODE V's default.
    pub by_default: bool,
    pub thickness: f64,
    pub medium: Option<CodeVWord<'a>>,
    pub stop: bool,
    conic: f64,
    coefficients: [f64; 9],
    apertures: Apertures<'a>,
    decentre: Decentre,
    module: Option<f64>,
}

/// Place of a surface in its file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub number: usize,
    /// Whether it is the image.
    pub image: bool,
    /// Unit of lengths (mm).
    pub unit: f64,
}

impl<'a> CodeVSurface<'a> {
    pub fn new(
        line: Line<'a>,
        curvature: f64,
        thickness: f64,
        medium: Option<CodeVWord<'a>>,
    ) -> Self {
        Self {
            line,
            curvature,
            by_default: false,
            thickness,
            medium,
            stop: false,
            conic: 0.0,
            coefficients: [0.0; 9],
            apertures: Apertures::default(),
            decentre: Decentre::default(),
            module: None,
        }
    }

    /// Reads a command; returns whether it belongs to a surface.
    pub fn read(
        &mut self,
        command: &CodeVWord<'a>,
        keyword: &str,
        values: &[CodeVWord<'a>],
        report: &mut ReadReport,
    ) -> Result<bool, LensError> {
        let last = || match values.last() {
            Some(word) => word.number(),
            None => Err(command.error(format!("{keyword} without a value"), "expected a number")),
        };
        let length = || match values.last() {
            Some(word) => word.length(),
            None => Err(command.error(format!("{keyword} without a value"), "expected a number")),
        };
        let kind = || values.first().map_or("", |word| word.text).to_ascii_uppercase();
        if let Some(i) = COEFFICIENTS.iter().position(|name| *name == keyword) {
            self.coefficients[i] = last()?;
            return Ok(true);
        }
        let target = values
            .first()
            .and_then(|word| surface_place(&word.text.to_ascii_uppercase()).flatten());
        if self.decentre.read(command, keyword, values, target)? {
            return Ok(true);
        }
        match keyword {
            "RDY" => {
                let radius = length()?;
                self.curvature = curvature_of(radius);
                self.by_default = false;
            }
            "CUY" => {
                self.curvature = last()?;
                self.by_default = false;
            }
            // Solves such as "THI HMY 0.0": the value is stored.
            "THI" if values.len() == 1 => self.thickness = length()?,
            "THI" => {}
            "GLA" => {
                let zoomed = values.windows(2).any(|pair| pair[0].text != pair[1].text);
                if let (true, Some(word)) = (zoomed, values.get(1)) {
                    let instead = "with the glass of the first position";
                    report.unsimulated(&word.line, word.text, "a zoomed glass", instead)?;
                }
                self.medium = values.first().copied();
            }
            "K" => self.conic = last()?,
            _ if self.apertures.read(command, keyword, values)? => {}
            "MFL" => self.module = Some(last()?),
            "RMD" if kind() == "REFL" => self.medium = values.first().copied(),
            "RMD" => {}
            _ if UNSIMULATED.contains(&keyword) => {
                // The type of a special surface stands behind its keyword.
                let subtype = match values.first() {
                    Some(word) if word.text.parse::<f64>().is_err() => format!(" {}", kind()),
                    _ => String::new(),
                };
                let what = format!("the command {keyword}{subtype} of a surface");
                report.unsimulated(&command.line, command.text, what, "without it")?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Appends the surface to a system, with the changes of the axis around it, and returns the
    /// place of the surface that holds its thickness. The image has only a change of the axis.
    pub fn append(
        &self,
        Place { number, image, unit }: Place,
        glasses: &GlassNames,
        frames: &mut Frames,
        surfaces: &mut Vec<SystemSurface>,
        report: &mut ReadReport,
    ) -> Result<Option<usize>, LensError> {
        let line = &self.line;
        if self.thickness.abs() >= INFINITE && !image {
            let found = format!("surface {number} has the thickness {}", self.thickness);
            return Err(line.error("", found, "expected a distance below 1e9"));
        }
        let axis = |coordinate_break: DAffine3| SystemSurface {
            line: line.number,
            coordinate_break: Some(coordinate_break),
            ..SystemSurface::default()
        };
        let [mut before, behind] = self.decentre.changes(unit);
        if let Some(back) = self.decentre.back_to {
            let Some(target) = back.checked_sub(1).and_then(|back| frames.surfaces.get(back))
            else {
                let found = format!("RET to surface {back}");
                return Err(line.error("", found, "expected a surface before this one"));
            };
            let home = frames.next.inverse() * *target;
            before = Some(before.map_or(home, |own| home * own));
        }
        let here = frames.next * before.unwrap_or(DAffine3::IDENTITY);
        surfaces.extend(before.map(axis));
        frames.surfaces.push(here);
        if image {
            return Ok(None);
        }
        let thickness = self.thickness * unit;
        let onward = DAffine3::from_translation(DVec3::new(0.0, 0.0, thickness));
        frames.next = here * behind.unwrap_or(DAffine3::IDENTITY) * onward;
        surfaces.push(self.surface(number, unit, glasses, report)?);
        surfaces.extend(behind.map(axis));
        let last = surfaces.len() - 1;
        surfaces[last].row.thickness = thickness;
        Ok(Some(last))
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
        let Some(word) = self.medium else { return Ok(MediumBehind::Air) };
        Ok(match word.text.to_ascii_uppercase().as_str() {
            "AIR" | "REFR" => MediumBehind::Air,
            "REFL" | "TIRO" => MediumBehind::Mirror,
            _ => glasses.resolve(&word.line, word.text, None, report)?,
        })
    }

    fn surface(
        &self,
        number: usize,
        unit: f64,
        glasses: &GlassNames,
        report: &mut ReadReport,
    ) -> Result<SystemSurface, LensError> {
        let line = &self.line;
        let mut row = Row { stop: self.stop, conic: self.conic, ..Row::default() };
        if self.curvature != 0.0 {
            row.radius = unit / self.curvature;
            if row.radius.abs() < MIN_RADIUS {
                let found = format!("surface {number} has the radius {} mm", row.radius);
                return Err(line.error("", found, "expected one above 1e-6 mm"));
            }
        }
        for (i, coefficient) in (0u32..).zip(self.coefficients) {
            if coefficient != 0.0 {
                let power = 4 + 2 * i;
                row.asphere.push((power, coefficient * unit.powi(1 - power as i32)));
            }
        }
        if let Some(focal_length) = self.module.filter(|length| *length != 0.0) {
            let c = -(focal_length * unit).recip();
            row.ideal = Some([RayTransferMatrix { a: 1.0, b: 0.0, c, d: 1.0 }; 2]);
        }
        let medium = self.medium_behind(glasses, report)?;
        let mut surface =
            SystemSurface { line: line.number, row, medium, ..SystemSurface::default() };
        self.apertures.apply(number, unit, &mut surface, report)?;
        Ok(surface)
    }
}
