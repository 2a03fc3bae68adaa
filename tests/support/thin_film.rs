//! Reflectances of thin films by naive formulas.

use petzval_lens::LayerStack;

/// A complex number.
type Complex = [f64; 2];

fn product([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

fn quotient(a: Complex, [c, d]: Complex) -> Complex {
    product(a, [c, -d]).map(|v| v / (c * c + d * d))
}

/// Returns the reflectances of a surface for s- and p-polarised light: Fresnel's amplitudes and the sum of
/// all reflections in a layer (Airy 1833), from the last to the first (Rouard 1937). Each layer is an index
/// and a thickness in vacuum wavelengths, in the order in which light meets them.
pub fn reflectances(n: f64, layers: &[[f64; 2]], after: f64, angle: f64) -> [f64; 2] {
    let cos = |m: f64| (1.0 - (n / m * angle.sin()).powi(2)).sqrt();
    let amplitudes = |a: f64, b: f64| {
        let (ca, cb) = (cos(a), cos(b));
        [(a * ca - b * cb) / (a * ca + b * cb), (b * ca - a * cb) / (b * ca + a * cb)]
    };
    let before = |i: usize| if i == 0 { n } else { layers[i - 1][0] };
    let last = amplitudes(before(layers.len()), after);
    let mut sums = last.map(|r| [r, 0.0]);
    for (i, &[index, thickness]) in layers.iter().enumerate().rev() {
        let first = amplitudes(before(i), index);
        let phase = 4.0 * std::f64::consts::PI * index * thickness * cos(index);
        for (sum, first) in sums.iter_mut().zip(first) {
            let there = product(*sum, [phase.cos(), phase.sin()]);
            let bottom = product([first, 0.0], there);
            *sum = quotient([first + there[0], there[1]], [1.0 + bottom[0], bottom[1]]);
        }
    }
    sums.map(|[re, im]| re * re + im * im)
}

/// Returns the films of a stack without dispersion, in the order in which light meets them between two
/// indices: each an index and a thickness in wavelengths (nm).
pub fn films(stack: &LayerStack, [n, after]: [f64; 2], nm: f64) -> Vec<[f64; 2]> {
    let film = |layer: &petzval_lens::CoatingLayer| [layer.index, layer.thickness / nm];
    match n < after {
        true => stack.layers.iter().map(film).collect(),
        false => stack.layers.iter().rev().map(film).collect(),
    }
}
