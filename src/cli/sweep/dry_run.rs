//! Dry run of a sweep: prepares pictures before the first is rendered, so that no value is refused
//! after hours.

use std::time::{Duration, Instant};

use super::Sweep;
use super::plan::SweepPlan;
use crate::cli::Failure;
use crate::cli::arguments::option_roles::{SweepRole, sweep_role};

/// Most pictures that a dry run prepares.
const MAX_PICTURES: usize = 64;
/// Time until a dry run is announced.
const SILENT: Duration = Duration::from_secs(3);

impl Sweep<'_> {
    /// Prepares pictures without rendering them. Returns the size of the first.
    pub(super) fn dry_run(&mut self) -> Result<[u32; 2], Failure> {
        let numbers = numbers(&self.plan);
        let (begun, mut silent) = (Instant::now(), true);
        let mut size = [1; 2];
        for &number in numbers.iter().rev() {
            if silent && begun.elapsed() > SILENT {
                silent = false;
                let (some, all) = (numbers.len(), self.names.len());
                say!("petzval: checking {some} of {all} pictures before the first is rendered");
            }
            let (argv, arguments) = self.command(number)?;
            let task = self.task(&arguments, argv, None);
            let (task, warnings) =
                task.map_err(|error| format!("{}: {error}", self.label(number)))?;
            size = task.job.frame.size();
            self.inputs.join(task.job.files);
            self.print_new(&warnings);
        }
        Ok(size)
    }
}

/// Chooses the pictures to prepare: all combinations of values that prepare differently, if they
/// are few. Otherwise every value at least once, or evenly spaced values with both ends.
fn numbers(plan: &SweepPlan) -> Vec<usize> {
    let axes = &plan.axes;
    let tried_once = |name: &str| sweep_role(name) == SweepRole::TriedOnce;
    let counts: Vec<usize> = axes
        .iter()
        .map(|axis| if tried_once(&axis.name) { 1 } else { axis.values.len() })
        .collect();
    let combinations: usize = counts.iter().product();
    if combinations <= MAX_PICTURES {
        let first_values = |&number: &usize| {
            let values = axes.iter().zip(plan.values(number));
            let mut once = values.filter(|(axis, _)| tried_once(&axis.name));
            once.all(|(axis, value)| axis.values[0] == value)
        };
        return (0..plan.count()).filter(first_values).collect();
    }
    let most = counts.iter().copied().max().unwrap_or(1).min(MAX_PICTURES);
    let index = |i: usize, count: usize| match count > most {
        true => i * (count - 1) / (most - 1),
        false => i % count,
    };
    let number = |i: usize| {
        let indices: Vec<usize> = counts.iter().map(|&count| index(i, count)).collect();
        plan.number(&indices)
    };
    (0..most).map(number).collect()
}
