//! Writes what a package of Overlook holds beside the program: manual pages and shell completions, made from the command line
//! itself, the icon in the sizes that desktops ask for, and the licenses of all packages that are compiled in on this machine, as
//! `cargo bundle-licenses` finds them. Where that finds no text, the package's own folder is searched: fonts come with theirs.
//!
//! ```sh
//! cargo bundle-licenses --format json --output licenses.json
//! cargo run --example package_files -- DIR licenses.json
//! ```
//!
//! An example rather than a command: the program itself needs none of it, nor the crates that make it.

use std::collections::{BTreeMap, HashMap};
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap_complete::{Shell, generate_to};
use resvg::{tiny_skia, usvg};
use serde::Deserialize;

const ICON: &str = include_str!("../packaging/icon.svg");

/// Sides of the icon, pixels: those that the hicolor theme installs everywhere.
const SIDES: [u32; 6] = [16, 32, 48, 64, 128, 256];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(folder), Some(found)) = (arguments.next(), arguments.next()) else {
        return Err("give the folder to write into, and the file of cargo bundle-licenses".into());
    };
    manual_pages(&folder.join("man"))?;
    completions(&folder.join("completions"))?;
    icons(&folder.join("icons"))?;
    let found = fs::read_to_string(&found).map_err(|error| format!("{}: {error}", found.display()))?;
    fs::write(folder.join("THIRD_PARTY.txt"), third_party(serde_json::from_str(&found)?)?)?;
    println!("Wrote manual pages, completions, icons and licenses into {}.", folder.display());
    Ok(())
}

/// What `cargo bundle-licenses` writes.
#[derive(Deserialize)]
struct Found {
    third_party_libraries: Vec<Library>,
}

#[derive(Deserialize)]
struct Library {
    package_name: String,
    package_version: String,
    repository: String,
    /// As the package states it.
    license: String,
    licenses: Vec<License>,
}

#[derive(Deserialize)]
struct License {
    license: String,
    /// `NOT FOUND` where the package comes without it.
    text: String,
}

/// What cargo knows of a package.
#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
    authors: Vec<String>,
    manifest_path: PathBuf,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

/// What cargo prints.
fn cargo(arguments: &[&str]) -> Result<String, Box<dyn Error>> {
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(program).args(arguments).output()?;
    if !output.status.success() {
        return Err(
            format!("cargo {}: {}", arguments.join(" "), String::from_utf8_lossy(&output.stderr)).into()
        );
    }
    Ok(String::from_utf8(output.stdout)?)
}

/// Every package that is compiled in on this machine, with its license; then every text once, with the packages that come under it.
fn third_party(found: Found) -> Result<String, Box<dyn Error>> {
    let metadata: Metadata =
        serde_json::from_str(&cargo(&["metadata", "--locked", "--format-version", "1"])?)?;
    let known: HashMap<(&str, &str), &Package> = (metadata.packages.iter())
        .map(|package| ((package.name.as_str(), package.version.as_str()), package))
        .collect();
    let tree = cargo(&["tree", "--locked", "--edges", "normal", "--prefix", "none", "--format", "{p}"])?;
    let is_compiled = |library: &Library| {
        let line = format!("{} v{}", library.package_name, library.package_version);
        tree.lines()
            .any(|of| of.strip_prefix(&line).is_some_and(|rest| rest.is_empty() || rest.starts_with(' ')))
    };
    let mut list = String::from(
        "Overlook is compiled with these packages, each under one of its licenses. The texts follow; where a package comes without \
         one, its authors are named, and the text of the same license below holds.\n\n",
    );
    let mut texts = BTreeMap::<(String, String), Vec<String>>::new();
    for library in found.third_party_libraries.into_iter().filter(is_compiled) {
        let Library { package_name, package_version, repository, license, licenses } = library;
        let mut own: Vec<_> = (licenses.into_iter())
            .filter(|license| license.text != "NOT FOUND")
            .map(|License { license, text }| (license, text.trim().to_owned()))
            .collect();
        let package = known.get(&(package_name.as_str(), package_version.as_str()));
        if let (true, Some(package)) = (own.is_empty(), package) {
            own = texts_beside(&package.manifest_path)?
                .into_iter()
                .map(|text| (license.clone(), text))
                .collect();
        }
        let _ = write!(list, "{package_name} {package_version}: {license}; {repository}");
        if let (true, Some(package)) = (own.is_empty(), package) {
            let _ = write!(list, "; no text; by {}", package.authors.join(", "));
        }
        list.push('\n');
        for text in own {
            texts.entry(text).or_default().push(package_name.clone());
        }
    }
    for ((license, text), packages) in texts {
        let line = "-".repeat(100);
        let _ = write!(list, "\n{line}\n{license}: {}\n\n{text}\n", packages.join(", "));
    }
    Ok(list)
}

/// The licenses in the folder of a manifest, in one that is named so, and in that of its fonts, in the order of their paths.
fn texts_beside(manifest: &Path) -> Result<Vec<String>, Box<dyn Error>> {
    let Some(folder) = manifest.parent() else { return Ok(Vec::new()) };
    let mut files = Vec::new();
    for (folder, is_license) in [
        (folder.to_path_buf(), (|name| name.starts_with("LICENSE")) as fn(&str) -> bool),
        (folder.join("LICENSES"), |_| true),
        (folder.join("fonts"), |name| Path::new(name).extension().is_some_and(|ending| ending == "txt")),
    ] {
        let Ok(entries) = fs::read_dir(folder) else { continue };
        for entry in entries {
            let path = entry?.path();
            if path.is_file() && path.file_name().and_then(|name| name.to_str()).is_some_and(is_license) {
                files.push(path);
            }
        }
    }
    files.sort();
    files.into_iter().map(|file| Ok(fs::read_to_string(file)?.trim().to_owned())).collect()
}

/// A page for the program and one for each of its commands, as in `overlook-render.1`.
fn manual_pages(folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    clap_mangen::generate_to(overlook::cli::command(), folder)?;
    Ok(())
}

fn completions(folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish, Shell::PowerShell] {
        generate_to(shell, &mut overlook::cli::command(), "overlook", folder)?;
    }
    Ok(())
}

fn icons(folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let tree = usvg::Tree::from_str(ICON, &usvg::Options::default())?;
    for side in SIDES {
        let scale = side as f32 / tree.size().width();
        let mut pixels = tiny_skia::Pixmap::new(side, side).ok_or("the icon has no pixels")?;
        resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut pixels.as_mut());
        let to = folder.join(format!("{side}x{side}"));
        fs::create_dir_all(&to)?;
        fs::write(to.join("overlook.png"), pixels.encode_png()?)?;
    }
    Ok(())
}
