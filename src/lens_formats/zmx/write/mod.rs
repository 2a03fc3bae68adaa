//! Writer of Zemax lens files (`.zmx`), sequential mode.
//!
//! It states what the reader of this folder reads, in mm and with every digit. Tilts, decentres and
//! folds of all kinds become coordinate breaks. Source: as for the reader.

mod configuration;
mod frame;
mod glass;
mod surface;

use std::fmt::Write as _;
use std::path::Path;

use super::super::write::WrittenLens;
use frame::{AxisChange, axis_changes};
use glass::GlassWriter;
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::Paraxial;
use petzval_lens::Prescription;
use petzval_lens::system::SystemAperture;
use petzval_lens::{FieldKind, SpectralLine};
use petzval_spectrum::D_LINE;

/// Relative difference of a stop from that of the f-number that counts as rounding.
const SAME_STOP: f64 = 1e-12;

/// The surface of the file that holds the space behind a row, and the part of the space it holds
/// (mm).
#[derive(Clone, Copy)]
struct Space {
    surface: usize,
    thickness: f64,
}

/// Surfaces of a file under construction.
#[derive(Default)]
struct Body {
    text: String,
    count: usize,
}

impl Body {
    /// Starts a surface and returns its number.
    fn start(&mut self, kind: &str) -> usize {
        let _ = write!(self.text, "SURF {}\n  TYPE {kind}\n", self.count);
        self.count += 1;
        self.count - 1
    }

    /// Writes a plane.
    fn plane(&mut self, thickness: f64) {
        self.start("STANDARD");
        let _ = write!(self.text, "  CURV 0.0 0 0 0 0 \"\"\n  DISZ {}\n", distance(thickness));
        self.text.push_str("  DIAM 0.0 0 0 0 1 \"\"\n");
    }

    /// Writes a coordinate break with its decentres, tilts and the space behind it.
    fn coordinate_break(&mut self, axis: &AxisChange) {
        self.start("COORDBRK");
        self.text.push_str("  CURV 0.0 0 0 0 0 \"\"\n");
        for (number, value) in (1..).zip(axis.decentre.into_iter().chain(axis.tilt).chain([0.0])) {
            let _ = writeln!(self.text, "  PARM {number} {value:?}");
        }
        let _ = write!(self.text, "  DISZ {:?}\n  DIAM 0.0 0 0 0 1 \"\"\n", axis.behind);
    }
}

/// Writes a lens so that reading it gives the same lens; notes name what a .zmx file cannot say.
///
/// # Errors
/// Returns an error if the file cannot hold the shape of a surface.
pub(in super::super) fn to_zmx(path: &Path, lens: &Prescription) -> Result<WrittenLens, LensError> {
    let mut notes = Vec::new();
    let mut lens = lens.clone();
    let paraxial = Paraxial::new(&lens);
    if lens.design.film_distance.is_none() && paraxial.back_focal_distance.is_finite() {
        lens.design.film_distance = Some(paraxial.back_focal_distance);
        notes.push(
            "the lens states no place of its film; the file has it at the paraxial focus".into(),
        );
    }
    let film = lens.travel_before(lens.rows.len()) * lens.design.film_distance.unwrap_or(0.0);
    let mut body = Body::default();
    body.plane(lens.design.object_distance.unwrap_or(f64::INFINITY));
    let mut glasses = GlassWriter::new();
    let changes = axis_changes(&lens, film);
    if let Some(axis) = &changes[0] {
        if axis.before != 0.0 {
            body.plane(axis.before);
        }
        body.coordinate_break(axis);
    }
    let mut spaces = Vec::new();
    for (i, row) in lens.rows.iter().enumerate() {
        let gap = if i + 1 == lens.rows.len() { film } else { row.thickness };
        let thickness = changes[i + 1].as_ref().map_or(gap, |axis| axis.before);
        let number = surface::write(path, &lens, i, thickness, &mut glasses, &mut body)?;
        spaces.push(Space { surface: number, thickness });
        if let Some(axis) = &changes[i + 1] {
            body.coordinate_break(axis);
        }
    }
    body.plane(0.0);
    surface::note_losses(&lens, &mut notes);
    let by_f_number = states_stop(&lens);
    let states = configuration::write(&lens, &spaces, by_f_number, &mut notes);
    let mut text = header(&lens, by_f_number, &mut notes);
    if !glasses.makers.is_empty() {
        let _ = writeln!(text, "GCAT {}", glasses.makers.join(" "));
    }
    notes.append(&mut glasses.notes);
    text += &body.text;
    text += &states;
    Ok(WrittenLens { text, notes })
}

