//! Compile-time switch that leaves effects out of the program.

/// Whether effects are compiled in: false in a build with the feature `bare`.
///
/// A branch of a hot stage that serves an effect tests this constant too, so that the two builds
/// show what the branch costs where its effect is off.
pub const EFFECTS: bool = cfg!(not(feature = "bare"));
