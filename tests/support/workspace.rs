//! Folder with a small scene in which a test runs the command, and the contents of the files it writes.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use tempfile::TempDir;

use super::{folder, root, wait_until, write};

/// A real lens at the origin that looks along z.
pub const CAMERA: &str = r#"
    LookAt 0 0 0  0 0 1  0 1 0
    Camera "realistic" "string lensfile" "lens.dat" "float aperturediameter" 17.1
        "float focusdistance" 4.1"#;

/// A small light, a floor and a metal ball under a sky: its ghosts, noise and layers all differ from 0. A
/// brighter light would need diffraction, which takes seconds at any size.
const SCENE: &str = r#"
    Film "rgb" "integer xresolution" 72 "integer yresolution" 50 "float diagonal" 43.27
    Integrator "path" "integer maxdepth" 4
    WorldBegin
    LightSource "infinite" "rgb L" [0.2 0.25 0.3]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [2000 1500 1000]
        Translate 0.6 0.5 5 Shape "sphere" "float radius" 0.05
    AttributeEnd
    Material "diffuse" "rgb reflectance" [0.7 0.6 0.5]
    Include "floor.pbrt"
    Material "conductor" "float roughness" 0.3
    Translate -0.3 -0.3 4 Shape "sphere" "float radius" 0.4"#;
const FLOOR: &str = r#"Shape "trianglemesh" "point3 P" [-3 -1 1  -3 -1 9  3 -1 9  3 -1 1]
    "integer indices" [0 1 2 0 2 3]"#;

/// A temporary folder with a scene `scene.pbrt`, its lens and its floor, in which commands run.
pub struct Workspace(TempDir);

impl Workspace {
    pub fn new() -> Self {
        let folder = folder();
        std::fs::copy(root().join("lenses/dgauss.50mm.dat"), folder.path().join("lens.dat"))
            .expect("a lens of the repository");
        write(&folder, "scene.pbrt", format!("{CAMERA}{SCENE}"));
        write(&folder, "floor.pbrt", FLOOR);
        Self(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Returns the names of all files but those of the scene, in alphabetical order.
    pub fn file_names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<String> =
            names.map(|name| name.to_string_lossy().into_owned()).collect();
        names.retain(|name| !["scene.pbrt", "floor.pbrt", "lens.dat"].contains(&name.as_str()));
        names.sort();
        names
    }

    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
        command.args(arguments.split_whitespace()).current_dir(self.0.path());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    pub fn start(&self, arguments: &str) -> Child {
        self.command(arguments).spawn().expect("the command starts")
    }

    /// Runs the command and returns its exit code and its standard error.
    pub fn run(&self, arguments: &str) -> (i32, String) {
        exit_and_stderr(self.command(arguments).output().expect("the command starts"))
    }

    /// Runs the command, which must succeed, and returns its standard error.
    pub fn run_ok(&self, arguments: &str) -> String {
        let (code, stderr) = self.run(arguments);
        assert_eq!(code, 0, "{arguments}: {stderr}");
        stderr
    }

    /// Runs a render as a whole, whole.exr, and in the shards 1.petzval to 3.petzval, which must merge to
    /// the same picture. The sums of shards are rounded in another order.
    pub fn merges_to_the_whole(&self, render: &str) {
        self.run_ok(&format!("{render} -o whole.exr"));
        for i in 1..=3 {
            self.run_ok(&format!("{render} -o {i}.petzval --shard {i}/3"));
        }
        self.run_ok("merge 2.petzval 1.petzval 3.petzval -o merged.exr");
        let [whole, merged] = ["whole.exr", "merged.exr"].map(|name| self.contents(name));
        let off = merged.difference(&whole);
        assert!(off < 1e-5, "{render}: the merged shards differ by {off:e}");
    }

    /// Runs the command, which must fail with exit code 2 and a message that holds `expected`.
    pub fn refuses(&self, arguments: &str, expected: &str) {
        let (code, stderr) = self.run(arguments);
        assert_eq!(code, 2, "{arguments}: {stderr}");
        assert!(
            stderr.contains(expected),
            "{arguments}\n  found    {stderr}\n  expected {expected}"
        );
        assert!(!stderr.contains("panicked"), "{arguments}: {stderr}");
    }

    /// Waits until a running command has written a file of more than `bytes` bytes.
    pub fn wait_for_file(&self, child: &mut Child, name: &str, bytes: u64) {
        let path = self.path(name);
        wait_until(name, || {
            let ended = child.try_wait().expect("a child").is_some();
            let found = path.metadata().is_ok_and(|metadata| metadata.len() > bytes);
            assert!(found || !ended, "the command ended before it wrote {name}");
            found
        });
    }

    pub fn contents(&self, name: &str) -> Contents {
        Contents::read(&self.path(name))
    }
}

/// Changes the head and the body of a checkpoint or a part in place, and corrects its checksums.
pub fn forge(path: &Path, change: impl FnOnce(&mut [u8], &mut [u8])) {
    let mut bytes = std::fs::read(path).expect("a file to forge");
    let length = u64::from_le_bytes(bytes[12..20].try_into().expect("8 bytes"));
    let end = 20 + length as usize;
    let (front, back) = bytes.split_at_mut(end);
    let (between, body) = back.split_at_mut(12);
    let (body, last) = body.split_at_mut(body.len() - 4);
    change(&mut front[20..], body);
    between[..4].copy_from_slice(&crc32fast::hash(&front[20..]).to_le_bytes());
    last.copy_from_slice(&crc32fast::hash(body).to_le_bytes());
    std::fs::write(path, bytes).expect("a forged file");
}

/// Makes a checkpoint or a part look as if another build of the program had written it.
pub fn forge_build(path: &Path) {
    forge(path, |head, _| {
        let text = str::from_utf8(head).expect("JSON");
        let key = "\"build\":\"";
        let at = text.find(key).expect("the build") + key.len();
        head[at] = if head[at] == b'0' { b'1' } else { b'0' };
    });
}

/// Sends a signal, such as `INT`.
pub fn signal(child: &Child, name: &str) {
    let kill = Command::new("kill").args(["-s", name, &child.id().to_string()]).status();
    assert!(kill.expect("kill starts").success());
}

/// Waits for the end of a command and returns its exit code and its standard error.
pub fn finish(child: Child) -> (i32, String) {
    exit_and_stderr(child.wait_with_output().expect("a child"))
}

/// Returns the exit code, -1 after a signal, and the standard error.
pub fn exit_and_stderr(output: Output) -> (i32, String) {
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().unwrap_or(-1), stderr)
}

