//! Crystals, silica and plastics.
//!
//! Fused silica: Malitson 1965, J. Opt. Soc. Am. 55, 1205. Calcium fluoride: Malitson 1963,
//! Appl. Opt. 2, 1103. PMMA, polycarbonate and polystyrene: Handbook of Optics, vol. II, as in the
//! Zemax catalogue "misc" of 2013. Zeonex: the maker's Zemax catalogue of 2013.

use super::catalogue::{CatalogueGlass, Formula};

const fn glass(
    maker: &'static str,
    name: &'static str,
    published: [f64; 2],
    formula: Formula,
) -> CatalogueGlass {
    CatalogueGlass { name, maker, published, formula }
}

#[rustfmt::skip]
pub(super) const GLASSES: &[CatalogueGlass] = &[
    glass("", "F_SILICA", [1.458464, 67.82], Formula::Sellmeier { b: [0.6961663, 0.4079426, 0.8974794], c: [0.0684043 * 0.0684043, 0.1162414 * 0.1162414, 9.896161 * 9.896161] }),
    glass("", "CAF2", [1.433849, 95.00], Formula::Sellmeier { b: [0.5675888, 0.4710914, 3.8484723], c: [0.050263605 * 0.050263605, 0.1003909 * 0.1003909, 34.649040 * 34.649040] }),
    glass("", "PMMA", [1.491756, 57.44], Formula::Schott([2.1864582, -2.4475348e-4, 1.4155787e-2, -4.4329781e-4, 7.7664259e-5, -2.9936382e-6])),
    glass("", "POLYCARB", [1.585470, 29.91], Formula::Schott([2.42838566, -3.86116645e-5, 2.87574474e-2, -1.97897366e-4, 1.48358968e-4, 1.38651935e-6])),
    glass("", "POLYSTYR", [1.590481, 30.87], Formula::Schott([2.44598368, 2.21428933e-5, 2.72988569e-2, 3.01210852e-4, 8.88934888e-5, -1.75707929e-6])),
    glass("Zeon", "E48R", [1.53117, 56.0], Formula::Schott([2.30319693, -1.17825616e-3, 1.40597151e-2, 2.97687093e-5, 3.28913151e-5, -1.61443145e-6])),
];
