//! Keeps the layers of the architecture: a module imports only from those to its left, and each outside library stays
//! where it belongs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Modules from the bottom up. A module may use those before it and itself.
const LAYERS: [&[&str]; 8] = [
    &["error", "grid", "job", "color", "settings", "simd", "whole_file"],
    &["capture"],
    &["preprocess"],
    &["store"],
    &["render"],
    &["evaluate"],
    &["cli", "app"],
    &["main", "lib"],
];

/// Outside libraries that only some files may use, as prefixes of paths below `src`.
const CONFINED: [(&str, &[&str]); 11] = [
    ("egui", &["app/"]),
    ("epaint", &["app/"]),
    ("egui_tiles", &["app/"]),
    ("egui_material_icons", &["app/"]),
    ("eframe", &["app/"]),
    ("egui_plot", &["app/"]),
    ("rfd", &["app/"]),
    ("wgpu", &["render/gpu", "app/"]),
    ("clap", &["cli/", "main.rs"]),
    ("indicatif", &["cli/"]),
    ("resvg", &["evaluate/chart"]),
];

/// Files that know bytes, not cameras, as prefixes of paths below `src`.
const BYTES_ONLY: [&str; 4] = ["store/iff.rs", "store/source.rs", "store/bytes.rs", "store/coding/"];

/// What they may use of the store: each other.
const BYTES_MODULES: [&str; 4] = ["iff", "source", "bytes", "coding"];

/// A file longer than this holds two ideas.
const MAX_LINES: usize = 450;

fn sources() -> Vec<(String, String)> {
    fn visit(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                visit(&path, files);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    visit(&root, &mut files);
    files.sort();
    files
        .into_iter()
        .map(|path| {
            let name = path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
            (name, std::fs::read_to_string(&path).unwrap())
        })
        .collect()
}

/// Code without comments: a doc comment may speak of any layer.
fn code(text: &str) -> impl Iterator<Item = &str> {
    text.lines().map(|line| line.split("//").next().unwrap_or_default())
}

/// Whether a line names something of an outside library.
fn uses(line: &str, library: &str) -> bool {
    let ends_in_a_name = |text: &str| text.ends_with(|c: char| c.is_alphanumeric() || c == '_');
    line.match_indices(&format!("{library}::")).any(|(at, _)| {
        let before = &line[..at];
        // A module may be called as a library is: `capture::exr::` is ours, `::exr::` is not.
        !ends_in_a_name(before) && !before.strip_suffix("::").is_some_and(ends_in_a_name)
    })
}

fn layer_of(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

/// Names that directly follow `prefix` in `code`, as in `crate::NAME`; also inside `crate::{A, B::{C, D}}`, on however many lines.
fn names_after<'a>(code: &'a str, prefix: &'a str) -> impl Iterator<Item = &'a str> {
    let name = |text: &'a str| {
        text.trim_start().split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default()
    };
    code.match_indices(prefix).flat_map(move |(at, _)| {
        let rest = &code[at + prefix.len()..];
        let Some(list) = rest.strip_prefix('{') else { return vec![name(rest)] };
        let (mut depth, mut begins, mut names) = (0, 0, Vec::new());
        for (at, letter) in list.char_indices() {
            match letter {
                '{' => depth += 1,
                '}' if depth > 0 => depth -= 1,
                ',' | '}' if depth == 0 => {
                    names.push(name(&list[begins..at]));
                    begins = at + 1;
                }
                _ => {}
            }
            if letter == '}' && begins == at + 1 {
                break;
            }
        }
        names
    })
}

#[test]
fn names_are_found_in_nested_lists_that_go_on_over_lines() {
    let code =
        "use crate::{\n    app::{self, views},\n    grid::Grid,\n};\nlet it = crate::store::read(a, b);";
    assert_eq!(names_after(code, "crate::").collect::<Vec<_>>(), ["app", "grid", "", "store"]);
}

#[test]
fn a_module_imports_only_from_the_layers_below_it() {
    for (name, text) in sources() {
        let module = name.split(['/', '.']).next().unwrap();
        let own = layer_of(module).unwrap_or_else(|| panic!("{name} belongs to no layer"));
        if module == "lib" || module == "main" {
            continue;
        }
        let code: Vec<&str> = code(&text).collect();
        for used in names_after(&code.join("\n"), "crate::") {
            let Some(layer) = layer_of(used) else { continue };
            // What lies at the bottom may use its like.
            assert!(layer < own || used == module || (own == 0 && layer == 0), "src/{name} uses {used}");
        }
    }
}

#[test]
fn each_outside_library_stays_where_it_belongs() {
    for (name, text) in sources() {
        for (library, allowed) in CONFINED {
            if allowed.iter().any(|prefix| name.starts_with(prefix)) {
                continue;
            }
            let used = code(&text).find(|line| uses(line, library));
            assert!(used.is_none(), "src/{name} uses {library}: {}", used.unwrap_or_default().trim());
        }
    }
}

#[test]
fn files_that_know_bytes_know_no_cameras() {
    let sources = sources();
    let modules_of_store: Vec<&str> = sources
        .iter()
        .filter_map(|(name, _)| name.strip_prefix("store/")?.split(['/', '.']).next())
        .collect();
    let is_foreign = |name: &&str| modules_of_store.contains(name) && !BYTES_MODULES.contains(name);
    for prefix in BYTES_ONLY {
        let mut files = sources.iter().filter(|(name, _)| name.starts_with(prefix)).peekable();
        assert!(files.peek().is_some(), "there is no src/{prefix}");
        for (name, text) in files {
            let is_nested = name.matches('/').count() == 2 && !name.ends_with("/mod.rs");
            let store = if is_nested { "super::super::" } else { "super::" };
            let code = code(text).collect::<Vec<_>>().join("\n");
            let mut used = names_after(&code, "crate::").filter(|used| !used.is_empty());
            let foreign = used.find(|used| *used != "store" && layer_of(used) != Some(0));
            assert_eq!(foreign, None, "in src/{name}");
            let mut of_store = names_after(&code, "crate::store::").chain(names_after(&code, store));
            assert_eq!(of_store.find(is_foreign), None, "in src/{name}");
        }
    }
}

/// The part of a file that is built without its tests, which stand last.
fn untested(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod ").next().unwrap_or_default()
}

fn manifest(path: &str) -> toml::Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(path).unwrap().parse().unwrap()
}

