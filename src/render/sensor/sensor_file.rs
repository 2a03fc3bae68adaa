//! Sensor files: the settings of a sensor in TOML.
//!
//! ```toml
//! name = "Example"
//! source = "data sheet of 2026"
//! pixel = 3.45               # um
//! well = 10500
//! read = [2.3, 0.2, 0.1]     # of photosites, rows and columns
//! bayer = "rggb"
//! ```

use std::path::Path;

use super::SensorSettings;
use super::settings_text::{NAMES, check_names};
use petzval_base::io::{Location, ReadContext, excerpt, hint};
use toml::de::{DeTable, DeValue};

/// Keys that describe a sensor and set nothing.
const NOTES: [&str; 2] = ["name", "source"];

/// Reads the settings of a file.
///
/// # Errors
/// Returns an error with file, line and column if the file cannot be read, or a key or a value is wrong.
pub(super) fn read(path: &Path) -> Result<SensorSettings, String> {
    let bytes = ReadContext::default().bytes(path).map_err(|error| error.to_string())?;
    let text = String::from_utf8(bytes)
        .map_err(|_| format!("{}: expected text in UTF-8", path.display()))?;
    let at = |offset: usize, problem: String| {
        format!("{}: {problem}", Location::in_text(path, &text, offset))
    };
    let table = DeTable::parse(&text).map_err(|error| {
        let found = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        let offset = error.span().map_or(0, |span| span.start);
        at(offset, format!("{found}; expected TOML: key = value, one a line"))
    })?;
    let mut entries: Vec<_> = table.get_ref().iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let mut settings = SensorSettings::default();
    for (key, value) in &entries {
        let (name, offset) = (key.get_ref().as_ref(), key.span().start);
        if NOTES.contains(&name) {
            continue;
        }
        if !NAMES.contains(&name) {
            let (found, near) = (excerpt(name), hint(name, NAMES.into_iter().chain(NOTES)));
            let known = [&NOTES[..], &NAMES[..]].concat().join(", ");
            return Err(at(offset, format!("unknown key \"{found}\"{near}; known are {known}")));
        }
        let offset = value.span().start;
        let words = words(value.get_ref()).ok_or_else(|| {
            let kind = value.get_ref().type_str();
            at(offset, format!("{name}: expected a number, a text or a list of them, found {kind}"))
        })?;
        settings.set(name, &words).map_err(|problem| at(offset, problem))?;
    }
    let names: Vec<&str> = entries.iter().map(|(key, _)| key.get_ref().as_ref()).collect();
    check_names(&names).map_err(|problem| format!("{}: {problem}", path.display()))?;
    settings.check().map_err(|(name, problem)| {
        let value = entries.iter().find(|(key, _)| key.get_ref() == name);
        at(value.map_or(0, |(_, value)| value.span().start), problem)
    })?;
    Ok(settings)
}

/// Returns a value as the text of a setting, lists with slashes; `None` if it is none.
fn words(value: &DeValue) -> Option<String> {
    match value {
        DeValue::Array(values) => {
            let words = values.iter().map(|value| word(value.get_ref()));
            words.collect::<Option<Vec<_>>>().map(|words| words.join("/"))
        }
        value => word(value),
    }
}

fn word(value: &DeValue) -> Option<String> {
    match value {
        DeValue::Integer(number) if number.radix() == 10 => Some(number.as_str().to_owned()),
        DeValue::Float(number) => Some(number.as_str().to_owned()),
        DeValue::String(text) => Some(text.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(text: &str, file: &str) -> Result<SensorSettings, String> {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("camera.toml"), file).expect("a file");
        SensorSettings::parse_in(folder.path(), text)
    }

    const FILE: &str = "name = \"Example\"
source = \"a data sheet\"
pixel = 3.45
well = 10_500
read = [2.3, 0.2, 0.1]
dark = \"20@25/7\"
temperature = 32
hot = [1e-4, 500]
prnu = 0.7
bits = 12
black = 64
bayer = \"gbrg\"
";

    #[test]
    fn a_file_sets_what_words_behind_it_replace() {
        let same = "pixel=3.45,well=10500,read=2.3/0.2/0.1,dark=20@25/7,temperature=32,hot=0.0001/500,\
                    prnu=0.7,bits=12,black=64,bayer=gbrg";
        assert_eq!(settings("camera.toml", FILE), same.parse());
        let both = settings("camera.toml,iso=800,well=6000", FILE).expect("a sensor");
        let expected =
            SensorSettings { iso: Some(800.0), well: Some(6000.0), ..same.parse().expect("") };
        assert_eq!(both, expected);
        // A speed replaces the gain of a file.
        let speed = settings("camera.toml,iso=200", "gain = 2").expect("a sensor");
        assert_eq!((speed.iso, speed.gain), (Some(200.0), None));
    }

    #[test]
    fn faults_are_named_with_their_place() {
        for (file, expected) in [
            (
                "pixel = 3.45\nwel = 5",
                "camera.toml:2:1: unknown key \"wel\"; did you mean \"well\"?; known are name, source, iso, gain",
            ),
            (
                "pixel = 3.45\n  well = -5",
                "camera.toml:2:10: well: expected electrons from 1 to 1000000000000, found \"-5\"",
            ),
            ("read = [1, 2]", "camera.toml:1:8: read: expected electrons from 0"),
            (
                "bits = true",
                "camera.toml:1:8: bits: expected a number, a text or a list of them, found boolean",
            ),
            (
                "bayer = \"rgb\"",
                "camera.toml:1:9: bayer: expected rggb, bggr, grbg or gbrg, or quad- before them, found \"rgb\"",
            ),
            ("bits = 8\nblack = 300", "camera.toml:2:9: black=300: expected less than 255"),
            (
                "temperature = 30",
                "camera.toml:1:15: temperature=30: expected dark=CURRENT@CELSIUS/KELVIN",
            ),
            ("iso = 200\ngain = 1", "camera.toml: iso and gain are both given"),
            ("bits = 0x10", "camera.toml:1:8: bits: expected a number"),
            ("read = [[1, 2], 3]", "camera.toml:1:8: read: expected a number, a text or a list"),
            ("bits = ", "camera.toml:1:"),
            ("[pixel]", "camera.toml:1:"),
        ] {
            let found = settings("camera.toml", file).expect_err(file);
            assert!(found.contains(expected), "{file}: {found}");
        }
        let found = settings("other.toml", FILE).expect_err("no file");
        assert!(found.contains("other.toml"), "{found}");
        let mixed = settings("camera.toml,dark=5", FILE).expect_err("no reference");
        assert!(mixed.starts_with("camera.toml: temperature=32"), "{mixed}");
        let late = settings("iso=100,camera.toml", FILE).expect_err("the order");
        assert!(late.contains("or a file NAME.toml before them, found \"camera.toml\""), "{late}");
    }
}
