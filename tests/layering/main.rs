//! The architecture within the crates: layers, no import circles, sizes, each outside library in its place, and the words of names and
//! texts.

mod ceilings;
mod imports;
mod plurals;
#[path = "../common/private_words.rs"]
mod private_words;
mod sightings;
mod words;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use imports::Imports;

/// Modules from the bottom up, each after its crate. A module may use those before it and itself.
const LAYERS: [&[&str]; 17] = [
    &[
        "engine/color",
        "engine/cover",
        "engine/error",
        "engine/grid",
        "engine/job",
        "engine/median",
        "engine/part",
        "engine/plural",
        "engine/random",
        "engine/settings",
        "engine/simd",
        "engine/whole_file",
    ],
    &["engine/capture"],
    &["engine/alignment"],
    &["engine/samples", "engine/demo"],
    &["engine/edits"],
    &["engine/store", "engine/preprocess"],
    &["engine/render", "engine/placement", "engine/edited_store"],
    &["engine/page", "engine/stored_verdicts"],
    &["engine/splats"],
    &["engine/lib"],
    &["lab"],
    &["desk/address", "desk/pruned_store", "desk/text"],
    &["desk/ways_out"],
    &["desk/app"],
    &["desk/cli", "python"],
    &["desk/lib"],
    &["desk/main"],
];

/// Modules that may not use another although it lies below them: pictures are rendered from samples, whoever made them.
const STRANGERS: [(&str, &str); 1] = [("engine/render", "engine/preprocess")];

/// Folders of a module from the first to the last in the order in which data flows: a folder may use those before it.
const STAGES: [(&str, &[&str]); 8] = [
    (
        "engine/preprocess",
        &[
            "noise",
            "normals",
            "temporal",
            "layers",
            "registration",
            "agreement",
            "pruning",
            "interactive",
            "inspect",
            "diagnostics",
            "traversal",
            "parts",
        ],
    ),
    (
        "engine/render",
        &[
            "input",
            "geometry",
            "splat",
            "free_space",
            "gather",
            "resolve",
            "fill",
            "magnified",
            "output",
            "gpu",
            "film",
            "renderer",
        ],
    ),
    (
        "engine/capture",
        &[
            "sighting",
            "overlap",
            "exr",
            "yuv",
            "pictures",
            "conventions",
            "colmap",
            "transforms",
            "miv",
            "cinema",
            "greedy_cover",
            "trajectory",
            "readers",
        ],
    ),
    ("engine/demo", &["tracer", "scenes"]),
    ("engine/store", &["container", "codec", "image", "file", "playback"]),
    (
        "lab",
        &["rivals", "metrics", "scoring", "truth", "trial", "sweep", "stress", "tune", "chart", "report"],
    ),
    ("desk/app", &["model", "dock", "work", "control", "ui"]),
    ("desk/cli", &["output", "input", "commands"]),
];

/// Outside libraries that only some files may use, as prefixes of their paths.
const CONFINED: [(&str, &[&str]); 18] = [
    ("egui", &["desk/app/"]),
    ("epaint", &["desk/app/"]),
    ("egui_commonmark", &["desk/app/"]),
    ("egui_tiles", &["desk/app/"]),
    ("egui_material_icons", &["desk/app/"]),
    ("eframe", &["desk/app/"]),
    ("winit", &["desk/app/"]),
    ("egui_plot", &["desk/app/"]),
    ("rfd", &["desk/app/"]),
    ("wgpu", &["engine/render/gpu", "desk/app/"]),
    ("clap", &["desk/cli/", "desk/main.rs", "desk/ways_out/"]),
    ("indicatif", &["desk/cli/"]),
    ("resvg", &["lab/chart/"]),
    ("pdf_writer", &["lab/chart/"]),
    ("skrifa", &["lab/chart/"]),
    ("subsetter", &["lab/chart/"]),
    ("pyo3", &["python/"]),
    ("numpy", &["python/"]),
];

/// Files that know bytes, not cameras, as prefixes of their paths.
const BYTES_ONLY: [&str; 2] = ["engine/store/container/", "engine/store/codec/"];

