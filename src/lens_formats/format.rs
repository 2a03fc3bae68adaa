//! Recognition of the format of a lens file, by its content.

use std::path::Path;

/// Format of a lens file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LensFormat {
    /// petzval's own, in TOML.
    Toml,
    /// Table of pbrt or ISET: radius, thickness, index, diameter.
    Dat,
    /// Zemax, sequential.
    Zmx,
    /// CODE V sequence of commands.
    CodeV,
    /// OSLO.
    Oslo,
    /// Text of the Optical Bench (Bill Claff).
    OpticalBench,
    /// polynomial-optics and its successors: sections in brackets.
    Fx,
    /// JSON of several programs.
    Json,
    /// Table with a line of column names: `radius;thickness;...`.
    Csv,
    /// DiffOptics: rows of surface type, distance, radius, diameter, material.
    DiffOptics,
}

impl LensFormat {
    /// Recognises the format of a text; the extension of its path decides only between TOML and a
    /// table.
    pub fn detect(path: &Path, text: &str) -> Self {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty()).take(200);
        let lower = |line: &str| line.to_ascii_lowercase();
        let first = lower(lines().next().unwrap_or_default());
        let any = |test: &dyn Fn(&str) -> bool| lines().any(|line| test(&lower(line)));
        let begins = |word: &'static str| any(&|line| line.starts_with(word));
        if extension == "toml" || begins("[[surface]]") {
            Self::Toml
        } else if first.starts_with('{') || (first.starts_with('[') && first.len() < 3) {
            Self::Json
        } else if begins("mode seq") || begins("mode nsc") || begins("surf 0") {
            Self::Zmx
        } else if first.starts_with("// oslo") || begins("len new") {
            Self::Oslo
        } else if begins("rdm") || begins("len;") || begins("len \"") || extension == "seq" {
            Self::CodeV
        } else if begins("[lens data]") || begins("[variable distances]") {
            Self::OpticalBench
        } else if begins("[surfaces]") {
            Self::Fx
        } else if any(&|line| line.starts_with("radius;") || line.starts_with("radius,")) {
            Self::Csv
        } else if begins("type ") && any(&|line| line.starts_with("type") && line.contains("roc")) {
            Self::DiffOptics
        } else {
            match extension.as_str() {
                "zmx" => Self::Zmx,
                "len" => Self::Oslo,
                "fx" => Self::Fx,
                "json" | "roa" => Self::Json,
                _ => Self::Dat,
            }
        }
    }
}
