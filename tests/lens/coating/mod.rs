//! Reflection losses: one surface against the textbook, a lens against the product of its surfaces, a
//! picture against the estimate.

mod picture;
pub mod rays;
mod stack;
mod surface;

use petzval_lens::{Coating, CoatingLayer, LayerStack};
use petzval_spectrum::Glass;

/// Index and thickness (nm) of the films of a V-coat for index 1.52 at 550 nm.
const V_COAT: &[[f64; 2]] = &[[1.38, 128.8755], [2.3, 12.548]];
/// Quarter, half and quarter wave at 550 nm.
const THREE_LAYERS: &[[f64; 2]] = &[[1.38, 99.637_681], [2.15, 127.906_977], [1.7, 80.882_353]];
const SEVEN_LAYERS: &[[f64; 2]] = &[
    [1.38, 92.0],
    [2.1, 110.0],
    [1.46, 35.0],
    [2.1, 25.0],
    [1.62, 60.0],
    [2.3, 15.0],
    [1.46, 40.0],
];

/// Makes a stack of films without dispersion, from air to glass.
fn stack(films: &[[f64; 2]]) -> Coating {
    let film =
        |&[index, thickness]: &[f64; 2]| CoatingLayer { index, glass: Glass::Constant, thickness };
    Coating::Stack(LayerStack { name: "films".into(), layers: films.iter().map(film).collect() })
}

/// Returns coatings of every kind.
fn all() -> Vec<Coating> {
    let mut all = vec![Coating::Bare, Coating::Mgf2, Coating::Broadband, Coating::Perfect];
    all.extend([V_COAT, THREE_LAYERS, SEVEN_LAYERS].map(stack));
    all
}
