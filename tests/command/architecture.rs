//! Rules of the source tree: imports between modules form no cycle, the name of a type means one thing,
//! folders of modules hold a `mod.rs`, and no test or benchmark includes sources of the crate.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn imports_between_top_level_modules_form_no_cycle() {
    let mut imports = Imports::default();
    for file in Source::all("src") {
        imports.add(&file);
    }
    assert!(imports.0.len() > 10, "{imports:?}");
    if let Some(cycle) = imports.cycle() {
        panic!("modules import each other:\n{}", imports.describe(&cycle));
    }
}

#[test]
fn the_name_of_a_type_means_one_thing() {
    let repeated = repeated_types(&Source::all("src"));
    assert!(repeated.is_empty(), "types of one name:\n{}", repeated.join("\n"));
}

#[test]
fn folders_of_modules_hold_a_mod_rs() {
    let beside: Vec<PathBuf> =
        files("src").into_iter().filter(|path| path.with_extension("").is_dir()).collect();
    assert!(beside.is_empty(), "move each to mod.rs of the folder beside it: {beside:?}");
}

#[test]
fn no_test_or_benchmark_includes_sources_of_the_crate() {
    let included: Vec<String> = ["tests", "benches", "examples"]
        .into_iter()
        .flat_map(files)
        .flat_map(|path| {
            let included = included_sources(&tokens(&read(&path)));
            included.into_iter().map(move |name| format!("{}: {name}", path.display()))
        })
        .collect();
    assert!(included.is_empty(), "import from the library instead:\n{}", included.join("\n"));
}

/// Files that may write without [`petzval::io::OutputFile`], and why.
const WRITERS: [(&str, &str); 8] = [
    ("src/io/output.rs", "the owner of outputs"),
    ("src/io/replace.rs", "the owner's atomic replacement of files"),
    ("src/cli/bench/files.rs", "writes into a temporary folder that it makes"),
    ("src/cli/denoise/mod.rs", "writes into a temporary folder that it makes"),
    ("src/cli/denoise/process.rs", "writes the log of a program into that folder"),
    ("src/cli/signals.rs", "removes temporary folders"),
    ("src/cli/view/frame.rs", "writes into a temporary folder that it makes"),
    ("python/src/lens.rs", "writes a lens into a temporary file that it makes"),
];

#[test]
fn files_are_written_past_the_check_of_outputs() {
    let python = files("python/src").into_iter();
    let python = python.map(|path| (without_tests(&tokens(&read(&path))).0, path));
    let sources = Source::all("src").into_iter().map(|source| (source.tokens, source.path));
    let mut found = BTreeMap::new();
    for (tokens, path) in sources.chain(python) {
        let writes = writes(&tokens);
        if !writes.is_empty() {
            found.insert(path, writes);
        }
    }
    let owners = WRITERS.map(|(path, _)| PathBuf::from(path));
    let strangers: Vec<_> = found.iter().filter(|(path, _)| !owners.contains(path)).collect();
    assert!(strangers.is_empty(), "write by OutputFile of petzval::io instead: {strangers:?}");
    let idle: Vec<_> = owners.iter().filter(|path| !found.contains_key(*path)).collect();
    assert!(idle.is_empty(), "remove from WRITERS, as they write nothing: {idle:?}");
}

/// Texts that hold options of other programs.
const OPTIONS_OF_OTHERS: [&str; 1] = ["nanovdb_convert --zip"];

/// Messages of the library reach Rust and Python too, where no setting has dashes before its name: they
/// name it in single quotes, and the command translates that.
#[test]
fn options_of_the_command_are_named_by_the_command_alone() {
    let library = Source::all("src").into_iter().filter(|source| {
        ["src/cli", "src/cpu", "src/main.rs"].iter().all(|own| !source.path.starts_with(own))
    });
    let python = files("python/src").into_iter();
    let python = python.map(|path| (without_tests(&tokens(&read(&path))).0, path));
    let mut found = Vec::new();
    for (tokens, path) in library.map(|source| (source.tokens, source.path)).chain(python) {
        let texts = tokens.iter().filter_map(|token| match token {
            Text(text) if has_option(text) => Some(format!("{}: {text:?}", path.display())),
            _ => None,
        });
        found.extend(texts);
    }
    found.retain(|text| !OPTIONS_OF_OTHERS.iter().any(|option| text.contains(option)));
    assert!(found.is_empty(), "name settings as 'focus' instead:\n{}", found.join("\n"));
}

