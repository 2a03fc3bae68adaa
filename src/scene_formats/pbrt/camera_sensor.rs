//! The film's parameter "sensor": the name of a measured camera, or a file of its responses.

use super::params::Params;
use super::{SceneError, resolve};
use petzval_base::io::{ReadError, hint, path_excerpt};
use petzval_spectrum::{CameraSensor, VISIBLE};

/// pbrt-v4's name of the sensor that sees X, Y and Z.
const IDEAL_SENSOR: &str = "cie1931";

/// Limit of the size of a table (bytes).
const MAX_FILE_SIZE: usize = 1 << 24;

const EXPECTED_ROWS: &str = "expected at least two rows of a wavelength [nm], in ascending order, and the \
    responses of red, green and blue, 0 or more";

/// A fault in a table: its line and column, from 1, and what was found.
struct Fault {
    line: usize,
    column: usize,
    found: String,
}

/// A row of a table: the wavelength (nm) and three responses.
type Row = [f64; 4];

impl Params {
    /// Reads the sensor of a film; `None` is the ideal one, the default of pbrt-v4.
    pub(super) fn camera_sensor(&self) -> Result<Option<CameraSensor>, SceneError> {
        let Some(name) = self.text("sensor")?.filter(|name| *name != IDEAL_SENSOR) else {
            return Ok(None);
        };
        match CameraSensor::from_name(name) {
            Some(known) => Ok(Some(known)),
            None => self.camera_of_file(name).map(Some),
        }
    }

    /// Reads a camera from a file beside the scene.
    fn camera_of_file(&self, name: &str) -> Result<CameraSensor, SceneError> {
        let path = resolve(&self.folder, name);
        let bytes =
            self.context.bytes(&path).map_err(|source| self.unknown_camera(name, &source))?;
        if bytes.len() > MAX_FILE_SIZE {
            let found = format!("the table {} is too long", path_excerpt(&path));
            return Err(self.refuse("sensor", found, "expected at most 16 MiB"));
        }
        camera(&String::from_utf8_lossy(&bytes)).map_err(|Fault { line, column, found }| {
            let found = format!("{}:{line}:{column}: {found}", path_excerpt(&path));
            self.refuse("sensor", found, EXPECTED_ROWS)
        })
    }

    /// Returns the error of a name that is neither that of a camera nor of a readable file.
    fn unknown_camera(&self, name: &str, source: &ReadError) -> SceneError {
        let names: Vec<&str> = [IDEAL_SENSOR].into_iter().chain(CameraSensor::names()).collect();
        let found =
            format!("unknown sensor \"{name}\"{}; {source}", hint(name, names.iter().copied()));
        let expected = format!(
            "expected one of {}, or a file of wavelengths [nm] and responses of red, green and blue",
            names.join(", ")
        );
        self.refuse("sensor", found, expected)
    }
}

/// Returns the camera of a text.
fn camera(text: &str) -> Result<CameraSensor, Fault> {
    let rows = rows(text)?;
    let end = |found| Fault { line: text.lines().count().max(1), column: 1, found };
    let [[first, ..], .., [last, ..]] = &rows[..] else {
        return Err(end(format!("{} rows", rows.len())));
    };
    let [low, high] = VISIBLE.map(f64::from);
    if *first >= high || *last <= low {
        let found = format!("wavelengths from {first} to {last} nm, none of them visible");
        return Err(end(match *last < 10.0 {
            true => format!("{found}; micrometres are 1000 nm"),
            false => found,
        }));
    }
    CameraSensor::from_table(&rows).map_err(|fault| end(fault.to_string()))
}

