//! Whether rows are read one after another.

use super::{By, Finding};

pub(super) fn find() -> Finding {
    Finding::not_called_for(By::Scene, "all rows are exposed at once, as the scene has it")
}
