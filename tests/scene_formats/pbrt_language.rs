//! Conformance with pbrt-v4: small scenes, each with the picture that pbrt-v4 gives.
//!
//! `rows.jsonl` is made by `benches/conformance/conformance.py`. A row agrees, or it says how it differs and by
//! how much at most, or it names what is not supported, and then reading it must cause a warning. docs/scenes.md
//! shows the rows.

use std::collections::BTreeMap;

use crate::support::{folder, in_parallel, mean, picture, root, write};
use glam::Vec3;
use petzval_image::{DisplayExposure, Picture};
use petzval_render::Backend;
use petzval_render::prepare::{Changes, prepare};
use petzval_spectrum::Primaries;
use serde_json::Value;

/// Samples per pixel.
const SAMPLES: u32 = 256;
/// Samples of pbrt's pictures: four seeds of 256 per pixel.
const PBRT_SAMPLES: f64 = 1024.0;
/// Texels along a side of a thumbnail.
const TEXELS: usize = 16;
/// Largest root mean square of the difference of thumbnails, relative to their mean, unless the row's
/// tolerance is larger. Upside down, all of them are at 0.27 or more.
const THUMBNAIL: f64 = 0.15;

/// A row of the table.
struct Row {
    group: String,
    name: String,
    scene: String,
    mean: [f64; 3],
    error: [f64; 3],
    /// Luminance of each texel, row by row.
    thumbnail: Vec<f64>,
    /// Whether paths carry wavelengths.
    spectra: bool,
    differs: Option<String>,
    missing: Option<String>,
    /// Largest relative difference of the mean, without noise.
    tolerance: f64,
}

fn rows() -> Vec<Row> {
    let text = std::fs::read_to_string(root().join("tests/pbrt_language/rows.jsonl")).unwrap();
    text.lines().map(|line| row(&serde_json::from_str(line).expect(line))).collect()
}

fn row(entry: &Value) -> Row {
    let text = |key: &str| entry[key].as_str().map(str::to_owned);
    let triple = |key: &str| [0, 1, 2].map(|i| entry[key][i].as_f64().expect(key));
    let white = entry["thumbnail"]["white"].as_f64().expect("a number");
    let texels = entry["thumbnail"]["texels"].as_str().expect("bytes").as_bytes().as_chunks::<2>();
    let byte = |hex: &[u8; 2]| u8::from_str_radix(str::from_utf8(hex).unwrap(), 16).unwrap();
    Row {
        group: text("group").unwrap(),
        name: text("name").unwrap(),
        scene: text("scene").unwrap().replace("@ROOT@", root().to_str().expect("a plain path")),
        mean: triple("mean"),
        error: triple("error"),
        thumbnail: texels.0.iter().map(|hex| f64::from(byte(hex)) / 255.0 * white).collect(),
        spectra: entry["spectra"] == true,
        differs: text("differs"),
        missing: text("missing"),
        tolerance: entry["tolerance"].as_f64().expect("a number"),
    }
}

/// Returns the means of blocks of luminance, row by row.
fn thumbnail(picture: &Picture) -> Vec<f64> {
    let [width, height] = picture.size;
    let mut texels = Vec::new();
    for row in 0..TEXELS {
        for column in 0..TEXELS {
            let range = |i: usize, n: usize| n * i / TEXELS..n * (i + 1) / TEXELS;
            let pixels = range(row, height)
                .flat_map(|y| range(column, width).map(move |x| picture.pixels[y * width + x]));
            let (sum, count) = pixels.fold((0.0, 0), |(sum, count), [r, g, b]| {
                (sum + 0.2126 * r + 0.7152 * g + 0.0722 * b, count + 1)
            });
            texels.push(f64::from(sum) / f64::from(count));
        }
    }
    texels
}

