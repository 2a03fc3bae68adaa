//! `petzval lens trace`: rays in, rays out, for checks against other tools.

use std::fmt::Write as _;
use std::path::Path;

use petzval::lanes::{Real, f32x8};
use petzval::lens::{Blocked, D_LINE, From, LensRay, Prescription, Surface, Why};
use petzval::lens::{read, sequence, trace, trace_one};
use petzval::rays::{LensBatch, WAVE};
use petzval::source::excerpt;

use super::{BackendArgument, Failure, Outcome, PrecisionArgument, TraceArguments};

/// A ray in lens space: the front vertex at z = 0, the film at +z; mm.
struct Row {
    start: [f64; 3],
    towards: [f64; 3],
    /// nm
    wavelength: f64,
}

pub(super) fn run(arguments: &TraceArguments) -> Result<Outcome, Failure> {
    let lens = read(&arguments.lens)?;
    let (header, rows) = rows(&arguments.rays)?;
    let wavelengths = rows.iter().map(|row| row.wavelength);
    if let Some(shortest) = wavelengths.clone().reduce(f64::min)
        && let Some(longest) = wavelengths.reduce(f64::max)
    {
        super::lens::warn(&arguments.lens, &lens, [shortest, longest]);
    }
    let mut text = String::new();
    if header {
        text.push_str("x,y,z,dx,dy,dz\n");
    }
    match (arguments.precision, arguments.backend) {
        (PrecisionArgument::F32, BackendArgument::Simd) => all::<f32x8>(&lens, &rows, 8, &mut text),
        (PrecisionArgument::F32, BackendArgument::Scalar) => all::<f32>(&lens, &rows, 8, &mut text),
        (PrecisionArgument::F64, _) => all::<f64>(&lens, &rows, 16, &mut text),
    }
    super::print(&text)
}

/// The rays of a CSV file, and whether it has a header.
fn rows(path: &Path) -> Result<(bool, Vec<Row>), Failure> {
    let name = path.display();
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| format!("cannot read the rays {name}: {error}"))?;
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
        let mut numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, D_LINE];
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
        rows.push(Row { start: [x, y, z], towards: [dx, dy, dz], wavelength });
    }
    Ok((header, rows))
}

/// A lens for one wavelength, ready to trace.
struct Tracer<R: Real> {
    wavelength: f64,
    /// Front to rear vertex, mm, and the index before the film.
    length: f64,
    index: f64,
    surfaces: Vec<Surface<R::Scalar>>,
    exact: Vec<Surface<f64>>,
}

impl<R: Real> Tracer<R> {
    fn new(lens: &Prescription, wavelength: f64) -> Self {
        let lens = lens.at_wavelength(wavelength);
        Self {
            wavelength,
            length: lens.length(),
            index: lens.rear().index,
            surfaces: sequence::<R>(&lens, From::Film(0.0)),
            exact: sequence::<f64>(&lens, From::Film(0.0)),
        }
    }

    /// A ray as the trace takes it: +z along the way out, relative to the rear vertex, the
    /// direction scaled to the index before the film. It starts at its point nearest to the vertex:
    /// wherever a file has it start, single precision then loses nothing to the length of its way,
    /// and knows how far off it is at most.
    fn start(&self, row: &Row) -> LensRay<f64> {
        let [x, y, z] = row.start;
        let [dx, dy, dz] = row.towards;
        let scale = self.index / dx.hypot(dy).hypot(dz);
        let (p, t) = ([x, y, self.length - z], [dx * scale, dy * scale, -dz * scale]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let back = dot(p, t) / dot(t, t);
        LensRay::new([0, 1, 2].map(|i| p[i] - back * t[i]), t)
    }
}

/// Traces all rays, wave by wave, and writes what became of them.
fn all<R: Real>(lens: &Prescription, rows: &[Row], digits: usize, text: &mut String) {
    let mut tracers: Vec<Tracer<R>> = Vec::new();
    let mut batch = Box::<LensBatch<R::Scalar>>::default();
    let mut counts = vec![0; lens.rows.len()];
    for rows in rows.chunk_by(|one, next| one.wavelength == next.wavelength) {
        let wavelength = rows[0].wavelength;
        let known = tracers.iter().position(|tracer| tracer.wavelength == wavelength);
        let place = known.unwrap_or_else(|| {
            tracers.push(Tracer::new(lens, wavelength));
            tracers.len() - 1
        });
        let tracer = &tracers[place];
        for wave in rows.chunks(WAVE) {
            for (i, row) in wave.iter().enumerate() {
                let start = tracer.start(row);
                [batch.x[i], batch.y[i], batch.z[i]] = start.p.map(R::scalar);
                [batch.tx[i], batch.ty[i], batch.tz[i]] = start.t.map(R::scalar);
                batch.weight[i] = R::scalar(1.0);
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
}

/// What became of the i-th ray of a traced batch.
fn outcome<R: Real>(
    batch: &LensBatch<R::Scalar>,
    tracer: &Tracer<R>,
    i: usize,
    row: &Row,
) -> Result<LensRay<f64>, Blocked> {
    let start = tracer.start(row);
    let ray = if batch.doubtful.contains(&(i as u32)) {
        trace_one::<f64>(start, &tracer.exact)?
    } else if !R::to_f64(batch.x[i]).is_nan() {
        LensRay::new(
            [batch.x[i], batch.y[i], batch.z[i]].map(R::to_f64),
            [batch.tx[i], batch.ty[i], batch.tz[i]].map(R::to_f64),
        )
    } else {
        // The batch forgot why: the same arithmetic again, one ray.
        let start = LensRay::new(start.p.map(R::constant), start.t.map(R::constant));
        trace_one::<R>(start, &tracer.surfaces)?;
        return Err(Blocked { row: tracer.surfaces[0].row, why: Why::Miss });
    };
    // Parallel to the plane in which exits are told.
    if ray.t[2] == 0.0 { Err(Blocked { row: 0, why: Why::Miss }) } else { Ok(ray) }
}

fn write_blocked(blocked: Blocked, text: &mut String) {
    let why = match blocked.why {
        Why::Clip => "clip",
        Why::Stop => "stop",
        Why::Miss => "miss",
        Why::Tir => "tir",
    };
    let _ = writeln!(text, "blocked,{},{why}", blocked.row + 1);
}

/// The crossing of the plane through the front vertex, and the unit direction.
fn write_exit(LensRay { p, t, .. }: LensRay<f64>, digits: usize, text: &mut String) {
    let s = -p[2] / t[2];
    let length = t[0].hypot(t[1]).hypot(t[2]);
    let numbers =
        [p[0] + s * t[0], p[1] + s * t[1], 0.0, t[0] / length, t[1] / length, -t[2] / length];
    for (i, number) in numbers.into_iter().enumerate() {
        let comma = if i == 0 { "" } else { "," };
        let _ = write!(text, "{comma}{number:.digits$e}");
    }
    text.push('\n');
}
