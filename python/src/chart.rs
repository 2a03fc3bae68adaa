//! Test charts as scenes.

use std::io;
use std::path::PathBuf;

use petzval_base::io::{FileLog, OutputFile};
use petzval_lens::film_size;
use petzval_optics::FocusedLens;
use petzval_tools::charts::{ChartFiles, ChartFilesError, ChartKind, check_name};
use pyo3::prelude::*;
use serde_json::json;

use crate::error::{image_error, value_error};
use crate::lens::Lens;
use crate::worker;

/// Names of the charts.
const KINDS: [(&str, ChartKind); 7] = [
    ("edges", ChartKind::Edges),
    ("grid", ChartKind::Grid),
    ("flat", ChartKind::Flat),
    ("leaves", ChartKind::Leaves),
    ("colours", ChartKind::Colours),
    ("star", ChartKind::Star),
    ("greys", ChartKind::Greys),
];

/// Width and height of a film (mm), or the name of a film or a camera.
#[derive(FromPyObject)]
pub enum FilmSetting {
    Size((f64, f64)),
    Name(String),
}

impl FilmSetting {
    fn size(&self) -> PyResult<[f64; 2]> {
        match self {
            Self::Size((width, height)) => {
                let is_length = |mm: &f64| (1e-3..=1e4).contains(mm);
                match [width, height].into_iter().all(is_length) {
                    true => Ok([*width, *height]),
                    false => Err(value_error(format!(
                        "film_size=({width}, {height}): expected width and height in mm"
                    ))),
                }
            }
            Self::Name(name) => film_size(name).map(|known| known.size).ok_or_else(|| {
                let problem = "expected (width, height) in mm, or the name of a film or a camera, such as \"35mm\"";
                value_error(format!("film_size={name:?}: {problem}"))
            }),
        }
    }
}

/// Writes the scene of a chart, and returns what measurements need to know, as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "one for each argument of the package's function")]
pub fn chart(
    py: Python<'_>,
    kind: &str,
    lens: &Bound<'_, Lens>,
    path: PathBuf,
    resolution: (i64, i64),
    film: FilmSetting,
    focus: f64,
    fstop: Option<f64>,
) -> PyResult<String> {
    let Some((_, kind)) = KINDS.into_iter().find(|(known, _)| *known == kind) else {
        let known = KINDS.map(|(known, _)| format!("{known:?}")).join(", ");
        return Err(value_error(format!("kind={kind:?}: expected one of {known}")));
    };
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("pbrt")) {
        let found = path.display();
        return Err(value_error(format!("path={found}: expected the name of a scene, .pbrt")));
    }
    if ![resolution.0, resolution.1].iter().all(|side| (1..=65536).contains(side)) {
        return Err(value_error(format!(
            "resolution={resolution:?}: expected 1 to 65536 pixels a side"
        )));
    }
    let resolution = [resolution.0, resolution.1].map(|side| side as u32);
    if focus.is_nan() || focus <= 0.0 {
        return Err(value_error(format!("focus={focus}: expected a distance in m above 0")));
    }
    let lens = lens.get();
    let Some(file) = lens.file().on_disk() else {
        return Err(value_error(
            "lens: the scene of a chart names a lens file, and this lens is a table",
        ));
    };
    let file = std::path::absolute(file)?;
    let mut prescription = lens.prescription().clone();
    if let Some(f_number) = fstop {
        if !(f_number > 0.0 && f_number.is_finite()) {
            return Err(value_error(format!("fstop={f_number}: expected a number above 0")));
        }
        let diameter = prescription
            .f_number_diameter(f_number)
            .map_err(|error| value_error(format!("fstop={f_number}: {error}")))?;
        prescription.stop_down(diameter);
    }
    let mut inputs = FileLog::default();
    inputs.add(&file, None);
    let output = |path: PathBuf| OutputFile::new(path, &inputs).map_err(value_error);
    let texture = path.with_extension("png");
    check_name(&file).map_err(value_error)?;
    check_name(&texture).map_err(value_error)?;
    let scene = output(path)?;
    let texture = kind.has_texture().then(|| output(texture)).transpose()?;
    let film = film.size()?;
    let work = || -> Result<String, ChartFilesError> {
        let focused = FocusedLens::new(&prescription, 1e3 * focus, film, resolution)?;
        let files = ChartFiles::new(kind, &focused, &file)?;
        files.write("petzval.chart", &scene, texture.as_ref())?;
        let chart = &files.chart;
        let region = |[low, high]: [[u32; 2]; 2]| [low[0], low[1], high[0], high[1]];
        Ok(json!({
            "texture": texture.as_ref().map(OutputFile::path),
            "region": chart.region.map(region),
            "edges": chart.edges.iter().map(|edge| region(*edge)).collect::<Vec<_>>(),
            "spacing_mm": chart.spacing,
        })
        .to_string())
    };
    worker::run_whole(py, work)?.map_err(|error| match error {
        ChartFilesError::Texture(error) => image_error(&error),
        ChartFilesError::Scene { ref source, .. } => {
            io::Error::new(source.kind(), error.to_string()).into()
        }
        error => value_error(error),
    })
}
