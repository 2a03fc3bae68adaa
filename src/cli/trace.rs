//! `petzval lens trace`: rays in, rays out, for checks against other tools.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use petzval::lanes::{Real, f32x8};
use petzval::lens::{Blocked, From, LensRay, Prescription, Surface, Why, read, sequence};
use petzval::lens::{trace, trace_one};
use petzval::rays::{LensBatch, WAVE};

use super::{BackendArgument, Failure, Outcome, PrecisionArgument, TraceArguments};

/// A ray in lens space: the front vertex at z = 0, the film at +z; mm.
struct Row {
    start: [f64; 3],
    towards: [f64; 3],
}

pub(super) fn run(arguments: &TraceArguments) -> Result<Outcome, Failure> {
    let lens = read(&arguments.lens)?;
    let (header, rows) = rows(&arguments.rays)?;
    let mut text = String::new();
    if header {
        text.push_str("x,y,z,dx,dy,dz\n");
    }
    match (arguments.precision, arguments.backend) {
        (PrecisionArgument::F32, BackendArgument::Simd) => all::<f32x8>(&lens, &rows, 8, &mut text),
        (PrecisionArgument::F32, BackendArgument::Scalar) => all::<f32>(&lens, &rows, 8, &mut text),
        (PrecisionArgument::F64, _) => all::<f64>(&lens, &rows, 16, &mut text),
    }
    match std::io::stdout().write_all(text.as_bytes()) {
        // Whoever reads has seen enough.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(Outcome::Done),
        other => Ok(other.map(|()| Outcome::Done)?),
    }
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
        let mut numbers = [0.0; 6];
        for (number, word) in numbers.iter_mut().zip(&record) {
            *number = word.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
                let word: String = word.chars().take(40).collect();
                format!("{name}:{line}: \"{word}\" is not a finite number")
            })?;
        }
        let [x, y, z, dx, dy, dz] = numbers;
        if dx.hypot(dy).hypot(dz) == 0.0 {
            return Err(format!("{name}:{line}: a ray without a direction").into());
        }
        rows.push(Row { start: [x, y, z], towards: [dx, dy, dz] });
    }
    Ok((header, rows))
}

/// Traces all rays, wave by wave, and writes what became of them.
fn all<R: Real>(lens: &Prescription, rows: &[Row], digits: usize, text: &mut String) {
    let surfaces = sequence::<R>(lens, From::Film(0.0));
    let mut batch = Box::<LensBatch<R::Scalar>>::default();
    let mut counts = vec![0; surfaces.len()];
    for wave in rows.chunks(WAVE) {
        for (i, row) in wave.iter().enumerate() {
            let ([x, y, z], [tx, ty, tz]) = local(lens, row);
            [batch.x[i], batch.y[i], batch.z[i]] = [x, y, z].map(R::scalar);
            [batch.tx[i], batch.ty[i], batch.tz[i]] = [tx, ty, tz].map(R::scalar);
        }
        batch.resize::<R>(wave.len());
        trace::<R>(&mut batch, &surfaces, &mut counts);
        for (i, row) in wave.iter().enumerate() {
            let p = [batch.x[i], batch.y[i], batch.z[i]].map(R::to_f64);
            let t = [batch.tx[i], batch.ty[i], batch.tz[i]].map(R::to_f64);
            // Away from the lens no surface is met, whatever lies behind the start.
            if p[0].is_nan() || row.towards[2] >= 0.0 {
                write_blocked(blocked::<R>(lens, &surfaces, row), text);
            } else {
                write_exit(p, t, digits, text);
            }
        }
    }
}

/// A ray as the trace takes it: +z along the way out, relative to the rear vertex, the
/// direction scaled to the index before the film.
fn local(lens: &Prescription, row: &Row) -> ([f64; 3], [f64; 3]) {
    let [x, y, z] = row.start;
    let [dx, dy, dz] = row.towards;
    let scale = lens.rear().index / dx.hypot(dy).hypot(dz);
    ([x, y, lens.length() - z], [dx * scale, dy * scale, -dz * scale])
}

/// Where and why a ray ends that does not come through: the same arithmetic again, one ray.
fn blocked<R: Real>(lens: &Prescription, surfaces: &[Surface<R::Scalar>], row: &Row) -> Blocked {
    let miss = Blocked { row: lens.rows.len() - 1, why: Why::Miss };
    if row.towards[2] >= 0.0 {
        return miss;
    }
    let (p, t) = local(lens, row);
    let ray = LensRay::new(p.map(R::constant), t.map(R::constant));
    trace_one::<R>(ray, surfaces).err().unwrap_or(miss)
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
fn write_exit(p: [f64; 3], t: [f64; 3], digits: usize, text: &mut String) {
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
