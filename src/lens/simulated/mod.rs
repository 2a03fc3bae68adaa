//! A camera whose lens is simulated less exactly than it could be, or more.

mod exposure;
mod thin;

use super::camera::{Camera, Model};
use super::fidelity::Fidelity;

impl Camera {
    /// This camera with its real lens simulated so exactly, for the plan it has now: its effects
    /// are to be chosen first. A camera without a lens of glass stays as it is.
    pub fn simulated(&self, fidelity: Fidelity) -> Self {
        let Model::Real(lens) = &self.model else { return self.clone() };
        match fidelity {
            Fidelity::Pinhole | Fidelity::Thin => {
                let exposed = exposure::on_axis(lens);
                thin::thin(self, lens, fidelity == Fidelity::Thin, exposed)
            }
            _ => self.clone(),
        }
    }
}
