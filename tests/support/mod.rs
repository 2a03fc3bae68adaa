//! Shared parts of the tests: the independent oracle, lenses, scenes, folders and nasty numbers.
#![allow(dead_code, reason = "each test file uses its own part")]

pub mod grazing;
pub mod nasty;
pub mod oracle;
pub mod probe;
pub mod reference;
pub mod sampling;
pub mod thin_film;
pub mod workspace;
pub mod world;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use petzval_lens::{Prescription, Row};
use petzval_lens_formats::read;

/// Returns the root of the repository.
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

/// A plane-convex lens of 50 mm behind its stop.
pub const LANDSCAPE: &str = r#"
name = "landscape lens"
[[surface]]
radius = inf
thickness = 10.0
diameter = 6.4
stop = true
[[surface]]
radius = inf
thickness = 4.0
diameter = 24.0
glass = "N-BK7"
[[surface]]
radius = -25.9
diameter = 24.0
"#;

/// Reads a lens of the repository, `lenses/NAME.dat`.
pub fn lens(name: &str) -> Prescription {
    read(&root().join("lenses").join(format!("{name}.dat"))).expect("a lens of the repository")
}

/// Returns a row with radius, thickness and diameter in mm. Radius 0 makes it the stop.
pub fn row(radius: f64, thickness: f64, index: f64, diameter: f64) -> Row {
    let stop = radius == 0.0;
    let radius = if stop { f64::INFINITY } else { radius };
    Row { radius, thickness, index, diameter, stop, ..Row::default() }
}

/// Creates a temporary folder, which is removed when it is dropped.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

pub fn write(folder: &tempfile::TempDir, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("a file in the temporary folder");
    path
}

/// The longest that a test waits: only a command that hangs reaches it.
const HANG: Duration = Duration::from_secs(300);

/// Waits until a condition holds.
pub fn wait_until(what: &str, mut condition: impl FnMut() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < HANG, "waited {HANG:?} in vain for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// The longest that an answer may take which an idle machine gives within some seconds. A busy machine
/// does not reach it; work that grows with a number in the input instead of its size does.
const PROMPT: Duration = Duration::from_secs(60);

/// Returns the result of `work`, which must come promptly.
pub fn promptly<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    assert!(start.elapsed() < PROMPT, "{what} took {:?}", start.elapsed());
    result
}

/// Runs the command in a folder, without an input. Returns its exit code, standard output and
/// standard error.
pub fn petzval(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
    let output = command.args(arguments).current_dir(folder).stdin(Stdio::null()).output();
    let output = output.expect("the command starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (output.status.code().unwrap_or(-1), text(output.stdout), text(output.stderr))
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

/// Writes a picture in the format of the file's extension.
pub fn write_picture(picture: &petzval_image::Picture, path: impl Into<PathBuf>) {
    let frame = picture.size.map(|n| n as u32);
    let window = petzval_image::PictureWindow { origin: [0, 0], frame };
    let file = petzval_base::io::Outputs::without_inputs().claim(path).expect("an output");
    picture.write(&file, window, Default::default(), &Vec::new()).expect("a picture");
}

/// Renders a scene given as text. The text names files by absolute paths.
pub fn rendered(text: &str) -> petzval_image::Picture {
    let folder = folder();
    let path = write(&folder, "scene.pbrt", text);
    let description = petzval_scene_formats::pbrt::read(&path).expect("a scene of a test");
    let job =
        petzval_render::prepare::prepare(description, &Default::default()).expect("a job").job;
    picture(&job, petzval_render::Backend::Simd, 1)
}

/// Renders a job to its end.
pub fn picture(
    job: &petzval_render::job::Job,
    backend: petzval_render::Backend,
    threads: usize,
) -> petzval_image::Picture {
    let exposed = petzval_render::render(
        job,
        petzval_render::RenderOptions {
            backend,
            threads,
            ..petzval_render::RenderOptions::default()
        },
    )
    .expect("a render that is not stopped");
    assert_eq!(exposed.film.dropped.count(), 0, "a sample is not a finite number");
    exposed.film.picture(job.samples.end - job.samples.start)
}

/// Returns the mean of each channel of a picture.
pub fn mean(picture: &petzval_image::Picture) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in &picture.pixels {
        for (sum, value) in sum.iter_mut().zip(pixel) {
            *sum += f64::from(*value);
        }
    }
    sum.map(|s| s / picture.pixels.len() as f64)
}

/// Returns the mean and its standard error.
pub fn mean_and_error(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean, (variance / n).sqrt()]
}

/// Returns the result of a function for each item, computed on two threads.
pub fn in_parallel<T: Sync, A: Send>(items: &[T], f: impl Fn(&T) -> A + Sync) -> Vec<A> {
    let (even, odd): (Vec<&T>, Vec<&T>) =
        (items.iter().step_by(2).collect(), items.iter().skip(1).step_by(2).collect());
    let f = &f;
    let run = |items: Vec<&T>| items.into_iter().map(f).collect::<Vec<A>>();
    let (even, odd) = std::thread::scope(|scope| {
        let odd = scope.spawn(|| run(odd));
        (run(even), odd.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    let (mut even, mut odd) = (even.into_iter(), odd.into_iter());
    (0..items.len()).filter_map(|i| if i % 2 == 0 { even.next() } else { odd.next() }).collect()
}
