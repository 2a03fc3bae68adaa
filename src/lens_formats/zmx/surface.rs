//! Surface of a Zemax file.

use std::collections::BTreeMap;

use glam::DAffine3;

use super::super::MIN_RADIUS;
use super::super::axis::{decentre_then_tilt, tangents_to_angles, tilt_then_decentre};
use super::super::glass_name::{GlassNames, ModelFigures};
use super::super::report::ReadReport;
use super::super::text::Line;
use super::aperture::Aperture;
use super::{keyword, number_at, surface_type};
use petzval_lens::LensError;
use petzval_lens::Row;
use petzval_lens::system::{MediumBehind, SystemSurface};
use petzval_lens::{INFINITE, MAX_INDEX, MIN_INDEX};

/// Statements about one surface, in units of the file.
pub(super) struct ZemaxSurface<'a> {
    /// Line of `SURF`.
    pub line: Line<'a>,
    /// Line of `TYPE` and the type.
    pub kind: (Line<'a>, &'a str),
    pub curvature: f64,
    pub conic: f64,
    /// Distance to the next surface; infinite for a distant object.
    pub thickness: f64,
    /// `PARM` by number.
    pub parameters: BTreeMap<usize, f64>,
    /// `XDAT` by number.
    pub extra: BTreeMap<usize, f64>,
    pub glass: Option<NamedGlass<'a>>,
    pub semi_diameter: Option<f64>,
    aperture: Aperture<'a>,
    stop: bool,
    ignored: bool,
}

/// Value of `GLAS`.
#[derive(Clone)]
pub(super) struct NamedGlass<'a> {
    pub line: Line<'a>,
    pub name: &'a str,
    /// Surface whose glass it is, if the file says only that.
    pickup: Option<usize>,
    figures: Option<ModelFigures>,
}

impl<'a> ZemaxSurface<'a> {
    pub fn new(line: Line<'a>) -> Self {
        Self {
            line,
            kind: (line, "STANDARD"),
            curvature: 0.0,
            conic: 0.0,
            thickness: 0.0,
            parameters: BTreeMap::new(),
            extra: BTreeMap::new(),
            glass: None,
            semi_diameter: None,
            aperture: Aperture::default(),
            stop: false,
            ignored: false,
        }
    }

