//! Names of settings in the library's messages, as options of the command.
//!
//! The library serves Rust, Python and the command, so its messages name a setting neutrally, in
//! single quotes and with underscores: `'film_diagonal'`. The command says `--film-diagonal`.

use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::LazyLock;

use clap::CommandFactory as _;

use super::Arguments;

/// Settings whose option has another name.
const OTHER_NAMES: [(&str, &str); 1] = [("distance", "focus")];

/// Long options of all subcommands, without dashes before them.
static OPTIONS: LazyLock<HashSet<String>> = LazyLock::new(|| {
    let mut names = HashSet::new();
    let mut commands = vec![Arguments::command()];
    while let Some(command) = commands.pop() {
        names.extend(command.get_arguments().filter_map(clap::Arg::get_long).map(str::to_owned));
        commands.extend(command.get_subcommands().cloned());
    }
    names
});

/// Returns a text in which each setting in single quotes is the option of the command. Other words in
/// quotes stay.
pub(super) fn with_option_names(text: &str) -> Cow<'_, str> {
    if !text.contains('\'') {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once('\'') {
        shown.push_str(before);
        match behind.split_once('\'').and_then(|(word, rest)| Some((option(word)?, rest))) {
            Some((option, behind)) => {
                shown.push_str("--");
                shown.push_str(&option);
                rest = behind;
            }
            None => {
                shown.push('\'');
                rest = behind;
            }
        }
    }
    shown.push_str(rest);
    Cow::Owned(shown)
}

/// Returns the option of a setting, without dashes before it.
fn option(setting: &str) -> Option<String> {
    let is_name = |c: char| c.is_ascii_lowercase() || c == '_';
    if setting.is_empty() || !setting.chars().all(is_name) {
        return None;
    }
    let other = OTHER_NAMES.iter().find(|(name, _)| *name == setting).map(|(_, option)| *option);
    let option = other.unwrap_or(setting).replace('_', "-");
    OPTIONS.contains(&option).then_some(option)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_become_options_and_other_words_stay() {
        let said = |text| with_option_names(text).into_owned();
        assert_eq!(said("'film_diagonal' 30mm fits"), "--film-diagonal 30mm fits");
        assert_eq!(said("'noise' and 'time' need 16"), "--noise and --time need 16");
        assert_eq!(said("an object with 'distance'"), "an object with --focus");
        for plain in
            ["missing field `draw`", "'nonsense' stays", "the lens's 'two words'", "''", ""]
        {
            assert_eq!(said(plain), plain);
        }
        assert_eq!(said("the file's 'x' and 'zoom'"), "the file's 'x' and --zoom");
    }
}
