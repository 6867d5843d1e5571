//! Which file of the crates imports from which, read from the text: `use` declarations, and paths within code. The first folder of a
//! file's name is its crate.
//!
//! A path leads to the file of the deepest module that it names. What a folder's `mod.rs` re-exports is an import from that
//! `mod.rs`, and `mod.rs` imports from the files whose items it re-exports. Tests within files are left out.

use std::collections::{BTreeMap, BTreeSet};

/// A module, as the names from its crate on.
type Module = Vec<String>;

/// The files of the crates, and what each imports from the others.
pub(crate) struct Imports {
    /// Paths that begin with the crate.
    pub(crate) files: Vec<String>,
    /// For each file, those that it imports from, by their place in `files`.
    pub(crate) imported: Vec<BTreeSet<usize>>,
}

impl Imports {
    /// Reads the imports of files that are given as paths and their texts.
    pub(crate) fn read(sources: &[(String, String)]) -> Self {
        let modules: BTreeMap<Module, usize> =
            sources.iter().enumerate().map(|(at, (name, _))| (module_of(name), at)).collect();
        let imported = sources.iter().enumerate().map(|(at, (name, text))| {
            let paths = paths_in(&tokens(super::untested(text)));
            let mut files = files_of(&module_of(name), &paths, &modules);
            files.remove(&at);
            files
        });
        Self { files: sources.iter().map(|(name, _)| name.clone()).collect(), imported: imported.collect() }
    }

    /// The files of every circle of imports, the longest first.
    pub(crate) fn circles(&self) -> Vec<Vec<&str>> {
        let reached: Vec<BTreeSet<usize>> =
            (0..self.files.len()).map(|file| self.reached_from(file)).collect();
        let mut circles = BTreeSet::new();
        for file in 0..self.files.len() {
            let circle: Vec<&str> = reached[file]
                .iter()
                .filter(|other| reached[**other].contains(&file))
                .map(|other| self.files[*other].as_str())
                .collect();
            if circle.len() > 1 {
                circles.insert(circle);
            }
        }
        let mut circles: Vec<_> = circles.into_iter().collect();
        circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
        circles
    }

    /// The circles between neighbors, the files and folders that lie in one folder. A folder imports what any of its files imports from
    /// outside of it. A folder's own `mod.rs` is no neighbor of what it holds.
    pub(crate) fn circles_of_neighbors(&self) -> Vec<Vec<String>> {
        let mut edges: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        let pairs: Vec<_> =
            self.pairs().map(|(file, imported)| (by_layer(file), by_layer(imported))).collect();
        for (file, imported) in &pairs {
            if let Some((from, to)) = neighbors(file, imported) {
                edges.entry(from).or_default().insert(to);
            }
        }
        let reached = |start: &str| {
            let mut reached: BTreeSet<&str> = BTreeSet::new();
            let mut open: Vec<&str> = edges.get(start).into_iter().flatten().copied().collect();
            while let Some(next) = open.pop() {
                if reached.insert(next) {
                    open.extend(edges.get(next).into_iter().flatten());
                }
            }
            reached
        };
        let all: BTreeMap<&str, BTreeSet<&str>> =
            edges.keys().map(|start| (*start, reached(start))).collect();
        let circle_of = |start: &str| -> Vec<String> {
            let others =
                all.iter().filter(|(other, back)| all[start].contains(*other) && back.contains(start));
            others.map(|(other, _)| (*other).to_owned()).collect()
        };
        let circles: BTreeSet<Vec<String>> =
            all.keys().map(|start| circle_of(start)).filter(|circle| circle.len() > 1).collect();
        circles.into_iter().collect()
    }

    /// All files that a file imports from, directly or through others; itself only if it lies on a circle.
    fn reached_from(&self, file: usize) -> BTreeSet<usize> {
        let mut reached = BTreeSet::new();
        let mut open: Vec<usize> = self.imported[file].iter().copied().collect();
        while let Some(next) = open.pop() {
            if reached.insert(next) {
                open.extend(&self.imported[next]);
            }
        }
        reached
    }

