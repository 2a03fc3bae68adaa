//! Settings of the view: a command line of `petzval render`, whose options the page changes.

use std::path::Path;

use petzval_render::prepare::Changes;
use petzval_render::sensor::SensorSettings;
use petzval_scene_formats::pbrt::Description;
use serde_json::{Map, Value};

use crate::cli::Failure;
use crate::cli::arguments::argv::{accepted_words, is_faithful, parse_render, shell_line};

/// Longer side of the picture, unless the user gives a size: what a screen shows (pixels).
const SIDE: f64 = 1280.0;

/// Longest value of an option that the page sets (bytes).
const MAX_VALUE: usize = 1000;

/// Options that the page sets. None of them reads a file but `lens`, which the lens drawer checks, and `sensor`,
/// whose file is that of the command line.
const SETTABLE: [&str; 15] = [
    "assume-vd",
    "coating",
    "effects",
    "film-diagonal",
    "film-shift",
    "film-tilt",
    "focus",
    "fstop",
    "lens",
    "light-paths",
    "look-at",
    "resolution",
    "sensor",
    "shutter",
    "zoom",
];

/// The command line of a picture.
#[derive(Clone, Debug)]
pub(super) struct ViewSettings {
    /// The words up to the scene.
    words: Vec<String>,
    /// The options and their values; flags have none.
    options: Vec<(String, Option<String>)>,
    /// The sensor file of the command line.
    sensor_file: Option<String>,
}

impl ViewSettings {
    /// Returns the settings of the command line, in a size that fits a screen.
    pub fn new(argv: &[String], scene: &Path, description: &Description) -> Result<Self, Failure> {
        let faithful = is_faithful(argv);
        let words = accepted_words(argv, "render").filter(|_| faithful);
        let words = words.ok_or_else(|| {
            format!("{}: this command line is not UTF-8; rename the file", scene.display())
        })?;
        let is_option = |word: &String| word.starts_with("--");
        let (options, words): (Vec<String>, Vec<String>) = words.into_iter().partition(is_option);
        let split = |word: String| match word[2..].split_once('=') {
            Some((name, value)) => (name.to_owned(), Some(value.to_owned())),
            None => (word[2..].to_owned(), None),
        };
        let options = options.into_iter().map(split).collect();
        let mut settings = Self { words, options, sensor_file: None };
        let file = settings.value("sensor").and_then(SensorSettings::file_name);
        settings.sensor_file = file.map(str::to_owned);
        if settings.value("resolution").is_none() {
            let size = description.film.resolution.map(f64::from);
            let scale = (SIDE / size[0].max(size[1])).min(1.0);
            let [width, height] = size.map(|n| (n * scale).round().max(1.0));
            settings.put("resolution", Some(format!("{width}x{height}")));
        }
        Ok(settings)
    }

    /// Changes options as the page asks: a text is a value, `true` sets a flag, and `null` goes back
    /// to the scene's value. Changes nothing if one is refused.
    pub fn set(&mut self, changes: &Map<String, Value>) -> Result<(), String> {
        let mut changed = self.clone();
        for (name, value) in changes {
            if !SETTABLE.contains(&name.as_str()) {
                return Err(format!("--{name} cannot be changed while the camera is shown"));
            }
            match value {
                Value::Null | Value::Bool(false) => changed.remove(name),
                Value::Bool(true) => changed.put(name, None),
                Value::String(value) if value.len() <= MAX_VALUE => {
                    let value = match name.as_str() {
                        "sensor" => self.sensor(value)?,
                        _ => value.clone(),
                    };
                    changed.put(name, Some(value));
                }
                _ => return Err(format!("--{name}: expected a short text")),
            }
        }
        changed.changes()?;
        *self = changed;
        Ok(())
    }

