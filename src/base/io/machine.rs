//! Memory and cores of the machine. Memory is known on Linux only; elsewhere no job is refused by
//! default.

use std::fs;
use std::path::Path;

/// Returns the number of cores that this process may use.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Resident memory of this process; 0 if unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ResidentMemory {
    /// The current value (bytes).
    pub now: u64,
    /// The largest value so far (bytes).
    pub peak: u64,
}

/// Returns the resident memory of this process.
pub fn resident() -> ResidentMemory {
    let status = text("/proc/self/status");
    let [now, peak] = ["VmRSS:", "VmHWM:"].map(|name| field(&status, name).unwrap_or(0));
    ResidentMemory { now, peak }
}

/// Returns the most memory that this process can have (bytes), if all others give way: that of the
/// machine with its swap, or of the container or batch job that it runs in.
pub fn limit() -> Option<u64> {
    let machine = text("/proc/meminfo");
    let total = field(&machine, "MemTotal:")?;
    let swap = field(&machine, "SwapTotal:").unwrap_or(0);
    let groups = limits(&text("/proc/self/cgroup"), |path| fs::read_to_string(path).ok());
    Some(groups.into_iter().fold(total + swap, u64::min))
}

/// Returns the memory that is free now (bytes).
pub fn available() -> Option<u64> {
    let machine = text("/proc/meminfo");
    Some(field(&machine, "MemAvailable:")? + field(&machine, "SwapFree:").unwrap_or(0))
}

fn text(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// Returns a field of a table in kB (bytes).
fn field(text: &str, name: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kib: u64 = rest.split_whitespace().next()?.parse().ok()?;
    kib.checked_mul(1024)
}

/// Returns the memory limits of the control groups of a process and of their parents, given its list
/// of groups: of version 2 (one line, 0::/path) and version 1 (the line of the controller "memory").
fn limits(groups: &str, read: impl Fn(&Path) -> Option<String>) -> Vec<u64> {
    let mut limits = Vec::new();
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':');
        let (Some(_), Some(controllers), Some(path)) =
            (fields.next(), fields.next(), fields.next())
        else {
            continue;
        };
        let (root, name) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ if controllers.split(',').any(|name| name == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        for group in Path::new(path.trim_start_matches('/')).ancestors() {
            let limit = read(&Path::new(root).join(group).join(name));
            limits.extend(limit.and_then(|limit| limit.trim().parse::<u64>().ok()));
        }
    }
    limits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_fields_are_found_by_name() {
        let table = "MemTotal:       24683520 kB\nMemAvailable:   1024 kB\nHugePages_Total: 0\n";
        assert_eq!(field(table, "MemTotal:"), Some(24_683_520 * 1024));
        assert_eq!(field(table, "MemAvailable:"), Some(1 << 20));
        assert_eq!(field(table, "SwapTotal:"), None);
    }

    #[test]
    fn limits_of_all_parent_groups_are_found() {
        let read = |path: &Path| match path.to_str() {
            Some("/sys/fs/cgroup/slurm/job_7/memory.max") => Some("4294967296\n".to_owned()),
            Some("/sys/fs/cgroup/slurm/job_7/step_0/memory.max") => Some("max\n".to_owned()),
            Some("/sys/fs/cgroup/memory/box/memory.limit_in_bytes") => Some("1000\n".to_owned()),
            _ => None,
        };
        assert_eq!(limits("0::/slurm/job_7/step_0\n", read), [4_294_967_296]);
        assert_eq!(limits("3:cpu,memory:/box\n2:cpuset:/box\n", read), [1000]);
        assert!(limits("", read).is_empty());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_machine_reports_plausible_memory() {
        let ResidentMemory { now, peak } = resident();
        assert!(now > 0 && now <= peak && peak < limit().unwrap());
        assert!(available().unwrap() > 0);
    }
}
