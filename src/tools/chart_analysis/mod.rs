//! Analysis of photographed test charts: spatial frequency response of slanted edges, stars and texture, distortion and
//! lateral colour of a grid of dots, colours of a colour checker, tone and noise of steps of grey, shading of white.

mod colours;
mod dot_grid;
mod dots;
mod edge;
mod edge_response;
mod greys;
mod grid_order;
mod json;
mod patches;
mod shading;
mod star;
mod star_fit;
mod texture;

pub use colours::{ColourPatches, ColoursError, PatchColour};
pub use dot_grid::{DotGrid, GridDot, GridError};
pub use edge::EdgeError;
pub use edge_response::{EdgeAxis, EdgeResponse};
pub use greys::{GreyStep, GreySteps, GreysError};
pub use patches::PatchError;
pub use shading::{Shading, ShadingError, ShadingZone};
pub use star::{StarChart, StarError, StarResponse, StarRing};
pub use texture::{TextureError, TextureResponse};

/// Returns the luminance of linear sRGB (IEC 61966-2-1).
pub fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}