/// A channel's name and its values, bit for bit.
type Channel = (String, Vec<u32>);

/// Channels and attributes of an EXR, bit for bit, without the command line.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    pub channels: Vec<Channel>,
    pub attributes: Vec<String>,
}

impl Contents {
    pub fn read(path: &Path) -> Self {
        let image = read_all_flat_layers_from_file(path).expect("a whole picture");
        let layer = &image.layer_data[0];
        let bits = |samples: &FlatSamples| match samples {
            FlatSamples::F32(values) => values.iter().map(|v| v.to_bits()).collect(),
            _ => panic!("a picture of 32-bit floats"),
        };
        let channels = &layer.channel_data.list;
        let channels = channels.iter().map(|c| (c.name.to_string(), bits(&c.sample_data)));
        let mut attributes = layer.attributes.clone();
        let other = image.attributes.other.iter().chain(&layer.attributes.other);
        let mut list: Vec<String> = other
            .map(|(name, value)| format!("{name}: {value:?}"))
            .filter(|line| !line.starts_with("commandLine:"))
            .collect();
        list.sort();
        attributes.other.clear();
        list.push(format!("{attributes:?}"));
        Self { channels: channels.collect(), attributes: list }
    }

    /// Returns the largest difference of a value, relative to the mean of its channel.
    pub fn difference(&self, other: &Self) -> f64 {
        assert_eq!(self.channels.len(), other.channels.len());
        let channel = |((name, one), (_, other)): (&Channel, &Channel)| {
            let value = |bits: &u32| f64::from(f32::from_bits(*bits));
            let mean = one.iter().map(|bits| value(bits).abs()).sum::<f64>() / one.len() as f64;
            let differences = one.iter().zip(other).map(|(a, b)| (value(a) - value(b)).abs());
            let largest = differences.fold(0.0, f64::max) / mean.max(1e-30);
            assert!(largest.is_finite(), "{name}");
            largest
        };
        self.channels.iter().zip(&other.channels).map(channel).fold(0.0, f64::max)
    }
}
