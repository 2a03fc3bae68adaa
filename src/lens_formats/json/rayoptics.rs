//! Reader of the models of rayoptics (`.roa`, "optical_model"): interfaces and the gaps between them,
//! object first, image last.
//!
//! Every object has its class in `__instance_type__` and its members in `attributes`. Profiles stand in
//! the interfaces, or since version 0.9 in a table of their own. Source: rayoptics 0.5 to 0.9.8,
//! `OpticalModel.save_model` and "Lens File Specification (.roa)".

use std::path::Path;

use super::ReadReport;
use super::value::Json;
use crate::WAVELENGTHS;
use crate::checks::{even_powers, medium, powers, radius_of_curvature};
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::RayTransferMatrix;
use petzval_lens::system::{MediumBehind, SequentialSystem, SystemAperture, SystemSurface};
use petzval_lens::{CrossSection, Prescription, Row};
use petzval_lens::{Design, FieldKind, Fields, SpectralLine};

/// Reads a lens.
///
/// # Errors
/// Returns an error with line and column if a surface is invalid or not simulated.
pub(super) fn read(
    path: &Path,
    model: &Json<'_>,
    report: &mut ReadReport<'_>,
) -> Result<Prescription, LensError> {
    let model = members_of(model);
    let sequence = members_of(model.need("seq_model")?);
    let (mut name, mut unit) = (String::new(), 1.0);
    if let Some(spec) = model.get("system_spec").map(members_of) {
        name = spec.get("title").and_then(Json::text).unwrap_or_default().trim().to_owned();
        if let Some(word) = spec.any(&["_dimensions", "dimensions"]) {
            unit = unit_of(word)?;
        }
    }
    let mut system = SequentialSystem { name, ..SequentialSystem::default() };
    if let Some(spec) = model.get("optical_spec") {
        specify(members_of(spec), unit, &mut system, report)?;
    }
    let interfaces = sequence.need("ifcs")?.list()?;
    let gaps = sequence.need("gaps")?.list()?;
    let ([_, lens @ .., _], [before, behind @ ..]) = (interfaces, gaps) else {
        return Err(sequence.error("no surfaces", "expected object, surfaces and image"));
    };
    if behind.len() != lens.len() {
        let found = format!("{} interfaces and {} gaps", interfaces.len(), gaps.len());
        return Err(sequence.error(found, "expected a gap behind each interface but the image"));
    }
    let distance = members_of(before).need("thi")?.number_or_infinity()?;
    let near = distance.abs() < INFINITE;
    system.design.object_distance = Some(if near { distance * unit } else { f64::INFINITY });
    system.object_medium = medium_of(before, report)?;
    let stop = match sequence.get("stop_surface") {
        Some(stop) => Some(stop.number()?),
        None => None,
    };
    let reader = SurfaceReader { profiles: model.get("profile_dict"), unit };
    for (i, (interface, gap)) in lens.iter().zip(behind).enumerate() {
        let mut surface = reader.surface(interface, report)?;
        let thickness = members_of(gap).need("thi")?;
        surface.row.thickness = thickness.number()? * unit;
        surface.row.stop = stop == Some(i as f64 + 1.0);
        if !matches!(surface.medium, MediumBehind::Mirror) {
            surface.medium = medium_of(gap, report)?;
        }
        system.surfaces.push(surface);
    }
    system.design.notes.extend(report.take_notes());
    system.build(path)
}

/// Returns the members of an object that is stored with its class.
fn members_of<'b, 'a>(json: &'b Json<'a>) -> &'b Json<'a> {
    json.get("attributes").unwrap_or(json)
}

/// Returns the name of the class of an object; empty if none is stored.
fn class_of<'b>(json: &'b Json<'_>) -> &'b str {
    let class = json.get("__instance_type__").and_then(|class| class.list().ok()?.last());
    class.and_then(Json::text).unwrap_or_default()
}

/// Returns the numbers of a list or of an array of numpy.
fn numbers_of(json: &Json<'_>) -> Result<Vec<f64>, LensError> {
    json.get("__ndarray__").unwrap_or(json).numbers()
}

/// Returns the length of a unit (mm).
fn unit_of(word: &Json<'_>) -> Result<f64, LensError> {
    match word.text().unwrap_or_default().to_ascii_lowercase().as_str() {
        "mm" => Ok(1.0),
        "cm" => Ok(10.0),
        "m" => Ok(1000.0),
        "in" => Ok(25.4),
        "ft" => Ok(304.8),
        other => Err(word.error(format!("the unit \"{other}\""), "expected mm, cm, m, in or ft")),
    }
}

