//! Test charts as scenes: flat, in the plane in focus of a given camera, and filling its picture.

mod files;
pub(crate) mod leaves;
mod patch;
pub(crate) mod patch_grid;
mod scene_text;
pub(crate) mod star;
mod view;

pub use files::{ChartFiles, ChartFilesError, check_name};
pub use scene_text::ChartCamera;
pub use view::{ChartError, ChartView};

use leaves::leaves;
use patch::{Patch, Reflectance, dots, flat, squares};
use patch_grid::{PatchGrid, grey_reflectance};
use petzval_image::Picture;
use star::star;
use view::{MIN_LEAVES, MIN_STAR};

/// Reflectances of the sides of an edge: the contrast of 4:1 of ISO 12233.
const EDGE_REFLECTANCES: [f64; 2] = [0.18, 0.72];

/// Reflectance about the leaves.
const GREY: f64 = 0.18;
/// Shares of the shorter side of the picture that leaves and star fill, and the most pixels that they do.
const LEAVES_SHARE: f64 = 0.5;
const STAR_SHARE: f64 = 0.9;
const MAX_TEXTURE: f64 = 400.0;

/// Reflectance of the frame about patches.
const FRAME: f64 = 0.04;

/// A test chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChartKind {
    /// Slanted squares in nine places, of 4:1 contrast (ISO 12233).
    Edges,
    /// Black dots in a square grid on white.
    Grid,
    /// White everywhere.
    Flat,
    /// Dead leaves: random detail of all sizes, in a square in the middle.
    Leaves,
    /// The 24 patches of the ColorChecker.
    Colours,
    /// A sinusoidal Siemens star (ISO 12233), in a square in the middle.
    Star,
    /// Twenty steps of grey over 12.6 stops (ISO 14524).
    Greys,
}

/// A chart in front of a camera.
#[derive(Clone, Debug)]
pub struct Chart {
    kind: ChartKind,
    patches: Vec<Patch>,
    /// Regions around the edges (pixels): first column and row, and those that no longer belong to it.
    pub edges: Vec<[[u32; 2]; 2]>,
    /// Distance from dot to dot (mm), if there are dots.
    pub spacing: Option<f64>,
    /// The region of leaves, star or patches, if the chart has them.
    pub region: Option<[[u32; 2]; 2]>,
    /// Reflectances of leaves or star, several for each pixel of the region.
    pub texture: Option<Picture>,
}

impl Chart {
    /// Draws a chart that fills the picture.
    ///
    /// # Errors
    /// Returns an error if no flat chart can fill it, or if it has too few pixels.
    pub fn new(kind: ChartKind, view: &ChartView<'_>) -> Result<Self, ChartError> {
        let background = match kind {
            ChartKind::Flat | ChartKind::Grid => 1.0,
            ChartKind::Edges => EDGE_REFLECTANCES[1],
            ChartKind::Leaves => GREY,
            ChartKind::Star => star::MIDDLE,
            ChartKind::Colours | ChartKind::Greys => FRAME,
        };
        let patches = vec![flat(view, background)?];
        let edges = Vec::new();
        let mut chart = Self { kind, patches, edges, spacing: None, region: None, texture: None };
        match kind {
            ChartKind::Flat => {}
            ChartKind::Grid => chart.spacing = Some(dots(view, &mut chart.patches)?),
            ChartKind::Edges => {
                chart.edges = squares(view, EDGE_REFLECTANCES[0], &mut chart.patches)?;
            }
            ChartKind::Leaves => {
                chart.texture(view, MIN_LEAVES, LEAVES_SHARE, |side| leaves(side, 0))?;
            }
            ChartKind::Star => chart.texture(view, MIN_STAR, STAR_SHARE, star)?,
            ChartKind::Colours => {
                let region =
                    PatchGrid::COLOURS.draw(view, Reflectance::OfChecker, &mut chart.patches)?;
                chart.region = Some(region);
            }
            ChartKind::Greys => {
                let grey = |step: usize| Reflectance::Grey(grey_reflectance(step));
                chart.region = Some(PatchGrid::GREYS.draw(view, grey, &mut chart.patches)?);
            }
        }
        Ok(chart)
    }

    /// Returns the kind of chart.
    pub fn kind(&self) -> ChartKind {
        self.kind
    }

    /// Draws a texture for a square in the middle of a picture of at least so many pixels.
    fn texture(
        &mut self,
        view: &ChartView<'_>,
        least: u32,
        share: f64,
        draw: impl FnOnce(usize) -> Picture,
    ) -> Result<(), ChartError> {
        view.check_size(least)?;
        let resolution = view.resolution();
        let side = (share * f64::from(resolution[0].min(resolution[1]))).min(MAX_TEXTURE) as u32;
        let low = resolution.map(|n| (n - side) / 2);
        self.region = Some([low, low.map(|n| n + side)]);
        self.texture = Some(draw(side as usize));
        Ok(())
    }
}
