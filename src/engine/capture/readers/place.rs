//! A folder or file that may be a capture, and the names in it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// A folder, or one file in it, with the names directly in the folder. Subfolders are looked into by path.
#[derive(Clone, Debug)]
pub(crate) struct SourceFolder {
    /// What was named.
    pub path: PathBuf,
    /// The folder: `path` itself, or the one that holds its file.
    pub folder: PathBuf,
    /// The file, where one was named.
    pub file: Option<String>,
    names: BTreeSet<String>,
}

impl SourceFolder {
    /// Looks at `path`.
    ///
    /// # Errors
    /// `Io` where it is not there or cannot be listed.
    pub(crate) fn look(path: &Path) -> Result<Self> {
        let is_folder = path.metadata().map_err(|error| Error::io(path, error))?.is_dir();
        let file = path.file_name().filter(|_| !is_folder).map(|name| name.to_string_lossy().into_owned());
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = if is_folder { path } else { parent };
        let names = names_in(folder)?.into_iter().collect();
        Ok(Self { path: path.to_path_buf(), folder: folder.to_path_buf(), file, names })
    }

    /// Whether the folder has a file or folder of this name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.names.contains(name)
    }

    /// Whether it has all of these.
    pub(crate) fn has_all(&self, names: &[&str]) -> bool {
        names.iter().all(|name| self.has(name))
    }

    /// The first of these names that it has.
    pub(crate) fn first_of<'a>(&self, names: &[&'a str]) -> Option<&'a str> {
        names.iter().copied().find(|name| self.has(name))
    }

    /// All names, sorted by bytes.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// The path of something in the folder.
    pub(crate) fn join(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }
}

/// The names in a folder. Numbers in them are in the order of their values: `2.png` comes before `10.png`.
///
/// # Errors
/// `Io` where the folder is not there or cannot be listed.
pub(crate) fn names_in(folder: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, error))?;
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(|error| Error::io(folder, error))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.sort_by_cached_key(|name| (numeric_key(name), name.clone()));
    Ok(names)
}

/// A key that orders names as people count them: runs of digits by value.
pub(crate) fn numeric_key(name: &str) -> Vec<(u128, char)> {
    let mut key = Vec::new();
    let mut number: Option<u128> = None;
    for letter in name.chars() {
        if let Some(digit) = letter.to_digit(10) {
            number = Some(number.unwrap_or(0).saturating_mul(10).saturating_add(u128::from(digit)));
        } else {
            key.extend(number.take().map(|number| (number, '0')));
            key.push((0, letter));
        }
    }
    key.extend(number.map(|number| (number, '0')));
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_listed_as_people_count_them() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["10.png", "2.png", "frame-000010.png", "frame-9.png", "a"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let names = names_in(folder.path()).unwrap();
        let at = |name: &str| names.iter().position(|other| other == name).unwrap();
        assert!(at("2.png") < at("10.png") && at("frame-9.png") < at("frame-000010.png"), "{names:?}");
        let place = SourceFolder::look(&folder.path().join("a")).unwrap();
        assert_eq!((place.folder.as_path(), place.file.as_deref()), (folder.path(), Some("a")));
        assert!(place.has_all(&["a", "2.png"]));
    }
}