/// Returns the medium of a gap.
fn medium_of(gap: &Json<'_>, report: &mut ReadReport<'_>) -> Result<MediumBehind, LensError> {
    let Some(stored) = members_of(gap).get("medium") else { return Ok(MediumBehind::Air) };
    let class = class_of(stored);
    let figures = members_of(stored);
    if class == "Air" {
        return Ok(MediumBehind::Air);
    }
    let number = |names: &[&str]| figures.any(names).map(Json::number).transpose();
    let (index, abbe) = (number(&["n", "nd", "_n"])?, number(&["v", "vd", "_v"])?);
    let name = figures.any(&["gname", "name", "label"]).and_then(Json::text).unwrap_or_default();
    if index.is_none() && name.is_empty() {
        let found = format!("a medium of the class \"{class}\" without a name or an index");
        return Err(stored.error(found, "expected a glass, or an index \"n\""));
    }
    let maker = class.strip_suffix("Glass").filter(|maker| !["Model", ""].contains(maker));
    let named = match (index, maker) {
        (None, Some(maker)) => medium(None, None, &format!("{maker} {name}"), report)
            .or_else(|_| medium(None, None, name, report)),
        _ => medium(index, abbe, name, report),
    };
    named.map_err(|found| {
        stored.error(
            found,
            "expected a glass of a catalogue; add its AGF file \
                                               with 'catalogue'",
        )
    })
}

/// Reader of interfaces.
struct SurfaceReader<'b, 'a> {
    /// Profiles by their identity.
    profiles: Option<&'b Json<'a>>,
    /// Length of a unit of the file (mm).
    unit: f64,
}

impl<'b, 'a> SurfaceReader<'b, 'a> {
    /// Reads an interface, without thickness, stop and the medium behind it.
    fn surface(
        &self,
        interface: &'b Json<'a>,
        report: &mut ReadReport<'_>,
    ) -> Result<SystemSurface, LensError> {
        let (class, figures, unit) = (class_of(interface), members_of(interface), self.unit);
        let mut row = Row::default();
        match class {
            "ThinLens" => {
                let power = figures.any(&["_power", "optical_power"]);
                let power = power.ok_or_else(|| {
                    interface.error("a thin lens without a power", "expected \"_power\"")
                })?;
                let c = -power.number()? / unit;
                row.ideal = Some([RayTransferMatrix { c, ..RayTransferMatrix::IDENTITY }; 2]);
            }
            _ => {
                if let Some(phase) = figures.get("phase_element") {
                    let what = format!("a {} on a surface", class_of(phase));
                    report.leave_out(&phase.line, phase.word, &what)?;
                }
                self.profile(interface, &mut row, report)?;
            }
        }
        if let Some(decentre) = figures.get("decenter") {
            let what = "a tilted or decentred surface";
            report.leave_out(&decentre.line, decentre.word, what)?;
        }
        let mode = figures.get("interact_mode").and_then(Json::text).unwrap_or("transmit");
        let medium = if mode == "reflect" { MediumBehind::Mirror } else { MediumBehind::Air };
        let computed = figures.any(&["max_aperture", "od"]).map(Json::number).transpose()?;
        let stated = self.clear_aperture(figures, report)?;
        let semi_diameter = stated.or(computed.map(|semi| semi * unit)).filter(|semi| *semi > 0.0);
        let (line, clips) = (interface.line.number, stated.is_some());
        Ok(SystemSurface { line, row, medium, semi_diameter, clips, ..SystemSurface::default() })
    }

    /// Returns the radius (mm) of the stated clear aperture, if it is a centred circle.
    fn clear_aperture(
        &self,
        figures: &'b Json<'a>,
        report: &mut ReadReport<'_>,
    ) -> Result<Option<f64>, LensError> {
        let Some(list) = figures.get("clear_apertures") else { return Ok(None) };
        let mut radius = None;
        for aperture in list.list()? {
            let members = members_of(aperture);
            let offset = |name: &str| members.get(name).map_or(Ok(0.0), Json::number);
            let centred = offset("x_offset")? == 0.0 && offset("y_offset")? == 0.0;
            match (class_of(aperture), members.get("radius")) {
                ("Circular", Some(found)) if centred => {
                    let found = found.number()? * self.unit;
                    radius = Some(radius.map_or(found, |other: f64| other.min(found)));
                }
                (class, _) => {
                    let what = format!("a {class} aperture that is no circle about the axis");
                    report.leave_out(&aperture.line, aperture.word, &what)?;
                }
            }
        }
        Ok(radius.filter(|radius| (1e-9..1e6).contains(radius)))
    }

