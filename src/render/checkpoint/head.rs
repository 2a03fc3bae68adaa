//! Head of a checkpoint: its command line, its inputs and its progress, as JSON.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use serde_json::{Value, json};

use super::Inputs;
use crate::stats::{BounceOccupancy, LaneOccupancy, LensStats, StageStats, Stats};

/// Largest number of rays or samples in a sound head.
const MAX_COUNT: u64 = 1 << 53;

/// Head of a checkpoint.
#[derive(Clone, Debug, Default)]
pub struct Head {
    /// The command line that began the render.
    pub command_line: Vec<String>,
    /// The inputs of the picture.
    pub inputs: Inputs,
    /// The sample numbers of every pixel, if all pixels have the same.
    pub samples: Range<u32>,
    /// The number of samples per pixel of the complete picture.
    pub total_samples: u32,
    /// Whether all samples are there.
    pub complete: bool,
    /// The number of film samples in the body.
    pub film_samples: u64,
    /// Counts and times of the stages so far.
    pub stats: Stats,
}

impl Head {
    pub(super) fn text(&self) -> Vec<u8> {
        let Self { command_line, inputs, samples, total_samples, complete, film_samples, stats } =
            self;
        let stage = |stats: &StageStats| {
            json!([
                stats.time.as_nanos() as u64,
                stats.rays,
                stats.occupancy.live,
                stats.occupancy.all
            ])
        };
        let bounce = |bounce: &BounceOccupancy| {
            let lanes = [bounce.intersect, bounce.shade, bounce.occlude];
            json!(lanes.map(|lanes| [lanes.live, lanes.all]).concat())
        };
        let value = json!({
            "words": command_line,
            "program": inputs.program,
            "build": inputs.build,
            "files": inputs.files,
            "options": inputs.options,
            "samples": [samples.start, samples.end, *total_samples],
            "complete": complete,
            "taken": film_samples,
            "stages": stats.stages.iter().map(stage).collect::<Vec<_>>(),
            "lens": [stats.lens.aimed, stats.lens.retraced],
            "blocked": stats.lens.blocked(),
            "bounces": stats.bounces.iter().map(bounce).collect::<Vec<_>>(),
        });
        value.to_string().into_bytes()
    }

    pub(super) fn parse(text: &[u8]) -> Result<Self, String> {
        let value: Value = serde_json::from_slice(text)
            .map_err(|error| format!("its head is no JSON: {error}"))?;
        let missing = |name: &str| format!("its head has no sound \"{name}\"");
        read(&value).map_err(missing)
    }
}

/// Returns the head, or the name of the first entry that is missing or not sound.
fn read(value: &Value) -> Result<Head, &'static str> {
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let list = |name: &'static str| value[name].as_array().ok_or(name);
    let texts = |name: &'static str| -> Result<BTreeMap<String, String>, &'static str> {
        let entry = |(key, value): (&String, &Value)| Some((key.clone(), text(value)?));
        value[name].as_object().and_then(|map| map.iter().map(entry).collect()).ok_or(name)
    };
    let numbers = |name: &'static str| counts(&value[name]).ok_or(name);
    let command_line: Option<Vec<String>> = list("words")?.iter().map(text).collect();
    let sample = |n: u64| u32::try_from(n).map_err(|_| "samples");
    let [start, end, total] = fixed(numbers("samples")?).ok_or("samples")?;
    let [start, end, total] = [sample(start)?, sample(end)?, sample(total)?];
    if start > end || end > total {
        return Err("samples");
    }
    let stage = |value: &Value| {
        let [nanos, rays, live, all] = fixed(counts(value)?)?;
        let time = Duration::from_nanos(nanos);
        Some(StageStats { time, rays, occupancy: LaneOccupancy { live, all } })
    };
    let stages: Option<Vec<StageStats>> = list("stages")?.iter().map(stage).collect();
    let bounce = |value: &Value| {
        let [a, b, c, d, e, f] = fixed(counts(value)?)?;
        let lanes = |live, all| LaneOccupancy { live, all };
        Some(BounceOccupancy { intersect: lanes(a, b), shade: lanes(c, d), occlude: lanes(e, f) })
    };
    let bounces: Option<Vec<BounceOccupancy>> = list("bounces")?.iter().map(bounce).collect();
    let [aimed, retraced] = fixed(numbers("lens")?).ok_or("lens")?;
    Ok(Head {
        command_line: command_line.ok_or("words")?,
        inputs: Inputs {
            program: text(&value["program"]).ok_or("program")?,
            build: text(&value["build"]).ok_or("build")?,
            files: texts("files")?,
            options: texts("options")?,
        },
        samples: start..end,
        total_samples: total,
        complete: value["complete"].as_bool().ok_or("complete")?,
        film_samples: count(&value["taken"]).ok_or("taken")?,
        stats: Stats {
            stages: stages.and_then(fixed).ok_or("stages")?,
            lens: LensStats::restored(aimed, numbers("blocked")?, retraced),
            bounces: bounces.ok_or("bounces")?,
        },
    })
}

fn count(value: &Value) -> Option<u64> {
    value.as_u64().filter(|&count| count <= MAX_COUNT)
}

fn counts(value: &Value) -> Option<Vec<u64>> {
    value.as_array()?.iter().map(count).collect()
}

fn fixed<T, const N: usize>(list: Vec<T>) -> Option<[T; N]> {
    list.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head() -> Head {
        let map = |key: &str, value: &str| [(key.to_owned(), value.to_owned())].into();
        let lanes = LaneOccupancy { live: 3, all: 8 };
        let bounce =
            BounceOccupancy { intersect: lanes, shade: lanes, occlude: LaneOccupancy::default() };
        let mut stats = Stats { bounces: vec![bounce], ..Stats::default() };
        stats.stages[2] = StageStats { time: Duration::from_nanos(77), rays: 5, occupancy: lanes };
        stats.lens = LensStats::restored(9, vec![1, 2], 4);
        Head {
            command_line: vec!["petzval".to_owned(), "render".to_owned(), "a b.pbrt".to_owned()],
            inputs: Inputs {
                program: "petzval 0".to_owned(),
                build: "0f".to_owned(),
                files: map("a b.pbrt", "00ff"),
                options: map("seed", "3"),
            },
            samples: 8..16,
            total_samples: 64,
            complete: true,
            film_samples: 12,
            stats,
        }
    }

    #[test]
    fn a_head_survives_writing_and_reading() {
        let written = head();
        let read = Head::parse(&written.text()).unwrap();
        assert_eq!(format!("{read:?}"), format!("{written:?}"));
    }

    #[test]
    fn missing_and_unsound_entries_are_named() {
        let good: Value = serde_json::from_slice(&head().text()).unwrap();
        for name in good.as_object().unwrap().keys() {
            let mut bad = good.clone();
            bad[name] = json!({ "no": [-1] });
            let found = Head::parse(bad.to_string().as_bytes()).unwrap_err();
            assert!(found.contains(name), "{name}: {found}");
        }
        let mut bad = good;
        bad["samples"] = json!([5, 4, 9]);
        assert!(Head::parse(bad.to_string().as_bytes()).is_err());
        assert!(Head::parse(&[b'['; 100_000]).unwrap_err().contains("no JSON"));
    }
}
