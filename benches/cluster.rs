//! Simulated cost of a picture of 3840 x 2160 pixels with 4096 samples on 1 to 1000 nodes.
//!
//! The properties of one node are measured with the program itself: the time to start, the samples per
//! second, the size of a part, the time to merge. The simulation of many nodes is event-driven: nodes of
//! unequal speed fail at random, their shards are queued again from the last checkpoint, and one file
//! server serves all nodes in turn. As a check, the simulation first predicts the time of four shards and
//! their merge on this machine, and they are run.
//!
//!     cargo bench --bench cluster

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

const SCENE: &str = "scenes/atelier.pbrt";
/// Resolution of the picture in the tables, pixels.
const FRAME: [f64; 2] = [3840.0, 2160.0];
/// Samples per pixel.
const SAMPLES: f64 = 4096.0;
/// Throughput of the file server for all nodes together [bytes/s]: ten gigabit Ethernet.
const SERVER: f64 = 1.25e9;
/// Relative standard deviation of the speed of nodes.
const SPREAD: f64 = 0.05;
/// Mean time between failures of one node [s]: ten days, far worse than usual.
const BETWEEN_FAILURES: f64 = 10.0 * 86_400.0;
/// Time until a failed node is back (s).
const REPAIR: f64 = 600.0;
/// Time until the shard of a failed node starts on another one (s).
const REQUEUE: f64 = 30.0;
/// Default interval between checkpoints (s).
const MINUTE: f64 = 60.0;
/// Interval without checkpoints (s).
const OFF: f64 = f64::INFINITY;

/// Measured properties of one node.
#[derive(Clone, Copy)]
struct Node {
    /// Time until the first ray (s).
    start: f64,
    /// Film samples per second.
    rate: f64,
    /// Size of a part (bytes).
    part: f64,
    /// Time to begin and end a merge, and to add one part (s).
    merge: [f64; 2],
    /// Size of the scene and its files (bytes).
    scene: f64,
}

/// Simulated farm and its work.
#[derive(Clone, Copy)]
struct Farm {
    nodes: usize,
    shards: usize,
    /// Film samples of the whole picture.
    samples: f64,
    /// Interval between checkpoints (s).
    checkpoint: f64,
    /// Whether all nodes have the same speed and never fail.
    ideal: bool,
}

#[derive(Default)]
struct Outcome {
    /// Time until the last part is written (s).
    rendered: f64,
    /// Time until the picture is written (s).
    merged: f64,
    /// Traffic of parts (bytes).
    parts: f64,
    /// Traffic of checkpoints (bytes).
    checkpoints: f64,
    failures: u32,
    /// Render time lost by failures (s).
    lost: f64,
    /// Total time in which nodes worked (s).
    busy: f64,
}

/// Uniform numbers in (0, 1): SplitMix64 (Steele, Lea and Flood 2014).
struct Chance(u64);

