//! Results of the benchmark, and the timing of its runs.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Time of one measurement.
const DURATION: Duration = Duration::from_millis(300);

/// One result.
struct Measure {
    name: String,
    value: f64,
    unit: &'static str,
}

/// The results so far.
#[derive(Default)]
pub(super) struct Suite {
    measures: Vec<Measure>,
}

impl Suite {
    pub fn put(&mut self, name: impl Into<String>, value: f64, unit: &'static str) {
        self.measures.push(Measure { name: name.into(), value, unit });
    }

    /// Measures millions of elements per second.
    pub fn rate(&mut self, name: &str, elements: u64, mut run: impl FnMut()) {
        let seconds = fastest(&mut run);
        self.put(name, elements as f64 / seconds / 1e6, "M/s");
    }

    /// Adds the quotient of two results.
    pub fn ratio(&mut self, name: &str, [numerator, denominator]: [&str; 2]) {
        self.put(name, self.value(numerator) / self.value(denominator), "x");
    }

    fn value(&self, name: &str) -> f64 {
        self.measures.iter().find(|measure| measure.name == name).map_or(f64::NAN, |m| m.value)
    }

    pub fn json(&self) -> String {
        let row = |Measure { name, value, unit }: &Measure| json!({ "name": name, "value": value, "unit": unit });
        format!("{:#}\n", Value::Array(self.measures.iter().map(row).collect()))
    }

    pub fn table(&self) -> String {
        let line =
            |Measure { name, value, unit }: &Measure| format!("{name:<32}{value:>12.3} {unit}\n");
        self.measures.iter().map(line).collect()
    }
}

/// Returns the time of the fastest of many runs [s]: other load on the machine can only slow a run.
pub(super) fn fastest(run: &mut impl FnMut()) -> f64 {
    run();
    let (begun, mut best) = (Instant::now(), f64::INFINITY);
    while begun.elapsed() < DURATION {
        let start = Instant::now();
        run();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}