/// Where the files of each crate lie, and what it is called here.
const CRATES: [(&str, &str); 4] =
    [("src/engine", "engine"), ("src/lab", "lab"), ("src/desk", "desk"), ("python/src", "python")];

/// A file longer than this holds two ideas.
const MAX_LINES: usize = 600;

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
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut sources = Vec::new();
    for (folder, name) in CRATES {
        let folder = root.join(folder);
        let mut files = Vec::new();
        visit(&folder, &mut files);
        files.sort();
        sources.extend(files.into_iter().map(|path| {
            let within = path.strip_prefix(&folder).unwrap().to_string_lossy().replace('\\', "/");
            (format!("{name}/{within}"), std::fs::read_to_string(&path).unwrap())
        }));
    }
    sources
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

/// The crate and the module at the top of a path; the lab and the Python module are one layer each.
fn top(file: &str) -> &str {
    let (home, rest) = file.split_once('/').unwrap_or((file, ""));
    if home == "lab" || home == "python" {
        return home;
    }
    &file[..home.len() + 1 + rest.find(['/', '.']).unwrap_or(rest.len())]
}

#[test]
fn a_module_imports_only_from_the_layers_below_it() {
    for (file, imported) in Imports::read(&sources()).pairs() {
        let own = layer_of(top(file)).unwrap_or_else(|| panic!("{file} belongs to no layer"));
        let layer = layer_of(top(imported)).unwrap_or_else(|| panic!("{imported} belongs to no layer"));
        // What lies at the bottom may use its like.
        let is_below = layer < own || top(file) == top(imported) || (own == 0 && layer == 0);
        assert!(is_below, "{file} imports from {imported}");
        assert!(!STRANGERS.contains(&(top(file), top(imported))), "{file} imports from {imported}");
    }
}

#[test]
fn no_imports_run_in_a_circle() {
    let imports = Imports::read(&sources());
    let circles = imports.circles();
    assert!(circles.is_empty(), "files that import from each other: {circles:#?}");
}

#[test]
fn no_neighbors_import_from_each_other_in_a_circle() {
    let circles = Imports::read(&sources()).circles_of_neighbors();
    assert!(circles.is_empty(), "files and folders that import from each other: {circles:#?}");
}

#[test]
fn a_planted_circle_between_a_file_and_a_folder_is_found() {
    let root = ("desk/lib.rs", "pub mod app;");
    let app = ("desk/app/mod.rs", "mod control;\nmod state;\nmod window;");
    let folder = ("desk/app/control/mod.rs", "mod keys;\npub use keys::carry_out;");
    let keys = ("desk/app/control/keys.rs", "use crate::app::state::State;");
    let state = ("desk/app/state.rs", "pub struct State;");
    let window = ("desk/app/start.rs", "use super::control::carry_out;\nuse super::state::State;");
    let right = [root, app, folder, keys, state, window];
    assert_eq!(planted(&right).circles_of_neighbors(), Vec::<Vec<String>>::new());
    // No file imports from itself through others here, and yet the folder and the file need each other.
    let back = ("desk/app/state.rs", "use super::control::Other;\npub struct State;");
    let folder = ("desk/app/control/mod.rs", "mod keys;\npub struct Other;");
    let imports = planted(&[root, app, folder, keys, back]);
    assert!(imports.circles().is_empty());
    assert_eq!(imports.circles_of_neighbors(), [["desk/app/control", "desk/app/state.rs"]]);
}

/// The place of a file's folder among the stages of a module; `None` outside of them.
fn stage_of(file: &str, module: &str, stages: &[&str]) -> Option<usize> {
    let folder = file.strip_prefix(module)?.strip_prefix('/')?.split_once('/')?.0;
    let place = stages.iter().position(|stage| *stage == folder);
    assert!(place.is_some() || ["tests", "rooms"].contains(&folder), "{module}/{folder} is in no order");
    place
}