    /// Returns the sensor that the page asks for, after the file of the command line.
    fn sensor(&self, asked: &str) -> Result<String, String> {
        let known = self.sensor_file.as_deref();
        match SensorSettings::file_name(asked) {
            Some(file) if known != Some(file) => {
                Err(format!("{file} is not the sensor file of the command line"))
            }
            Some(_) => Ok(asked.to_owned()),
            None => Ok(known.into_iter().chain([asked]).collect::<Vec<_>>().join(",")),
        }
    }

    /// Returns the value of an option that is given.
    pub fn value(&self, name: &str) -> Option<&str> {
        let found = self.options.iter().rev().find(|(option, _)| option == name);
        found.and_then(|(_, value)| value.as_deref())
    }

    /// Sets an option.
    pub fn put(&mut self, name: &str, value: Option<String>) {
        self.remove(name);
        self.options.push((name.to_owned(), value));
    }

    /// Returns whether these settings differ from others in the viewpoint alone, and nothing else
    /// depends on it.
    pub fn differs_in_view(&self, other: &Self) -> bool {
        let fixed = |settings: &Self| {
            let mut fixed = settings.clone();
            fixed.remove("look-at");
            fixed.options.sort();
            fixed.options
        };
        let by_pixel = self.value("focus").is_some_and(|focus| focus.starts_with("auto"));
        !by_pixel && fixed(self) == fixed(other)
    }

    fn remove(&mut self, name: &str) {
        self.options.retain(|(option, _)| option != name);
    }

    /// Returns the command line for another scene file, without the options that it replaces.
    pub fn of_scene(&self, scene: &Path, replaced: &[&str]) -> Vec<String> {
        let mut rest = self.clone();
        rest.options.retain(|(name, _)| !replaced.contains(&name.as_str()));
        if let Some(word) = rest.words.last_mut() {
            *word = scene.display().to_string();
        }
        rest.argv()
    }

    /// Returns the words of the command line.
    pub fn argv(&self) -> Vec<String> {
        let option = |(name, value): &(String, Option<String>)| match value {
            Some(value) => format!("--{name}={value}"),
            None => format!("--{name}"),
        };
        self.words.iter().cloned().chain(self.options.iter().map(option)).collect()
    }

    /// Returns the changes to the scene.
    ///
    /// # Errors
    /// Returns the message of the command if a value does not parse.
    pub fn changes(&self) -> Result<Changes, String> {
        let arguments = parse_render(&self.argv()).map_err(|failure| {
            let message = failure.to_string();
            let first = message.lines().find(|line| !line.is_empty()).unwrap_or_default();
            first.trim_start_matches("error: ").to_owned()
        })?;
        Ok(arguments.picture.changes())
    }

    /// Returns the command that renders the picture as it is seen.
    pub fn command(&self) -> String {
        shell_line(&self.argv())
    }

    /// Returns the options and their values, as the page reads and sets them.
    pub fn to_json(&self) -> Value {
        let value = |value: &Option<String>| match value {
            Some(text) => Value::String(text.clone()),
            None => Value::Bool(true),
        };
        self.options.iter().map(|(name, text)| (name.clone(), value(text))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_names_no_sensor_file_but_that_of_the_command_line() {
        let settings = |file: Option<&str>| ViewSettings {
            words: Vec::new(),
            options: Vec::new(),
            sensor_file: file.map(str::to_owned),
        };
        let (with, without) = (settings(Some("camera.toml")), settings(None));
        assert_eq!(with.sensor("iso=400").as_deref(), Ok("camera.toml,iso=400"));
        assert_eq!(with.sensor("camera.toml,iso=400").as_deref(), Ok("camera.toml,iso=400"));
        assert_eq!(without.sensor("iso=400").as_deref(), Ok("iso=400"));
        for settings in [with, without] {
            let refused = settings.sensor(" /etc/secret.toml,iso=9").expect_err("a file");
            assert!(refused.starts_with("/etc/secret.toml is not the sensor file"), "{refused}");
        }
    }
}
