//! Apertures on surfaces of a Zemax file.

use super::super::report::ReadReport;
use super::super::text::Line;
use super::number_at;
use crate::lens::prescription::error::LensError;
use crate::lens::prescription::system::SystemSurface;

/// Decentre of an aperture around the axis.
const NO_DECENTRE: [f64; 2] = [0.0; 2];

/// Apertures of one surface, in units of the file.
#[derive(Default)]
pub(super) struct Aperture<'a> {
    /// Smallest and largest open radius.
    open: Option<[f64; 2]>,
    /// Smallest and largest blocked radius.
    blocked: Option<[f64; 2]>,
    /// Another shape, by the line of its keyword, and the radius around it.
    other: Option<(Line<'a>, &'a str, Option<f64>)>,
    decentre: Option<(Line<'a>, [f64; 2])>,
}

impl<'a> Aperture<'a> {
    /// Reads a keyword; returns whether it states an aperture.
    pub fn read(
        &mut self,
        line: Line<'a>,
        keyword: &'a str,
        values: &[&'a str],
    ) -> Result<bool, LensError> {
        let number = |i: usize| number_at(&line, keyword, values, i);
        match keyword {
            "CLAP" | "FLAP" => self.open = Some([number(0)?, number(1)?]),
            "OBSC" => self.blocked = Some([number(0)?, number(1)?]),
            "OBDC" => self.decentre = Some((line, [number(0)?, number(1)?])),
            "SQAP" | "ELAP" => {
                let around = match keyword {
                    "SQAP" => number(0)?.hypot(number(1)?),
                    _ => number(0)?.max(number(1)?),
                };
                self.other = Some((line, keyword, Some(around)));
            }
            "SQOB" | "ELOB" | "SPID" | "UDAD" | "UDOB" | "USAP" | "USOB" | "UDAP" => {
                self.other = Some((line, keyword, None));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Applies the apertures to a surface.
    pub fn apply(
        &self,
        number: usize,
        unit: f64,
        surface: &mut SystemSurface,
        report: &mut ReadReport,
    ) -> Result<(), LensError> {
        if let Some([inner, outer]) = self.open {
            surface.row.obstruction = 2.0 * unit * inner.max(0.0);
            if outer > 0.0 {
                surface.semi_diameter = Some(outer * unit);
                surface.clips = true;
            }
        }
        match self.blocked {
            Some([inner, outer]) if inner <= 0.0 => {
                surface.row.obstruction = surface.row.obstruction.max(2.0 * unit * outer.max(0.0));
            }
            Some([inner, _]) => {
                let semi =
                    surface.semi_diameter.map_or(f64::INFINITY, |semi| semi.min(inner * unit));
                surface.semi_diameter = Some(if semi.is_finite() { semi } else { inner * unit });
                surface.clips = true;
            }
            None => {}
        }
        if let Some((line, keyword, around)) = self.other {
            let what = format!("the aperture {keyword} of surface {number}");
            let instead = match around {
                Some(_) => "with the circle around it",
                None => "without it",
            };
            report.unsimulated(&line, keyword, what, instead)?;
            if let Some(around) = around.filter(|&around| around > 0.0) {
                surface.semi_diameter = Some(around * unit);
                surface.clips = true;
            }
        }
        if let Some((line, decentre)) = self.decentre
            && decentre != NO_DECENTRE
        {
            let what = format!("the decentred aperture of surface {number}");
            report.unsimulated(&line, line.words().next().unwrap_or(""), what, "with it wider")?;
            let [x, y] = decentre;
            surface.semi_diameter = surface.semi_diameter.map(|semi| semi + x.hypot(y) * unit);
            surface.row.obstruction = 0.0;
        }
        Ok(())
    }
}
