//! Shutter parameters of a camera. pbrt has the times at which the shutter opens and closes; the
//! parameters of its curtains and of the rolling read-out are extensions.

use super::params::Params;
use super::{Dialect, SceneError};
use petzval_scene::shutter::{Curtain, RollingShutter, Shutter};

/// Exposure time of a shutter that closes when it opens (s), which pbrt reads before v4 as a still
/// picture: nothing moves visibly in it, and times of 1e6 s still differ by it.
const STILL: f64 = 1e-9;

/// Reads the shutter of a camera.
pub(super) fn shutter(params: &Params, dialect: Dialect) -> Result<Shutter, SceneError> {
    let [open, mut close] = [params.float("shutteropen", 0.0)?, params.float("shutterclose", 1.0)?];
    if open == close && dialect.is_older() {
        close += STILL.max(open.abs() * STILL);
    }
    if open > close {
        let found = format!("a shutter that opens at {open} and closes at {close}");
        return Err(params.refuse(
            "shutterclose",
            found,
            "expected shutterclose after shutteropen",
        ));
    }
    let curtain = match (curve(params)?, ramps(params)?) {
        (Some(_), Some(_)) => {
            let found = "both \"shuttercurve\" and \"shutterramp\"";
            return Err(params.refuse("shuttercurve", found, "give only one of them"));
        }
        (Some(curtain), None) | (None, Some(curtain)) => curtain,
        (None, None) => Curtain::Ideal,
    };
    let name = if params.find("shuttercurve").is_some() { "shuttercurve" } else { "shutterramp" };
    let shutter = Shutter { open, close, curtain, rolling: rolling(params)? };
    match shutter.curve() {
        Ok(_) => Ok(shutter),
        Err(problem) => Err(params.refuse(name, problem, "")),
    }
}

fn curve(params: &Params) -> Result<Option<Curtain>, SceneError> {
    let fractions = params.numbers("shuttercurve", &["float", "integer"])?;
    match fractions {
        Some([_]) => Err(params.wrong_count("shuttercurve", 1, "two fractions or more")),
        fractions => Ok(fractions.map(|fractions| Curtain::Table(fractions.to_vec()))),
    }
}

fn ramps(params: &Params) -> Result<Option<Curtain>, SceneError> {
    let (opening, closing) = match params.numbers("shutterramp", &["float", "integer"])? {
        None => return Ok(None),
        Some(&[both]) => (both, both),
        Some(&[opening, closing]) => (opening, closing),
        Some(many) => {
            let expected = "one time, or two: for opening and for closing";
            return Err(params.wrong_count("shutterramp", many.len(), expected));
        }
    };
    if opening < 0.0 || closing < 0.0 {
        let found = format!("\"shutterramp\" is {opening} {closing}");
        return Err(params.refuse("shutterramp", found, "expected 0 s or more"));
    }
    Ok(Some(Curtain::Ramps { opening, closing }))
}

fn rolling(params: &Params) -> Result<Option<RollingShutter>, SceneError> {
    let time = params.float("rollingshutter", 0.0)?;
    if time < 0.0 {
        let found = format!("\"rollingshutter\" is {time}");
        return Err(params.refuse("rollingshutter", found, "expected 0 s or more"));
    }
    let direction = params.text("rollingdirection")?.unwrap_or("down");
    let direction = direction
        .parse()
        .map_err(|problem: String| params.refuse("rollingdirection", problem, ""))?;
    Ok((time > 0.0).then_some(RollingShutter { time, direction }))
}