/// Returns whether the stated f-number gives the diameter of the stop.
fn states_stop(lens: &Prescription) -> bool {
    let Some(number) = lens.stated_f_number else { return false };
    let mut unit = lens.clone();
    let stop = unit.stop();
    unit.rows[stop].diameter = 1.0;
    let paraxial = Paraxial::new(&unit);
    let object = lens.design.object_distance.unwrap_or(f64::INFINITY);
    let pupil = SystemAperture::FNumber(number).entrance_pupil(&paraxial, object);
    let diameter = pupil / paraxial.entrance_pupil.diameter;
    (diameter / lens.rows[stop].diameter - 1.0).abs() <= SAME_STOP
}

/// Writes all before the surfaces.
fn header(lens: &Prescription, by_f_number: bool, notes: &mut Vec<String>) -> String {
    let mut text = "VERS 200000 0 0 0\nMODE SEQ\n".to_owned();
    let clean = |name: &str| name.replace(char::is_control, " ");
    let _ = writeln!(text, "NAME {}", clean(&lens.name));
    for line in lens.source.iter().flat_map(|source| source.lines()) {
        let _ = writeln!(text, "NOTE 0 {}", clean(line));
    }
    text.push_str("UNIT MM X W X CM MR CPMM\n");
    if let (Some(number), true) = (lens.stated_f_number, by_f_number) {
        let _ = writeln!(text, "FNUM {number:?} 0");
    } else {
        // Programs that cannot float by the stop take the diameter of the pupil.
        let pupil = Paraxial::new(lens).entrance_pupil.diameter;
        if pupil.is_finite() {
            let _ = writeln!(text, "ENPD {pupil:?}");
        }
        text.push_str("FLOA\n");
        if let Some(number) = lens.stated_f_number {
            notes.push(format!(
                "the stated f-number {number} is not that of the stop, and is not written"
            ));
        }
    }
    if let Some(stated) = lens.stated_focal_length {
        notes.push(format!("the stated focal length {stated} mm is not written"));
    }
    text.push_str("ENVD 20.0 1.0 0\n");
    let design = &lens.design;
    let axis = vec![[0.0; 2]];
    let (kind, points) =
        design.fields.as_ref().map_or((0, &axis), |fields| (kind(fields.kind), &fields.points));
    let lines = match design.wavelengths.is_empty() {
        true => vec![[D_LINE, 1.0]],
        false => design.wavelengths.iter().map(|line| [line.nm, line.weight]).collect(),
    };
    let _ = writeln!(text, "FTYP {kind} 0 {} {} 0 0 0", points.len(), lines.len());
    for (keyword, column) in [("XFLN", 0), ("YFLN", 1)] {
        let values: Vec<String> =
            points.iter().map(|point| format!("{:?}", point[column])).collect();
        let _ = writeln!(text, "{keyword} {}", values.join(" "));
    }
    for keyword in ["VDXN", "VDYN", "VCXN", "VCYN", "VANN"] {
        let _ = writeln!(text, "{keyword} {}", vec!["0.0"; points.len()].join(" "));
    }
    let _ = writeln!(text, "FWGN {}", vec!["1.0"; points.len()].join(" "));
    for (number, &[nm, weight]) in (1..).zip(&lines) {
        let micrometres = SpectralLine { nm, weight }.um();
        let _ = writeln!(text, "WAVM {number} {micrometres:?} {weight:?}");
    }
    let _ = writeln!(text, "PWAV {}", design.primary + 1);
    text
}

/// Returns the type of a field.
fn kind(kind: FieldKind) -> u32 {
    match kind {
        FieldKind::Angle => 0,
        FieldKind::ObjectHeight => 1,
        FieldKind::ImageHeight => 2,
    }
}

/// Returns a distance as a word.
fn distance(value: f64) -> String {
    if value.abs() < INFINITE { format!("{value:?}") } else { "INFINITY".to_owned() }
}

/// Returns the number near `guess` from which `function` gives exactly `value`; `guess` if rounding
/// leaves none.
fn inverse(value: f64, guess: f64, function: impl Fn(f64) -> f64) -> f64 {
    let candidates = [guess, guess.next_up(), guess.next_down()];
    candidates.into_iter().find(|&x| function(x) == value).unwrap_or(guess)
}
