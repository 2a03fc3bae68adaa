//! Hits per second on a height field of 520,000 triangles beside Embree, on one core in one run.
//!
//! Embree is not a dependency. The bench compiles `benches/embree/peer.cpp` where a C++ compiler and Embree
//! 3 or 4 with its headers are installed (Debian: `g++ libembree-dev`), and says so where they are not.
//!
//!     cargo bench --bench embree

use std::error::Error;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

use petzval_base::lanes::f32x8;
use petzval_base::rays::{Column, HitBatch, NO_INDEX, RayBatch};
use petzval_scene::{Mesh, Scene, TraversalStack};
use petzval_tools::bench::hills::{built, hills, waves};

/// Number of quads along a side, of two triangles each.
const SIDE: u32 = 510;
/// Kinds of rays. The last asks for any hit, the others for the nearest one.
const KINDS: [&str; 3] = ["camera", "diffuse", "shadow"];
/// Rays of Embree's packets.
const PACKETS: [&str; 3] = ["1", "8", "16"];
/// Runs of each variant. The table shows medians.
const RUNS: usize = 15;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Seconds, hits and the sum of their distances.
struct Measured {
    seconds: f64,
    hits: usize,
    sum: f64,
}

/// Running peer. It ends when its input does.
struct Peer {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    version: String,
}

impl Peer {
    fn start(program: &Path, mesh: &Path, rays: &[PathBuf]) -> Outcome<Self> {
        let kinds = KINDS.iter().zip(rays).map(|(kind, path)| format!("{kind}={}", path.display()));
        let mut child = Command::new(program)
            .arg(mesh)
            .args(kinds)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let input = child.stdin.take().ok_or("no standard input")?;
        let mut output = BufReader::new(child.stdout.take().ok_or("no standard output")?);
        let mut version = String::new();
        output.read_line(&mut version)?;
        Ok(Self { child, input, output, version: version.trim().to_owned() })
    }

    fn trace(&mut self, kind: &str, packet: &str, robust: bool) -> Outcome<Measured> {
        writeln!(self.input, "{kind} {packet} {}", u8::from(robust))?;
        let mut line = String::new();
        self.output.read_line(&mut line)?;
        let [seconds, hits, sum] = line.split_whitespace().collect::<Vec<_>>()[..] else {
            return Err(format!("the peer answered '{}'", line.trim()).into());
        };
        Ok(Measured { seconds: seconds.parse()?, hits: hits.parse()?, sum: sum.parse()? })
    }

    fn stop(mut self) -> Outcome<()> {
        drop(self.input);
        self.child.wait()?;
        Ok(())
    }
}

/// Compiles the peer against Embree 4 or 3. Returns `None` where neither can be had.
fn compile(folder: &Path) -> Outcome<Option<PathBuf>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/embree/peer.cpp");
    let compiler = std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
    let program = folder.join("peer");
    for library in ["embree4", "embree3"] {
        let probe = folder.join("probe.cpp");
        fs::write(&probe, format!("#include <{library}/rtcore.h>\n"))?;
        let found = Command::new(&compiler).arg("-E").arg(&probe).output();
        if !found.is_ok_and(|output| output.status.success()) {
            continue;
        }
        let status = Command::new(&compiler)
            .args(["-std=c++17", "-O3", "-march=native", "-o"])
            .arg(&program)
            .arg(&source)
            .arg(format!("-l{library}"))
            .status()?;
        if !status.success() {
            return Err(format!("{compiler} cannot compile {}", source.display()).into());
        }
        return Ok(Some(program));
    }
    Ok(None)
}

/// Writes counts, positions and indices.
fn write_mesh(path: &Path, mesh: &Mesh) -> Outcome<()> {
    let mut bytes = Vec::new();
    for count in [mesh.positions.len(), mesh.triangles.len()] {
        bytes.extend(u32::try_from(count)?.to_ne_bytes());
    }
    bytes.extend(mesh.positions.as_flattened().iter().flat_map(|v| v.to_ne_bytes()));
    bytes.extend(mesh.triangles.as_flattened().iter().flat_map(|v| v.to_ne_bytes()));
    Ok(fs::write(path, bytes)?)
}

/// Writes a count, then origin, direction and end of each ray.
fn write_rays(path: &Path, waves: &[RayBatch]) -> Outcome<()> {
    let count: usize = waves.iter().map(|wave| wave.len).sum();
    let mut bytes = u32::try_from(count)?.to_ne_bytes().to_vec();
    for wave in waves {
        for i in 0..wave.len {
            let ray = wave.ray(i);
            let numbers = ray.origin.into_iter().chain(ray.direction).chain([ray.t_max]);
            bytes.extend(numbers.flat_map(f32::to_ne_bytes));
        }
    }
    Ok(fs::write(path, bytes)?)
}