    /// Every import as a pair of names: who imports, and from whom.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.iter().zip(&self.imported).flat_map(move |(file, imported)| {
            imported.iter().map(move |other| (file.as_str(), self.files[*other].as_str()))
        })
    }
}

/// A file of the window by its layer: `rooms/live/work/image.rs` as `work/live image.rs`. Rooms are features. What is known (`state`) and asked
/// (`mod.rs`), computed (`work`), changed (`control`, or files named by an idea) and drawn (`ui`) are layers, which run through all of them.
pub(crate) fn by_layer(file: &str) -> String {
    let place = file.strip_prefix("desk/app/rooms/").and_then(|rest| rest.split_once('/'));
    let Some((room, rest)) = place else { return file.to_owned() };
    let role = rest.split(['/', '.']).next().unwrap_or_default();
    let layer = match role {
        "state" | "mod" => "model",
        "work" | "ui" => role,
        _ => "control",
    };
    format!("desk/app/{layer}/{room} {}", rest.replace('/', " "))
}

/// What of two files' paths lies in the deepest folder that holds both; `None` where one of them is that folder's `mod.rs` or `lib.rs`,
/// or both are one.
fn neighbors<'a>(file: &'a str, other: &'a str) -> Option<(&'a str, &'a str)> {
    let shared = file.split('/').zip(other.split('/')).take_while(|(a, b)| a == b);
    let length: usize = shared.map(|(name, _)| name.len() + 1).sum();
    let within = |path: &'a str| {
        let rest = path.get(length..)?;
        let end = rest.find('/').map_or(path.len(), |at| length + at);
        (!["mod.rs", "lib.rs", "main.rs"].contains(&rest)).then_some(&path[..end])
    };
    Some((within(file)?, within(other)?))
}

fn module_of(file: &str) -> Module {
    let path = file.trim_end_matches(".rs");
    let path = path.strip_suffix("/mod").or(path.strip_suffix("/lib")).unwrap_or(path);
    path.split('/').map(str::to_owned).collect()
}

/// A path in code, and whether a `use` declaration brings its last name into scope under which name.
struct CodePath {
    segments: Vec<String>,
    brought: Option<String>,
}

/// Names, `::` and single marks, without comments, texts and letters in quotes.
fn tokens(code: &str) -> Vec<String> {
    let letters: Vec<char> = code.chars().collect();
    let at = |place: usize| letters.get(place).copied().unwrap_or(' ');
    let is_name = |letter: char| letter.is_alphanumeric() || letter == '_';
    let (mut tokens, mut place) = (Vec::new(), 0);
    while place < letters.len() {
        let begin = place;
        match at(place) {
            '/' if at(place + 1) == '/' => {
                while place < letters.len() && at(place) != '\n' {
                    place += 1;
                }
            }
            '"' => {
                place += 1;
                while place < letters.len() && at(place) != '"' {
                    place += if at(place) == '\\' { 2 } else { 1 };
                }
                place += 1;
            }
            '\'' if at(place + 1) == '\\' => {
                place += 3;
                while place < letters.len() && at(place) != '\'' {
                    place += 1;
                }
                place += 1;
            }
            '\'' if at(place + 2) == '\'' => place += 3,
            ':' if at(place + 1) == ':' => {
                tokens.push("::".to_owned());
                place += 2;
            }
            letter if is_name(letter) => {
                while is_name(at(place)) {
                    place += 1;
                }
                tokens.push(letters[begin..place].iter().collect());
            }
            letter => {
                if !letter.is_whitespace() {
                    tokens.push(letter.to_string());
                }
                place += 1;
            }
        }
    }
    tokens
}

