//! Parser of shutter settings such as `open=0.1,time=1/60,ramp=2ms`.

use std::str::FromStr;

use super::duration::parse_seconds;
use super::{Curtain, Shutter};

/// Requested changes to a scene's shutter; `None` keeps the scene's value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShutterSettings {
    /// When the shutter opens, s.
    pub open: Option<f64>,
    /// When the shutter has closed, s.
    pub close: Option<f64>,
    /// Exposure time, s; sets `close` relative to `open`.
    pub time: Option<f64>,
    /// How it opens and closes.
    pub curtain: Option<Curtain>,
}

impl ShutterSettings {
    /// Returns a scene's shutter with the requested changes.
    ///
    /// # Errors
    /// Returns an error if it would close before it opens, or take longer to open and close than it
    /// is open.
    pub fn apply_to(&self, shutter: &Shutter) -> Result<Shutter, String> {
        let mut shutter = shutter.clone();
        shutter.open = self.open.unwrap_or(shutter.open);
        shutter.close = self.close.unwrap_or(shutter.close);
        if let Some(time) = self.time {
            shutter.close = shutter.open + time;
        }
        if let Some(curtain) = &self.curtain {
            shutter.curtain = curtain.clone();
        }
        if *self != Self::default() && shutter.time() <= 0.0 {
            return Err(format!(
                "the shutter opens at {} s and closes at {} s; expected it to close later",
                shutter.open, shutter.close
            ));
        }
        shutter.curve()?;
        Ok(shutter)
    }
}

const EXPECTED: &str =
    "expected NAME=VALUE with open, close, time, ramp, opening, closing or curve";

impl FromStr for ShutterSettings {
    type Err = String;

    /// Parses `name=value,name=value`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut settings = Self::default();
        let mut seen = Vec::new();
        let (mut opening, mut closing, mut table) = (None, None, None);
        for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
            let (name, value) = word.split_once('=').unwrap_or((word, ""));
            let (name, value) = (name.trim(), value.trim());
            let time = || parse_seconds(value).map_err(|why| format!("{name}: {why}"));
            let later = || match time()? {
                time if time >= 0.0 => Ok(time),
                time => Err(format!("{name}: expected 0 s or more, found {time} s")),
            };
            match name {
                "open" => settings.open = Some(time()?),
                "close" => settings.close = Some(time()?),
                "time" => settings.time = Some(later()?),
                "ramp" => (opening, closing) = (Some(later()?), Some(later()?)),
                "opening" => opening = Some(later()?),
                "closing" => closing = Some(later()?),
                "curve" => table = Some(shares(value)?),
                _ => {
                    return Err(format!("{EXPECTED}, found {word:?}"));
                }
            }
            if seen.contains(&name) {
                return Err(format!("{name} is given twice"));
            }
            seen.push(name);
        }
        if seen.is_empty() {
            return Err(format!("{EXPECTED}, such as time=1/60, found nothing"));
        }
        let with = |name: &str, others: &[&str]| {
            seen.contains(&name) && others.iter().any(|other| seen.contains(other))
        };
        for (name, others) in [
            ("time", &["close"][..]),
            ("ramp", &["opening", "closing"]),
            ("curve", &["ramp", "opening", "closing"]),
        ] {
            if with(name, others) {
                return Err(format!("{name} excludes {}; leave one out", others.join(", ")));
            }
        }
        settings.curtain = match (table, opening, closing) {
            (Some(table), ..) => Some(Curtain::Table(table)),
            (None, None, None) => None,
            (None, opening, closing) => Some(Curtain::Ramps {
                opening: opening.unwrap_or(0.0),
                closing: closing.unwrap_or(0.0),
            }),
        };
        Ok(settings)
    }
}

fn shares(text: &str) -> Result<Vec<f64>, String> {
    let share = |word: &str| word.trim().parse().ok().filter(|v| (0.0..=1.0).contains(v));
    let shares: Option<Vec<f64>> = text.split('/').map(share).collect();
    shares.filter(|shares| shares.len() >= 2).ok_or_else(|| {
        format!("curve: expected two or more shares from 0 to 1, such as 0/1/1/0, found {text:?}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(text: &str) -> Result<Shutter, String> {
        text.parse::<ShutterSettings>()?.apply_to(&Shutter { close: 0.5, ..Shutter::default() })
    }

    #[test]
    fn omitted_settings_keep_the_values_of_the_scene() {
        let scene = Shutter { close: 0.5, ..Shutter::default() };
        assert_eq!(ShutterSettings::default().apply_to(&scene), Ok(scene));
        assert_eq!(changed("open=0.25").map(|s| [s.open, s.close]), Ok([0.25, 0.5]));
        let said = changed("open=1,time=1/50,ramp=5ms").unwrap();
        assert_eq!([said.open, said.close], [1.0, 1.02]);
        assert_eq!(said.curtain, Curtain::Ramps { opening: 0.005, closing: 0.005 });
        assert!((said.curve().unwrap().efficiency() - 0.75).abs() < 1e-12);
        let one = changed("closing=100ms").unwrap();
        assert_eq!(one.curtain, Curtain::Ramps { opening: 0.0, closing: 0.1 });
        assert_eq!(changed("curve=0/1/0").unwrap().curtain, Curtain::Table(vec![0.0, 1.0, 0.0]));
    }

    #[test]
    fn invalid_settings_are_refused_with_a_reason() {
        for (text, expected) in [
            ("", "such as time=1/60, found nothing"),
            (" ,", "such as time=1/60, found nothing"),
            ("scene.pbrt", "expected NAME=VALUE with open, close, time, ramp"),
            ("open", "open: expected a time such as 20ms"),
            ("time=-1", "time: expected 0 s or more"),
            ("close=-1", "opens at 0 s and closes at -1 s; expected it to close later"),
            ("time=0", "expected it to close later"),
            ("ramp=0.3", "expected 0.5 s together at most"),
            ("open=0,open=1", "open is given twice"),
            ("time=1,close=2", "time excludes close"),
            ("curve=0/1/0,ramp=1ms", "leave one out"),
            ("curve=1", "two or more shares"),
            ("curve=0/2/0", "shares from 0 to 1"),
            ("curve=0/0", "lets no light through"),
        ] {
            let said = changed(text).expect_err(text);
            assert!(said.contains(expected), "{text}: {said}");
        }
    }
}
