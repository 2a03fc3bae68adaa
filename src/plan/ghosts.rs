//! Whether light that is mirrored twice inside the lens can be seen.

use super::{By, Finding};

pub(super) fn find() -> Finding {
    Finding::not_called_for(By::Lens, "not simulated yet")
}