/// Returns whether a text holds two dashes and a letter, but no longer row of dashes.
fn has_option(text: &str) -> bool {
    let bytes = text.as_bytes();
    (0..bytes.len()).any(|i| {
        bytes[i..].starts_with(b"--")
            && bytes.get(i + 2).is_some_and(u8::is_ascii_lowercase)
            && (i == 0 || bytes[i - 1] != b'-')
    })
}

/// Returns the calls of the system that write, rename or remove files, and outputs that know no inputs.
fn writes(tokens: &[Token]) -> Vec<String> {
    const OF_FS: [&str; 6] =
        ["write", "rename", "copy", "hard_link", "remove_file", "remove_dir_all"];
    const OF_FILE: [&str; 3] = ["create", "create_new", "options"];
    const ALONE: [&str; 4] = ["OpenOptions", "NamedTempFile", "tempfile_in", "without_inputs"];
    let mut found = Vec::new();
    for (i, token) in tokens.iter().enumerate() {
        let Word(word) = token else { continue };
        if ALONE.contains(&word.as_str()) {
            found.push(word.clone());
        }
        let members: &[&str] = match word.as_str() {
            "fs" => &OF_FS,
            "File" => &OF_FILE,
            _ => continue,
        };
        if tokens.get(i + 1..i + 3) != Some(&[Mark(':'), Mark(':')]) {
            continue;
        }
        let end = match tokens.get(i + 3) {
            Some(Mark('{')) => behind_bracket(tokens, i + 3),
            _ => tokens.len().min(i + 4),
        };
        let used = tokens[i + 3..end].iter().filter_map(|token| match token {
            Word(used) if members.contains(&used.as_str()) => Some(format!("{word}::{used}")),
            _ => None,
        });
        found.extend(used);
    }
    found
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(root().join(path)).expect("a source file")
}

/// Returns the Rust files of a folder and its subfolders, relative to the root of the repository.
fn files(folder: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path.strip_prefix(root()).expect("a path in the repository").into());
            }
        }
    }
    found.sort();
    found
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    /// An identifier, a keyword or a number.
    Word(String),
    /// The content of a string literal.
    Text(String),
    Mark(char),
}

use Token::{Mark, Text, Word};

fn is_word(token: Option<&Token>, expected: &str) -> bool {
    matches!(token, Some(Word(word)) if word == expected)
}

/// Splits Rust source into tokens, without comments, lifetimes and characters.
fn tokens(source: &str) -> Vec<Token> {
    let chars: Vec<char> = source.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < chars.len() {
        match at(i) {
            '/' if at(i + 1) == '/' => {
                while i < chars.len() && at(i) != '\n' {
                    i += 1;
                }
            }
            '/' if at(i + 1) == '*' => {
                let mut depth = 0;
                loop {
                    match (at(i), at(i + 1)) {
                        ('/', '*') => (depth, i) = (depth + 1, i + 2),
                        ('*', '/') => (depth, i) = (depth - 1, i + 2),
                        _ => i += 1,
                    }
                    if depth == 0 || i >= chars.len() {
                        break;
                    }
                }
            }
            '"' => {
                let begin = i + 1;
                i += 1;
                while i < chars.len() && at(i) != '"' {
                    i += if at(i) == '\\' { 2 } else { 1 };
                }
                tokens.push(Text(chars[begin..i.min(chars.len())].iter().collect()));
                i += 1;
            }
            '\'' if at(i + 1) == '\\' => {
                i += 3;
                while i < chars.len() && at(i) != '\'' {
                    i += 1;
                }
                i += 1;
            }
            '\'' => i += if at(i + 2) == '\'' { 3 } else { 1 },
            c if c.is_alphanumeric() || c == '_' => {
                let begin = i;
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
                let word: String = chars[begin..i].iter().collect();
                let hashes = (i..).take_while(|&j| at(j) == '#').count();
                let is_raw = ["r", "br", "cr"].contains(&word.as_str());
                if is_raw && at(i + hashes) == '"' {
                    let begin = i + hashes + 1;
                    let ends = |&j: &usize| at(j) == '"' && (1..=hashes).all(|k| at(j + k) == '#');
                    let end = (begin..chars.len()).find(ends).unwrap_or(chars.len());
                    tokens.push(Text(chars[begin..end].iter().collect()));
                    i = end + hashes + 1;
                } else if !(["b", "c"].contains(&word.as_str()) && at(i) == '"') {
                    tokens.push(Word(word));
                }
            }
            c => {
                if !c.is_whitespace() {
                    tokens.push(Mark(c));
                }
                i += 1;
            }
        }
    }
    tokens
}

