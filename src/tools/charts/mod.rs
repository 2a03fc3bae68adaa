//! Test charts as scenes: flat, in the plane in focus of a given camera, and filling its picture.

mod patch;
mod scene_text;
mod view;

pub use scene_text::ChartCamera;
pub use view::{ChartError, ChartView};

use patch::{Patch, dots, flat, squares};

/// Reflectances of the sides of an edge: the contrast of 4:1 of ISO 12233.
const EDGE_REFLECTANCES: [f64; 2] = [0.18, 0.72];

/// A test chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChartKind {
    /// Slanted squares in nine places, of 4:1 contrast (ISO 12233).
    Edges,
    /// Black dots in a square grid on white.
    Grid,
    /// White everywhere.
    Flat,
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
}

impl Chart {
    /// Draws a chart that fills the picture.
    ///
    /// # Errors
    /// Returns an error if no flat chart can fill it, or if it has too few pixels.
    pub fn new(kind: ChartKind, view: &ChartView<'_>) -> Result<Self, ChartError> {
        let (mut patches, mut edges, mut spacing) = (Vec::new(), Vec::new(), None);
        match kind {
            ChartKind::Flat => patches.push(flat(view, 1.0)?),
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
        Ok(Self { kind, patches, edges, spacing })
    }
}
