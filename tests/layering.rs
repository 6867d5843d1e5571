//! Keeps the layers of the architecture: a module imports only from those to its left, and each outside library stays
//! where it belongs.

use std::path::{Path, PathBuf};

/// Modules from the bottom up. A module may use those before it and itself.
const LAYERS: [&[&str]; 8] = [
    &["error", "grid", "job", "color", "settings", "simd"],
    &["capture"],
    &["preprocess"],
    &["store"],
    &["render"],
    &["evaluate"],
    &["cli", "app"],
    &["main", "lib"],
];

/// Outside libraries that only some files may use, as prefixes of paths below `src`.
const CONFINED: [(&str, &[&str]); 7] = [
    ("egui", &["app/"]),
    ("eframe", &["app/"]),
    ("egui_plot", &["app/"]),
    ("rfd", &["app/"]),
    ("wgpu", &["render/gpu", "app/"]),
    ("clap", &["cli/", "main.rs"]),
    ("indicatif", &["cli/"]),
];

/// Files that know bytes, not cameras.
const BYTES_ONLY: [&str; 2] = ["store/iff.rs", "store/source.rs"];

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

fn layer_of(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

/// Names that directly follow `prefix` in `line`, as in `crate::NAME`; also inside `crate::{A, B}`.
fn names_after<'a>(line: &'a str, prefix: &'a str) -> impl Iterator<Item = &'a str> {
    line.match_indices(prefix).flat_map(move |(at, _)| {
        let rest = &line[at + prefix.len()..];
        let list = rest.strip_prefix('{').map_or(rest, |inner| inner.split('}').next().unwrap_or(inner));
        let braced = rest.starts_with('{');
        list.split(',').take(if braced { usize::MAX } else { 1 }).map(|name| {
            name.trim().split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default()
        })
    })
}

#[test]
fn a_module_imports_only_from_the_layers_below_it() {
    for (name, text) in sources() {
        let module = name.split(['/', '.']).next().unwrap();
        let own = layer_of(module).unwrap_or_else(|| panic!("{name} belongs to no layer"));
        if module == "lib" || module == "main" {
            continue;
        }
        for line in code(&text) {
            for used in names_after(line, "crate::") {
                let Some(layer) = layer_of(used) else { continue };
                assert!(layer < own || used == module || own == 0, "src/{name} uses {used}: {}", line.trim());
            }
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
            let used = code(&text).find(|line| {
                line.match_indices(&format!("{library}::"))
                    .any(|(at, _)| !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
            });
            assert!(used.is_none(), "src/{name} uses {library}: {}", used.unwrap_or_default().trim());
        }
    }
}

#[test]
fn files_that_know_bytes_know_no_cameras() {
    for (name, text) in sources() {
        if BYTES_ONLY.contains(&name.as_str()) {
            for line in code(&text) {
                for used in names_after(line, "crate::") {
                    assert!(layer_of(used) == Some(0), "src/{name} uses {used}");
                }
            }
        }
    }
}

#[test]
fn no_file_grew_to_hold_two_ideas() {
    for (name, text) in sources() {
        let lines = text.lines().count();
        assert!(lines <= MAX_LINES, "src/{name} has {lines} lines; {MAX_LINES} at most");
    }
}
