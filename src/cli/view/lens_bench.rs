//! Lens bench: the camera of a picture, and how its lens forms the image at one place.

use petzval_lens::{BlockReason, Blocked, Camera, LensModel, RayPath, RealLens};
use petzval_render::film::Frame;
use petzval_render::job::Job;
use serde_json::{Value, json};

use petzval_report::lens_drawing::{DrawnPath, aims, draw_paths};
use petzval_report::lens_report::point_report;
use petzval_report::svg::Position;

/// Rays from a film point, evenly over the rear element.
const RAYS: u32 = 320;
/// Most rays that are drawn of those that pass, and of those that end at one surface.
const SHOWN: [usize; 2] = [11, 4];
/// Colour of rays that pass.
const PASSING: &str = "#0072b2";

/// The camera of a picture.
pub(super) struct LensBench {
    camera: Camera,
    frame: Frame,
}

/// Rays of a film point that end in the same way.
struct RayGroup {
    /// Where and why they are blocked; `None` if they pass.
    end: Option<Blocked>,
    paths: Vec<RayPath>,
}

impl LensBench {
    pub fn new(job: &Job) -> Self {
        Self { camera: job.camera.clone(), frame: job.frame }
    }

    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    fn lens(&self) -> Option<&RealLens> {
        match &self.camera.model {
            LensModel::Real(lens) => Some(lens),
            _ => None,
        }
    }

    /// Returns the film point (mm) of a place in the picture, in shares of its size from the upper
    /// left corner.
    fn film_point(&self, place: [f64; 2]) -> [f64; 2] {
        let Frame { resolution, low, .. } = self.frame;
        let size = self.frame.size();
        let at = [0, 1].map(|i| f64::from(low[i]) + place[i] * f64::from(size[i]));
        self.camera.film_point(at, resolution)
    }

    /// Traces rays from a place to all of the rear element, in the plane through the axis. Returns
    /// the section with them, and what becomes of them; `None` without a lens file.
    pub fn rays(&self, place: [f64; 2]) -> Option<Value> {
        let lens = self.lens()?;
        let film = self.film_point(place);
        let [x, y, z] = lens.film_pose.film_point(film);
        let radius = x.hypot(y);
        // The upper half of the plane is up in the picture of the section.
        let side = if y < 0.0 { -1.0 } else { 1.0 };
        let across = if radius > 0.0 { [side * x / radius, side * y / radius] } else { [0.0, 1.0] };
        let on_plane = |[x, y, z]: [f64; 3]| [z, x * across[0] + y * across[1]];
        let heights = aims(&lens.prescription, lens.film_distance - z, side * radius, RAYS);
        let path = |&height: &f64| lens.path_between(film, across.map(|c| c * height));
        let paths: Vec<RayPath> = heights.iter().map(path).collect();
        let limits = limits(&paths);
        let groups = groups(paths);
        let all: usize = groups.iter().map(|group| group.paths.len()).sum();
        let half = self.camera.half_diagonal();
        let edge = |sign: f64| {
            on_plane(lens.path_between(across.map(|c| sign * c * half), [0.0; 2]).start)
        };
        let drawn: Vec<DrawnPath> = groups.iter().flat_map(|group| group.drawn(on_plane)).collect();
        let fates: Vec<Value> = groups
            .iter()
            .map(|group| {
                json!({
                    "words": group.end.map_or_else(|| "pass".to_owned(), words),
                    "colour": colour(group.end),
                    "share": group.paths.len() as f64 / all.max(1) as f64,
                })
            })
            .collect();
        Some(json!({
            "height": radius,
            "film": film,
            "section": draw_paths(&lens.prescription, [-1.0, 1.0].map(edge), &drawn),
            "fates": fates,
            "limits": limits.map(|limits| limits.map(|end| end.map(words))),
        }))
    }

    /// Returns the spot diagram and the modulation transfer at the distance of a place from the
    /// axis.
    ///
    /// # Errors
    /// Returns a message if the lens cannot be analysed there.
    pub fn image(&self, place: [f64; 2]) -> Result<Value, String> {
        let lens = self.lens().ok_or("this camera has no lens file")?;
        let [x, y, _] = lens.film_pose.film_point(self.film_point(place));
        let height = x.hypot(y);
        let report = point_report(&lens.prescription, lens.film_distance, height)?;
        let [spot, transfer] = report.plots;
        Ok(json!({ "height": height, "rms": report.rms, "spot": spot, "transfer": transfer }))
    }
}

impl RayGroup {
    /// Returns some of the paths, evenly spread, on the plane of the drawing.
    fn drawn(&self, on_plane: impl Fn([f64; 3]) -> Position) -> Vec<DrawnPath> {
        let last = self.paths.len().saturating_sub(1);
        let most = SHOWN[usize::from(self.end.is_some())];
        let steps = last.min(most - 1);
        let chosen = (0..=steps).map(|i| &self.paths[(i * last).checked_div(steps).unwrap_or(0)]);
        let path = |path: &RayPath| {
            let points = path.crossings.iter().filter_map(|crossing| crossing.point);
            let [tx, ty, tz] = path.end.as_ref().map_or([f64::NAN; 3], |ray| ray.t);
            DrawnPath {
                points: std::iter::once(path.start).chain(points).map(&on_plane).collect(),
                towards: self.end.is_none().then(|| on_plane([tx, ty, -tz])),
                colour: colour(self.end),
            }
        };
        chosen.map(path).collect()
    }
}

/// Sorts paths by their ends; those that pass come last and are drawn over the others.
fn groups(paths: Vec<RayPath>) -> Vec<RayGroup> {
    let mut groups: Vec<RayGroup> = Vec::new();
    for path in paths {
        let end = path.end.as_ref().err().copied();
        match groups.iter_mut().find(|group| group.end == end) {
            Some(group) => group.paths.push(path),
            None => groups.push(RayGroup { end, paths: vec![path] }),
        }
    }
    groups.sort_by_key(|group| group.end.map_or(usize::MAX, |blocked| blocked.row));
    groups
}

/// Returns the ends of the rays next to those that pass, below and above; `None` if none pass.
fn limits(paths: &[RayPath]) -> Option<[Option<Blocked>; 2]> {
    let first = paths.iter().position(|path| path.end.is_ok())?;
    let last = paths.iter().rposition(|path| path.end.is_ok())?;
    let end = |i: Option<usize>| paths.get(i?)?.end.as_ref().err().copied();
    Some([end(first.checked_sub(1)), end(Some(last + 1))])
}

fn words(Blocked { row, reason }: Blocked) -> String {
    let row = row + 1;
    match reason {
        BlockReason::Stop => "the stop".to_owned(),
        BlockReason::Clip => format!("the rim of surface {row}"),
        BlockReason::Miss => format!("no point on surface {row}"),
        BlockReason::Tir => format!("total reflection at surface {row}"),
    }
}

/// Returns the colour of rays that end there (Okabe & Ito 2008).
fn colour(end: Option<Blocked>) -> &'static str {
    match end.map(|blocked| blocked.reason) {
        None => PASSING,
        Some(BlockReason::Stop) => "#7f7f7f",
        Some(BlockReason::Clip) => "#d55e00",
        Some(BlockReason::Miss) => "#e69f00",
        Some(BlockReason::Tir) => "#cc79a7",
    }
}
