//! `petzval lens trace`: traces rays of a CSV file, for checks against other tools.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use petzval_base::io::{ReadContext, excerpt};
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{LensBatch, WAVE_SIZE};
use petzval_lens::{BlockReason, Blocked, LensRay, Prescription, Side, Surface};
use petzval_lens::{sequence, trace, trace_one};
use petzval_render::memory::machine;
use petzval_spectrum::IndexRangeError;

use crate::cli::arguments::BackendArgument;
use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::{Failure, Outcome};

/// Arguments of `petzval lens trace`.
#[derive(Debug, clap::Args)]
pub(super) struct TraceArguments {
    /// Lens file
    lens: PathBuf,
    #[command(flatten)]
    file: LensFileArguments,
    /// CSV of rays: x,y,z,dx,dy,dz[,wavelength_nm]; mm; the front vertex at z = 0, the film at +z;
    /// rays start on the film side and travel towards -z (towards the last surface behind mirrors)
    #[arg(long, value_name = "FILE")]
    rays: PathBuf,
    /// Floating-point precision of the trace
    #[arg(long, value_enum, default_value_t)]
    precision: PrecisionArgument,
    /// Rays per kernel call: eight lanes or one
    ///
    /// The result is the same
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArgument,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum PrecisionArgument {
    #[default]
    F32,
    F64,
}

/// Memory of the rays and of the text of the result, for each byte of the file (bytes). A line has 12
/// bytes or more.
const MEMORY_PER_BYTE: u64 = 16;

/// A ray of the file, in lens space: the front vertex at z = 0, the film at +z (mm).
struct RayRow {
    start: [f64; 3],
    towards: [f64; 3],
    /// Wavelength (nm).
    wavelength: f64,
}

pub(super) fn run(arguments: &TraceArguments) -> Result<Outcome, Failure> {
    let lens = arguments.file.options().read(&arguments.lens, &ReadContext::default())?;
    super::warn_of_notes(&arguments.lens, &lens);
    let (header, rows) = rows(&arguments.rays, lens.design.primary_wavelength())?;
    let wavelengths = rows.iter().map(|row| row.wavelength);
    if let Some(shortest) = wavelengths.clone().reduce(f64::min)
        && let Some(longest) = wavelengths.reduce(f64::max)
    {
        super::warn_indices(&arguments.lens, &lens, [shortest, longest]);
    }
    let mut text = String::new();
    if header {
        text.push_str("x,y,z,dx,dy,dz\n");
    }
    match (arguments.precision, arguments.backend) {
        (PrecisionArgument::F32, BackendArgument::Simd) => {
            trace_all::<f32x8>(&lens, &rows, 8, &mut text)
        }
        (PrecisionArgument::F32, BackendArgument::Scalar) => {
            trace_all::<f32>(&lens, &rows, 8, &mut text)
        }
        (PrecisionArgument::F64, _) => trace_all::<f64>(&lens, &rows, 16, &mut text),
    }
    .map_err(|error| format!("{}: {error}", arguments.lens.display()))?;
    crate::cli::print(&text)
}

/// Reads the rays of a CSV file; those without a wavelength get that of the lens (nm). Returns also
/// whether the file has a header.
fn rows(path: &Path, primary: f64) -> Result<(bool, Vec<RayRow>), Failure> {
    let name = path.display();
    let memory = machine::limit().unwrap_or(u64::MAX) / MEMORY_PER_BYTE;
    let bytes = ReadContext::with_memory(memory)
        .bytes(path)
        .map_err(|error| format!("cannot read the rays {name}: {}", error.source))?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(&bytes[..]);
    let (mut header, mut rows) = (false, Vec::new());
    for (i, record) in reader.records().enumerate() {
        let record = record.map_err(|error| format!("{name}: {error}"))?;
        let line = record.position().map_or(0, csv::Position::line);
        if i == 0 && record.get(0).is_some_and(|word| word.parse::<f64>().is_err()) {
            header = true;
            continue;
        }
        if !(6..=7).contains(&record.len()) {
            let found = record.len();
            let expected = "expected x,y,z,dx,dy,dz and perhaps wavelength_nm";
            return Err(format!("{name}:{line}: {found} columns; {expected}").into());
        }
        let mut numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, primary];
        for (number, word) in numbers.iter_mut().zip(&record) {
            *number = word.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
                format!("{name}:{line}: \"{}\" is not a finite number", excerpt(word))
            })?;
        }
        let [x, y, z, dx, dy, dz, wavelength] = numbers;
        if dx.hypot(dy).hypot(dz) == 0.0 {
            return Err(format!("{name}:{line}: a ray without a direction").into());
        }
        if !(100.0..=1e6).contains(&wavelength) {
            let expected = "expected a wavelength in nm, from 100 to 1000000";
            return Err(format!("{name}:{line}: wavelength {wavelength}; {expected}").into());
        }
        rows.push(RayRow { start: [x, y, z], towards: [dx, dy, dz], wavelength });
    }
    Ok((header, rows))
}

/// A lens at one wavelength, ready to trace.
struct Tracer<R: Real> {
    wavelength: f64,
    /// From lens space to the axis of the film, with its origin at the rear vertex.
    to_film_axis: DAffine3,
    /// Direction of travel behind the lens along that axis: -1 after an odd number of mirrors.
    travel: f64,
    /// Refractive index in front of the film.
    index: f64,
    surfaces: Vec<Surface<R::Scalar>>,
    exact: Vec<Surface<f64>>,
}

