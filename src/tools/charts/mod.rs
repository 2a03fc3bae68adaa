//! Test charts as scenes: flat, in the plane in focus of a given camera, and filling its picture.

pub(crate) mod colours;
pub(crate) mod leaves;
mod patch;
mod scene_text;
mod view;

pub use scene_text::ChartCamera;
pub use view::{ChartError, ChartView};

use colours::colours;
use leaves::leaves;
use patch::{Patch, dots, flat, squares};
use petzval_image::Picture;
use view::MIN_LEAVES;

/// Reflectances of the sides of an edge: the contrast of 4:1 of ISO 12233.
const EDGE_REFLECTANCES: [f64; 2] = [0.18, 0.72];

/// Reflectance about the leaves, and the largest side of their square (pixels).
const GREY: f64 = 0.18;
const MAX_LEAVES: u32 = 400;

/// Reflectance of the frame about the patches of the colour checker.
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
}

/// Leaves in the middle of a chart.
#[derive(Clone, Debug)]
pub struct LeavesSquare {
    /// Reflectances, several for each pixel.
    pub picture: Picture,
    /// The pixels that show them: first column and row, and those that no longer do.
    pub region: [[u32; 2]; 2],
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
    /// Dead leaves, if the chart has them.
    pub leaves: Option<LeavesSquare>,
    /// The pixels that the patches of the colour checker fill, if the chart has them: first column and row, and those
    /// that no longer do.
    pub colours: Option<[[u32; 2]; 2]>,
}

impl Chart {
    /// Draws a chart that fills the picture.
    ///
    /// # Errors
    /// Returns an error if no flat chart can fill it, or if it has too few pixels.
    pub fn new(kind: ChartKind, view: &ChartView<'_>) -> Result<Self, ChartError> {
        let (mut patches, mut edges, mut spacing) = (Vec::new(), Vec::new(), None);
        let (mut square, mut checker) = (None, None);
        match kind {
            ChartKind::Flat => patches.push(flat(view, 1.0)?),
            ChartKind::Leaves => {
                patches.push(flat(view, GREY)?);
                square = Some(leaves_square(view)?);
            }
            ChartKind::Colours => {
                patches.push(flat(view, FRAME)?);
                checker = Some(colours(view, &mut patches)?);
            }
            ChartKind::Grid => {
                patches.push(flat(view, 1.0)?);
                spacing = Some(dots(view, &mut patches)?);
            }
            ChartKind::Edges => {
                let [dark, bright] = EDGE_REFLECTANCES;
                patches.push(flat(view, bright)?);
                edges = squares(view, dark, &mut patches)?;
            }
        }
        Ok(Self { kind, patches, edges, spacing, leaves: square, colours: checker })
    }
}

/// Draws leaves for a square in the middle of the picture.
fn leaves_square(view: &ChartView<'_>) -> Result<LeavesSquare, ChartError> {
    view.check_size(MIN_LEAVES)?;
    let resolution = view.resolution();
    let side = (resolution[0].min(resolution[1]) / 2).min(MAX_LEAVES);
    let low = resolution.map(|n| (n - side) / 2);
    let region = [low, low.map(|n| n + side)];
    Ok(LeavesSquare { picture: leaves(side as usize, 0), region })
}
