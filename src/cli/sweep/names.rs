//! File names of a sweep's pictures.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use petzval_image::ImageFormat;

use super::axis::SweepAxis;
use super::plan::SweepPlan;
use crate::cli::Failure;

impl SweepPlan {
    /// Returns the names of all pictures. The scene's and the lens's file names fill placeholders,
    /// too.
    ///
    /// # Errors
    /// Returns an error if a placeholder is unknown or two pictures would have one name.
    pub fn names(&self, scene: &Path, lens: Option<&Path>) -> Result<Vec<PathBuf>, Failure> {
        let stem =
            |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut fixed = HashMap::from([("scene", stem(scene))]);
        fixed.extend(lens.map(|lens| ("lens", stem(lens))));
        let swept = |name: &str| self.axes.iter().position(|axis| axis.name == name);
        let known: BTreeSet<&str> =
            fixed.keys().copied().chain(self.axes.iter().map(|axis| axis.name.as_str())).collect();
        let braced = |names: Vec<&str>| {
            let names: Vec<String> = names.iter().map(|name| format!("{{{name}}}")).collect();
            names.join(", ")
        };
        let template = &self.template_text;
        if let Some(place) = self.template.placeholders().find(|place| !known.contains(place)) {
            let known = braced(known.into_iter().collect());
            let problem = format!("unknown placeholder {{{place}}}; known are {known}");
            return Err(format!("-o {template}: {problem}").into());
        }
        let needed = |axis: &&SweepAxis| axis.values.len() > 1;
        let missing = self.axes.iter().filter(needed).map(|axis| axis.name.as_str());
        let missing =
            missing.filter(|name| self.template.placeholders().all(|place| place != *name));
        let missing: Vec<&str> = missing.collect();
        if !missing.is_empty() {
            let missing = braced(missing);
            return Err(format!(
                "-o {template}: two pictures would have one name; add {missing} to it"
            )
            .into());
        }
        let mut numbers: HashMap<PathBuf, usize> = HashMap::new();
        let mut names = Vec::with_capacity(self.count());
        for number in 0..self.count() {
            let fill = |(axis, value): (&SweepAxis, &str)| match axis.name.as_str() {
                "lens" => stem(Path::new(value)),
                _ => value.to_owned(),
            };
            let values: Vec<String> = self.axes.iter().zip(self.values(number)).map(fill).collect();
            let filled = self.template.filled(|place| match swept(place) {
                Some(at) => &values[at],
                None => &fixed[place],
            });
            let name = PathBuf::from(filled);
            if let Some(other) = numbers.insert(name.clone(), number) {
                let [one, other] = [other, number].map(|n| self.values(n).join(", "));
                let name = name.display();
                return Err(format!("-o {template}: both {one} and {other} would be {name}").into());
            }
            if matches!(ImageFormat::of(&name)?, ImageFormat::Npy | ImageFormat::Dng) {
                let hint = "the contact sheet shows .exr, .png, .jpg and .tif";
                return Err(format!("-o {template}: {hint}").into());
            }
            names.push(name);
        }
        Ok(names)
    }

    /// Returns the folder in which all pictures are, or their folders.
    pub fn folder(&self) -> PathBuf {
        match self.template.prefix().rsplit_once('/') {
            Some((folder, _)) => PathBuf::from(format!("{folder}/")),
            None => PathBuf::new(),
        }
    }
}
