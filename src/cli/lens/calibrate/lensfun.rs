//! Calibration as a lens of lensfun's database.

use petzval_optics::{Calibration, ChannelFields, Falloff, LateralColour, RadialDistortion};

use super::Report;

/// Diagonal of the film that crop factors refer to (mm).
const FULL_FRAME: f64 = 43.266_615_305_567_87;
/// Distance that stands for infinity (m).
const FAR: f64 = 1000.0;

/// The polynomials of photographers' programs.
pub(super) struct Photographic {
    /// Distortion by model, the most exact first.
    pub distortions: Vec<RadialDistortion>,
    /// Lateral colour of red and blue.
    pub colour: Option<[LateralColour; 2]>,
    pub falloff: Option<Falloff>,
}

impl Photographic {
    pub fn new(calibration: &Calibration, channels: Option<&ChannelFields>) -> Self {
        let mut distortions = calibration.radial_distortions();
        distortions.sort_by(|a, b| a.error.total_cmp(&b.error));
        Self {
            distortions,
            colour: channels.and_then(|channels| calibration.lateral_colour(channels)),
            falloff: calibration.falloff(),
        }
    }
}

/// Returns the lens; `None` if it is not rotationally symmetric about the middle of the picture.
pub(super) fn text(report: &Report, photographic: &Photographic) -> Option<String> {
    let Photographic { distortions, colour, falloff } = photographic;
    let best = distortions.first()?;
    let pixels = report.calibration.pixels;
    let nominal = nominal_focal(best);
    let focal = format!("focal=\"{nominal:.4}\"");
    let mut calibration = String::new();
    for distortion in distortions.iter().skip(1) {
        let line = element(distortion, &focal);
        calibration +=
            &format!("            <!-- {line} largest error {:.3} pixels -->\n", distortion.error);
    }
    calibration += &format!("            {}\n", element(best, &focal));
    if let Some([red, blue]) = colour {
        let [[vr, cr, br], [vb, cb, bb]] = [red.terms, blue.terms];
        calibration += &format!(
            "            <tca model=\"poly3\" {focal} br=\"{br:.8}\" cr=\"{cr:.8}\" vr=\"{vr:.8}\" \
             bb=\"{bb:.8}\" cb=\"{cb:.8}\" vb=\"{vb:.8}\"/>\n"
        );
    }
    if let (Some(Falloff { terms: [k1, k2, k3], .. }), Some(f_number)) = (falloff, report.f_number)
    {
        let focus = report.calibration.focus * 1e-3;
        let distance = if focus.is_finite() { focus } else { FAR };
        calibration += &format!(
            "            <vignetting model=\"pa\" {focal} aperture=\"{f_number:.2}\" \
             distance=\"{distance:.3}\" k1=\"{k1:.8}\" k2=\"{k2:.8}\" k3=\"{k3:.8}\"/>\n"
        );
    }
    let [width, height] = pixels.film_size();
    let kind = if report.calibration.is_fisheye() { "fisheye" } else { "rectilinear" };
    Some(format!(
        "<!DOCTYPE lensdatabase SYSTEM \"lensfun-database.dtd\">\n\
         <!-- {} -->\n\
         <lensdatabase version=\"1\">\n\
         \x20   <lens>\n\
         \x20       <maker>petzval</maker>\n\
         \x20       <model>{}</model>\n\
         \x20       <mount>Generic</mount>\n\
         \x20       <focal value=\"{nominal:.4}\"/>\n\
         \x20       <type>{kind}</type>\n\
         \x20       <cropfactor>{:.6}</cropfactor>\n\
         \x20       <aspect-ratio>{:.6}</aspect-ratio>\n\
         \x20       <calibration>\n{calibration}\
         \x20       </calibration>\n\
         \x20   </lens>\n\
         </lensdatabase>\n",
        // A comment holds no two hyphens.
        escaped(&report.headline()).replace("--", "- -"),
        escaped(&report.setup.lens.name),
        FULL_FRAME / width.hypot(height),
        width.max(height) / width.min(height),
    ))
}

/// Returns the focal length (mm) from which lensfun derives the one near the axis.
fn nominal_focal(distortion: &RadialDistortion) -> f64 {
    let terms: f64 = distortion.terms.iter().map(|(_, value)| value).sum();
    match distortion.model {
        "poly5" => distortion.real_focal,
        _ => distortion.real_focal / (1.0 - terms),
    }
}

fn element(distortion: &RadialDistortion, focal: &str) -> String {
    let terms: Vec<String> =
        distortion.terms.iter().map(|(name, value)| format!("{name}=\"{value:.8}\"")).collect();
    format!("<distortion model=\"{}\" {focal} {}/>", distortion.model, terms.join(" "))
}

/// Escapes the characters that XML reserves, and drops control characters.
fn escaped(text: &str) -> String {
    let one = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        c if c.is_control() => " ".to_owned(),
        c => c.to_string(),
    };
    text.chars().map(one).collect()
}
