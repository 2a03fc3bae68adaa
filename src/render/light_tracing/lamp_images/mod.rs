//! Lamp images: the picture of small bright lamps and of a sun in a sky, found from the lamps.
//!
//! A camera path finds a lamp only if its pixel and its point of the pupil happen to look at it. At
//! the rim of a lamp and in its bokeh few paths do, and each that does is as bright as the lamp. A
//! light path starts on the lamp instead: it goes to a point of the plane of the front vertex, through
//! the lens to the film, and is splatted through the pixel filter.
//!
//! Both kinds of paths find the same light, so multiple importance sampling weighs them (Veach
//! 1997, section 9.2). A lens in air conserves the etendue dG = cos dA dw: it is the same at the film
//! and in the plane of the front vertex. Densities over dG are comparable without the Jacobian of
//! the lens:
//!
//! - The camera takes one path per pixel of area `a`, with the density `p` over the directions from
//!   the film: `1 / a * p / cos`, at the film. The weight of a camera ray is `cos / p`, times the
//!   transmission of the lens, so that the density is `1 / (a * weight)` up to that transmission.
//! - `n` light paths choose a lamp with probability `s`, an entry point with density `e` (mm^-2) and
//!   a direction to the lamp with density `q` (1/sr): `n s e q / cos`, in the plane of the front
//!   vertex.
//!
//! The camera's density is divided by the transmission of the path in both weights. Any function of
//! the path is allowed, as long as the weights of both strategies add up to one for every path.
//!
//! With dispersion, a camera ray is traced at the wavelength of its hero and shared by other bands. Its
//! density is that of the hero. A light path is traced in the same bands, and takes what the rays of
//! each hero leave ([`add_splats`](crate::light_tracing::light_paths)).
//!
//! Paths by way of other surfaces, and lamps that a mirror or a window shows, stay with the camera.

mod density;
mod lamp;
mod reach;
mod survey;
mod trace;

pub use density::LampImageWeights;
pub(crate) use survey::survey;
pub(crate) use trace::LampColumns;

use crate::light_tracing::entry::EntrySquare;
use crate::light_tracing::light_paths::FrontEntry;
use lamp::Lamp;
use petzval_base::distribution::DiscreteDistribution;
use petzval_lens::RealLens;

/// The lamps that light paths start from.
#[derive(Clone, Debug)]
pub struct LampImages {
    lamps: Vec<Lamp>,
    /// Choice of a lamp.
    choice: DiscreteDistribution,
    /// Index of the lamp, by light of the scene.
    by_light: Vec<Option<u32>>,
    /// The lens as the paths enter it.
    front: FrontEntry,
    /// Whether light paths are the exclusive strategy: they have weight 1, and camera paths leave out
    /// all that they can find.
    exclusive: bool,
}

impl LampImages {
    /// Prepares light paths without lamps, for a lens, the square of entry points and the number of
    /// lights of the scene.
    fn new(lens: &RealLens, square: EntrySquare, lights: usize) -> Self {
        Self {
            lamps: Vec::new(),
            choice: DiscreteDistribution::from_probabilities(&[1.0]),
            by_light: vec![None; lights],
            front: FrontEntry::new(lens, square),
            exclusive: false,
        }
    }

    /// Makes light paths the exclusive strategy, of weight 1, for all light that they can find, instead
    /// of weighing them against camera paths. The picture has the same light, and shows whether light
    /// paths find all of it.
    pub fn make_exclusive(&mut self) {
        self.exclusive = true;
    }

    /// Sets the lamps, each with the number that its probability is proportional to.
    fn set_lamps(&mut self, lamps: Vec<(Lamp, f64)>) {
        let total: f64 = lamps.iter().map(|(_, weight)| weight).sum();
        let shares: Vec<f64> = lamps.iter().map(|(_, weight)| weight / total).collect();
        self.by_light.fill(None);
        self.lamps.clear();
        for (i, ((lamp, _), &share)) in lamps.into_iter().zip(&shares).enumerate() {
            self.by_light[lamp.light as usize] = Some(i as u32);
            self.lamps.push(Lamp { share: share as f32, ..lamp });
        }
        self.choice = DiscreteDistribution::from_probabilities(&shares);
    }

    /// Returns the number of lamps.
    pub fn lamps(&self) -> usize {
        self.lamps.len()
    }
}
