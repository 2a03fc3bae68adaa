//! Multi-configuration operands of Zemax files.

use super::super::report::ReadReport;
use super::super::text::Line;
use super::number_at;
use super::surface::ZemaxSurface;
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::system::SystemAperture;
use petzval_lens::{Configuration, Quantity, Setting};

/// Operands that change rays.
const OPERANDS: &[&str] = &[
    "THIC", "CRVT", "SDIA", "APER", "CONN", "GLSS", "PRAM", "PAR1", "PAR2", "PAR3", "PAR4", "PAR5",
    "PAR6", "PAR7", "PAR8", "STPS", "MIND", "MABB", "MDPG", "IGNR", "IGNM", "TEMP", "PRES", "APMN",
    "APMX", "EDVA", "SATP", "CSP1", "CSP2",
];

/// Returns whether a keyword is an operand that changes rays.
pub(super) fn is_operand(keyword: &str) -> bool {
    OPERANDS.contains(&keyword)
}

/// The value of an operand in one configuration.
pub(super) struct Operand<'a> {
    keyword: &'a str,
    surface: usize,
    /// Configuration, from 1.
    configuration: usize,
    value: &'a str,
    number: Option<f64>,
}

impl<'a> Operand<'a> {
    /// Reads surface, configuration and value; none for an operand without them.
    pub fn read(
        line: Line<'a>,
        keyword: &'a str,
        values: &[&'a str],
    ) -> Result<Option<Self>, LensError> {
        let Some(&value) = values.get(2) else { return Ok(None) };
        Ok(Some(Self {
            keyword,
            surface: number_at(&line, keyword, values, 0)? as usize,
            configuration: number_at(&line, keyword, values, 1)? as usize,
            value,
            number: value.parse().ok().filter(|number: &f64| number.is_finite()),
        }))
    }
}

/// Gives the surfaces and the aperture the values of one configuration, from 1: in a file the operands
/// of the current one hold, whatever stands beside the surfaces.
pub(super) fn settle(
    operands: &[Operand],
    current: usize,
    surfaces: &mut [ZemaxSurface],
    aperture: &mut Option<SystemAperture>,
) {
    for operand in operands.iter().filter(|operand| operand.configuration == current) {
        let is_infinite = operand.value.to_ascii_uppercase().starts_with("INF");
        if let ("APER", Some(value)) = (operand.keyword, operand.number) {
            *aperture = aperture.map(|aperture| match aperture {
                SystemAperture::EntrancePupil(_) => SystemAperture::EntrancePupil(value),
                SystemAperture::FNumber(_) => SystemAperture::FNumber(value),
                SystemAperture::ImageNa(_) => SystemAperture::ImageNa(value),
                SystemAperture::ObjectNa(_) => SystemAperture::ObjectNa(value),
            });
        }
        let Some(surface) = surfaces.get_mut(operand.surface) else { continue };
        match (operand.keyword, operand.number) {
            ("THIC", Some(value)) => surface.thickness = value,
            ("THIC", None) if is_infinite => surface.thickness = f64::INFINITY,
            ("CRVT", Some(value)) => surface.curvature = value,
            ("CONN", Some(value)) => surface.conic = value,
            ("SDIA", Some(value)) => surface.semi_diameter = Some(value),
            _ => {}
        }
    }
}

/// Returns the configurations of a file; none if it has one. `places` gives the surface of the
/// system for each surface of the file.
pub(super) fn configurations(
    count: usize,
    operands: &[Operand],
    places: &[Option<usize>],
    unit: f64,
    aperture: Option<SystemAperture>,
    report: &mut ReadReport,
) -> Vec<Configuration> {
    if count < 2 || operands.is_empty() {
        return Vec::new();
    }
    let state =
        |number: usize| Configuration { name: number.to_string(), ..Configuration::default() };
    let mut states: Vec<Configuration> = (1..=count).map(state).collect();
    for operand in operands {
        let Some(state) = operand.configuration.checked_sub(1).and_then(|i| states.get_mut(i))
        else {
            continue;
        };
        let row = places.get(operand.surface).copied().flatten();
        let mut set = |quantity: Quantity, value: f64| {
            state.settings.extend(row.map(|row| Setting { row, quantity, value }));
        };
        match (operand.keyword, operand.number) {
            ("THIC", number) if operand.surface == 0 => {
                let near = number.filter(|distance| distance.abs() < INFINITE);
                state.object_distance =
                    Some(near.map_or(f64::INFINITY, |distance| distance * unit));
            }
            ("THIC", Some(value)) => set(Quantity::Thickness, value * unit),
            ("CRVT", Some(value)) => set(Quantity::Curvature, value / unit),
            ("SDIA" | "APMX", Some(value)) => set(Quantity::Diameter, 2.0 * value * unit),
            ("APER", Some(value)) if matches!(aperture, Some(SystemAperture::FNumber(_))) => {
                state.f_number = Some(value);
            }
            _ => {
                let same = |other: &&Operand| {
                    (other.keyword, other.surface) == (operand.keyword, operand.surface)
                        && other.value != operand.value
                };
                if operands.iter().any(|other| same(&other)) {
                    report.note(format!(
                        "configurations: {} of surface {} is not changed",
                        operand.keyword, operand.surface
                    ));
                }
            }
        }
    }
    states
}