fn paths_in(tokens: &[String]) -> Vec<CodePath> {
    let is_name = |token: &str| token.starts_with(|c: char| c.is_alphabetic() || c == '_');
    let (mut paths, mut place) = (Vec::new(), 0);
    while place < tokens.len() {
        let token = tokens[place].as_str();
        // `use<'a>` in a type says what it borrows.
        if token == "use" && tokens.get(place + 1).is_some_and(|next| next != "<") {
            place = use_tree(tokens, place + 1, &[], &mut paths);
        } else if is_name(token)
            && tokens.get(place + 1).is_some_and(|next| next == "::")
            && !(place > 0 && tokens[place - 1] == "::")
        {
            let mut segments = vec![token.to_owned()];
            while tokens.get(place + 1).is_some_and(|next| next == "::")
                && tokens.get(place + 2).is_some_and(|next| is_name(next))
            {
                segments.push(tokens[place + 2].clone());
                place += 2;
            }
            paths.push(CodePath { segments, brought: None });
            place += 1;
        } else {
            place += 1;
        }
    }
    paths
}

/// Reads one tree of a `use` declaration and gives the place behind it.
fn use_tree(tokens: &[String], mut place: usize, above: &[String], paths: &mut Vec<CodePath>) -> usize {
    let mut segments = above.to_vec();
    let mut name = None;
    while let Some(token) = tokens.get(place) {
        match token.as_str() {
            "::" => place += 1,
            "{" => {
                place += 1;
                while tokens.get(place).is_some_and(|token| token != "}" && token != ";") {
                    place = use_tree(tokens, place, &segments, paths);
                    if tokens.get(place).is_some_and(|token| token == ",") {
                        place += 1;
                    }
                }
                return place + 1;
            }
            "as" => {
                name = tokens.get(place + 1).cloned();
                place += 2;
            }
            "," | "}" | ";" => break,
            "self" if segments.len() > above.len() || !above.is_empty() => place += 1,
            word => {
                segments.push(word.to_owned());
                place += 1;
            }
        }
    }
    let brought = name.or_else(|| segments.last().cloned());
    paths.push(CodePath { segments, brought });
    place
}

/// The files that paths in a module's file lead to.
fn files_of(module: &Module, paths: &[CodePath], modules: &BTreeMap<Module, usize>) -> BTreeSet<usize> {
    let mut aliases: BTreeMap<&str, Module> = BTreeMap::new();
    let mut files = BTreeSet::new();
    // Names that declarations bring into scope are known before the paths that begin with them.
    for uses_first in [true, false] {
        for path in paths.iter().filter(|path| path.brought.is_some() == uses_first) {
            let Some((deepest, whole)) = deepest_module(module, &path.segments, &aliases, modules) else {
                continue;
            };
            files.insert(modules[&deepest]);
            if let (true, Some(name)) = (whole, &path.brought) {
                aliases.insert(name, deepest);
            }
        }
    }
    files
}

/// The crate that other crates know by a name, as the first folder of its files' names.
fn crate_of(name: &str) -> Option<String> {
    let known = [("overlook_engine", "engine"), ("overlook_lab", "lab"), ("overlook", "desk")];
    known.iter().find(|(library, _)| *library == name).map(|(_, folder)| (*folder).to_owned())
}

/// The deepest module on a path, and whether the path names nothing within it; `None` where it leads out of the crate.
fn deepest_module(
    module: &Module,
    segments: &[String],
    aliases: &BTreeMap<&str, Module>,
    modules: &BTreeMap<Module, usize>,
) -> Option<(Module, bool)> {
    let first = segments.first()?.as_str();
    let child = || [module.as_slice(), &segments[..1]].concat();
    let (mut current, mut rest) = match first {
        "crate" => (module[..1].to_vec(), &segments[1..]),
        _ if crate_of(first).is_some() => (crate_of(first).into_iter().collect(), &segments[1..]),
        "self" => (module.clone(), &segments[1..]),
        "super" => (module.clone(), segments),
        _ if modules.contains_key(&child()) => (child(), &segments[1..]),
        _ => (aliases.get(first)?.clone(), &segments[1..]),
    };
    while rest.first().is_some_and(|segment| segment == "super") {
        current.pop();
        rest = &rest[1..];
    }
    while let Some(segment) = rest.first() {
        current.push(segment.clone());
        if !modules.contains_key(&current) {
            current.pop();
            break;
        }
        rest = &rest[1..];
    }
    modules.contains_key(&current).then_some((current, rest.is_empty()))
}