/// Returns what is wrong with a row, if anything is.
fn check(row: &Row) -> Option<String> {
    let folder = folder();
    let sampler = format!("Sampler \"zsobol\" \"integer pixelsamples\" {SAMPLES}\nWorldBegin");
    let text = row.scene.replacen("WorldBegin", &sampler, 1);
    let description = match petzval_scene_formats::pbrt::read(&write(&folder, "row.pbrt", text)) {
        Ok(description) => description,
        Err(error) => return Some(error.to_string()),
    };
    if row.missing.is_some() {
        return description.warnings.is_empty().then(|| "no warning".to_owned());
    }
    let effects = if row.spectra { "+spectra" } else { "auto" };
    let effects = effects.parse().expect("effects");
    let job = match prepare(description, &Changes { effects, ..Changes::default() }) {
        Ok(prepared) => prepared.job,
        Err(error) => return Some(error.to_string()),
    };
    let mut found = picture(&job, Backend::Simd, 1);
    if let Some(space) = job.encoding(DisplayExposure::default()).space {
        // The file has the colours of the scene's space.
        let matrix = Primaries::SRGB.to(&space).expect("a space");
        for pixel in &mut found.pixels {
            *pixel = (matrix.as_mat3() * Vec3::from_array(*pixel)).to_array();
        }
    }
    let ours = mean(&found);
    for channel in 0..3 {
        // The noise of both pictures: the variance of a sample is at most that of pbrt.
        let ratio = PBRT_SAMPLES / f64::from(SAMPLES);
        let noise = 4.5 * row.error[channel] * (1.0 + ratio).sqrt();
        let (ours, theirs) = (ours[channel], row.mean[channel]);
        if (ours - theirs).abs() > row.tolerance * theirs + noise {
            let percent = 100.0 * (ours / theirs - 1.0);
            return Some(format!(
                "channel {channel}: {ours:.5}, pbrt {theirs:.5} ({percent:+.2} %)"
            ));
        }
    }
    let ours = thumbnail(&found);
    let square = |(a, b): (&f64, &f64)| (a - b).powi(2);
    let sum: f64 = ours.iter().zip(&row.thumbnail).map(square).sum();
    let level = row.thumbnail.iter().sum::<f64>() / ours.len() as f64;
    let apart = (sum / ours.len() as f64).sqrt() / level;
    (apart > THUMBNAIL.max(row.tolerance))
        .then(|| format!("thumbnails are {:.0} % apart", 100.0 * apart))
}

#[test]
fn pictures_are_those_of_pbrt() {
    let rows = rows();
    assert!(rows.len() >= 300, "{}", rows.len());
    let wrong: Vec<String> = in_parallel(&rows, |row| {
        check(row).map(|why| format!("{}: {}: {why}", row.group, row.name))
    })
    .into_iter()
    .flatten()
    .collect();
    assert!(wrong.is_empty(), "{} of {} rows:\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}

#[test]
fn the_manual_shows_every_row() {
    // One line for all rows of a group that agree, and one for each other row.
    let mut groups: BTreeMap<String, (Vec<String>, String)> = BTreeMap::new();
    for row in rows() {
        let (agreeing, others) = groups.entry(row.group.clone()).or_default();
        let status = match (&row.differs, &row.missing) {
            (_, Some(missing)) => format!("not supported: {missing}"),
            (Some(differs), _) => format!("within {} %: {differs}", 100.0 * row.tolerance),
            _ => {
                agreeing.push(row.name + if row.spectra { " (+spectra)" } else { "" });
                continue;
            }
        };
        *others += &format!("| {} | {} | {status} |\n", row.group, row.name);
    }
    let mut table = String::from("| | | |\n|---|---|---|\n");
    for (group, (agreeing, others)) in groups {
        if !agreeing.is_empty() {
            table += &format!("| {group} | {} | agree |\n", agreeing.join("; "));
        }
        table += &others;
    }
    let page = std::fs::read_to_string(root().join("docs/scenes.md")).expect("docs/scenes.md");
    assert!(page.contains(&table), "docs/scenes.md must have this table:\n{table}");
}
