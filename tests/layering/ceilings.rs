//! How large the crates may be: `ceilings.toml` has the most lines of each folder and of each room of the window, and the most imports
//! between rooms. `OVERLOOK_WRITE_CEILINGS=1 cargo test --test layering` writes that file anew.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Names of rows and their numbers.
type Rows = BTreeMap<String, usize>;

/// Where each room of the window lies, in a folder or a file of its name.
const ROOMS: &str = "desk/app/rooms/";

/// A shorter file holds less than an idea. The root of a crate may be shorter.
const MIN_LINES: usize = 20;

/// Numbers of lines are written as the next multiple of this.
const STEP: usize = 20;

/// How far a row may stand above what is there: a share, and lines or pieces beside it.
const SLACK: (f64, usize, usize) = (0.03, 40, 3);

/// What stands above the rows in their file.
const HEAD: &str = "\
# The most lines of Rust of each folder and room, and the most of what ties rooms together: `tests/layering` compares them.
# `OVERLOOK_WRITE_CEILINGS=1 cargo test --test layering` writes them anew. A commit that raises a row says so in its title.
";

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/layering/ceilings.toml")
}

fn is_written_anew() -> bool {
    std::env::var_os("OVERLOOK_WRITE_CEILINGS").is_some_and(|value| value == "1")
}

/// The rows of lines that a file counts for: the whole, its folder of the crate, and its room.
fn rows_of(file: &str) -> Vec<String> {
    let (home, rest) = file.split_once('/').unwrap_or((file, ""));
    let folder = rest.split_once('/').map_or("*.rs", |(folder, _)| folder);
    let room = room_of(file).map(|room| format!("{ROOMS}{room}"));
    [Some("src".to_owned()), Some(format!("{home}/{folder}")), room].into_iter().flatten().collect()
}

/// The room that a file belongs to.
fn room_of(file: &str) -> Option<&str> {
    let name = file.strip_prefix(ROOMS)?.split(['/', '.']).next()?;
    (name != "mod").then_some(name)
}

/// The rooms that a file imports from: it names them behind `rooms::` or as a neighbor of its own folder.
fn rooms_named(file: &str, text: &str, rooms: &BTreeSet<&str>) -> BTreeSet<String> {
    let is_name = |letter: char| letter.is_ascii_lowercase() || letter == '_';
    let name_at = |text: &str| text[..text.find(|c| !is_name(c)).unwrap_or(text.len())].to_owned();
    let mut named = BTreeSet::new();
    for (at, start) in text.match_indices("rooms::") {
        let rest = &text[at + start.len()..];
        match rest.strip_prefix('{').and_then(|group| group.split(';').next()) {
            Some(group) => named.extend(group.split(|c| !is_name(c)).map(str::to_owned)),
            None => _ = named.insert(name_at(rest)),
        }
    }
    // As many `super` as lead to the folder of all rooms.
    let depth = file[ROOMS.len()..].split('/').count() - usize::from(file.ends_with("/mod.rs"));
    let up = "super::".repeat(depth);
    named.extend(text.match_indices(&up).map(|(at, _)| name_at(&text[at + up.len()..])));
    named.retain(|name| rooms.contains(name.as_str()) && Some(name.as_str()) != room_of(file));
    named
}

/// What `sources` have, row by row.
fn measured(sources: &[(String, String)]) -> Rows {
    let mut rows = Rows::new();
    let mut arrows = BTreeSet::new();
    let rooms: BTreeSet<&str> = sources.iter().filter_map(|(file, _)| room_of(file)).collect();
    let (mut files, mut short) = (0, 0);
    for (file, text) in sources.iter().filter(|(file, _)| !file.starts_with("python/")) {
        let lines = text.lines().count();
        let is_root = ["/lib.rs", "/main.rs"].iter().any(|root| file.ends_with(root));
        short += usize::from(lines < MIN_LINES && !is_root);
        for row in rows_of(file) {
            *rows.entry(format!("lines of {row}")).or_default() += lines;
        }
        files += usize::from(file.starts_with(ROOMS));
        if let Some(room) = room_of(file) {
            arrows.extend(rooms_named(file, text, &rooms).into_iter().map(|other| (room.to_owned(), other)));
        }
    }
    let both = arrows.iter().filter(|(from, to)| from < to && arrows.contains(&(to.clone(), from.clone())));
    rows.insert("pairs of rooms that import from each other".to_owned(), both.count());
    rows.insert("imports of one room from another".to_owned(), arrows.len());
    rows.insert("files in rooms".to_owned(), files);
    rows.insert(format!("files shorter than {MIN_LINES} lines"), short);
    rows
}

