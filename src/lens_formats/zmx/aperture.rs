//! Apertures on surfaces of a Zemax file.

use super::super::report::ReadReport;
use super::super::text::Line;
use super::number_at;
use petzval_lens::LensError;
use petzval_lens::system::SystemSurface;
use petzval_lens::{ApertureForm, SurfaceAperture};

/// Decentre of an aperture around the axis.
const NO_DECENTRE: [f64; 2] = [0.0; 2];

/// Greatest number of arms of a spider.
const MOST_ARMS: f64 = 64.0;

/// Apertures of one surface, in units of the file.
#[derive(Default)]
pub(super) struct Aperture<'a> {
    /// Smallest and largest open radius.
    open: Option<[f64; 2]>,
    /// Smallest and largest blocked radius.
    blocked: Option<[f64; 2]>,
    /// Rectangle or ellipse around the origin.
    shape: Option<SurfaceAperture>,
    /// Width and number of the arms of a spider.
    spider: Option<[f64; 2]>,
    /// Keyword of a shape in a file of its own.
    other: Option<&'a str>,
    decentre: [f64; 2],
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
        let rim = |i: usize| match values.get(i) {
            Some(word) => line.length_of(word),
            None => number(i),
        };
        let half_widths = || -> Result<[f64; 2], LensError> {
            let half_widths = [number(0)?, number(1)?];
            match half_widths.iter().find(|half| !(1e-9..=1e9).contains(*half)) {
                None => Ok(half_widths),
                Some(half) => {
                    let found = format!("{keyword} with a half-width of {half}");
                    Err(line.error(keyword, found, "expected 1e-9 to 1e9"))
                }
            }
        };
        let shape = |form: ApertureForm, obscures: bool| -> Result<_, LensError> {
            let half_widths = half_widths()?;
            let centre = NO_DECENTRE;
            Ok(Some(SurfaceAperture { form, half_widths, centre, rotation: 0.0, obscures }))
        };
        match keyword {
            // "CLAP 15 INF" has no outer rim.
            "CLAP" | "FLAP" => self.open = Some([number(0)?, rim(1)?]),
            "OBSC" => self.blocked = Some([number(0)?, rim(1)?]),
            "OBDC" => self.decentre = [number(0)?, number(1)?],
            "SQAP" => self.shape = shape(ApertureForm::Rectangle, false)?,
            "SQOB" => self.shape = shape(ApertureForm::Rectangle, true)?,
            "ELAP" => self.shape = shape(ApertureForm::Ellipse, false)?,
            "ELOB" => self.shape = shape(ApertureForm::Ellipse, true)?,
            "SPID" => {
                let [width, arms] = [number(0)?, number(1)?];
                if !(0.0..=1e9).contains(&width) || !(0.0..=MOST_ARMS).contains(&arms) {
                    let found = format!("SPID with {arms} arms of the width {width}");
                    return Err(line.error(keyword, found, "expected a width, and 1 to 64 arms"));
                }
                self.spider = Some([width, arms.trunc()]);
            }
            "UDAD" | "UDOB" | "USAP" | "USOB" | "UDAP" => self.other = Some(keyword),
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
        if let Some(keyword) = self.other {
            report.note(format!(
                "surface {number}: the shape of its user-defined aperture ({keyword}) stands in a file \
                 of its own and is not used; light that it would block passes, up to the \
                 semi-diameter: state it by apertures of a .toml lens (petzval lens convert)"
            ));
        }
        if self.decentre == NO_DECENTRE {
            self.apply_centred_circles(unit, surface);
        }
        for aperture in self.shapes() {
            let aperture = SurfaceAperture {
                half_widths: aperture.half_widths.map(|half| half * unit),
                centre: self.decentre.map(|place| place * unit),
                ..aperture
            };
            if !aperture.obscures {
                surface.semi_diameter = Some(aperture.reach());
                surface.clips = true;
            }
            surface.row.apertures.push(aperture);
        }
        if let Some([width, arms]) = self.spider
            && width > 0.0
        {
            self.apply_spider(number, [width * unit, arms], unit, surface, report);
        }
        Ok(())
    }

    /// Adds the arms of a spider, the first along x and all at equal angles. They reach beyond any rim,
    /// or from a decentred spider beyond the rim on its other side.
    fn apply_spider(
        &self,
        number: usize,
        [width, arms]: [f64; 2],
        unit: f64,
        surface: &mut SystemSurface,
        report: &mut ReadReport,
    ) {
        let [x, y] = self.decentre.map(|place| place * unit);
        let Some(semi) = surface.semi_diameter else {
            report.note(format!(
                "surface {number}: its spider (SPID) is left out, because the file states no \
                 semi-diameter of the surface; its arms would block light"
            ));
            return;
        };
        let reach = 2.0 * semi + x.hypot(y);
        for arm in 0..arms as u32 {
            let direction = 360.0 * f64::from(arm) / arms;
            let arm = SurfaceAperture::arm(width, reach, direction);
            let centre = [arm.centre[0] + x, arm.centre[1] + y];
            surface.row.apertures.push(SurfaceAperture { centre, ..arm });
        }
    }

    fn apply_centred_circles(&self, unit: f64, surface: &mut SystemSurface) {
        if let Some([inner, outer]) = self.open {
            surface.row.obstruction = 2.0 * unit * inner.max(0.0);
            if outer > 0.0 && outer.is_finite() {
                surface.semi_diameter = Some(outer * unit);
                surface.clips = true;
            }
        }
        match self.blocked {
            Some([inner, outer]) if inner <= 0.0 && outer.is_finite() => {
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
    }

    /// Returns the rectangle or ellipse, and circles that are decentred, around the origin.
    fn shapes(&self) -> Vec<SurfaceAperture> {
        let mut shapes: Vec<SurfaceAperture> = self.shape.into_iter().collect();
        if self.decentre == NO_DECENTRE {
            return shapes;
        }
        let circle = |radius: f64| {
            (radius > 0.0 && radius.is_finite())
                .then(|| SurfaceAperture::circle(radius, NO_DECENTRE))
        };
        if let Some([inner, outer]) = self.open {
            shapes.extend(circle(outer));
            shapes.extend(circle(inner).map(SurfaceAperture::obscuring));
        }
        match self.blocked {
            Some([inner, outer]) if inner <= 0.0 => {
                shapes.extend(circle(outer).map(SurfaceAperture::obscuring));
            }
            // Light outside the opaque ring is left out, as in a centred one.
            Some([inner, _]) => shapes.extend(circle(inner)),
            None => {}
        }
        shapes
    }
}
