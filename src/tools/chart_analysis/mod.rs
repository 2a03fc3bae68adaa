//! Analysis of photographed test charts: spatial frequency response of slanted edges and of texture, distortion and
//! lateral colour of a grid of dots.

mod dot_grid;
mod dots;
mod edge;
mod edge_response;
mod grid_order;
mod texture;

pub use dot_grid::{DotGrid, GridDot, GridError};
pub use edge::EdgeError;
pub use edge_response::{EdgeAxis, EdgeResponse};
pub use texture::{TextureError, TextureResponse};
