//! Colours from parameters.

use super::params::{Params, Values};
use super::{Notices, SceneError};

impl Params {
    /// A colour, if one is given: linear RGB. Spectra are not supported yet: they count as
    /// their mean.
    pub(super) fn colour(
        &self,
        name: &str,
        notices: &mut Notices,
    ) -> Result<Option<[f32; 3]>, SceneError> {
        let Some(param) = self.find(name) else { return Ok(None) };
        let kind = param.kind.as_str();
        let what = format!("a spectrum for \"{name}\"");
        let colour = match (&param.values, kind) {
            (Values::Numbers(v), "rgb") if v.len() == 3 => [v[0], v[1], v[2]],
            (Values::Numbers(v), "float") if v.len() == 1 => [v[0]; 3],
            (Values::Numbers(v), "xyz") if v.len() == 3 => {
                // ITU-R BT.709 primaries, D65.
                [
                    3.240_97 * v[0] - 1.537_383_2 * v[1] - 0.498_610_8 * v[2],
                    -0.969_243_6 * v[0] + 1.875_967_5 * v[1] + 0.041_555 * v[2],
                    0.055_630_1 * v[0] - 0.203_977 * v[1] + 1.056_971_5 * v[2],
                ]
            }
            (Values::Numbers(v), "spectrum") if !v.is_empty() && v.len() % 2 == 0 => {
                notices.instead(&param.at, &what, "it counts as grey of its mean");
                let sum: f64 = v.as_chunks::<2>().0.iter().map(|[_, value]| value).sum();
                [sum / (v.len() / 2) as f64; 3]
            }
            (_, "spectrum" | "blackbody") => {
                notices.instead(&param.at, &what, "it counts as white");
                [1.0; 3]
            }
            _ => return Err(param.wrong(&["rgb", "xyz", "spectrum", "blackbody", "float"])),
        };
        if colour.iter().any(|&c| c < 0.0) && kind != "xyz" {
            let found = format!("a colour below 0 for \"{name}\"");
            return Err(self.refuse(name, found, "expected 0 or more"));
        }
        Ok(Some(colour.map(|c| c as f32)))
    }

    /// The `scale` of a light, by channel: pbrt-v4 gives a number, pbrt-v2 a colour.
    pub(super) fn scale(&self, notices: &mut Notices) -> Result<[f32; 3], SceneError> {
        Ok(self.colour("scale", notices)?.unwrap_or([1.0; 3]))
    }
}
