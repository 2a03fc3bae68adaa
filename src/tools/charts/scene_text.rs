//! Charts as scenes in the language of pbrt-v4.

use std::fmt::Write as _;
use std::path::Path;

use petzval_spectrum::{Spectrum, colour_checker};

use super::patch::{Patch, PatchShape, Reflectance};
use super::view::{ChartError, ChartView};
use super::{Chart, ChartKind};

/// f-number that is lit for where a lens has none.
const USUAL_F_NUMBER: f64 = 4.0;
/// Value that pictures show for white in their middle.
const WHITE: f64 = 0.9;
/// Distance between a patch and the one before it, relative to that of the chart.
const LAYER: f64 = 1e-6;

/// The camera in front of a chart, as the scene describes it.
#[derive(Clone, Copy, Debug)]
pub struct ChartCamera<'a> {
    /// The lens file.
    pub lens: &'a Path,
    /// Diameter of its stop (mm).
    pub stop_diameter: f64,
    /// Its f-number at infinity, if it has one.
    pub f_number: Option<f64>,
}

impl Chart {
    /// Returns the scene. `command` is the one that made it, and `texture` the name of the picture of leaves or star
    /// beside it. The world is in metres, and the film stands at the origin.
    ///
    /// # Errors
    /// Returns an error if the middle of the picture shows no point of the chart.
    pub fn scene(
        &self,
        view: &ChartView<'_>,
        camera: &ChartCamera<'_>,
        command: &str,
        texture: &str,
    ) -> Result<String, ChartError> {
        let [width, height] = view.resolution();
        let magnification = view.magnification()?;
        let diagonal = view.film_diagonal();
        // A white surface in the irradiance E has the radiance E / pi, and lights the film with a quarter of E over the
        // square of the working f-number.
        let f_number = camera.f_number.unwrap_or(USUAL_F_NUMBER) * (1.0 + magnification);
        let light = 4.0 * WHITE * f_number * f_number;
        let distance = view.distance() * 1e-3;
        let name = match self.kind {
            ChartKind::Edges => "Slanted edges",
            ChartKind::Grid => "Grid of dots",
            ChartKind::Flat => "White",
            ChartKind::Leaves => "Dead leaves",
            ChartKind::Colours => "Colour checker",
            ChartKind::Star => "Siemens star",
            ChartKind::Greys => "Steps of grey",
        };
        let command: String =
            command.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let mut text = format!(
            "# {name}, in the plane in focus. Made by:\n#   {command}\n\n\
             Film \"rgb\" \"integer xresolution\" {width} \"integer yresolution\" {height} \"float diagonal\" {diagonal:.9}\n\
             PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5\n\
             Sampler \"zsobol\" \"integer pixelsamples\" 256\n\
             Integrator \"path\" \"integer maxdepth\" 1\n\
             Camera \"realistic\" \"string lensfile\" \"{}\"\n    \
             \"float aperturediameter\" {} \"float focusdistance\" {distance:.9}\n\n\
             WorldBegin\n\
             LightSource \"distant\" \"point3 from\" [0 0 0] \"point3 to\" [0 0 1] \"rgb L\" [{light:.6} {light:.6} {light:.6}]\n",
            quoted(&camera.lens.display().to_string()),
            camera.stop_diameter,
        );
        let mut reflectance = None;
        for (i, patch) in self.patches.iter().enumerate() {
            if reflectance != Some(patch.reflectance) {
                reflectance = Some(patch.reflectance);
                write_material(&mut text, patch.reflectance);
            }
            // Dots do not overlap, and squares neither: all lie on the background.
            let z = distance * (1.0 - LAYER * f64::from(u8::from(i > 0)));
            write_patch(&mut text, patch, z);
        }
        if let (Some(region), Some(_)) = (self.region, &self.texture) {
            let corners = view.corners(region.map(|at| at.map(|n| f64::from(n) - 0.5)))?;
            let _ = writeln!(
                text,
                "\nTexture \"chart\" \"spectrum\" \"imagemap\" \"string filename\" \"{}\" \"string filter\" \"point\"\n\
                 Material \"diffuse\" \"texture reflectance\" \"chart\"\n\
                 {} \"point2 uv\" [0 0 1 0 1 1 0 1]",
                quoted(texture),
                quad(&corners, distance * (1.0 - LAYER))
            );
        }
        Ok(text)
    }
}

/// Returns a text as that of a string of the scene.
fn quoted(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"")
}

/// Returns the shape of a quadrilateral.
fn quad(corners: &[[f64; 2]; 4], z: f64) -> String {
    let points: Vec<String> =
        corners.iter().map(|[x, y]| format!("{:.9} {:.9} {z:.9}", x * 1e-3, y * 1e-3)).collect();
    format!(
        "Shape \"trianglemesh\" \"point3 P\" [{}] \"integer indices\" [0 1 2 0 2 3]",
        points.join("  ")
    )
}

fn write_material(text: &mut String, reflectance: Reflectance) {
    let _ = match reflectance {
        Reflectance::Grey(grey) => {
            writeln!(text, "\nMaterial \"diffuse\" \"rgb reflectance\" [{grey} {grey} {grey}]")
        }
        Reflectance::OfChecker(patch) => {
            let Some((name, Spectrum::Samples(samples))) = colour_checker().nth(patch) else {
                unreachable!("the chart has 24 patches of samples")
            };
            let samples = samples.iter().map(|[nm, value]| format!("{nm} {value:.3}"));
            let samples = samples.collect::<Vec<_>>().join(" ");
            writeln!(text, "\n# {name}\nMaterial \"diffuse\" \"spectrum reflectance\" [{samples}]")
        }
    };
}

fn write_patch(text: &mut String, patch: &Patch, z: f64) {
    let _ = match &patch.shape {
        PatchShape::Quad(corners) => writeln!(text, "{}", quad(corners, z)),
        PatchShape::Disk { centre: [x, y], radius } => writeln!(
            text,
            "AttributeBegin Translate {:.9} {:.9} {z:.9} Shape \"disk\" \"float radius\" {:.9} AttributeEnd",
            x * 1e-3,
            y * 1e-3,
            radius * 1e-3
        ),
    };
}
