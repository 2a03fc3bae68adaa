//! Ghosts: light that is mirrored twice inside the lens.
//!
//! Of a bright source, two surfaces that each reflect a few percent make a second, fainter and
//! mostly unsharp image: one for every pair of them. From the film such a source would hardly
//! ever be hit, so here light goes its own way: from points of the front surface a light is
//! sampled, its rays are traced through the pair's sequence of surfaces, and what arrives is put
//! on the film (light tracing; Hullin et al. 2011, "Physically-based real-time lens flare
//! rendering", has the pairs). Every surface takes or gives its exact share, by angle.
//!
//! What is left out: light mirrored four times or more, and that of the film itself; light that
//! comes to the lens by way of mirrors, panes and bright walls; uniform skies; and light that
//! enters from behind the plane of the front vertex.

mod photons;
mod splat;
mod survey;

pub use splat::SAMPLES;
pub use survey::{Sighting, lamp, survey};

use crate::distribution::Distribution;
use crate::lens::{Prescription, Surface, ghost_sequence};
use crate::spectrum::LightBand;

/// The ghosts of a picture that are simulated.
#[derive(Clone, Debug)]
pub struct Ghosts {
    /// The brightest pairs.
    pub pairs: Vec<Pair>,
}

/// Two surfaces that mirror.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Their rows, from 0 at the scene side; light comes to the second first.
    pub rows: [usize; 2],
    /// The share of light paths that it gets.
    pub share: f64,
    /// Where on the front surface light must enter, over the square about it.
    entry: Distribution,
    /// Its surfaces for light of one wavelength, and what that counts in red, green and blue.
    bands: Vec<(Vec<Surface<f32>>, [f64; 3])>,
}

/// All pairs of rows of which both reflect light.
pub fn pairs(lens: &Prescription) -> Vec<[usize; 2]> {
    let mirrors: Vec<usize> =
        (0..lens.rows.len()).filter(|&row| lens.transmittance(row) < 1.0).collect();
    let below = |&second: &usize| mirrors.iter().filter(move |&&row| row < second);
    mirrors.iter().flat_map(|second| below(second).map(move |&first| [first, *second])).collect()
}

/// The surfaces of a pair in all light at once, or by bands.
fn sequences(
    lens: &Prescription,
    rows: [usize; 2],
    bands: &[LightBand],
) -> Vec<(Vec<Surface<f32>>, [f64; 3])> {
    let one = |band: &LightBand| {
        let lens = lens.at_wavelength(band.wavelength);
        (ghost_sequence::<f32>(&lens, rows, band.wavelength), band.response)
    };
    bands.iter().map(one).collect()
}
