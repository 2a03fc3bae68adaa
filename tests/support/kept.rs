//! Renders that are interrupted, and what their files hold.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use tempfile::TempDir;

use super::{folder, root, write};

/// A lens with ghosts, a lamp, a moving ball: everything that is added up.
const SCENE: &str = r#"
    Film "rgb" "integer xresolution" 72 "integer yresolution" 50 "float diagonal" 43.27
    LookAt 0 0 0  0 0 1  0 1 0
    Camera "realistic" "string lensfile" "LENS" "float aperturediameter" 17.1
        "float focusdistance" 4.1
    Integrator "path" "integer maxdepth" 4
    WorldBegin
    LightSource "infinite" "rgb L" [0.2 0.25 0.3]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [4000 3000 2000]
        Translate 0.6 0.5 5 Shape "sphere" "float radius" 0.05
    AttributeEnd
    Material "diffuse" "rgb reflectance" [0.7 0.6 0.5]
    Include "floor.pbrt"
    Material "conductor" "float roughness" 0.3
    Translate -0.3 -0.3 4 Shape "sphere" "float radius" 0.4"#;
const FLOOR: &str = r#"Shape "trianglemesh" "point3 P" [-3 -1 1  -3 -1 9  3 -1 9  3 -1 1]
    "integer indices" [0 1 2 0 2 3]"#;

/// A folder with a scene, its lens and its pictures.
pub struct Studio(TempDir);

impl Studio {
    pub fn new() -> Self {
        let folder = folder();
        std::fs::copy(root().join("lenses/dgauss.50mm.dat"), folder.path().join("lens.dat"))
            .expect("a lens of the repository");
        write(&folder, "scene.pbrt", SCENE.replace("LENS", "lens.dat"));
        write(&folder, "floor.pbrt", FLOOR);
        Self(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The names of all files but the scene's.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<String> =
            names.map(|name| name.to_string_lossy().into_owned()).collect();
        names.retain(|name| !["scene.pbrt", "floor.pbrt", "lens.dat"].contains(&name.as_str()));
        names.sort();
        names
    }

    pub fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
        command.args(words.split_whitespace()).current_dir(self.0.path());
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    pub fn start(&self, words: &str) -> Child {
        self.command(words).spawn().expect("the command starts")
    }

    /// Runs a command to its end: its exit code, and what it says.
    pub fn run(&self, words: &str) -> (i32, String) {
        said(self.command(words).output().expect("the command starts"))
    }

    /// What a command says that succeeds.
    pub fn done(&self, words: &str) -> String {
        let (code, said) = self.run(words);
        assert_eq!(code, 0, "{words}: {said}");
        said
    }

    /// Fails, and says this.
    pub fn refuses(&self, words: &str, expected: &str) {
        let (code, said) = self.run(words);
        assert_eq!(code, 2, "{words}: {said}");
        assert!(said.contains(expected), "{words}\n  said     {said}\n  expected {expected}");
        assert!(!said.contains("panicked"), "{words}: {said}");
    }

    pub fn contents(&self, name: &str) -> Contents {
        Contents::of(&self.path(name))
    }
}

/// Changes the head and the body of a checkpoint or a part, in place, and sees to it that its checksums
/// say nothing against it.
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

/// Makes a file look as if another build of the program had written it.
pub fn forge_build(path: &Path) {
    forge(path, |head, _| {
        let text = str::from_utf8(head).expect("JSON");
        let key = "\"build\":\"";
        let at = text.find(key).expect("the build") + key.len();
        head[at] = if head[at] == b'0' { b'1' } else { b'0' };
    });
}

pub fn said(output: Output) -> (i32, String) {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().unwrap_or(-1), said)
}

/// A channel's name and its values, bit for bit.
type Channel = (String, Vec<u32>);

/// All that an EXR holds, bit for bit, but the command line.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    pub channels: Vec<Channel>,
    pub attributes: Vec<String>,
}

impl Contents {
    fn of(path: &Path) -> Self {
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

    /// The largest difference of a channel, over its mean.
    pub fn difference(&self, other: &Self) -> f64 {
        assert_eq!(self.channels.len(), other.channels.len());
        let channel = |((name, one), (_, other)): (&Channel, &Channel)| {
            let value = |bits: &u32| f64::from(f32::from_bits(*bits));
            let mean = one.iter().map(|bits| value(bits).abs()).sum::<f64>() / one.len() as f64;
            let off = one.iter().zip(other).map(|(a, b)| (value(a) - value(b)).abs());
            let off = off.fold(0.0, f64::max) / mean.max(1e-30);
            assert!(off.is_finite(), "{name}");
            off
        };
        self.channels.iter().zip(&other.channels).map(channel).fold(0.0, f64::max)
    }
}