/// Returns the rows of a text.
fn rows(text: &str) -> Result<Vec<Row>, Fault> {
    let mut rows: Vec<Row> = Vec::new();
    for (i, whole) in text.lines().enumerate() {
        let data = whole.split('#').next().unwrap_or_default().trim_start_matches('\u{feff}');
        let words: Vec<&str> = data
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .filter(|word| !word.is_empty())
            .collect();
        let number = |word: &str| word.parse().ok().filter(|number: &f64| number.is_finite());
        // Lines before the first row may name the columns.
        if words.is_empty() || rows.is_empty() && number(words[0]).is_none() {
            continue;
        }
        let fault = |word: &str, found: String| {
            // A word is a part of its line.
            let bytes = word.as_ptr() as usize - whole.as_ptr() as usize;
            Fault { line: i + 1, column: whole[..bytes].chars().count() + 1, found }
        };
        let mut row = Row::default();
        if words.len() != row.len() {
            return Err(fault(words[0], format!("{} columns", words.len())));
        }
        for (to, word) in row.iter_mut().zip(&words) {
            *to = number(word).ok_or_else(|| fault(word, format!("found {word:?}")))?;
        }
        if let Some(column) = (1..row.len()).find(|&column| row[column] < 0.0) {
            let found = format!("the response {} at {} nm, below 0", row[column], row[0]);
            return Err(fault(words[column], found));
        }
        if let Some(before) = rows.last().filter(|before| row[0] <= before[0]) {
            let found = format!("the wavelength {} nm after {} nm", row[0], before[0]);
            return Err(fault(words[0], found));
        }
        rows.push(row);
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::super::colour::tests::{given_in, word};
    use super::*;

    const TABLE: &str = "# A camera.\nnm, red, green, blue\n400, 0, 0.1, 0.8\n\n500, 0.1, 0.9, 0.2 # and on\n\
        600, 1, 0.3, 0\n";

    fn fault(text: &str) -> String {
        let Err(Fault { line, column, found }) = camera(text) else {
            panic!("{text:?} is a camera")
        };
        format!("{line}:{column}: {found}")
    }

    #[test]
    fn a_table_has_headers_comments_and_any_separator() {
        let expected = camera(TABLE).ok().expect("a camera");
        for separator in ["\t", " ", ";", " ,  "] {
            let text = TABLE.replace(", ", separator).replace('\n', "\r\n");
            assert_eq!(camera(&text).ok(), Some(expected.clone()), "{separator:?}");
        }
    }

    #[test]
    fn a_fault_has_its_line_and_column() {
        for (from, to, expected) in [
            ("500, 0.1", "400, 0.1", "5:1: the wavelength 400 nm after 400 nm"),
            ("500, 0.1", " 390, 0.1", "5:2: the wavelength 390 nm after 400 nm"),
            ("0.1, 0.9", "-0.1, 0.9", "5:6: the response -0.1 at 500 nm, below 0"),
            ("0.1, 0.9", "0.1, nine", "5:11: found \"nine\""),
            ("0.1, 0.9", "0.1, NaN", "5:11: found \"NaN\""),
            ("0.1, 0.9", "0.9", "5:1: 3 columns"),
            ("0.1, 0.9", "1, 0.1, 0.9", "5:1: 5 columns"),
        ] {
            assert_eq!(fault(&TABLE.replacen(from, to, 1)), expected);
        }
    }

    #[test]
    fn a_table_that_is_no_camera_is_refused() {
        assert_eq!(fault(""), "1:1: 0 rows");
        assert_eq!(fault("500 1 1 1"), "1:1: 1 rows");
        let micrometres = "0.4 1 0 0\n0.5 0 1 0\n0.6 0 0 1";
        let found = "wavelengths from 0.4 to 0.6 nm, none of them visible; micrometres are 1000 nm";
        assert_eq!(fault(micrometres), format!("3:1: {found}"));
        let blind = "400 1 0 0\n500 0 1 0\n600 0 1 0";
        assert_eq!(fault(blind), "3:1: no response of the blue channel to visible light");
        let grey = "400 1 2 1\n500 1 2 2\n600 1 2 1";
        assert_eq!(fault(grey), "3:1: channels that do not tell three colours apart");
    }

    #[test]
    fn a_sensor_is_a_camera_or_a_file_beside_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("own.csv"), TABLE).unwrap();
        std::fs::write(folder.path().join("bad.csv"), TABLE.replace("0.9", "-9")).unwrap();
        let params = |name: &str| given_in("sensor", "string", word(name), folder.path());
        let sensor = |name: &str| params(name).camera_sensor().map_err(|error| error.to_string());
        assert_eq!(sensor("cie1931"), Ok(None));
        assert_eq!(sensor("nikon_d850"), Ok(CameraSensor::from_name("nikon_d850")));
        assert_eq!(sensor("own.csv"), Ok(camera(TABLE).ok()));
        let own = params("own.csv");
        own.camera_sensor().unwrap();
        assert_eq!(own.context.files().iter().count(), 1, "the table is one of the inputs");
        let bad = sensor("bad.csv").unwrap_err();
        assert!(bad.contains("test.pbrt:2:3"), "{bad}");
        assert!(bad.contains("bad.csv:5:11: the response -9 at 500 nm"), "{bad}");
        assert!(bad.contains("expected at least two rows"), "{bad}");
        let typo = sensor("nikon_d85").unwrap_err();
        assert!(typo.contains("did you mean \"nikon_d850\"?"), "{typo}");
        assert!(typo.contains("or a file of wavelengths"), "{typo}");
    }
}
