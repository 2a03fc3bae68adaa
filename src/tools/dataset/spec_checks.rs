//! Checks of the values of a specification.

use std::fmt::Display;
use std::path::PathBuf;

use super::spec::CleanCamera;
use super::spec::{
    CleanSpec, DatasetSpec, DrawSpec, DrawnFrom, FocusValue, Range, Reach, RigPlace,
};
use petzval_base::io::path_excerpt;
use petzval_render::plan::EffectSelection;
use petzval_render::prepare::settings::{self, SettingError, SettingValue};

/// Most pairs of a data set.
const MAX_PAIRS: u32 = 10_000_000;

impl DatasetSpec {
    /// Checks all values.
    pub(super) fn check(&self) -> Result<(), String> {
        numbers("pairs", &[self.pairs], [1, MAX_PAIRS])?;
        let whole = |n: u32| SettingValue::Whole(n.into());
        setting("spp", self.spp, settings::samples, &whole(self.spp))?;
        let [width, height] = self.resolution;
        let size = SettingValue::List(vec![whole(width), whole(height)]);
        setting("resolution", format!("[{width}, {height}]"), settings::resolution, &size)?;
        numbers("exposure", &[self.exposure], [-64.0, 64.0])?;
        let DrawSpec { scene, lens, focus, fstop, light, shift, turn, .. } = &self.draw;
        files("scene", scene)?;
        lens.iter().try_for_each(|lens| files("lens", lens))?;
        let f_number = |n| setting("draw.fstop", n, settings::f_number, &SettingValue::Number(n));
        fstop.iter().try_for_each(|fstop| drawn_numbers("fstop", fstop, f_number))?;
        let stops = |stops| numbers("draw.light", &[stops], [-30.0, 16.0]);
        light.iter().try_for_each(|light| drawn_numbers("light", light, stops))?;
        for (name, reach, most) in [("move", shift, 1e9), ("turn", turn, 180.0)] {
            let reach = reach.map_or([0.0; 3], Reach::axes);
            numbers(name, &reach, [0.0, most])?;
        }
        self.check_cameras()?;
        if light.is_some() && self.degraded.sensor.is_none() {
            let hint = "the light changes the noise of a sensor: add sensor = \"\" to [degraded]";
            return Err(format!("draw.light: {hint}"));
        }
        let mosaic = self.degraded.sensor.and_then(|sensor| sensor.bayer);
        if self.degraded.develop.is_some() && mosaic.is_none_or(|bayer| bayer.is_quad()) {
            let hint = "a picture is developed from a mosaic without a quad pattern: add bayer=rggb to 'sensor'";
            return Err(format!("degraded.develop: {hint}"));
        }
        let CleanSpec { camera, effects } = &self.clean;
        let none = EffectSelection::None;
        if *camera == CleanCamera::Pinhole && effects.as_ref().is_some_and(|e| *e != none) {
            let hint =
                "a pinhole has no effects; expected \"none\", or camera = \"deep\" or \"lens\"";
            return Err(format!("clean.effects: {hint}"));
        }
        let metres = |metres| focus_value(&FocusValue::Metres(metres));
        match focus {
            None => Ok(()),
            Some(DrawnFrom::Range(range)) => drawn_range("focus", range, metres),
            Some(DrawnFrom::List(list)) if list.is_empty() => {
                Err("draw.focus has no values".into())
            }
            Some(DrawnFrom::List(list)) => list.iter().try_for_each(focus_value),
            Some(DrawnFrom::One(value)) => focus_value(value),
        }
    }
}

impl DatasetSpec {
    /// Checks the rig and the trajectory of the camera.
    fn check_cameras(&self) -> Result<(), String> {
        let DrawSpec { rig, trajectory, .. } = &self.draw;
        for RigPlace { shift, turn } in rig {
            numbers("rig", shift, [-1e9, 1e9])?;
            numbers("rig", turn, [-180.0, 180.0])?;
        }
        let cameras = rig.len().max(1) as u32;
        if !self.pairs.is_multiple_of(cameras) {
            return Err(format!(
                "pairs = {}: expected a multiple of the {cameras} cameras of draw.rig",
                self.pairs
            ));
        }
        let views = self.pairs / cameras;
        match trajectory {
            Some(trajectory) if trajectory.len() < views as usize => {
                let (name, poses) = (path_excerpt(&trajectory.path), trajectory.len());
                Err(format!(
                    "draw.trajectory: {name} has {poses} poses for {views} views; reduce 'pairs'"
                ))
            }
            _ => Ok(()),
        }
    }
}

/// Checks a value of a setting, which has its range everywhere.
fn setting<T>(
    name: &str,
    found: impl Display,
    read: fn(&SettingValue) -> Result<T, SettingError>,
    value: &SettingValue,
) -> Result<(), String> {
    read(value).map(|_| ()).map_err(|expected| format!("{name} = {found}: {expected}"))
}

fn focus_value(value: &FocusValue) -> Result<(), String> {
    match value {
        FocusValue::Metres(metres) => {
            setting("draw.focus", metres, settings::focus, &SettingValue::Number(*metres))
        }
        FocusValue::Word(word) if word == "auto" => Ok(()),
        FocusValue::Word(word) => {
            Err(format!("draw.focus: found \"{word}\"; expected a distance in m, inf, or \"auto\""))
        }
    }
}

fn numbers<T: Copy + PartialOrd + Display>(
    name: &str,
    values: &[T],
    [low, high]: [T; 2],
) -> Result<(), String> {
    match values.iter().find(|value| !(low..=high).contains(*value)) {
        None => Ok(()),
        Some(value) => Err(format!("{name} = {value}: expected {low} to {high}")),
    }
}

fn drawn_range(
    name: &str,
    range: &Range,
    check: impl Fn(f64) -> Result<(), String>,
) -> Result<(), String> {
    [range.from, range.to].into_iter().try_for_each(check)?;
    if range.from > range.to || range.to.is_infinite() || range.log && range.from <= 0.0 {
        let Range { from, to, .. } = range;
        let above = if range.log { ", both above 0 for a logarithmic range" } else { "" };
        let expected = format!("expected from <= to, both finite{above}");
        return Err(format!("draw.{name}: from = {from}, to = {to}: {expected}"));
    }
    Ok(())
}

fn drawn_numbers(
    name: &str,
    values: &DrawnFrom<f64>,
    check: impl Fn(f64) -> Result<(), String>,
) -> Result<(), String> {
    match values {
        DrawnFrom::Range(range) => drawn_range(name, range, check),
        DrawnFrom::List(list) if list.is_empty() => Err(format!("draw.{name} has no values")),
        DrawnFrom::List(list) => list.iter().copied().try_for_each(check),
        DrawnFrom::One(value) => check(*value),
    }
}

fn files(name: &str, values: &DrawnFrom<PathBuf>) -> Result<(), String> {
    match values {
        DrawnFrom::Range(_) => Err(format!("draw.{name}: expected the name of a file, or a list")),
        DrawnFrom::List(list) if list.is_empty() => Err(format!("draw.{name} has no values")),
        _ => Ok(()),
    }
}