/// Returns the index behind the bracket that closes the one at `open`.
fn behind_bracket(tokens: &[Token], open: usize) -> usize {
    let mut depth = 0;
    for (i, token) in tokens.iter().enumerate().skip(open) {
        match token {
            Mark('(' | '[' | '{') => depth += 1,
            Mark(')' | ']' | '}') => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    tokens.len()
}

/// Removes the items that are compiled for tests only. Also returns the names of their modules that
/// stand in files.
fn without_tests(tokens: &[Token]) -> (Vec<Token>, Vec<String>) {
    let (mut kept, mut modules) = (Vec::new(), Vec::new());
    let mut i = 0;
    while i < tokens.len() {
        let is_attribute = tokens[i] == Mark('#') && tokens.get(i + 1) == Some(&Mark('['));
        let end = if is_attribute { behind_bracket(tokens, i + 1) } else { i + 1 };
        let has = |word| tokens[i..end].iter().any(|token| is_word(Some(token), word));
        if !(is_attribute && is_word(tokens.get(i + 2), "cfg") && has("test") && !has("not")) {
            kept.extend_from_slice(&tokens[i..end]);
            i = end;
            continue;
        }
        i = end;
        while i < tokens.len() {
            match &tokens[i] {
                Mark('{') => {
                    i = behind_bracket(tokens, i);
                    break;
                }
                Mark('(' | '[') => i = behind_bracket(tokens, i),
                Mark(';') => {
                    if let [Word(keyword), Word(name)] = &tokens[i - 2..i]
                        && keyword == "mod"
                    {
                        modules.push(name.clone());
                    }
                    i += 1;
                    break;
                }
                _ => i += 1,
            }
        }
    }
    (kept, modules)
}

/// A file of the library, without its tests.
struct Source {
    path: PathBuf,
    /// Names of the module and of those around it, from the top.
    module: Vec<String>,
    tokens: Vec<Token>,
}

impl Source {
    fn new(path: &Path, text: &str) -> (Self, Vec<PathBuf>) {
        let relative = path.strip_prefix("src").expect("a file of src").with_extension("");
        let names = relative.components().map(|name| name.as_os_str().to_string_lossy().into());
        let mut module: Vec<String> = names.collect();
        if ["mod", "lib", "main"].contains(&module[module.len() - 1].as_str()) {
            module.pop();
        }
        let (tokens, tests) = without_tests(&tokens(text));
        let folder = Path::new("src").join(module.iter().collect::<PathBuf>());
        let tests = tests.into_iter().map(|name| folder.join(name)).collect();
        (Self { path: path.into(), module, tokens }, tests)
    }

    /// Reads all files but those of tests.
    fn all(folder: &str) -> Vec<Self> {
        let read = |path: &PathBuf| Self::new(path, &read(path));
        let (sources, tests): (Vec<Self>, Vec<_>) = files(folder).iter().map(read).unzip();
        let tests: Vec<PathBuf> = tests.concat();
        let is_test =
            |path: &Path| tests.iter().any(|test| path.with_extension("").starts_with(test));
        sources.into_iter().filter(|source| !is_test(&source.path)).collect()
    }

    /// Returns the names behind paths to the root of the crate: `crate::`, and `super::` often enough.
    fn root_names(&self) -> Vec<String> {
        let mut names = Vec::new();
        let tokens = &self.tokens;
        let separates = |i: usize| tokens.get(i..i + 2) == Some(&[Mark(':'), Mark(':')]);
        for i in 0..tokens.len() {
            let mut behind = i + 3;
            if is_word(tokens.get(i), "super") && !(i > 1 && separates(i - 2)) && separates(i + 1) {
                let mut supers = 1;
                while is_word(tokens.get(behind), "super") && separates(behind + 1) {
                    (supers, behind) = (supers + 1, behind + 3);
                }
                if supers != self.module.len() {
                    continue;
                }
            } else if !(is_word(tokens.get(i), "crate") && separates(i + 1)) {
                continue;
            }
            match tokens.get(behind) {
                // Macros stand at the root wherever they are defined.
                Some(Word(name)) if tokens.get(behind + 1) != Some(&Mark('!')) => {
                    names.push(name.clone());
                }
                Some(Mark('{')) => {
                    let end = behind_bracket(tokens, behind);
                    let mut j = behind + 1;
                    while j < end {
                        if let Word(name) = &tokens[j] {
                            names.push(name.clone());
                        }
                        while j < end && tokens[j] != Mark(',') {
                            j = match tokens[j] {
                                Mark('{') => behind_bracket(tokens, j),
                                _ => j + 1,
                            };
                        }
                        j += 1;
                    }
                }
                _ => {}
            }
        }
        names
    }
}

/// Which top-level modules a top-level module imports, each with a file that does.
#[derive(Debug, Default)]
struct Imports(BTreeMap<String, BTreeMap<String, PathBuf>>);

impl Imports {
    fn add(&mut self, source: &Source) {
        let Some(module) = source.module.first() else { return };
        let imported = self.0.entry(module.clone()).or_default();
        for name in source.root_names() {
            if name != *module {
                imported.entry(name).or_insert_with(|| source.path.clone());
            }
        }
    }

    /// Returns the modules of a cycle, the first again at the end.
    fn cycle(&self) -> Option<Vec<String>> {
        let mut done = BTreeSet::new();
        self.0.keys().find_map(|module| self.cycle_from(module, &mut Vec::new(), &mut done))
    }

    fn cycle_from<'a>(
        &'a self,
        module: &'a String,
        way: &mut Vec<&'a String>,
        done: &mut BTreeSet<&'a String>,
    ) -> Option<Vec<String>> {
        if let Some(begin) = way.iter().position(|earlier| *earlier == module) {
            return Some(
                way[begin..].iter().chain([&module]).map(|name| (*name).clone()).collect(),
            );
        }
        if !done.contains(module) {
            way.push(module);
            for imported in self.0.get(module).into_iter().flat_map(BTreeMap::keys) {
                if let Some(cycle) = self.cycle_from(imported, way, done) {
                    return Some(cycle);
                }
            }
            way.pop();
            done.insert(module);
        }
        None
    }

    fn describe(&self, cycle: &[String]) -> String {
        let line = |pair: &[String]| {
            format!("{} imports {}, in {}", pair[0], pair[1], self.0[&pair[0]][&pair[1]].display())
        };
        cycle.windows(2).map(line).collect::<Vec<_>>().join("\n")
    }
}

/// Returns a line for each name that two types have which are visible outside of their modules.
fn repeated_types(sources: &[Source]) -> Vec<String> {
    let mut found: BTreeMap<&str, Vec<&Path>> = BTreeMap::new();
    for source in sources {
        for i in 0..source.tokens.len() {
            if !is_word(source.tokens.get(i), "pub") {
                continue;
            }
            let restricted = source.tokens.get(i + 1) == Some(&Mark('('));
            let next = if restricted { behind_bracket(&source.tokens, i + 1) } else { i + 1 };
            if let Some([Word(kind), Word(name)]) = source.tokens.get(next..next + 2)
                && ["struct", "enum", "union", "trait", "type"].contains(&kind.as_str())
            {
                found.entry(name).or_default().push(&source.path);
            }
        }
    }
    found.retain(|_, paths| paths.len() > 1);
    found.into_iter().map(|(name, paths)| format!("{name}: {paths:?}")).collect()
}

/// Returns the files of `src` that `#[path = "..."]` names.
fn included_sources(tokens: &[Token]) -> Vec<String> {
    let named = tokens.windows(3).filter_map(|three| match three {
        [Word(word), Mark('='), Text(path)] if word == "path" => Some(path.clone()),
        _ => None,
    });
    named.filter(|path| path.split('/').any(|part| part == "src")).collect()
}

mod checkers {
    use super::*;

    fn source(path: &str, text: &str) -> Source {
        Source::new(Path::new(path), text).0
    }

    fn cycle(files: &[(&str, &str)]) -> Option<String> {
        let mut imports = Imports::default();
        files.iter().for_each(|(path, text)| imports.add(&source(path, text)));
        imports.cycle().map(|cycle| cycle.join(" "))
    }

    #[test]
    fn tokens_leave_comments_and_literals_apart() {
        let text = r###"a /* b /* c */ d */ 'e' '\'' 'f g // h
            "i \" j" r#"k " l"# b"m" br"n" 0x1F"###;
        let text_of = |text: &str| Text(text.to_owned());
        let word = |text: &str| Word(text.to_owned());
        let expected = [
            word("a"),
            word("f"),
            word("g"),
            text_of("i \\\" j"),
            text_of("k \" l"),
            text_of("m"),
            text_of("n"),
            word("0x1F"),
        ];
        assert_eq!(tokens(text), expected);
    }

    #[test]
    fn a_cycle_is_found_in_every_form_of_path() {
        for import in [
            "use crate::b;",
            "use crate::b::Item;",
            "use crate::{c, b::{self, Item}};",
            "use crate::{c::{d, e}, b};",
            "fn f() -> crate::b::Item { todo!() }",
            "use super::b::Item;",
            "use super::{c, b::Item};",
        ] {
            let files = [("src/a/mod.rs", import), ("src/b.rs", "use crate::a::Item;")];
            assert_eq!(cycle(&files).as_deref(), Some("a b a"), "{import}");
        }
        let deep = [("src/a/x/y.rs", "use super::super::super::b;"), ("src/b.rs", "use crate::a;")];
        assert_eq!(cycle(&deep).as_deref(), Some("a b a"));
        let long = [
            ("src/a.rs", "use crate::b;"),
            ("src/b.rs", "use crate::c; use crate::d;"),
            ("src/c.rs", ""),
            ("src/d.rs", "use crate::b;"),
        ];
        assert_eq!(cycle(&long).as_deref(), Some("b d b"));
    }

    #[test]
    fn no_cycle_is_found_where_there_is_none() {
        for import in [
            "use crate::a::Item;",
            "// use crate::b;",
            "/// [`crate::b::Item`]",
            "const TEXT: &str = \"crate::b\";",
            "#[cfg(test)] mod tests { use crate::b; }",
            "#[cfg(test)] use crate::b::Item;",
            "#[cfg(all(test, unix))] #[allow(unused)] mod tests { fn f() { use crate::b; } }",
            "pub(crate) fn b() {}",
            "mod inner { use super::b; }  fn f() { self::b::g() }",
            "crate::b!();",
        ] {
            let files = [("src/a/x.rs", import), ("src/b.rs", "use crate::a;")];
            assert_eq!(cycle(&files), None, "{import}");
        }
        let (_, tests) = Source::new(Path::new("src/a/mod.rs"), "#[cfg(test)]\nmod tests;");
        assert_eq!(tests, [Path::new("src/a/tests")]);
        let kept = source("src/a.rs", "#[cfg(not(test))] use crate::b;");
        assert_eq!(kept.root_names(), ["b"]);
    }

    #[test]
    fn a_cycle_is_described_by_its_files() {
        let mut imports = Imports::default();
        imports.add(&source("src/a/x.rs", "use crate::b;"));
        imports.add(&source("src/b.rs", "use crate::a;"));
        let text = imports.describe(&imports.cycle().expect("a cycle"));
        assert_eq!(text, "a imports b, in src/a/x.rs\nb imports a, in src/b.rs");
    }

    #[test]
    fn a_name_of_two_types_is_found() {
        let of = |one: &str, other: &str| {
            repeated_types(&[source("src/a.rs", one), source("src/b/mod.rs", other)])
        };
        let expected = [r#"Item: ["src/a.rs", "src/b/mod.rs"]"#];
        for other in [
            "pub enum Item {}",
            "pub(crate) trait Item {}",
            "pub(in crate::b) type Item = u8;",
            "pub(super) struct Item<T>(T);",
        ] {
            assert_eq!(of("pub struct Item;", other), expected, "{other}");
        }
        for other in ["struct Item;", "pub fn Item() {}", "#[cfg(test)] pub struct Item;"] {
            assert!(of("pub struct Item;", other).is_empty(), "{other}");
        }
    }

    #[test]
    fn a_write_is_found_in_every_form() {
        for text in [
            "std::fs::write(path, text)",
            "use std::fs::{self, File, rename};",
            "fs::remove_file(path)",
            "File::create(path)",
            "fs::File::options()",
            "OpenOptions::new()",
            "Outputs::without_inputs()",
            "tempfile::tempfile_in(folder)",
        ] {
            assert_eq!(writes(&tokens(text)).len(), 1, "{text}");
        }
        for text in ["fs::read(path)", "file.write(fill)", "// fs::write", "\"File::create\""] {
            assert!(writes(&tokens(text)).is_empty(), "{text}");
        }
    }

    #[test]
    fn an_included_source_is_found() {
        let included = |text: &str| included_sources(&tokens(text));
        assert_eq!(included("#[path = \"../src/cli/plot.rs\"] mod plot;"), ["../src/cli/plot.rs"]);
        assert!(included("#[path = \"fuzz/readers.rs\"] mod readers;").is_empty());
        assert!(included("// #[path = \"../src/a.rs\"]").is_empty());
    }
}
