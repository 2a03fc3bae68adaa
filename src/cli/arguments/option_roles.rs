//! How the options of `petzval render` take part in resuming and in sweeps.

/// An option that is not recorded and swept like most.
struct OptionRole {
    /// The option without dashes.
    name: &'static str,
    /// Whether the inputs of a picture list the option's words. They do not if the option does not
    /// affect the samples, or if its outcome is listed instead.
    in_inputs: bool,
    sweep: SweepRole,
}

/// How a sweep uses an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) enum SweepRole {
    /// Swept; each value is tried before the first picture is rendered.
    Tried,
    /// Swept; one value is tried, as all values prepare alike.
    TriedOnce,
    /// Not swept: one value for the whole sweep.
    Whole,
}

/// All options that differ from the default: in the inputs, and [`SweepRole::Tried`].
const ROLES: [OptionRole; 26] = {
    const fn role(name: &'static str, in_inputs: bool, sweep: SweepRole) -> OptionRole {
        OptionRole { name, in_inputs, sweep }
    }
    use SweepRole::{Tried, TriedOnce, Whole};
    [
        role("aov", false, Tried),
        role("backend", false, Whole),
        role("bit-depth", false, TriedOnce),
        role("catalogue", false, Whole),
        role("checkpoint", false, Whole),
        role("contact", false, Whole),
        role("crop", false, Tried),
        role("denoise", false, Whole),
        role("exposure", false, TriedOnce),
        role("half", false, TriedOnce),
        role("help", false, Tried),
        role("lens", false, Tried),
        role("memory", false, Whole),
        role("noise", true, TriedOnce),
        role("output", false, Whole),
        role("resolution", false, Tried),
        role("resume", false, Whole),
        role("samples", false, Whole),
        role("seed", false, TriedOnce),
        role("shard", false, Whole),
        role("spp", false, TriedOnce),
        role("sweep", false, Whole),
        role("threads", false, Whole),
        role("time", true, TriedOnce),
        role("tone", false, TriedOnce),
        role("white-balance", false, TriedOnce),
    ]
};

fn role(name: &str) -> Option<&'static OptionRole> {
    ROLES.iter().find(|role| role.name == name)
}

/// Returns whether the inputs of a picture list this option.
pub(in crate::cli) fn in_inputs(name: &str) -> bool {
    role(name).is_none_or(|role| role.in_inputs)
}

/// Returns how a sweep uses this option.
pub(in crate::cli) fn sweep_role(name: &str) -> SweepRole {
    role(name).map_or(SweepRole::Tried, |role| role.sweep)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::cli::Arguments;

    #[test]
    fn every_listed_option_exists() {
        let mut command = Arguments::command();
        command.build();
        let render = command.find_subcommand("render").expect("a command");
        let known: Vec<&str> = render.get_arguments().filter_map(clap::Arg::get_long).collect();
        for OptionRole { name, .. } in &ROLES {
            assert!(known.contains(name), "petzval render has no --{name}");
        }
    }
}
