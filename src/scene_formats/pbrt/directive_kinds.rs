//! Tables of the kinds of a directive, such as `Shape "sphere"`: the parameters that each kind
//! reads, those that it ignores, and the substitute for what is not supported.
//!
//! A new kind or parameter is added to the table of its directive.

use super::attributes::Target;
use super::params::{Param, Params};
use super::reader::SceneReader;
use super::{Dialect, SceneError};
use petzval_base::io::hint;

/// A directive that selects one of several kinds by name.
pub(super) struct Directive<K: 'static> {
    pub(super) name: &'static str,
    /// The `Attribute` defaults that apply to it.
    pub(super) target: Option<Target>,
    /// Parameters that every kind reads.
    pub(super) shared: &'static [&'static str],
    pub(super) kinds: &'static [KindEntry<K>],
}

/// A kind of a directive.
pub(super) struct KindEntry<K> {
    name: &'static str,
    /// `None` if the kind is not supported.
    kind: Option<K>,
    /// Parameters that are read.
    reads: &'static [&'static str],
    /// Parameters that are known but not read.
    ignores: &'static [Ignored],
    /// The substitute, if the kind is not supported or only similar to pbrt's.
    instead: Option<&'static str>,
}

/// A parameter that is known but not read, and the consequence that a warning states, or
/// [`SILENT`].
pub(super) type Ignored = (&'static str, &'static str);

/// Suppresses the warning about a parameter or kind that changes the mean of no pixel, or that
/// pbrt-v4's upgrade of a scene drops, too.
pub(super) const SILENT: &str = "";

/// The consequence of a parameter that a kind does not read, before pbrt-v4.
const UNUSED: &str = "no part of this kind reads it, and it is left out";

/// A kind of a directive that a scene selects, with parameters that are checked if the kind is
/// supported.
pub(super) struct Selected<K> {
    pub(super) name: &'static str,
    /// `None` if the kind is not supported; the warning is given.
    pub(super) kind: Option<K>,
    pub(super) params: Params,
}

/// A kind that is supported.
pub(super) const fn known<K: Copy>(
    name: &'static str,
    kind: K,
    reads: &'static [&'static str],
    ignores: &'static [Ignored],
) -> KindEntry<K> {
    KindEntry { name, kind: Some(kind), reads, ignores, instead: None }
}

/// A kind that is read as the most similar one, with a warning.
pub(super) const fn similar<K: Copy>(
    name: &'static str,
    kind: K,
    reads: &'static [&'static str],
    ignores: &'static [Ignored],
    instead: &'static str,
) -> KindEntry<K> {
    KindEntry { name, kind: Some(kind), reads, ignores, instead: Some(instead) }
}

/// A kind that is not supported, whose parameters are not checked.
pub(super) const fn unsupported<K: Copy>(
    name: &'static str,
    instead: &'static str,
) -> KindEntry<K> {
    KindEntry { name, kind: None, reads: &[], ignores: &[], instead: Some(instead) }
}

