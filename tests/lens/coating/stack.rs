//! Stacks of films against a textbook, another program and their own symmetries.

use petzval_spectrum::D_LINE;

use super::surface::reflected;
use super::{SEVEN_LAYERS, THREE_LAYERS, V_COAT, stack};
use petzval_lens::{Coating, CoatingLayer, LayerStack, MGF2_INDEX};
use petzval_spectrum::{Glass, find_glass};

/// Films from air to glass, indices before and behind, wavelength (nm), and reflectances for unpolarised
/// light at 0, 30 and 60 degrees, from glass at 0, 20 and 38: optiland 0.6.3,
/// `ThinFilmStack.reflectance_nm_deg`.
type Row = (&'static [[f64; 2]], [f64; 2], f64, [f64; 3]);
const OPTILAND: [Row; 27] = [
    (V_COAT, [1.0, 1.52], 420.0, [0.049_320_419, 0.028_861_965, 0.026_075_564]),
    (V_COAT, [1.0, 1.52], 550.0, [0.000_000_000, 0.002_483_620, 0.051_078_481]),
    (V_COAT, [1.0, 1.52], 680.0, [0.013_351_122, 0.021_336_791, 0.078_295_386]),
    (V_COAT, [1.52, 1.0], 420.0, [0.049_320_419, 0.027_447_844, 0.077_446_804]),
    (V_COAT, [1.52, 1.0], 550.0, [0.000_000_000, 0.002_944_413, 0.122_481_779]),
    (V_COAT, [1.52, 1.0], 680.0, [0.013_351_122, 0.022_175_971, 0.150_883_357]),
    (V_COAT, [1.0, 1.9], 420.0, [0.082_710_230, 0.062_249_963, 0.049_122_278]),
    (V_COAT, [1.0, 1.9], 550.0, [0.012_345_633, 0.004_927_265, 0.025_253_269]),
    (V_COAT, [1.0, 1.9], 680.0, [0.000_832_442, 0.004_189_410, 0.050_210_023]),
    (THREE_LAYERS, [1.0, 1.52], 420.0, [0.016_810_761, 0.006_274_097, 0.025_047_219]),
    (THREE_LAYERS, [1.0, 1.52], 550.0, [0.000_000_657, 0.001_385_356, 0.040_852_291]),
    (THREE_LAYERS, [1.0, 1.52], 680.0, [0.002_621_348, 0.006_189_270, 0.054_596_713]),
    (THREE_LAYERS, [1.52, 1.0], 420.0, [0.016_810_761, 0.005_793_915, 0.079_810_318]),
    (THREE_LAYERS, [1.52, 1.0], 550.0, [0.000_000_657, 0.001_657_729, 0.109_956_486]),
    (THREE_LAYERS, [1.52, 1.0], 680.0, [0.002_621_348, 0.006_654_241, 0.128_695_861]),
    (THREE_LAYERS, [1.0, 1.9], 420.0, [0.053_464_230, 0.028_870_982, 0.047_195_851]),
    (THREE_LAYERS, [1.0, 1.9], 550.0, [0.012_524_172, 0.011_509_534, 0.027_977_083]),
    (THREE_LAYERS, [1.0, 1.9], 680.0, [0.009_063_508, 0.014_940_713, 0.080_663_393]),
    (SEVEN_LAYERS, [1.0, 1.52], 420.0, [0.007_961_323, 0.000_669_544, 0.044_315_051]),
    (SEVEN_LAYERS, [1.0, 1.52], 550.0, [0.021_999_310, 0.021_496_995, 0.071_949_291]),
    (SEVEN_LAYERS, [1.0, 1.52], 680.0, [0.070_488_707, 0.086_461_907, 0.158_850_344]),
    (SEVEN_LAYERS, [1.52, 1.0], 420.0, [0.007_961_323, 0.000_790_104, 0.104_040_455]),
    (SEVEN_LAYERS, [1.52, 1.0], 550.0, [0.021_999_310, 0.021_756_482, 0.150_944_646]),
    (SEVEN_LAYERS, [1.52, 1.0], 680.0, [0.070_488_707, 0.087_950_499, 0.232_715_259]),
    (SEVEN_LAYERS, [1.0, 1.9], 420.0, [0.004_599_193, 0.014_827_302, 0.046_485_714]),
    (SEVEN_LAYERS, [1.0, 1.9], 550.0, [0.026_607_023, 0.025_828_473, 0.076_055_862]),
    (SEVEN_LAYERS, [1.0, 1.9], 680.0, [0.038_451_297, 0.042_464_097, 0.098_515_886]),
];

#[test]
fn stacks_reflect_as_in_optiland() {
    for (films, indices, nm, expected) in OPTILAND {
        let angles = if indices[0] < indices[1] { [0.0, 30.0, 60.0] } else { [0.0, 20.0, 38.0] };
        for (degrees, expected) in angles.into_iter().zip(expected) {
            let found = reflected(&stack(films), indices, degrees, nm);
            let what = format!("{films:?} {indices:?}, {nm} nm, {degrees} degrees");
            assert!((found - expected).abs() < 1e-9, "{what}: {found}, not {expected}");
        }
    }
}

#[test]
fn a_v_coat_reflects_nothing_at_its_wavelength() {
    // Macleod, Thin-Film Optical Filters, 2010, eqs. 4.5 and 4.6: phases of the outer and the inner film.
    let [n0, n1, n2, glass] = [1.0f64, 1.38, 2.3, 1.52];
    let (squares, span) = ([n1 * n1, n2 * n2], glass - n0);
    let shared = squares[0] * glass - n0 * squares[1];
    let outer =
        span * (squares[1] - n0 * glass) * squares[0] / (shared * (n0 * glass - squares[0]));
    let inner =
        span * (n0 * glass - squares[0]) * squares[1] / (shared * (squares[1] - n0 * glass));
    let phases = [std::f64::consts::PI - outer.sqrt().atan(), inner.sqrt().atan()];
    let film = |i: usize, n: f64| [n, 550.0 * phases[i] / (std::f64::consts::TAU * n)];
    let films = [film(0, n1), film(1, n2)];
    for (film, known) in films.iter().zip(V_COAT) {
        assert!((film[1] - known[1]).abs() < 1e-4, "{films:?}");
    }
    let found = reflected(&stack(&films), [n0, glass], 0.0, 550.0);
    assert!(found.abs() < 1e-12, "{found:e}");
}

#[test]
fn three_layers_reflect_as_in_the_textbook() {
    // A half wave has no effect at its wavelength; two quarter waves turn the glass to n1^2 ns / n3^2.
    let seen = (1.38f64 / 1.7).powi(2) * 1.52;
    let expected = ((1.0 - seen) / (1.0 + seen)).powi(2);
    let found = reflected(&stack(THREE_LAYERS), [1.0, 1.52], 0.0, 550.0);
    assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
}

#[test]
fn one_film_is_a_quarter_wave_layer() {
    let film = stack(&[[MGF2_INDEX, 550.0 / 4.0 / MGF2_INDEX]]);
    for degrees in [0.0, 20.0, 45.0, 70.0, 89.0] {
        for nm in [400.0, D_LINE, 700.0] {
            let found = reflected(&film, [1.0, 1.6], degrees, nm);
            let expected = reflected(&Coating::Mgf2, [1.0, 1.6], degrees, nm);
            assert!((found - expected).abs() < 2e-7, "{degrees} {nm}: {found}, not {expected}");
        }
    }
}

#[test]
fn films_of_a_material_disperse() {
    let glass = Glass::Catalogue(find_glass("MGF2").expect("a known crystal"));
    let film = |glass: Glass, index: f64| {
        let layers = [CoatingLayer { index, glass, thickness: 800.0 }];
        Coating::Stack(LayerStack { name: "a film".into(), layers: layers.into() })
    };
    for nm in [405.0, 546.0, 656.0] {
        let index = glass.nearest_index(1.0, nm);
        let found = reflected(&film(glass.clone(), glass.nd()), [1.0, 1.5], 20.0, nm);
        let expected = reflected(&film(Glass::Constant, index), [1.0, 1.5], 20.0, nm);
        assert_eq!(found, expected, "{nm} nm");
    }
    let blue = glass.nearest_index(1.0, 405.0) - glass.nearest_index(1.0, 656.0);
    assert!(blue > 0.005, "{blue}");
}

#[test]
fn a_hundred_layers_keep_the_energy() {
    // A quarter-wave mirror of 100 films reflects all but 1e-15 of its colour.
    let films: Vec<[f64; 2]> =
        (0..LayerStack::MAX_LAYERS).map(|i| [2.3, 1.46][i % 2]).map(|n| [n, 137.5 / n]).collect();
    let mirror = stack(&films);
    for degrees in [0.0, 30.0, 60.0, 89.0] {
        for nm in [300.0, 550.0, 900.0, 2000.0] {
            let found = reflected(&mirror, [1.0, 1.52], degrees, nm);
            assert!((0.0..=1.0).contains(&found), "{degrees} {nm}: {found}");
            let back = (f64::to_radians(degrees).sin() / 1.52).asin().to_degrees();
            let back = reflected(&mirror, [1.52, 1.0], back, nm);
            assert!((found - back).abs() < 1e-9, "{degrees} {nm}: {found} {back}");
        }
    }
    assert!(reflected(&mirror, [1.0, 1.52], 0.0, 550.0) > 1.0 - 1e-9);
    assert!(reflected(&mirror, [1.0, 1.52], 0.0, 900.0) < 0.5);
}

#[test]
fn seven_layers_have_a_colour() {
    let [blue, red] =
        [420.0, 680.0].map(|nm| reflected(&stack(SEVEN_LAYERS), [1.0, 1.52], 0.0, nm));
    assert!(red > 5.0 * blue, "{blue} {red}");
    assert!(stack(SEVEN_LAYERS).is_coloured() && !Coating::Broadband.is_coloured());
}
