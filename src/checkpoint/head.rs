//! What a checkpoint says of itself.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use serde_json::{Value, json};

use super::Inputs;
use crate::stats::{BounceLanes, Lanes, LensStats, StageStats, Stats};

/// Counts that are larger were never counted.
const MOST: u64 = 1 << 53;

/// What a checkpoint says of itself.
#[derive(Clone, Debug, Default)]
pub struct Head {
    /// The command line that began it.
    pub words: Vec<String>,
    /// What its picture is made of.
    pub inputs: Inputs,
    /// Its samples of every pixel, where all have as many.
    pub samples: Range<u32>,
    /// How many samples a pixel of the picture has in the end.
    pub of: u32,
    /// Whether they are all there.
    pub complete: bool,
    /// Film samples that its body holds.
    pub taken: u64,
    /// What came about on the way.
    pub stats: Stats,
}

impl Head {
    pub(super) fn text(&self) -> Vec<u8> {
        let Self { words, inputs, samples, of, complete, taken, stats } = self;
        let stage = |of: &StageStats| {
            json!([of.time.as_nanos() as u64, of.rays, of.lanes.live, of.lanes.all])
        };
        let bounce = |of: &BounceLanes| {
            let lanes = [of.intersect, of.shade, of.occlude];
            json!(lanes.map(|lanes| [lanes.live, lanes.all]).concat())
        };
        let value = json!({
            "words": words,
            "program": inputs.program,
            "build": inputs.build,
            "files": inputs.files,
            "options": inputs.options,
            "samples": [samples.start, samples.end, *of],
            "complete": complete,
            "taken": taken,
            "stages": stats.stages.iter().map(stage).collect::<Vec<_>>(),
            "lens": [stats.lens.aimed, stats.lens.redone],
            "blocked": stats.lens.blocked,
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

/// The head, or the name of what is wrong.
fn read(value: &Value) -> Result<Head, &'static str> {
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let list = |name: &'static str| value[name].as_array().ok_or(name);
    let texts = |name: &'static str| -> Result<BTreeMap<String, String>, &'static str> {
        let entry = |(key, value): (&String, &Value)| Some((key.clone(), text(value)?));
        value[name].as_object().and_then(|map| map.iter().map(entry).collect()).ok_or(name)
    };
    let numbers = |name: &'static str| counts(&value[name]).ok_or(name);
    let words: Option<Vec<String>> = list("words")?.iter().map(text).collect();
    let sample = |n: u64| u32::try_from(n).map_err(|_| "samples");
    let [start, end, of] = fixed(numbers("samples")?).ok_or("samples")?;
    let [start, end, of] = [sample(start)?, sample(end)?, sample(of)?];
    if start > end || end > of {
        return Err("samples");
    }
    let stage = |value: &Value| {
        let [nanos, rays, live, all] = fixed(counts(value)?)?;
        let time = Duration::from_nanos(nanos);
        Some(StageStats { time, rays, lanes: Lanes { live, all } })
    };
    let stages: Option<Vec<StageStats>> = list("stages")?.iter().map(stage).collect();
    let bounce = |value: &Value| {
        let [a, b, c, d, e, f] = fixed(counts(value)?)?;
        let lanes = |live, all| Lanes { live, all };
        Some(BounceLanes { intersect: lanes(a, b), shade: lanes(c, d), occlude: lanes(e, f) })
    };
    let bounces: Option<Vec<BounceLanes>> = list("bounces")?.iter().map(bounce).collect();
    let [aimed, redone] = fixed(numbers("lens")?).ok_or("lens")?;
    Ok(Head {
        words: words.ok_or("words")?,
        inputs: Inputs {
            program: text(&value["program"]).ok_or("program")?,
            build: text(&value["build"]).ok_or("build")?,
            files: texts("files")?,
            options: texts("options")?,
        },
        samples: start..end,
        of,
        complete: value["complete"].as_bool().ok_or("complete")?,
        taken: count(&value["taken"]).ok_or("taken")?,
        stats: Stats {
            stages: stages.and_then(fixed).ok_or("stages")?,
            lens: LensStats { aimed, blocked: numbers("blocked")?, redone },
            bounces: bounces.ok_or("bounces")?,
        },
    })
}

fn count(value: &Value) -> Option<u64> {
    value.as_u64().filter(|&count| count <= MOST)
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
        let lanes = Lanes { live: 3, all: 8 };
        let bounce = BounceLanes { intersect: lanes, shade: lanes, occlude: Lanes::default() };
        let mut stats = Stats { bounces: vec![bounce], ..Stats::default() };
        stats.stages[2] = StageStats { time: Duration::from_nanos(77), rays: 5, lanes };
        stats.lens = LensStats { aimed: 9, blocked: vec![1, 2], redone: 4 };
        Head {
            words: vec!["petzval".to_owned(), "render".to_owned(), "a b.pbrt".to_owned()],
            inputs: Inputs {
                program: "petzval 0".to_owned(),
                build: "0f".to_owned(),
                files: map("a b.pbrt", "00ff"),
                options: map("--seed", "3"),
            },
            samples: 8..16,
            of: 64,
            complete: true,
            taken: 12,
            stats,
        }
    }

    #[test]
    fn a_head_is_read_as_it_was_written() {
        let written = head();
        let read = Head::parse(&written.text()).unwrap();
        assert_eq!(format!("{read:?}"), format!("{written:?}"));
    }

    #[test]
    fn what_is_missing_or_absurd_is_named() {
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
