//! Report of a lens: analyses by real rays, as JSON, CSV, SVG, PNG and one page.
//!
//! [`LensReport::new`] traces the fields once. [`LensReport::analyse`] makes a section of the report from
//! them, by the name of an analysis ([`ANALYSES`]), and [`LensReport::files`] returns the files.

mod curves;
mod fans;
mod files;
mod first_order;
mod heading;
mod inputs;
mod light;
mod missing;
mod page;
mod picture;
mod point;
mod section;
mod spots;
mod transfer;
mod transmittance;
mod wave;

use petzval_lens::Prescription;
use petzval_optics::{ImageQuality, ImagingConditions, ImagingGrid};

use inputs::ReportInputs;
use section::ReportFailure;

pub use files::{PageText, ReportFile};
pub use point::{PointReport, point_report};
pub use section::ReportSection;

/// Fields that are shown one by one without statements of the lens file, as shares of the largest.
const SHOWN: [f64; 5] = [0.0, 0.5, 0.7, 0.85, 1.0];
/// Most stated fields that are shown.
const MOST_SHOWN: usize = 12;

/// Names of the analyses, in the order of the page.
pub const ANALYSES: [&str; 20] = [
    "prescription",
    "first-order",
    "seidel",
    "ray-fan",
    "opd-fan",
    "spot",
    "field-curvature",
    "distortion",
    "lateral-colour",
    "longitudinal",
    "relative-illumination",
    "transmittance",
    "vignetting",
    "mtf",
    "mtf-field",
    "mtf-focus",
    "wavefront",
    "psf",
    "encircled-energy",
    "ghosts",
];

/// Choices of a report.
#[derive(Clone, Debug)]
pub struct ReportChoices {
    /// Fields of curves, rays over the pupil, and threads.
    pub grid: ImagingGrid,
    /// Fields that are shown one by one, as shares of the largest, from 0 to 1; by default those of the
    /// lens file, or five from the axis to the edge.
    pub fields: Option<Vec<f64>>,
    /// Largest spatial frequency of the MTF (cycles / mm); by default about half of the diffraction
    /// limit, and 200 at most.
    pub frequency: Option<f64>,
}

/// A lens with its traced fields, from which analyses are made.
pub struct LensReport(ReportInputs);

impl LensReport {
    /// Traces the fields of a lens.
    ///
    /// # Errors
    /// Returns an error if a glass has no index at a wavelength, or the lens cannot be analysed.
    pub fn new(
        lens: &Prescription,
        conditions: ImagingConditions,
        choices: &ReportChoices,
    ) -> Result<Self, Box<dyn std::error::Error + Send + Sync>> {
        let lens = lens.at_wavelength(conditions.primary_line().nm)?;
        let quality = ImageQuality::new(&lens, conditions, choices.grid)?;
        let (mut shown, mut left_out) = (Vec::new(), quality.left_out.clone());
        for field in shown_fields(&quality, choices.fields.as_deref()) {
            match quality.field(field, choices.grid.pupil) {
                Some(rays) => shown.push(rays),
                None => left_out.push(field),
            }
        }
        left_out.sort_by(f64::total_cmp);
        left_out.dedup();
        Ok(Self(ReportInputs::new(lens, quality, (shown, left_out), choices.frequency)))
    }

    /// Makes the section of an analysis, one of [`ANALYSES`]. Several threads may do so at once.
    ///
    /// # Errors
    /// Returns an error if there is no such analysis, or it fails.
    pub fn analyse(
        &self,
        name: &str,
    ) -> Result<ReportSection, Box<dyn std::error::Error + Send + Sync>> {
        let mut section = section(name, &self.0)?;
        missing::state_missing(&mut section, &self.0);
        Ok(section)
    }

    /// Returns the files of a report of these sections; the last is the page, "index.html".
    ///
    /// # Errors
    /// Returns an error if a table cannot be written as CSV.
    pub fn files(
        &self,
        sections: &[ReportSection],
        text: &PageText,
    ) -> Result<Vec<ReportFile>, Box<dyn std::error::Error + Send + Sync>> {
        files::files(&self.0, sections, text)
    }
}

/// Returns the fields that are shown one by one, in ascending order.
fn shown_fields(quality: &ImageQuality, shares: Option<&[f64]>) -> Vec<f64> {
    let conditions = &quality.conditions;
    if let Some(shares) = shares {
        let mut shares = shares.to_owned();
        shares.sort_by(f64::total_cmp);
        shares.dedup();
        return shares.iter().map(|share| share * conditions.largest_field).collect();
    }
    let mut fields = conditions.stated_fields.clone();
    fields.sort_by(f64::total_cmp);
    fields.dedup();
    if fields.is_empty() || fields.len() > MOST_SHOWN {
        fields = SHOWN.map(|share| share * conditions.largest_field).to_vec();
    }
    fields
}

fn section(name: &str, inputs: &ReportInputs) -> Result<ReportSection, ReportFailure> {
    Ok(match name {
        "prescription" => first_order::prescription(inputs),
        "first-order" => first_order::first_order(inputs)?,
        "seidel" => first_order::seidel(inputs)?,
        "ray-fan" => fans::rays(inputs),
        "opd-fan" => fans::paths(inputs),
        "spot" => spots::spots(inputs),
        "field-curvature" => curves::curvature(inputs),
        "distortion" => curves::distortion(inputs),
        "lateral-colour" => curves::lateral_colour(inputs),
        "longitudinal" => curves::longitudinal(inputs),
        "relative-illumination" => light::relative_illumination(inputs),
        "transmittance" => transmittance::transmittance(inputs),
        "vignetting" => light::vignetting(inputs),
        "mtf" => transfer::by_frequency(inputs),
        "mtf-field" => transfer::by_field(inputs),
        "mtf-focus" => transfer::by_focus(inputs),
        "wavefront" => wave::wavefronts(inputs)?,
        "psf" => wave::psf(inputs)?,
        "encircled-energy" => wave::encircled_energy(inputs),
        "ghosts" => light::ghosts(inputs),
        _ => return Err(format!("expected one of {}", ANALYSES.join(", ")).into()),
    })
}