/// Traces all waves once. Shadow rays have a contribution of 1, so those that hit nothing add 1.
fn ours(scene: &Scene, waves: &[RayBatch], is_any: bool) -> Measured {
    let mut stack = TraversalStack::default();
    let mut hits: Vec<HitBatch> = waves.iter().map(|_| HitBatch::default()).collect();
    let mut radiance: [Column<f32>; 3] = Default::default();
    let start = Instant::now();
    for (wave, hits) in waves.iter().zip(&mut hits) {
        if is_any {
            scene.occlude::<f32x8>(wave, &mut stack, &mut radiance);
        } else {
            scene.intersect::<f32x8>(wave, hits, &mut stack);
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let count: usize = waves.iter().map(|wave| wave.len).sum();
    if is_any {
        let open: f32 = radiance[0].iter().sum();
        return Measured { seconds, hits: count - open as usize, sum: 0.0 };
    }
    let found = waves.iter().zip(&hits).flat_map(|(wave, hits)| &hits[..wave.len]);
    let found = found.filter(|hit| hit.shape != NO_INDEX);
    let (hits, sum) = found.fold((0, 0.0), |(n, sum), hit| (n + 1, sum + f64::from(hit.t)));
    Measured { seconds, hits, sum }
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// Fails if two tracers disagree by more than rays at the rims of triangles explain.
fn check(kind: &str, ours: &Measured, theirs: &Measured) -> Outcome<()> {
    let apart = |a: f64, b: f64| (a - b).abs() > 2e-4 * a.abs().max(b.abs());
    if apart(ours.hits as f64, theirs.hits as f64) || apart(ours.sum, theirs.sum) {
        return Err(format!(
            "{kind}: petzval finds {} hits at a total distance of {}, Embree {} at {}",
            ours.hits, ours.sum, theirs.hits, theirs.sum
        )
        .into());
    }
    Ok(())
}

fn main() -> Outcome<()> {
    let folder = tempfile::tempdir()?;
    let Some(program) = compile(folder.path())? else {
        println!("skipped: no C++ compiler or no Embree 3 or 4 (Debian: g++ libembree-dev)");
        return Ok(());
    };
    let mesh = hills(SIDE);
    let mesh_file = folder.path().join("mesh");
    write_mesh(&mesh_file, &mesh)?;
    let scene = built(mesh);
    let waves = waves(&scene);
    let mut rays = Vec::new();
    for (kind, waves) in KINDS.iter().zip(&waves) {
        rays.push(folder.path().join(kind));
        write_rays(&rays[rays.len() - 1], waves)?;
    }
    let mut peer = Peer::start(&program, &mesh_file, &rays)?;
    println!("million rays a second, one core; Embree {} built for this CPU", peer.version);
    println!("| rays | petzval | Embree, fastest | which | petzval / Embree | / robust Embree |");
    println!("|---|---|---|---|---|---|");
    for (kind, waves) in KINDS.iter().zip(&waves) {
        let count: usize = waves.iter().map(|wave| wave.len).sum();
        let variants: Vec<_> =
            PACKETS.iter().flat_map(|packet| [(*packet, false), (*packet, true)]).collect();
        let mut times = vec![Vec::new(); variants.len() + 1];
        for _ in 0..RUNS {
            let own = ours(&scene, waves, *kind == "shadow");
            for ((packet, robust), times) in variants.iter().zip(&mut times) {
                let theirs = peer.trace(kind, packet, *robust)?;
                check(kind, &own, &theirs)?;
                times.push(theirs.seconds);
            }
            times[variants.len()].push(own.seconds);
        }
        let rates: Vec<f64> =
            times.into_iter().map(|times| count as f64 / median(times) / 1e6).collect();
        let fastest = |robust: bool| {
            let of_kind = (0..variants.len()).filter(|&i| !robust || variants[i].1);
            of_kind.max_by(|&a, &b| rates[a].total_cmp(&rates[b])).unwrap_or(0)
        };
        let (own, best, robust) = (rates[variants.len()], fastest(false), fastest(true));
        println!(
            "| {kind} | {own:.1} | {:.1} | {} a packet{} | {:.2} | {:.2} |",
            rates[best],
            variants[best].0,
            if variants[best].1 { ", robust" } else { "" },
            own / rates[best],
            own / rates[robust],
        );
    }
    peer.stop()
}