impl Chance {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 + f64::EPSILON
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Converts seconds to whole microseconds, which have a total order.
fn microseconds(seconds: f64) -> u64 {
    (1e6 * seconds) as u64
}

/// A shard in progress.
struct Shard {
    node: usize,
    /// Samples that remain since its last checkpoint.
    left: f64,
    /// Time of the next failure of its node (s).
    fails: f64,
    begun: f64,
}

/// Transfers bytes over the server, which serves one request after another. Returns the time at which
/// they arrive.
fn transfer(server: &mut f64, now: f64, bytes: f64) -> f64 {
    *server = server.max(now) + bytes / SERVER;
    *server
}

fn simulate(node: Node, farm: Farm) -> Outcome {
    let mut chance = Chance(1);
    let rates: Vec<f64> = (0..farm.nodes)
        .map(|_| match farm.ideal {
            true => node.rate,
            false => node.rate * (1.0 + SPREAD * chance.normal()).max(0.5),
        })
        .collect();
    let mut outcome = Outcome::default();
    let mut server = 0.0;
    let each = farm.samples / farm.shards as f64;
    // Waiting shards and free nodes, each with the time from which on they are.
    let mut waiting: BinaryHeap<_> =
        (0..farm.shards).map(|shard| Reverse((0, shard, each as u64))).collect();
    let mut free: BinaryHeap<_> = (0..farm.nodes).map(|node| Reverse((0, node))).collect();
    // Shards in progress, by the time of their next event: a checkpoint, their end, a failure.
    let mut busy: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
    let mut shards: Vec<Option<Shard>> = (0..farm.shards).map(|_| None).collect();
    let next = |shard: &Shard, rate: f64| {
        let end = shard.begun + (shard.left / rate).min(farm.checkpoint);
        microseconds(end.min(shard.fails))
    };
    loop {
        // The earliest event comes next.
        let ready = match (waiting.peek(), free.peek()) {
            (Some(Reverse((from, ..))), Some(Reverse((at, _)))) => Some(*from.max(at)),
            _ => None,
        };
        let event = busy.peek().map(|Reverse((at, _))| *at);
        match (ready, event) {
            (Some(ready), event) if event.is_none_or(|event| ready <= event) => {
                let (Some(Reverse((_, index, left))), Some(Reverse((_, place)))) =
                    (waiting.pop(), free.pop())
                else {
                    break;
                };
                let now = ready as f64 / 1e6;
                let goes_on = (left as f64) < each.floor();
                let saved = if goes_on { node.part } else { 0.0 };
                outcome.checkpoints += saved;
                let begun = transfer(&mut server, now, node.scene + saved) + node.start;
                outcome.busy += begun - now;
                let factor = if farm.ideal { f64::INFINITY } else { 1.0 };
                let fails = begun - factor * BETWEEN_FAILURES * chance.uniform().ln();
                let shard = Shard { node: place, left: left as f64, fails, begun };
                busy.push(Reverse((next(&shard, rates[place]), index)));
                shards[index] = Some(shard);
            }
            (_, Some(_)) => {
                let Some(Reverse((now, index))) = busy.pop() else { break };
                let Some(mut shard) = shards[index].take() else { break };
                let (now, rate) = (now as f64 / 1e6, rates[shard.node]);
                let worked = now - shard.begun;
                outcome.busy += worked;
                if now + 1e-6 >= shard.fails {
                    outcome.failures += 1;
                    outcome.lost += worked;
                    free.push(Reverse((microseconds(now + REPAIR), shard.node)));
                    waiting.push(Reverse((microseconds(now + REQUEUE), index, shard.left as u64)));
                    continue;
                }
                shard.left -= worked * rate;
                let written = transfer(&mut server, now, node.part);
                if shard.left > 1e-3 * rate {
                    // The render continues while the checkpoint is written.
                    outcome.checkpoints += node.part;
                    shard.begun = now;
                    busy.push(Reverse((next(&shard, rate), index)));
                    shards[index] = Some(shard);
                } else {
                    outcome.parts += node.part;
                    outcome.busy += written - now;
                    outcome.rendered = outcome.rendered.max(written);
                    free.push(Reverse((microseconds(written), shard.node)));
                }
            }
            _ => break,
        }
    }
    let [fixed, each] = node.merge;
    let merge = fixed + farm.shards as f64 * each.max(node.part / SERVER);
    outcome.parts *= 2.0;
    outcome.busy += merge;
    outcome.merged = outcome.rendered + merge;
    outcome
}

/// Runs the program and returns the time it takes (s).
fn seconds(folder: &Path, words: &[&str]) -> f64 {
    let start = Instant::now();
    let status = Command::new(env!("CARGO_BIN_EXE_petzval"))
        .args(words)
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .expect("the program");
    assert!(status.success(), "petzval {}: {status}", words.join(" "));
    start.elapsed().as_secs_f64()
}

/// Returns the median of three runs.
fn median(mut run: impl FnMut() -> f64) -> f64 {
    let mut times = [run(), run(), run()];
    times.sort_by(f64::total_cmp);
    times[1]
}

/// Returns the size of all files below a folder (bytes).
fn bytes(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry"));
    let size = |entry: fs::DirEntry| match entry.metadata().expect("a file") {
        data if data.is_dir() => bytes(&entry.path()),
        data => data.len(),
    };
    entries.map(size).sum()
}

/// Samples per pixel and resolution of the run that is measured and predicted.
const TRIAL: (u32, [u32; 2]) = (16, [960, 640]);

fn main() {
    // `cargo test` runs benches with this argument, to see that they start.
    if std::env::args().any(|word| word == "--test") {
        return;
    }
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(SCENE);
    let (scene, files) = (scene.to_string_lossy(), scene.parent().map_or(0, bytes) as f64);
    let folder = std::env::temp_dir().join(format!("petzval-cluster-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for parts");
    let (spp, [width, height]) = TRIAL;
    let (count, size) = (spp.to_string(), format!("{width}x{height}"));
    let pixels = f64::from(width) * f64::from(height);

    let tiny = ["render", &scene, "--resolution", "16x16", "--spp", "1", "-o", "tiny.exr"];
    let start = median(|| seconds(&folder, &tiny));
    let shard = |n: u32, of: u32| {
        let (share, part) = (format!("{n}/{of}"), format!("{n}-{of}.petzval"));
        let words = ["render", &scene, "--resolution", &size, "--spp", &count, "--shard", &share];
        seconds(&folder, &[&words[..], &["-o", &part]].concat())
    };
    let rate = pixels * f64::from(spp) / (median(|| shard(1, 1)) - start);
    let part = fs::metadata(folder.join("1-1.petzval")).expect("a part").len() as f64;
    let merge = |of: u32| {
        let parts: Vec<String> = (1..=of).map(|n| format!("{n}-{of}.petzval")).collect();
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        median(|| seconds(&folder, &[&["merge", "-o", "out.exr"], &parts[..]].concat()))
    };
    for n in 1..=spp {
        shard(n, spp);
    }
    let [one, many] = [merge(1), merge(spp)];
    let added = (many - one).max(0.0) / f64::from(spp - 1);
    let node = Node { start, rate, part, merge: [one - added, added], scene: files };
    println!(
        "measured: {start:.2} s to start, {:.2} million samples a second, {:.1} bytes a pixel in \
         a part, {one:.2} s to merge one part and {:.0} ms for each more ({size})",
        rate / 1e6,
        part / pixels,
        1e3 * added,
    );

    let samples = pixels * f64::from(spp);
    let farm = Farm { nodes: 1, shards: 4, samples, checkpoint: OFF, ideal: true };
    let said = simulate(node, farm).merged;
    let seen = (1..=4).map(|n| shard(n, 4)).sum::<f64>() + merge(4);
    println!(
        "four shards one after another and their merge: {said:.1} s predicted, {seen:.1} s measured"
    );
    let _ = fs::remove_dir_all(&folder);

    let scale = FRAME[0] * FRAME[1] / pixels;
    let samples = samples * scale * SAMPLES / f64::from(spp);
    // The time to read the scene does not depend on the picture.
    let fixed = start + (one - added - start).max(0.0) * scale;
    let node = Node { part: part * scale, merge: [fixed, added * scale], ..node };
    table(node, samples);
}

/// Prints the results of the simulation for farms of several sizes.
fn table(node: Node, samples: f64) {
    let [width, height] = FRAME;
    println!("\n{width} x {height}, {SAMPLES} samples, {SCENE}:\n");
    println!(
        "| nodes | checkpoints | render | merge | in all | beside an even share | node hours | \
         parts | checkpoints | failures | undone |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let ideal = Farm { nodes: 1, shards: 1, samples, checkpoint: OFF, ideal: true };
    let alone = simulate(node, ideal).merged;
    for (nodes, checkpoint, name) in [
        (1, MINUTE, "60 s"),
        (10, MINUTE, "60 s"),
        (100, MINUTE, "60 s"),
        (100, OFF, "off"),
        (300, OFF, "off"),
        (1000, MINUTE, "60 s"),
        (1000, OFF, "off"),
    ] {
        let farm = Farm { nodes, shards: nodes, samples, checkpoint, ideal: false };
        let out = simulate(node, farm);
        println!(
            "| {nodes} | {name} | {} | {} | {} | {:.2} | {:.1} | {:.1} GB | {:.1} GB | {} | {} |",
            time(out.rendered),
            time(out.merged - out.rendered),
            time(out.merged),
            out.merged * nodes as f64 / alone,
            out.busy / 3600.0,
            out.parts / 1e9,
            out.checkpoints / 1e9,
            out.failures,
            time(out.lost),
        );
    }
}

fn time(seconds: f64) -> String {
    match seconds {
        ..100.0 => format!("{seconds:.1} s"),
        ..6000.0 => format!("{:.1} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}
