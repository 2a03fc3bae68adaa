//! Analysis of photographed test charts: spatial frequency response of slanted edges and of texture, distortion and
//! lateral colour of a grid of dots, colours of a colour checker.

mod colours;
mod dot_grid;
mod dots;
mod edge;
mod edge_response;
mod grid_order;
mod json;
mod texture;

pub use colours::{ColourPatches, ColoursError, PatchColour};
pub use dot_grid::{DotGrid, GridDot, GridError};
pub use edge::EdgeError;
pub use edge_response::{EdgeAxis, EdgeResponse};
pub use texture::{TextureError, TextureResponse};

/// Returns the luminance of linear sRGB (IEC 61966-2-1).
pub fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}
