//! `petzval chart`: test charts as scenes.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use petzval_base::io::ReadContext;
use petzval_tools::charts::{Chart, ChartFiles, ChartFilesError, ChartKind, check_name};

use super::arguments::argv::{accepted_words, argv, shell_line};
use super::lens::LensCameraArguments;
use super::measure::region_text;
use super::outputs::claim_writable;
use super::{Failure, Outcome};

/// Options that choose what a lens file means, which the render needs too.
const OF_LENS_FILE: [&str; 4] = ["--zoom", "--wavelengths", "--catalogue", "--approximate"];

/// Arguments of `petzval chart`.
#[derive(Debug, clap::Args)]
pub(super) struct ChartArguments {
    /// Chart: slanted edges, a grid of dots, white, dead leaves, colours, a star, or greys
    #[arg(value_enum)]
    kind: KindArgument,
    #[command(flatten)]
    camera: LensCameraArguments,
    /// Scene to write, such as chart.pbrt
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum KindArgument {
    /// Slanted squares in nine places, of 4:1 contrast (ISO 12233)
    Edges,
    /// Black dots in a square grid on white
    Grid,
    /// White everywhere
    Flat,
    /// Dead leaves: random detail of all sizes, in a square in the middle; their picture stands beside the scene
    Leaves,
    /// The 24 patches of the ColorChecker
    Colours,
    /// Sinusoidal Siemens star in a square in the middle (ISO 12233); its picture stands beside the scene
    Star,
    /// Twenty steps of grey over 12.6 stops (ISO 14524)
    Greys,
}

impl From<KindArgument> for ChartKind {
    fn from(kind: KindArgument) -> Self {
        match kind {
            KindArgument::Edges => Self::Edges,
            KindArgument::Grid => Self::Grid,
            KindArgument::Flat => Self::Flat,
            KindArgument::Leaves => Self::Leaves,
            KindArgument::Colours => Self::Colours,
            KindArgument::Star => Self::Star,
            KindArgument::Greys => Self::Greys,
        }
    }
}

pub(super) fn run(arguments: &ChartArguments) -> Result<Outcome, Failure> {
    let ChartArguments { kind, camera, output } = arguments;
    let context = ReadContext::default();
    let is_scene =
        output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("pbrt"));
    if !is_scene {
        return Err(format!("-o {}: expected the name of a scene, .pbrt", output.display()).into());
    }
    let lens_path = std::path::absolute(&camera.lens)?;
    check_name(&lens_path).map_err(|error| error.to_string())?;
    let lens = camera.read(&context)?;
    let outputs = camera.file.outputs(&context.files());
    let file = claim_writable(&outputs, output, "-o")?;
    let texture = output.with_extension("png");
    let kind = ChartKind::from(*kind);
    let texture_file = match kind.has_texture() {
        true => {
            check_name(&texture).map_err(|error| error.to_string())?;
            Some(claim_writable(&outputs, &texture, "-o")?)
        }
        false => None,
    };
    let focused = camera.focused(lens)?;
    let named = |error: ChartFilesError| match error {
        ChartFilesError::Calibration(_) | ChartFilesError::Chart(_) => {
            Failure::from(format!("{}: {error}", camera.lens.display()))
        }
        _ => error.to_string().into(),
    };
    let files = ChartFiles::new(kind, &focused, &lens_path).map_err(named)?;
    files.write(&shell_line(&argv()), &file, texture_file.as_ref()).map_err(named)?;
    super::print(&next_steps(&files.chart, output, focused.setup().disperses()))
}

/// Returns the commands that photograph the chart and measure the picture. Lateral colour counts long before it is seen.
fn next_steps(chart: &Chart, scene: &Path, disperses: bool) -> String {
    let picture = scene.with_extension("exr");
    let [scene, picture] = [scene, &picture].map(|path| path.display().to_string());
    let line = |words: &[&str]| {
        shell_line(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>())
    };
    let mut render = vec!["petzval", "render", &scene, "-o", &picture];
    if disperses {
        render.extend(["--effects", "+dispersion"]);
    }
    let accepted = accepted_words(&argv(), "render").unwrap_or_default();
    let is_of_file = |word: &&str| OF_LENS_FILE.iter().any(|option| word.starts_with(option));
    render.extend(accepted.iter().map(String::as_str).filter(is_of_file));
    let measure = |words: &[&str]| line(&[&["petzval", "measure"], words].concat()) + "\n";
    let region = chart.region.map(region_text).unwrap_or_default();
    let texture = Path::new(&scene).with_extension("png").display().to_string();
    let measure = match chart.kind() {
        ChartKind::Flat => measure(&["shading", &picture]),
        ChartKind::Grid => measure(&["grid", &picture]),
        ChartKind::Colours => measure(&["colours", &picture, "--region", &region]),
        ChartKind::Greys => measure(&["greys", &picture, "--region", &region]),
        ChartKind::Star => measure(&["star", &picture, "--region", &region]),
        ChartKind::Leaves => {
            measure(&["texture", &picture, "--region", &region, "--chart", &texture])
        }
        ChartKind::Edges => {
            let edges: Vec<String> = chart.edges.iter().map(|edge| region_text(*edge)).collect();
            let edges = edges.iter().flat_map(|edge| ["--edge", edge]);
            measure(&[picture.as_str()].into_iter().chain(edges).collect::<Vec<_>>())
        }
    };
    line(&render) + "\n" + &measure
}