/// The rows as their file has them: lines a little above what is there, so that not every line is a new table.
fn written(measured: &Rows) -> String {
    let number = |(name, number): (&String, &usize)| {
        let most = if name.starts_with("lines of ") { number.next_multiple_of(STEP) } else { *number };
        format!("\"{name}\" = {most}\n")
    };
    HEAD.chars().chain(measured.iter().map(number).collect::<String>().chars()).collect()
}

fn read(text: &str) -> Rows {
    let table: toml::Table = text.parse().unwrap();
    table.into_iter().map(|(name, most)| (name, most.as_integer().unwrap() as usize)).collect()
}

/// A sentence for each row that does not hold what is there.
fn above(measured: &Rows, ceilings: &Rows) -> Vec<String> {
    let sentence = |(name, number): (&String, &usize)| match ceilings.get(name) {
        Some(most) if number <= most => None,
        Some(most) => Some(format!("{name}: {number}, and {most} at most")),
        None => Some(format!("{name}: {number}, and ceilings.toml has no such row")),
    };
    measured.iter().filter_map(sentence).collect()
}

/// A sentence for each row that stands so high above what is there that it would let it grow back.
fn far_above(ceilings: &Rows, measured: &Rows) -> Vec<String> {
    let sentence = |(name, most): (&String, &usize)| {
        let number = measured.get(name).copied().unwrap_or(0);
        let (share, lines, pieces) = SLACK;
        let beside = if name.starts_with("lines of ") { lines } else { pieces };
        let slack = (share * number as f64) as usize + beside;
        let is_gone = !measured.contains_key(name);
        (is_gone || *most > number + slack).then(|| format!("{name}: {number}, and {most} allowed"))
    };
    ceilings.iter().filter_map(sentence).collect()
}

#[test]
fn no_folder_grew_above_its_ceiling_and_no_ceiling_stayed_far_above_what_was_cut() {
    let measured = measured(&super::sources());
    if is_written_anew() {
        std::fs::write(path(), written(&measured)).unwrap();
    }
    let ceilings = read(&std::fs::read_to_string(path()).unwrap());
    let above = above(&measured, &ceilings);
    assert!(above.is_empty(), "{above:#?}");
    let far_above = far_above(&ceilings, &measured);
    assert!(far_above.is_empty(), "write ceilings.toml anew, as it says: {far_above:#?}");
}

#[test]
fn planted_lines_and_imports_are_found_by_their_rows() {
    let file =
        |name: &str, text: &str| (format!("desk/app/rooms/{name}"), text.to_owned() + &"\n".repeat(20));
    let before = vec![
        file("mod.rs", ""),
        file("live/state.rs", "use super::super::{files::Path, picture};"),
        file("live/ui.rs", "fn f(source: &Source) { super::state::g(source) }"),
        file("source.rs", "use crate::app::rooms::live::state::State;"),
    ];
    let rows = measured(&before);
    assert_eq!(rows["files in rooms"], 4);
    assert_eq!(rows["imports of one room from another"], 1);
    assert_eq!(rows["pairs of rooms that import from each other"], 0);
    assert_eq!(rows["files shorter than 20 lines"], 0);
    assert_eq!(rows["lines of desk/app/rooms/live"], 40);
    let ceilings = read(&written(&rows));
    assert!(above(&rows, &ceilings).is_empty() && far_above(&ceilings, &rows).is_empty());
    let mut grown = ceilings.clone();
    grown.insert("lines of desk/app/rooms/live".to_owned(), 82);
    grown.insert("lines of desk/app/rooms/gone".to_owned(), 20);
    let expected = [
        "lines of desk/app/rooms/gone: 0, and 20 allowed",
        "lines of desk/app/rooms/live: 40, and 82 allowed",
    ];
    assert_eq!(far_above(&grown, &rows), expected);
    for (back, found) in [
        ("use super::super::source::Source;", "imports of one room from another: 2, and 1 at most"),
        ("use crate::app::rooms::{files, source};", "imports of one room from another: 2, and 1 at most"),
        ("use super::source;", "files in rooms: 5, and 4 at most"),
    ] {
        let after: Vec<_> = before.iter().cloned().chain([file("live/control.rs", back)]).collect();
        let above = above(&measured(&after), &ceilings);
        assert!(above.iter().any(|sentence| sentence == found), "{back}: {above:#?}");
        let both = "pairs of rooms that import from each other: 1, and 0 at most".to_owned();
        assert_eq!(above.contains(&both), found.starts_with("imports"), "{back}: {above:#?}");
        assert!(above.contains(&"lines of desk/app/rooms/live: 60, and 40 at most".to_owned()), "{above:#?}");
    }
}
