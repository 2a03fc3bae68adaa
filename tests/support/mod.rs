//! What the tests share: the independent oracle, the lenses, and nasty numbers.
#![allow(dead_code, reason = "every test file uses its own part")]

use std::path::{Path, PathBuf};

use petzval::lens::{Prescription, Row, read};

/// The repository's root.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The four course lenses, with the film distances (mm) of their scenes.
pub const LENSES: [(&str, f64); 4] = [
    ("dgauss.50mm", 36.77),
    ("fisheye.10mm", 23.192),
    ("telephoto.250mm", 123.7439),
    ("wide.22mm", 14.54),
];

pub fn lens(name: &str) -> Prescription {
    read(&root().join("lenses").join(format!("{name}.dat"))).expect("a lens of the repository")
}

/// A row of a prescription made by hand; radius 0 is the stop.
pub fn row(radius: f64, thickness: f64, index: f64, diameter: f64) -> Row {
    let stop = radius == 0.0;
    let radius = if stop { f64::INFINITY } else { radius };
    Row { radius, thickness, index, diameter, stop, ..Row::default() }
}

/// A folder of its own for one test, removed at the end.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

pub fn write(folder: &tempfile::TempDir, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("a file in the temporary folder");
    path
}

/// Uniform numbers in [0, 1) for tests: xorshift64* (Vigna 2016).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// The oracle: a lens traced from the film by the textbook, in f64.
///
/// Written apart from the program: spheres by their centres and the quadratic formula,
/// refraction in vector form (Heckbert, in Glassner 1989, "An Introduction to Ray Tracing",
/// p. 291). z runs from the film (z = 0) to the scene.
pub mod oracle {
    use petzval::lens::Prescription;

    type V = [f64; 3];

    fn dot(a: V, b: V) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    fn along(a: V, t: f64, d: V) -> V {
        [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]]
    }

    /// The exit point relative to the front vertex and the unit direction, or the row (from 0)
    /// at which the ray ends.
    pub fn trace(lens: &Prescription, film: f64, start: V, towards: V) -> Result<[V; 2], usize> {
        let length = dot(towards, towards).sqrt();
        let mut p = start;
        let mut d = towards.map(|v| v / length);
        let mut vertex = film;
        for (i, row) in lens.rows.iter().enumerate().rev() {
            let half = row.diameter / 2.0;
            if row.radius.is_infinite() {
                let t = (vertex - p[2]) / d[2];
                if t <= 0.0 {
                    return Err(i);
                }
                p = along(p, t, d);
                if p[0] * p[0] + p[1] * p[1] > half * half {
                    return Err(i);
                }
                d = refract(d, [0.0, 0.0, -1.0], row.index, lens.index_before(i)).ok_or(i)?;
            } else {
                // The centre lies towards the film where the radius is positive.
                let centre = [0.0, 0.0, vertex - row.radius];
                let o = [p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]];
                let b = dot(o, d);
                let disc = b * b - dot(o, o) + row.radius * row.radius;
                if disc < 0.0 {
                    return Err(i);
                }
                // The sheet at the vertex: the far one where the centre is on this side.
                let t = if row.radius > 0.0 { -b + disc.sqrt() } else { -b - disc.sqrt() };
                p = along(p, t, d);
                let n = [p[0] / row.radius, p[1] / row.radius, (p[2] - centre[2]) / row.radius];
                let past_equator = n[2] <= 0.0;
                if p[0] * p[0] + p[1] * p[1] > half * half || past_equator {
                    return Err(i);
                }
                let n = n.map(|v| -v);
                d = refract(d, n, row.index, lens.index_before(i)).ok_or(i)?;
            }
            if i > 0 {
                vertex += lens.rows[i - 1].thickness;
            }
        }
        Ok([[p[0], p[1], p[2] - vertex], d])
    }

    /// Heckbert's refraction; the normal points against the ray.
    fn refract(d: V, n: V, n1: f64, n2: f64) -> Option<V> {
        let ratio = n1 / n2;
        let c1 = -dot(d, n);
        let c2 = 1.0 - ratio * ratio * (1.0 - c1 * c1);
        if c2 < 0.0 {
            return None;
        }
        let k = ratio * c1 - c2.sqrt();
        Some([ratio * d[0] + k * n[0], ratio * d[1] + k * n[1], ratio * d[2] + k * n[2]])
    }
}

/// Renders the text of a scene, whose files stand in the repository's scenes folder.
pub fn rendered(text: &str) -> petzval::image::Picture {
    let folder = folder();
    let path = write(&folder, "scene.pbrt", text);
    let description = petzval::scene::pbrt::read(&path).expect("a scene of a test");
    let (job, _, _) = petzval::job::prepare(description, &Default::default()).expect("a job");
    picture(&job, petzval::render::Backend::Simd, 2)
}

/// Renders a job.
pub fn picture(
    job: &petzval::render::Job,
    backend: petzval::render::Backend,
    threads: usize,
) -> petzval::image::Picture {
    let exposed = petzval::render::render(job, backend, threads, &Default::default())
        .expect("a render that nobody stops");
    assert_eq!(exposed.film.dropped, 0, "no sample may be other than a number");
    exposed.film.picture(job.samples.end - job.samples.start)
}

/// The mean of a picture, by channel.
pub fn mean(picture: &petzval::image::Picture) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in &picture.pixels {
        for (sum, value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(*value);
        }
    }
    sum.map(|s| s / picture.pixels.len() as f64)
}
