//! Widest stop of the lens on the camera.

use std::path::PathBuf;

use petzval_base::io::ReadContext;
use petzval_lens::{RealRayFocus, Zoom};
use petzval_render::prepare::Changes;
use petzval_scene_formats::pbrt::{CameraSpec, Description, RealisticSpec};

/// A lens file and its zoom setting.
type Mounted = (PathBuf, Option<Zoom>);

/// The widest f-number of the lens, measured once for each lens and zoom setting.
#[derive(Debug)]
pub(super) struct WidestStop {
    context: ReadContext,
    /// The lens file of the scene.
    own: Option<PathBuf>,
    last: Option<(Mounted, Option<f64>)>,
}

impl WidestStop {
    pub fn new(description: &Description) -> Self {
        let own = match &description.camera {
            CameraSpec::Realistic(
                RealisticSpec::V4 { lens, .. } | RealisticSpec::V2 { lens, .. },
            ) => Some(lens.clone()),
            _ => None,
        };
        Self { context: description.context.temporary(), own, last: None }
    }

    /// Returns the widest f-number, by the marginal ray, as `--fstop` counts it. `None` without a lens
    /// file, or if the lens forms no image.
    pub fn f_number(&mut self, changes: &Changes) -> Option<f64> {
        let file = changes.lens.clone().or_else(|| self.own.clone())?;
        let mounted = (file, changes.lens_options.zoom.clone());
        if let Some((_, f_number)) = self.last.as_ref().filter(|(last, _)| *last == mounted) {
            return *f_number;
        }
        let lens = changes.lens_options.read(&mounted.0, &self.context).ok();
        let f_number = lens.and_then(|lens| RealRayFocus::new(&lens).f_number());
        self.last = Some((mounted, f_number));
        f_number
    }
}