impl<R: Real> Tracer<R> {
    fn new(lens: &Prescription, wavelength: f64) -> Result<Self, IndexRangeError> {
        let lens = lens.at_wavelength(wavelength)?;
        Ok(Self {
            wavelength,
            to_film_axis: lens.film_axis().inverse(),
            travel: lens.travel_before(lens.rows.len()),
            index: lens.rear().index,
            surfaces: sequence::<R>(&lens, Side::Film(0.0)),
            exact: sequence::<f64>(&lens, Side::Film(0.0)),
        })
    }

    /// Returns a ray in the frame of the trace: +z towards the scene, relative to the rear vertex,
    /// the direction as long as the index in front of the film. It starts at its point nearest to
    /// the vertex, so that a distant start in the file costs no single precision.
    fn start(&self, row: &RayRow) -> LensRay<f64> {
        let [x, y, z] = row.start;
        let [dx, dy, dz] = row.towards;
        let scale = self.index / dx.hypot(dy).hypot(dz);
        let start = self.to_film_axis.transform_point3(DVec3::new(x, y, z));
        let towards = self.to_film_axis.transform_vector3(DVec3::new(dx, dy, dz) * scale);
        let p = [start.x, start.y, -self.travel * start.z];
        let t = [towards.x, towards.y, -self.travel * towards.z];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let back = dot(p, t) / dot(t, t);
        LensRay::new([0, 1, 2].map(|i| p[i] - back * t[i]), t)
    }
}

/// Traces all rays, wave by wave, and writes a line for each.
fn trace_all<R: Real>(
    lens: &Prescription,
    rows: &[RayRow],
    digits: usize,
    text: &mut String,
) -> Result<(), IndexRangeError> {
    let mut tracers: Vec<Tracer<R>> = Vec::new();
    let mut batch = Box::<LensBatch<R::Scalar>>::default();
    let mut counts = vec![0; lens.rows.len()];
    for rows in rows.chunk_by(|one, next| one.wavelength == next.wavelength) {
        let wavelength = rows[0].wavelength;
        let known = tracers.iter().position(|tracer| tracer.wavelength == wavelength);
        let place = match known {
            Some(place) => place,
            None => {
                tracers.push(Tracer::new(lens, wavelength)?);
                tracers.len() - 1
            }
        };
        let tracer = &tracers[place];
        for wave in rows.chunks(WAVE_SIZE) {
            for (i, row) in wave.iter().enumerate() {
                let start = tracer.start(row);
                [batch.x[i], batch.y[i], batch.z[i]] = start.p.map(R::from_f64);
                [batch.tx[i], batch.ty[i], batch.tz[i]] = start.t.map(R::from_f64);
                batch.weight[i] = R::from_f64(1.0);
            }
            batch.resize::<R>(wave.len());
            trace::<R>(&mut batch, &tracer.surfaces, &mut counts);
            for (i, row) in wave.iter().enumerate() {
                match outcome(&batch, tracer, i, row) {
                    Ok(ray) => write_exit(ray, digits, text),
                    Err(blocked) => write_blocked(blocked, text),
                }
            }
        }
    }
    Ok(())
}

/// Returns where the i-th ray of a traced batch leaves the lens, or where it is blocked.
fn outcome<R: Real>(
    batch: &LensBatch<R::Scalar>,
    tracer: &Tracer<R>,
    i: usize,
    row: &RayRow,
) -> Result<LensRay<f64>, Blocked> {
    let start = tracer.start(row);
    if batch.needs_f64.contains(&(i as u32)) {
        return trace_one::<f64>(start, &tracer.exact);
    }
    if !R::to_f64(batch.x[i]).is_nan() {
        return Ok(LensRay::new(
            [batch.x[i], batch.y[i], batch.z[i]].map(R::to_f64),
            [batch.tx[i], batch.ty[i], batch.tz[i]].map(R::to_f64),
        ));
    }
    // A batch does not keep the reason: trace the ray again, by the same arithmetic.
    let start = LensRay::new(start.p.map(R::constant), start.t.map(R::constant));
    trace_one::<R>(start, &tracer.surfaces)?;
    Err(Blocked { row: tracer.surfaces[0].row, reason: BlockReason::Miss })
}

fn write_blocked(blocked: Blocked, text: &mut String) {
    let reason = match blocked.reason {
        BlockReason::Clip => "clip",
        BlockReason::Stop => "stop",
        BlockReason::Miss => "miss",
        BlockReason::Tir => "tir",
    };
    let _ = writeln!(text, "blocked,{},{reason}", blocked.row + 1);
}

/// Writes where a ray crosses the plane through the front vertex, and its unit direction. A ray that
/// leaves at 90 degrees or more never crosses it: its point is that on the front surface.
fn write_exit(LensRay { p, t, .. }: LensRay<f64>, digits: usize, text: &mut String) {
    let length = t[0].hypot(t[1]).hypot(t[2]);
    let [x, y, z] = match t[2] > 0.0 {
        true => {
            let s = -p[2] / t[2];
            [p[0] + s * t[0], p[1] + s * t[1], 0.0]
        }
        false => [p[0], p[1], -p[2]],
    };
    let numbers = [x, y, z, t[0] / length, t[1] / length, -t[2] / length];
    for (i, number) in numbers.into_iter().enumerate() {
        let comma = if i == 0 { "" } else { "," };
        let _ = write!(text, "{comma}{number:.digits$e}");
    }
    text.push('\n');
}