    /// Sets the shape of a row by the profile of its interface.
    fn profile(
        &self,
        interface: &'b Json<'a>,
        row: &mut Row,
        report: &mut ReadReport<'_>,
    ) -> Result<(), LensError> {
        let figures = members_of(interface);
        let by_identity = |key: &Json<'a>| self.profiles?.get(key.text()?);
        let stored = figures.get("profile").or(figures.get("profile_id").and_then(by_identity));
        let stored = stored.ok_or_else(|| {
            interface
                .error("an interface without a profile", "expected \"profile\" or \"profile_id\"")
        })?;
        let (class, profile, unit) = (class_of(stored), members_of(stored), self.unit);
        let number = |name: &str| profile.get(name).map(Json::number).transpose();
        let refused = |found: String| {
            stored.error(found, "expected a radius of 1e-6 mm or more, and powers from 2 to 30")
        };
        row.radius = radius_of_curvature(number("cv")?.unwrap_or(0.0) / unit).map_err(refused)?;
        // ec is cc + 1.
        let asphere = number("ec")?.map(|ec| ec - 1.0);
        row.conic = number("cc")?.or(asphere).unwrap_or(0.0);
        let coefficients = profile.get("coefs").map_or(Ok(Vec::new()), numbers_of)?;
        let terms = match class {
            "Spherical" | "Conic" => Ok(Vec::new()),
            "EvenPolynomial" => even_powers(2, &coefficients),
            "RadialPolynomial" => powers((1..).zip(coefficients)),
            "YToroid" => {
                let sweep = radius_of_curvature(number("cR")?.unwrap_or(0.0) / unit);
                row.across = Some(CrossSection::Toroid { radius: sweep.map_err(refused)? });
                even_powers(2, &coefficients)
            }
            _ => {
                let what = format!("a profile of the class \"{class}\"");
                report.leave_out(&stored.line, stored.word, &what)?;
                Ok(Vec::new())
            }
        };
        let scaled = |(power, value): (u32, f64)| (power, value * unit.powi(1 - power as i32));
        row.asphere = terms.map_err(refused)?.into_iter().map(scaled).collect();
        Ok(())
    }
}

/// Reads aperture, fields, wavelengths and defocus.
fn specify(
    spec: &Json<'_>,
    unit: f64,
    system: &mut SequentialSystem,
    report: &mut ReadReport<'_>,
) -> Result<(), LensError> {
    if let Some(pupil) = spec.get("pupil").map(members_of)
        && let Some(value) = pupil.get("value")
    {
        let [side, kind] = last_words(pupil)?;
        let number = value.number()?;
        let aperture = match (side.as_str(), kind.as_str()) {
            ("object", "epd" | "pupil") => Some(SystemAperture::EntrancePupil(number * unit)),
            ("image", "f/#") => Some(SystemAperture::FNumber(number)),
            ("image", "NA") => Some(SystemAperture::ImageNa(number)),
            ("object", "NA") => Some(SystemAperture::ObjectNa(number)),
            _ => None,
        };
        match aperture {
            Some(aperture) if number > 0.0 => {
                system.aperture = Some(aperture);
                if let SystemAperture::FNumber(number) = aperture {
                    system.f_number = Some(number);
                }
            }
            _ => report.note(format!(
                "the aperture {number} of the kind \"{side} {kind}\" is not used; the stop has its \
                 own diameter"
            )),
        }
    }
    if let Some(field) = spec.get("field_of_view").map(members_of) {
        let [side, kind] = last_words(field)?;
        let (kind, scale) = match (side.as_str(), kind.as_str()) {
            (_, "angle") => (FieldKind::Angle, 1.0),
            ("object", _) => (FieldKind::ObjectHeight, unit),
            _ => (FieldKind::ImageHeight, unit),
        };
        let relative = field.get("is_relative").is_some_and(Json::is_true);
        let full = field.get("value").map_or(Ok(1.0), Json::number)?;
        let scale = if relative { scale * full } else { scale };
        let mut points = Vec::new();
        for point in field.need("fields")?.list()?.iter().map(members_of) {
            let place = |name: &str| point.get(name).map_or(Ok(0.0), Json::number);
            points.push([place("x")? * scale, place("y")? * scale]);
        }
        system.design.fields = (!points.is_empty()).then_some(Fields { kind, points });
    }
    if let Some(light) = spec.get("spectral_region").map(members_of) {
        wavelengths(light, &mut system.design)?;
    }
    Ok(())
}

/// Returns the last two words of the key of a specification, such as "image" and "f/#".
fn last_words(spec: &Json<'_>) -> Result<[String; 2], LensError> {
    let Some(key) = spec.any(&["_key", "key"]) else {
        return Err(
            spec.error("no \"key\"", "expected a side and a kind, such as \"image\", \"f/#\"")
        );
    };
    let words: Vec<&str> = key.list()?.iter().filter_map(Json::text).collect();
    match words[..] {
        [.., side, kind] => Ok([side.to_owned(), kind.to_owned()]),
        _ => Err(key.error("a key of fewer than two words", "expected a side and a kind")),
    }
}

/// Reads the wavelengths.
fn wavelengths(light: &Json<'_>, design: &mut Design) -> Result<(), LensError> {
    let Some(list) = light.get("wavelengths") else { return Ok(()) };
    let weights = light.get("spectral_wts").map_or(Ok(Vec::new()), numbers_of)?;
    for (i, nm) in numbers_of(list)?.into_iter().enumerate() {
        if !WAVELENGTHS.contains(&nm) {
            return Err(list.error(format!("a wavelength of {nm} nm"), "expected 100 to 1e9 nm"));
        }
        let weight = weights.get(i).copied().unwrap_or(1.0);
        design.wavelengths.push(SpectralLine { nm, weight });
    }
    let primary = light.get("reference_wvl").map_or(Ok(0.0), Json::number)?;
    design.primary = (primary.max(0.0) as usize).min(design.wavelengths.len().saturating_sub(1));
    Ok(())
}