impl<K: Copy> Directive<K> {
    fn entry(
        &'static self,
        name: &str,
        params: &Params,
    ) -> Result<&'static KindEntry<K>, SceneError> {
        self.kinds.iter().find(|entry| entry.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.kinds.iter().map(|entry| entry.name).collect();
            let hint = match hint(name, names.iter().copied()) {
                none if none.is_empty() => format!("; known are {}", names.join(", ")),
                hint => hint,
            };
            let found = format!("unknown {} \"{name}\"{hint}", self.name);
            SceneError::at(params.at.clone(), found, "")
        })
    }

    /// Returns whether the kind of this name reads a parameter.
    pub(super) fn reads_param(&self, kind: &str, param: &str) -> bool {
        let entry = self.kinds.iter().find(|entry| entry.name == kind);
        entry.is_some_and(|entry| self.reads(entry).any(|name| name == param))
    }

    /// Returns whether the kind of this name reads a parameter, or ignores it knowingly.
    pub(super) fn knows_param(&self, kind: &str, param: &str) -> bool {
        let entry = self.kinds.iter().find(|entry| entry.name == kind);
        let ignores = entry.is_some_and(|e| e.ignores.iter().any(|(name, _)| *name == param));
        ignores || self.reads_param(kind, param)
    }

    /// Returns the names of every parameter that a kind reads.
    fn reads(&self, entry: &KindEntry<K>) -> impl Iterator<Item = &'static str> {
        entry.reads.iter().chain(self.shared).copied()
    }

    /// Checks that every parameter is known. Calls `warn` for each one that is ignored, or unknown in
    /// a dialect that only warns.
    fn check_params(
        &self,
        entry: &KindEntry<K>,
        params: &Params,
        dialect: Dialect,
        mut warn: impl FnMut(&Param, &str),
    ) -> Result<(), SceneError> {
        for param in &params.all {
            let name = param.name.as_str();
            if self.reads(entry).any(|known| known == name) {
                continue;
            }
            if let Some((_, instead)) = entry.ignores.iter().find(|(ignored, _)| *ignored == name) {
                if *instead != SILENT {
                    warn(param, instead);
                }
                continue;
            }
            let names = self.reads(entry).chain(entry.ignores.iter().map(|(name, _)| *name));
            let hint = match hint(name, names) {
                none if none.is_empty() => {
                    let names: Vec<&str> = self.reads(entry).collect();
                    let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                    format!("; it reads {names}")
                }
                hint => hint,
            };
            if dialect.is_older() {
                warn(param, UNUSED);
                continue;
            }
            let found =
                format!("unknown parameter \"{name}\" of {} \"{}\"{hint}", self.name, entry.name);
            return Err(SceneError::at(param.at.clone(), found, ""));
        }
        Ok(())
    }
}

impl SceneReader {
    /// Reads the kind of a directive and its parameters, and [checks](Self::check_kind) them.
    pub(super) fn select<K: Copy>(
        &mut self,
        directive: &'static Directive<K>,
    ) -> Result<Selected<K>, SceneError> {
        let name = self.string()?;
        let params = self.params()?;
        self.check_kind(directive, &name, params)
    }

    /// Checks the kind of a directive and its parameters, to which it adds the defaults of
    /// `Attribute`. Warns of what is not supported.
    pub(super) fn check_kind<K: Copy>(
        &mut self,
        directive: &'static Directive<K>,
        name: &str,
        mut params: Params,
    ) -> Result<Selected<K>, SceneError> {
        let entry = directive.entry(name, &params)?;
        if let Some(target) = directive.target {
            self.add_defaults(
                target,
                |name| directive.reads(entry).any(|read| read == name),
                &mut params,
            );
        }
        let KindEntry { name, kind, .. } = *entry;
        if let Some(instead) = entry.instead.filter(|instead| *instead != SILENT) {
            let feature = format!("{} \"{name}\"", directive.name);
            self.warnings.unsupported(&params.at, &feature, instead);
        }
        if kind.is_some() {
            directive.check_params(entry, &params, self.dialect, |param, instead| {
                let feature = format!("\"{}\" of {} \"{name}\"", param.name, directive.name);
                self.warnings.unsupported(&param.at, &feature, instead);
            })?;
        }
        Ok(Selected { name, kind, params })
    }

    /// As [`Self::select`], but a kind that is not known is only a warning, or nothing if `instead`
    /// is [`SILENT`]: the picture does not depend on it, or has a substitute.
    pub(super) fn select_or<K: Copy>(
        &mut self,
        directive: &'static Directive<K>,
        instead: &str,
    ) -> Result<Selected<K>, SceneError> {
        let name = self.string()?;
        let params = self.params()?;
        if directive.kinds.iter().any(|entry| entry.name == name) {
            return self.check_kind(directive, &name, params);
        }
        if instead != SILENT {
            let hint = hint(&name, directive.kinds.iter().map(|entry| entry.name));
            let feature = format!("{} \"{name}\"", directive.name);
            self.warnings.unsupported(&params.at, &feature, &format!("{instead}{hint}"));
        }
        Ok(Selected { name: "", kind: None, params })
    }
}
