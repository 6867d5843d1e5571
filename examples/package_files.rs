//! Writes what a package of Overlook holds beside the program: manual pages and shell completions, made from the command line
//! itself, the icon in the sizes that desktops ask for, and the licenses of all packages that are compiled in, as
//! `cargo bundle-licenses` finds them.
//!
//! ```sh
//! cargo bundle-licenses --format json --output licenses.json
//! cargo run --example package_files -- DIR licenses.json
//! ```
//!
//! An example rather than a command: the program itself needs none of it, nor the crates that make it.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

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
    fs::write(folder.join("THIRD_PARTY.txt"), third_party(&serde_json::from_str(&found)?))?;
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

/// Every package with its license, then every text once, with the packages that come under it.
fn third_party(found: &Found) -> String {
    let mut list =
        String::from("Overlook is compiled with these packages, each under one of its licenses:\n\n");
    let mut texts = BTreeMap::<(&str, &str), Vec<&str>>::new();
    for library in &found.third_party_libraries {
        let Library { package_name, package_version, repository, license, licenses } = library;
        let _ = writeln!(list, "{package_name} {package_version}: {license}; {repository}");
        for License { license, text } in licenses.iter().filter(|license| license.text != "NOT FOUND") {
            texts.entry((license, text.trim())).or_default().push(package_name);
        }
    }
    for ((license, text), packages) in texts {
        let line = "-".repeat(100);
        let _ = write!(list, "\n{line}\n{license}: {}\n\n{text}\n", packages.join(", "));
    }
    list
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
