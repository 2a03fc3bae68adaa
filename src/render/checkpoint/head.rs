//! Head of a checkpoint: its command line, its inputs and its progress, as JSON.

use std::ops::Range;
use std::time::Duration;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::Inputs;
use petzval_base::stats::{BounceOccupancy, LaneOccupancy, LensStats, StageStats, Stats};

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

/// A number of rays, of samples or of nanoseconds.
#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "u64")]
struct Count(u64);

impl TryFrom<u64> for Count {
    type Error = &'static str;

    fn try_from(count: u64) -> Result<Self, Self::Error> {
        if count <= MAX_COUNT { Ok(Self(count)) } else { Err("a count that is too large") }
    }
}

/// Reads an entry of the head; the error is its name.
fn entry<T: DeserializeOwned>(head: &Value, name: &'static str) -> Result<T, &'static str> {
    T::deserialize(&head[name]).map_err(|_| name)
}

/// Returns the head, or the name of the first entry that is missing or not sound.
fn read(head: &Value) -> Result<Head, &'static str> {
    let command_line = entry(head, "words")?;
    let [start, end, total_samples]: [u32; 3] = entry(head, "samples")?;
    if start > end || end > total_samples {
        return Err("samples");
    }
    let stage = |[nanos, rays, live, all]: [Count; 4]| StageStats {
        time: Duration::from_nanos(nanos.0),
        rays: rays.0,
        occupancy: lanes(live, all),
    };
    let bounce = |[a, b, c, d, e, f]: [Count; 6]| BounceOccupancy {
        intersect: lanes(a, b),
        shade: lanes(c, d),
        occlude: lanes(e, f),
    };
    let [aimed, retraced]: [Count; 2] = entry(head, "lens")?;
    let blocked: Vec<Count> = entry(head, "blocked")?;
    let blocked = blocked.iter().map(|count| count.0).collect();
    let film_samples: Count = entry(head, "taken")?;
    Ok(Head {
        command_line,
        inputs: Inputs {
            program: entry(head, "program")?,
            build: entry(head, "build")?,
            files: entry(head, "files")?,
            options: entry(head, "options")?,
        },
        samples: start..end,
        total_samples,
        complete: entry(head, "complete")?,
        film_samples: film_samples.0,
        stats: Stats {
            stages: entry::<[[Count; 4]; _]>(head, "stages")?.map(stage),
            lens: LensStats::restored(aimed.0, blocked, retraced.0),
            bounces: entry::<Vec<[Count; 6]>>(head, "bounces")?.into_iter().map(bounce).collect(),
        },
    })
}

fn lanes(live: Count, all: Count) -> LaneOccupancy {
    LaneOccupancy { live: live.0, all: all.0 }
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
    fn heads_of_earlier_programs_are_read() {
        let lanes = "[0,0,0,0]";
        let stages = [lanes, lanes, "[77,5,3,8]", lanes, lanes, lanes, lanes, lanes, lanes];
        let text = [
            r#"{"blocked":[1,2],"bounces":[[3,8,3,8,0,0]],"build":"0f","complete":true,"#,
            r#""files":{"a b.pbrt":"00ff"},"lens":[9,4],"options":{"seed":"3"},"#,
            r#""program":"petzval 0","samples":[8,16,64],"stages":["#,
            &stages.join(","),
            r#"],"taken":12,"words":["petzval","render","a b.pbrt"]}"#,
        ]
        .concat();
        let read = Head::parse(text.as_bytes()).unwrap();
        assert_eq!(format!("{read:?}"), format!("{:?}", head()));
        assert_eq!(String::from_utf8(head().text()).unwrap(), text);
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