/// The dependencies in a manifest, on any system, and the version that is asked for.
fn dependencies(manifest: &toml::Table) -> BTreeMap<String, String> {
    let targets = manifest.get("target").and_then(|targets| targets.as_table());
    let tables = targets.into_iter().flat_map(|targets| targets.values());
    let tables = tables.map(|target| &target["dependencies"]).chain([&manifest["dependencies"]]);
    let version = |wanted: &toml::Value| wanted.get("version").unwrap_or(wanted).as_str().unwrap().to_owned();
    tables
        .flat_map(|table| table.as_table().unwrap())
        .map(|(name, wanted)| (name.clone(), version(wanted)))
        .collect()
}

#[test]
fn what_is_fuzzed_finds_every_outside_library_that_it_uses() {
    let fuzz = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/lib.rs")).unwrap();
    let modules: Vec<&str> =
        fuzz.split("#[path = \"../src/").skip(1).filter_map(|rest| rest.split(['/', '.']).next()).collect();
    assert!(modules.contains(&"capture") && modules.contains(&"store"), "{modules:?}");
    let (ours, fuzzed) = (dependencies(&manifest("Cargo.toml")), dependencies(&manifest("fuzz/Cargo.toml")));
    let lock = manifest("fuzz/Cargo.lock");
    let locked = |name: &str| {
        let mut packages = lock["package"].as_array().unwrap().iter();
        packages.any(|package| package["name"].as_str() == Some(name))
    };
    for (name, text) in sources() {
        if !modules.contains(&name.split(['/', '.']).next().unwrap()) {
            continue;
        }
        for (library, version) in &ours {
            if code(untested(&text)).any(|line| uses(line, &library.replace('-', "_"))) {
                assert_eq!(
                    fuzzed.get(library),
                    Some(version),
                    "{library}, for src/{name}, in fuzz/Cargo.toml"
                );
                assert!(locked(library), "{library}, for src/{name}, is not in fuzz/Cargo.lock");
            }
        }
    }
}

#[test]
fn the_files_that_the_architecture_names_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    // Every second part stands between marks: first of drawings, then of code within a sentence.
    let sentences: String = text.split("```").step_by(2).collect();
    let sources = sources();
    let mut found = 0;
    for word in sentences.split('`').skip(1).step_by(2) {
        let (folder, file) = word.rsplit_once('/').unwrap_or(("", word));
        let is_rust = Path::new(word).extension().is_some_and(|extension| extension == "rs");
        let is_path = !word.contains([' ', ':']) && (word.contains('/') || is_rust);
        if !is_path {
            continue;
        }
        found += 1;
        let matches = |entry: &str| match file.split_once('*') {
            Some((start, end)) => entry.starts_with(start) && entry.ends_with(end),
            None => file.is_empty() || entry == file,
        };
        let exists = std::fs::read_dir(root.join(folder)).is_ok_and(|mut entries| {
            entries.any(|entry| matches(&entry.unwrap().file_name().to_string_lossy()))
        });
        // A file or folder of the sources may be named by the end of its path, and without its extension.
        let is_source = || {
            sources.iter().any(|(name, _)| {
                let ending = if is_rust { word.to_owned() } else { format!("{word}.rs") };
                let is_folder = || name.starts_with(&format!("{word}/"));
                name == &ending || name.ends_with(&format!("/{ending}")) || is_folder()
            })
        };
        let of_root = ["src/", "tests/", "assets/", "shaders/", "fuzz/", "benches/"];
        let exists = if of_root.iter().any(|start| word.starts_with(start)) { exists } else { is_source() };
        assert!(exists, "ARCHITECTURE.md names `{word}`");
    }
    assert!(found > 80, "{found} paths");
}

#[test]
fn the_page_on_captures_names_every_key_of_the_manifest() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("CAPTURES.md")).unwrap();
    let (_, text) = sources().into_iter().find(|(name, _)| name == "capture/transforms/manifest.rs").unwrap();
    let keys = text.lines().filter_map(|line| line.strip_prefix("    pub ")?.split_once(':'));
    // Keys of bent lenses are told as a kind: none of them helps.
    let keys: Vec<&str> = keys
        .map(|(key, _)| key)
        .filter(|key| !key.contains(' ') && !["keys", "lens"].contains(key))
        .collect();
    assert!(keys.len() > 25, "{keys:?}");
    for key in keys {
        assert!(page.contains(&format!("`{key}`")) || page.contains(&format!("\"{key}\"")), "{key}");
    }
}

#[test]
fn no_file_grew_to_hold_two_ideas() {
    for (name, text) in sources() {
        let lines = text.lines().count();
        assert!(lines <= MAX_LINES, "src/{name} has {lines} lines; {MAX_LINES} at most");
    }
}
