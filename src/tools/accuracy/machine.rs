//! The machine on which times were measured.

/// A machine and the program version that ran on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Processor name, or the instruction set where the system does not tell.
    pub cpu: String,
    /// Number of hardware threads.
    pub threads: usize,
    /// Operating system and instruction set.
    pub system: String,
    /// Version of petzval.
    pub version: &'static str,
}

impl Machine {
    /// Describes this machine.
    pub fn this() -> Self {
        // Only Linux has this file.
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = info.lines().find_map(|line| line.strip_prefix("model name"));
        let name = name.map(|line| line.trim_start_matches([' ', '\t', ':']).trim().to_owned());
        Self {
            cpu: name.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}
