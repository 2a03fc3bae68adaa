//! Whether the film or an element stands askew.

use super::{By, Finding};

pub(super) fn find() -> Finding {
    Finding::not_called_for(By::Scene, "film and elements stand square to the axis")
}
