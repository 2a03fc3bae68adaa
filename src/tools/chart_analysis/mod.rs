//! Analysis of photographed test charts: spatial frequency response of slanted edges and of texture, distortion and
//! lateral colour of a grid of dots, colours of a colour checker.

mod colours;
mod dot_grid;
mod dots;
mod edge;
mod edge_response;
mod grid_order;
mod texture;

pub use colours::{ColourPatches, ColoursError, PatchColour};
pub use dot_grid::{DotGrid, GridDot, GridError};
pub use edge::EdgeError;
pub use edge_response::{EdgeAxis, EdgeResponse};
pub use texture::{TextureError, TextureResponse};
