//! Analysis of photographed test charts: spatial frequency response of slanted edges.

mod edge;
mod edge_response;

pub use edge::EdgeError;
pub use edge_response::{EdgeAxis, EdgeResponse};