    /// Reads a keyword; returns whether it belongs to a surface.
    pub fn read(
        &mut self,
        line: Line<'a>,
        keyword: &'a str,
        values: &[&'a str],
        report: &mut ReadReport,
    ) -> Result<bool, LensError> {
        let number = |i: usize| number_at(&line, keyword, values, i);
        let index = |i: usize| number(i).map(|value| value as usize);
        match keyword {
            "TYPE" => {
                let kind = values.first().copied().unwrap_or("STANDARD");
                self.kind = (line, kind);
            }
            "CURV" => self.curvature = number(0)?,
            "CONI" => self.conic = number(0)?,
            "DISZ" if values.first().is_some_and(|word| word.starts_with("INF")) => {
                self.thickness = f64::INFINITY;
            }
            "DISZ" => {
                self.thickness = match values.first() {
                    Some(word) => line.length_of(word)?,
                    None => number(0)?,
                }
            }
            "PARM" => {
                self.parameters.insert(index(0)?, number(1)?);
            }
            "XDAT" | "YDAT" => {
                self.extra.insert(index(0)?, number(1)?);
            }
            "GLAS" => self.glass = NamedGlass::read(line, values)?,
            "DIAM" => self.semi_diameter = Some(number(0)?),
            "STOP" => self.stop = true,
            "IGNR" | "IGNS" => self.ignored = values.first().is_none_or(|flag| *flag != "0"),
            _ if self.aperture.read(line, keyword, values)? => {}
            _ if keyword::surface_changes_no_ray(keyword) => {}
            _ if line.text.starts_with([' ', '\t']) => report.unknown(keyword),
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Converts the statements to a surface; none for an ignored one.
    pub fn surface(
        &self,
        number: usize,
        unit: f64,
        glasses: &GlassNames,
        all: &[Option<NamedGlass<'a>>],
        report: &mut ReadReport,
    ) -> Result<Option<SystemSurface>, LensError> {
        if self.ignored {
            report.note(format!("surface {number} is ignored, as the file says"));
            return Ok(None);
        }
        let line = &self.line;
        if self.thickness.abs() >= INFINITE {
            let found = format!("surface {number} has the thickness {}", self.thickness);
            return Err(line.error("", found, "expected a distance below 1e9"));
        }
        let thickness = self.thickness * unit;
        let row = Row { thickness, stop: self.stop, ..Row::default() };
        let mut surface = SystemSurface { line: line.number, row, ..SystemSurface::default() };
        if self.kind.1 == "COORDBRK" {
            let parameter = |i: usize| self.parameters.get(&i).copied().unwrap_or(0.0);
            let decentre = [parameter(1) * unit, parameter(2) * unit, 0.0];
            let tilt = [3, 4, 5].map(parameter);
            surface.coordinate_break = Some(match parameter(6) == 0.0 {
                true => decentre_then_tilt(decentre, tilt),
                false => tilt_then_decentre(decentre, tilt),
            });
            return Ok(Some(surface));
        }
        surface.row.radius = radius_of(self.curvature / unit);
        if surface.row.radius.abs() < MIN_RADIUS {
            let found = format!("surface {number} has the curvature {}", self.curvature);
            return Err(line.error("", found, "expected a radius above 1e-6 mm"));
        }
        surface.row.conic = self.conic;
        surface_type::shape(self, number, unit, &mut surface.row, report)?;
        surface.semi_diameter =
            self.semi_diameter.filter(|&semi| semi > 0.0).map(|semi| semi * unit);
        self.aperture.apply(number, unit, &mut surface, report)?;
        surface.medium = self.medium(glasses, all, report)?;
        Ok(Some(surface))
    }

    /// Returns the axis of a tilted plane, if it is one.
    pub fn tilted_axis(&self) -> Option<DAffine3> {
        let tangents = [1, 2].map(|i| self.parameters.get(&i).copied().unwrap_or(0.0));
        let tilted = self.kind.1 == "TILTSURF" && tangents != [0.0; 2];
        let [x, y] = tangents_to_angles(tangents);
        tilted.then(|| decentre_then_tilt([0.0; 3], [x, y, 0.0]))
    }

    /// Returns the medium behind the surface.
    pub fn medium(
        &self,
        glasses: &GlassNames,
        all: &[Option<NamedGlass<'a>>],
        report: &mut ReadReport,
    ) -> Result<MediumBehind, LensError> {
        let picked = |glass: &NamedGlass<'a>| {
            glass.pickup.and_then(|surface| all.get(surface).cloned().flatten())
        };
        let Some(glass) = &self.glass else { return Ok(MediumBehind::Air) };
        let glass = picked(glass).unwrap_or_else(|| glass.clone());
        Ok(match (glass.name, glass.figures) {
            ("MIRROR", _) => MediumBehind::Mirror,
            // A model glass of negative index reflects.
            ("___BLANK", Some(figures)) if figures.nd < 0.0 => MediumBehind::Mirror,
            ("___BLANK", Some(figures)) => figures.medium(),
            ("___BLANK", None) | ("AIR" | "VACUUM", _) => MediumBehind::Air,
            (name, figures) => {
                // 1.5 and 40 stand beside names for which no figures were given.
                let given = figures.filter(|figures| (figures.nd, figures.vd) != (1.5, 40.0));
                glasses.resolve(&glass.line, name, given, report)?
            }
        })
    }
}

/// Returns the radius of a curvature, infinite for none: of all that have this curvature the one with
/// the fewest digits, because programs store the curvature of a radius that was stated.
fn radius_of(curvature: f64) -> f64 {
    if curvature == 0.0 {
        return f64::INFINITY;
    }
    let radius = curvature.recip();
    let shorter = (0..16).filter_map(|digits| format!("{radius:.digits$e}").parse().ok());
    shorter.into_iter().find(|shorter: &f64| shorter.recip() == curvature).unwrap_or(radius)
}

impl<'a> NamedGlass<'a> {
    /// Reads name, kind (0 catalogue, 1 model, 2 and above pickup), surface of a pickup, index, Abbe
    /// number and deviation of the partial dispersion.
    fn read(line: Line<'a>, values: &[&'a str]) -> Result<Option<Self>, LensError> {
        let Some(&name) = values.first() else { return Ok(None) };
        let number = |i: usize| values.get(i).map_or(Ok(0.0), |word| line.number_of(word));
        let figures = ModelFigures { nd: number(3)?, vd: number(4)?, dpgf: number(5)? };
        let kind = number(1)?;
        let mirror = name == "___BLANK" && (-MAX_INDEX..=-1.0).contains(&figures.nd);
        let stated = mirror || (figures.nd != 1.0 && (MIN_INDEX..MAX_INDEX).contains(&figures.nd));
        if name == "___BLANK" && !stated && kind < 2.0 && figures.nd != 1.0 && figures.nd != 0.0 {
            let found = format!("a model glass of index {}", figures.nd);
            return Err(line.error(values[3], found, "expected 1 to 10, or -1 for a mirror"));
        }
        let unnamed = name == "___BLANK" && !stated;
        let pickup = (unnamed && kind >= 2.0).then_some(number(2)? as usize);
        Ok(Some(Self { line, name, pickup, figures: stated.then_some(figures) }))
    }
}