#[test]
fn within_a_module_a_folder_imports_only_from_earlier_ones() {
    let imports = Imports::read(&sources());
    let mut wrong = Vec::new();
    for (module, stages) in STAGES {
        for (file, imported) in imports.pairs() {
            let [own, other] =
                [file, imported].map(|file| stage_of(&imports::by_layer(file), module, stages));
            if let (Some(own), Some(other)) = (own, other)
                && other > own
            {
                wrong.push(format!("{file} imports from {imported}, a later stage"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Files with these names and texts, for tests of what the rules find.
fn planted(files: &[(&str, &str)]) -> Imports {
    let files: Vec<_> = files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect();
    Imports::read(&files)
}

#[test]
fn a_planted_circle_is_found() {
    let first = ("engine/stage/first.rs", "use super::second::Two;\npub struct One(Two);");
    let folder = ("engine/stage/mod.rs", "mod first;\nmod second;\npub use first::One;");
    let harmless = (
        "engine/stage/second.rs",
        "/// Used by [`One`](super::first::One).\npub const TWO: &str = \"super::first::One\";",
    );
    assert_eq!(planted(&[folder, first, harmless]).circles(), Vec::<Vec<&str>>::new());
    for back in [
        "use super::first::One;",
        "use crate::stage::{first::One as Other};",
        "use super::first;\nfn f() { first::f(); }",
        "fn f() -> crate::stage::first::One { todo!() }",
    ] {
        let imports = planted(&[folder, first, ("engine/stage/second.rs", back)]);
        assert_eq!(imports.circles(), [["engine/stage/first.rs", "engine/stage/second.rs"]], "{back}");
    }
    // Through the folder's re-export the circle is one of three files.
    let imports = planted(&[folder, first, ("engine/stage/second.rs", "use super::One;")]);
    assert_eq!(
        imports.circles(),
        [["engine/stage/mod.rs", "engine/stage/first.rs", "engine/stage/second.rs"]]
    );
}

#[test]
fn each_outside_library_stays_where_it_belongs() {
    for (name, text) in sources() {
        for (library, allowed) in CONFINED {
            if allowed.iter().any(|prefix| name.starts_with(prefix)) {
                continue;
            }
            let used = code(&text).find(|line| uses(line, library));
            assert!(used.is_none(), "{name} uses {library}: {}", used.unwrap_or_default().trim());
        }
    }
}

#[test]
fn files_that_know_bytes_know_no_cameras() {
    let imports = Imports::read(&sources());
    let is_bytes = |file: &str| BYTES_ONLY.iter().any(|folder| file.starts_with(folder));
    assert!(BYTES_ONLY.iter().all(|folder| imports.files.iter().any(|file| file.starts_with(folder))));
    for (file, imported) in imports.pairs().filter(|(file, _)| is_bytes(file)) {
        let is_bottom = layer_of(top(imported)) == Some(0);
        assert!(is_bytes(imported) || is_bottom, "{file} imports from {imported}");
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

fn manifest_of_workspace() -> toml::Table {
    manifest("Cargo.toml")
}

/// The dependencies in a manifest, on any system, and the version that is asked for.
fn dependencies(manifest: &toml::Table) -> BTreeMap<String, String> {
    let targets = manifest.get("target").and_then(|targets| targets.as_table());
    let tables = targets.into_iter().flat_map(|targets| targets.values());
    // A target may have libraries for tests alone.
    let tables = tables.filter_map(|target| target.get("dependencies")).chain([&manifest["dependencies"]]);
    let all = manifest_of_workspace();
    let version = |name: &str, wanted: &toml::Value| {
        let shared = wanted.get("workspace").map(|_| &all["workspace"]["dependencies"][name]);
        let wanted = shared.unwrap_or(wanted);
        wanted.get("version").unwrap_or(wanted).as_str().unwrap().to_owned()
    };
    tables
        .flat_map(|table| table.as_table().unwrap())
        .map(|(name, wanted)| (name.clone(), version(name, wanted)))
        .collect()
}

#[test]
fn what_is_fuzzed_finds_every_outside_library_that_it_uses() {
    let fuzz = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/lib.rs")).unwrap();
    let modules: Vec<&str> = fuzz
        .split("#[path = \"../src/engine/")
        .skip(1)
        .filter_map(|rest| rest.split(['/', '.']).next())
        .collect();
    assert!(modules.contains(&"capture") && modules.contains(&"store"), "{modules:?}");
    let (ours, fuzzed) =
        (dependencies(&manifest("src/engine/Cargo.toml")), dependencies(&manifest("fuzz/Cargo.toml")));
    let lock = manifest("fuzz/Cargo.lock");
    let locked = |name: &str| {
        let mut packages = lock["package"].as_array().unwrap().iter();
        packages.any(|package| package["name"].as_str() == Some(name))
    };
    for (name, text) in sources() {
        let module = name.strip_prefix("engine/").and_then(|rest| rest.split(['/', '.']).next());
        if !module.is_some_and(|module| modules.contains(&module)) {
            continue;
        }
        for (library, version) in &ours {
            if code(untested(&text)).any(|line| uses(line, &library.replace('-', "_"))) {
                assert_eq!(fuzzed.get(library), Some(version), "{library}, for {name}, in fuzz/Cargo.toml");
                assert!(locked(library), "{library}, for {name}, is not in fuzz/Cargo.lock");
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
        // A file or folder of the sources may be named by a part of its path, and without its extension.
        let is_source = || {
            sources.iter().any(|(name, _)| {
                let ending = if is_rust { word.to_owned() } else { format!("{word}.rs") };
                let folder = format!("{}/", word.trim_end_matches('/'));
                let is_folder = || name.starts_with(&folder) || name.contains(&format!("/{folder}"));
                name == &ending || name.ends_with(&format!("/{ending}")) || is_folder()
            })
        };
        let of_root = [
            "src/",
            "tests/",
            "assets/",
            "shaders/",
            "fuzz/",
            "benches/",
            "examples/",
            "packaging/",
            "python/",
        ];
        let exists = if of_root.iter().any(|start| word.starts_with(start)) { exists } else { is_source() };
        assert!(exists, "ARCHITECTURE.md names `{word}`");
    }
    assert!(found > 80, "{found} paths");
}

/// Folders that ARCHITECTURE.md has to name: those of a crate, those in them, and the rooms of the window.
fn told_folders() -> BTreeSet<String> {
    let mut folders = BTreeSet::new();
    for (name, _) in sources() {
        let parts: Vec<&str> = name.split('/').collect();
        let (parts, _) = parts.split_at(parts.len() - 1);
        let depth = if parts.starts_with(&["desk", "app", "rooms"]) { 4 } else { 3 };
        if parts[0] != "python" && !parts.contains(&"tests") {
            folders.extend((2..=parts.len().min(depth)).map(|end| format!("{}/", parts[..end].join("/"))));
        }
    }
    folders
}

#[test]
fn the_architecture_has_a_line_for_every_folder() {
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md")).unwrap();
    let folders = told_folders();
    assert!(folders.len() > 60, "{folders:?}");
    let untold: Vec<&String> =
        folders.iter().filter(|folder| !text.contains(&format!("`{folder}`"))).collect();
    assert!(untold.is_empty(), "ARCHITECTURE.md does not name {untold:?}");
    assert!(
        text.len() <= 30_000,
        "ARCHITECTURE.md has {} bytes; a page that is read whole has 30,000",
        text.len()
    );
}

#[test]
fn the_page_on_captures_names_every_key_of_the_manifest() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("CAPTURES.md")).unwrap();
    let text_of = |file: &str| sources().into_iter().find(|(name, _)| name == file).unwrap().1;
    let text =
        text_of("engine/capture/transforms/manifest.rs") + &text_of("engine/capture/transforms/raw_video.rs");
    let keys = text.lines().filter_map(|line| line.strip_prefix("    pub ")?.split_once(':'));
    // Keys of bent lenses are told as a kind: none of them helps. Those of raw video stand in a file of their own.
    let keys: Vec<&str> = keys
        .map(|(key, _)| key)
        .filter(|key| !key.contains(' ') && !["keys", "lens", "raw_video"].contains(key))
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
        assert!(lines <= MAX_LINES, "{name} has {lines} lines; {MAX_LINES} at most");
    }
}
