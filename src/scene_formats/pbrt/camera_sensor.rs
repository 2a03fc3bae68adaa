//! The film's parameter "sensor": the name of a measured camera, or a file of its responses.

use super::SceneError;
use super::params::Params;
use super::sample_files::{Fault, SampleFile, check_visible};
use petzval_base::io::{ReadError, hint};
use petzval_spectrum::CameraSensor;

/// pbrt-v4's name of the sensor that sees X, Y and Z.
const IDEAL_SENSOR: &str = "cie1931";

const EXPECTED_ROWS: &str = "expected at least two rows of a wavelength [nm], in ascending order, and the \
    responses of red, green and blue, 0 or more";

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
        let unknown = |source: ReadError| {
            let names: Vec<&str> =
                [IDEAL_SENSOR].into_iter().chain(CameraSensor::names()).collect();
            let hint = hint(name, names.iter().copied());
            let expected = format!(
                "expected one of {}, or a file of wavelengths [nm] and responses of red, green and blue",
                names.join(", ")
            );
            (format!("unknown sensor \"{name}\"{hint}; {source}"), expected)
        };
        let file = SampleFile::read(self, self.location("sensor"), name, unknown)?;
        camera(&file).map_err(|fault| file.refuse(fault, EXPECTED_ROWS))
    }
}

/// Returns the camera of a file.
fn camera(file: &SampleFile) -> Result<CameraSensor, Fault> {
    let rows = rows(file)?;
    let [[first, ..], .., [last, ..]] = &rows[..] else {
        return Err(file.fault_at_end(format!("{} rows", rows.len())));
    };
    check_visible(*first, *last).map_err(|found| file.fault_at_end(found))?;
    CameraSensor::from_table(&rows).map_err(|fault| file.fault_at_end(fault.to_string()))
}

/// Returns the rows of a file.
fn rows(file: &SampleFile) -> Result<Vec<Row>, Fault> {
    let mut rows: Vec<Row> = Vec::new();
    for words in file.lines() {
        // Lines before the first row may name the columns.
        let Some(first) = words.first() else { continue };
        if rows.is_empty() && first.number().is_err() {
            continue;
        }
        let mut row = Row::default();
        if words.len() != row.len() {
            return Err(first.fault(format!("{} columns", words.len())));
        }
        for (to, word) in row.iter_mut().zip(&words) {
            *to = word.number()?;
        }
        if let Some(column) = (1..row.len()).find(|&column| row[column] < 0.0) {
            let found = format!("the response {} at {} nm, below 0", row[column], row[0]);
            return Err(words[column].fault(found));
        }
        if let Some(before) = rows.last().filter(|before| row[0] <= before[0]) {
            return Err(first.fault(format!("the wavelength {} nm after {} nm", row[0], before[0])));
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
        let Err(Fault { line, column, found }) = camera(&SampleFile::of(text)) else {
            panic!("{text:?} is a camera")
        };
        format!("{line}:{column}: {found}")
    }

    #[test]
    fn a_table_has_headers_comments_and_any_separator() {
        let expected = camera(&SampleFile::of(TABLE)).expect("a camera");
        for separator in ["\t", " ", ";", " ,  "] {
            let text = TABLE.replace(", ", separator).replace('\n', "\r\n");
            assert_eq!(
                camera(&SampleFile::of(&text)).ok(),
                Some(expected.clone()),
                "{separator:?}"
            );
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
        assert_eq!(sensor("own.csv"), Ok(camera(&SampleFile::of(TABLE)).ok()));
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
