//! Files whose names another system takes for the same: in another case, with letters that are composed or not, or named from the root
//! of another machine.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use unicode_normalization::UnicodeNormalization;

/// The names of each folder that was looked into, by what all systems take for the same.
#[derive(Default)]
pub(super) struct SimilarNames {
    folders: RefCell<HashMap<PathBuf, HashMap<String, Vec<PathBuf>>>>,
}

impl SimilarNames {
    /// The one file that a path which is not there can mean; `None` where there is none, or several. A path from the root of another
    /// machine means the file in `folder` that has the longest end of it as its own.
    pub(super) fn file(&self, folder: &Path, path: &Path) -> Option<PathBuf> {
        self.similar(path).or_else(|| {
            // What was joined to the folder is no path of another machine, but for a name of Windows.
            let parts = foreign_parts(path.strip_prefix(folder).unwrap_or(path))?;
            let ends = (1..parts.len()).map(|from| parts[from..].iter().collect::<PathBuf>());
            ends.map(|end| folder.join(end)).find_map(|place| self.similar(&place))
        })
    }

    /// The path itself where it is a file, or the only one that differs by letters that systems take for the same.
    fn similar(&self, path: &Path) -> Option<PathBuf> {
        if path.is_file() {
            return Some(path.to_path_buf());
        }
        let mut place = PathBuf::new();
        for part in path.components() {
            let next = place.join(part);
            place = match part {
                Component::Normal(name) if !next.exists() => self.only(&place, &name.to_string_lossy())?,
                _ => next,
            };
        }
        place.is_file().then_some(place)
    }

    fn only(&self, folder: &Path, name: &str) -> Option<PathBuf> {
        let mut folders = self.folders.borrow_mut();
        let names = folders.entry(folder.to_path_buf()).or_insert_with(|| {
            let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let mut names: HashMap<String, Vec<PathBuf>> = HashMap::new();
            for entry in std::fs::read_dir(place).into_iter().flatten().flatten() {
                let own = entry.file_name();
                names.entry(folded(&own.to_string_lossy())).or_default().push(folder.join(own));
            }
            names
        });
        match names.get(&folded(name)).map(Vec::as_slice) {
            Some([only]) => Some(only.clone()),
            _ => None,
        }
    }
}

/// What names are compared by: letters without case, each composed where that can be.
fn folded(name: &str) -> String {
    name.nfd().flat_map(char::to_lowercase).nfc().collect()
}

/// Whether a name starts at the root of a machine, of whatever system.
pub(super) fn is_absolute(name: &str) -> bool {
    let of_windows = |name: &[u8]| name.len() > 2 && name[0].is_ascii_alphabetic() && name[1] == b':';
    name.starts_with(['/', '\\']) || of_windows(name.as_bytes())
}

/// The parts of a path from the root of a machine; `None` of any other path.
fn foreign_parts(path: &Path) -> Option<Vec<String>> {
    let text = path.to_string_lossy();
    // A name of Windows is no root here: it was joined to the folder of the manifest.
    let windows = text.char_indices().find(|(at, _)| {
        let starts = *at == 0 || text[..*at].ends_with(['/', '\\']);
        starts && text[*at..].as_bytes().get(1) == Some(&b':') && is_absolute(&text[*at..])
    });
    let name = windows.map_or(&*text, |(at, _)| &text[at..]);
    let parts = name.split(['/', '\\']).filter(|part| !part.is_empty() && *part != "." && *part != "..");
    is_absolute(name).then(|| parts.map(str::to_owned).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_means_a_file_of_other_case_or_composition_only_where_there_is_one() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("Left")).unwrap();
        for name in ["Left/Ra\u{308}ume.PNG", "twice.png", "Twice.png", "a.exr"] {
            std::fs::write(at(name), "").unwrap();
        }
        let found = |name: &str| SimilarNames::default().file(folder.path(), &at(name));
        assert_eq!(found("left/R\u{e4}ume.png"), Some(at("Left/Ra\u{308}ume.PNG")));
        assert_eq!(found("a.exr"), Some(at("a.exr")));
        assert_eq!((found("TWICE.png"), found("b.exr")), (None, None));
    }

    #[test]
    fn a_path_of_another_machine_means_the_file_with_the_longest_end_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("left")).unwrap();
        for name in ["left/1.png", "1.png"] {
            std::fs::write(at(name), "").unwrap();
        }
        let found = |name: &str| SimilarNames::default().file(folder.path(), &at(name));
        for name in ["/no/such/home/left/1.png", "C:\\Users\\me\\left\\1.png", "D:/x/left/1.png"] {
            assert_eq!(found(name), Some(at("left/1.png")), "{name}");
        }
        assert_eq!(found("/no/such/right/1.png"), Some(at("1.png")));
        assert_eq!((found("right/1.png"), found("/no/such/2.png")), (None, None));
    }
}
