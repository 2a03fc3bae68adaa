//! What the times were measured on.

/// A machine, and the program on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Its processor, where the system tells.
    pub cpu: String,
    /// Threads that it runs at once.
    pub threads: usize,
    /// Its system and instruction set.
    pub system: String,
    /// The program's version.
    pub version: &'static str,
}

impl Machine {
    /// This one.
    pub fn this() -> Self {
        // Linux tells it here; elsewhere the instruction set has to do.
        let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = told.lines().find_map(|line| line.strip_prefix("model name"));
        let name = name.map(|line| line.trim_start_matches([' ', '\t', ':']).trim().to_owned());
        Self {
            cpu: name.unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}
