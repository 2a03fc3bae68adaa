//! Spectra of the primaries of linear sRGB, whose sum is 1 at every wavelength (Mallett & Yuksel 2019,
//! "Spectral primary decomposition for rendering with sRGB reflectance").

use std::sync::LazyLock;

use glam::{DMat3, DVec3};

use crate::BandSpectrum;

/// Wavelength of the first entry, and the distance of two entries (nm).
const FIRST: f64 = 380.0;
const STEP: f64 = 5.0;

/// Spectra of red, green and blue by band. They are combined so that their colours are the primaries: those
/// of the table are off by 0.2 %, and white as it is.
pub(super) static BASIS: LazyLock<[BandSpectrum; 3]> = LazyLock::new(|| {
    let table = [0, 1, 2].map(|channel| BandSpectrum::of(|nm| primary(channel, nm)));
    let [r, g, b] = table.each_ref().map(|spectrum| DVec3::from_array(spectrum.to_rgb()));
    let shares = DMat3::from_cols(r, g, b).inverse();
    [0, 1, 2].map(|channel| {
        let share = shares.col(channel);
        BandSpectrum::of(|nm| (0..3).map(|i| share[i] * primary(i, nm)).sum())
    })
});

/// Returns the spectrum of a primary at a wavelength: linear between entries, constant beyond.
fn primary(channel: usize, nm: f64) -> f64 {
    let last = RED_AND_GREEN.len() - 2;
    let x = ((nm - FIRST) / STEP).clamp(0.0, (last + 1) as f64);
    let below = (x as usize).min(last);
    let value = |[red, green]: [f64; 2]| [red, green, 1.0 - red - green][channel];
    let (low, high) = (value(RED_AND_GREEN[below]), value(RED_AND_GREEN[below + 1]));
    low + (x - below as f64) * (high - low)
}

/// Red and green by wavelength; blue is what is left. From the supplement of the paper, rounded.
#[rustfmt::skip]
const RED_AND_GREEN: [[f64; 2]; 81] = [
    [0.327457, 0.331862],
    [0.323751, 0.329688],
    [0.313439, 0.327860],
    [0.288879, 0.319174],
    [0.239206, 0.294323],
    [0.189702, 0.258697],
    [0.121746, 0.188894],
    [0.074578, 0.125388],
    [0.044433, 0.078687],
    [0.028929, 0.053143],
    [0.022317, 0.042288],
    [0.016911, 0.033318],
    [0.014181, 0.029756],
    [0.013053, 0.030331],
    [0.011986, 0.030989],
    [0.011289, 0.031686],
    [0.010906, 0.034670],
    [0.010401, 0.034552],
    [0.010637, 0.040685],
    [0.010908, 0.054460],
    [0.011033, 0.080905],
    [0.011311, 0.146348],
    [0.011155, 0.379680],
    [0.010149, 0.766744],
    [0.008919, 0.876215],
    [0.007686, 0.918492],
    [0.006706, 0.940656],
    [0.005996, 0.953732],
    [0.005537, 0.961643],
    [0.005194, 0.967200],
    [0.005025, 0.970990],
    [0.005136, 0.972852],
    [0.005433, 0.973117],
    [0.005820, 0.973351],
    [0.006401, 0.973351],
    [0.007450, 0.972261],
    [0.008584, 0.973351],
    [0.010396, 0.973148],
    [0.013565, 0.971061],
    [0.019385, 0.966371],
    [0.032084, 0.954942],
    [0.074356, 0.913579],
    [0.624394, 0.364349],
    [0.918310, 0.071507],
    [0.949253, 0.041230],
    [0.958188, 0.032424],
    [0.958188, 0.031925],
    [0.958188, 0.031276],
    [0.955679, 0.032630],
    [0.958006, 0.029531],
    [0.954102, 0.031562],
    [0.947608, 0.035674],
    [0.938681, 0.041403],
    [0.924467, 0.050604],
    [0.904606, 0.063434],
    [0.880412, 0.078918],
    [0.847788, 0.099543],
    [0.805779, 0.125596],
    [0.752532, 0.157591],
    [0.686439, 0.195398],
    [0.618695, 0.231474],
    [0.540264, 0.268852],
    [0.472964, 0.296029],
    [0.432702, 0.309755],
    [0.405358, 0.317816],
    [0.385492, 0.322990],
    [0.370984, 0.326354],
    [0.357609, 0.329144],
    [0.348713, 0.330809],
    [0.344880, 0.331483],
    [0.341918, 0.331985],
    [0.339531, 0.332341],
    [0.337170, 0.332912],
    [0.336172, 0.332919],
    [0.335167, 0.333028],
    [0.334422, 0.333180],
    [0.334009, 0.333247],
    [0.333916, 0.333259],
    [0.333818, 0.333275],
    [0.333673, 0.333294],
    [0.333570, 0.333309],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colours_of_the_basis_are_the_primaries() {
        for (channel, spectrum) in BASIS.iter().enumerate() {
            let rgb = spectrum.to_rgb();
            for c in 0..3 {
                let wanted = f64::from(u8::from(c == channel));
                assert!((rgb[c] - wanted).abs() < 1e-6, "{channel}: {rgb:?}");
            }
        }
    }
}
