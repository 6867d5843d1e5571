//! Files that are seen under their names only when they are complete: whatever stood there stays until then. So are several at once.
//!
//! A link is written through: what it leads to is replaced, and the link stays. Pipes and devices are never replaced, and never read:
//! a pipe would be waited for, and a device need not end.

use std::fs::File;
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempPath};

use crate::error::{Error, Result};

/// As many links as operating systems follow.
const MOST_LINKS: usize = 40;

/// The path that a file of this name is written to: the name itself, or the target of a link, which need not exist.
pub(crate) fn place_of(path: &Path) -> PathBuf {
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = std::fs::read_link(&place) else { break };
        place = folder_of(&place).join(next);
    }
    place
}

/// The folder of a file.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Refuses a pipe or a device. A place where nothing is, and a folder, are let through.
///
/// # Errors
/// `Invalid` naming `path`.
pub fn refuse_pipe(path: &Path) -> Result<()> {
    match path.metadata() {
        Ok(facts) if !facts.is_file() && !facts.is_dir() => Err(Error::invalid(
            path.display(),
            "is a pipe or a device, and is read more than once; name a file",
        )),
        _ => Ok(()),
    }
}

/// Opens a file for reading.
///
/// # Errors
/// `Invalid` for a pipe or a device, `Io`; both naming `path`.
pub fn open(path: &Path) -> Result<File> {
    refuse_pipe(path)?;
    File::open(path).map_err(|error| Error::io(path, error))
}

/// Reads a whole file.
///
/// # Errors
/// As [`open`].
pub fn read_all(path: &Path) -> Result<Vec<u8>> {
    refuse_pipe(path)?;
    std::fs::read(path).map_err(|error| Error::io(path, error))
}

/// Bytes of a short text at most.
const SHORT_TEXT: u64 = 16 << 20;

/// Reads a text that a user gives, which may come from a pipe, but not without end.
///
/// # Errors
/// `Invalid` for more than 16 MiB, `Io`; both naming `path`.
pub fn short_text(path: &Path) -> Result<String> {
    let io = |error| Error::io(path, error);
    let mut text = String::new();
    File::open(path).map_err(io)?.take(SHORT_TEXT + 1).read_to_string(&mut text).map_err(io)?;
    if text.len() as u64 > SHORT_TEXT {
        return Err(Error::invalid(
            path.display(),
            "is too long for a text of settings or names; name another file",
        ));
    }
    Ok(text)
}

/// Refuses a place that holds something else than a file; nothing may be there.
fn refuse_other_than_file(path: &Path) -> Result<()> {
    match std::fs::metadata(path) {
        Ok(there) if !there.is_file() => Err(Error::invalid(
            path.display(),
            "is a folder, a pipe or a device, which no file may replace; name a file",
        )),
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io(path, error)),
        _ => Ok(()),
    }
}

/// Makes a file beside `path`, in its folder and so on its disk. It is removed unless `persist` gives it that
/// name. Temporary files are private by default; this one is for everybody the umask allows, as any new file is.
///
/// # Errors
/// `Invalid` where something else than a file has that name, `Io`; both naming `path`.
pub fn beside(path: &Path, suffix: &str) -> Result<NamedTempFile> {
    refuse_other_than_file(path)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".overlook-").suffix(suffix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The message of tempfile names the temporary file, which is of no use to a reader.
    builder.tempfile_in(folder_of(&place_of(path))).map_err(|error| Error::io(path, error.kind().into()))
}

/// Gives a file that was made [`beside`] `path` that name.
pub(crate) fn persist(unfinished: TempPath, path: &Path) -> Result<()> {
    unfinished.persist(place_of(path)).map_err(|error| Error::io(path, error.error))
}

/// Writes a file by `write`, and gives what that gave.
///
/// # Errors
/// As [`beside`], and whatever `write` gives; nothing is left behind then.
pub fn write<T>(path: &Path, write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<T>) -> Result<T> {
    let mut file = beside(path, ".part")?;
    let mut writer = BufWriter::new(file.as_file_mut());
    let result = write(&mut writer)?;
    writer.flush().map_err(|error| Error::io(path, error))?;
    drop(writer);
    persist(file.into_temp_path(), path)?;
    Ok(result)
}

/// Writes a file of this content.
///
/// # Errors
/// As [`beside`]; nothing is left behind then.
pub fn write_all(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    write(path, |writer| writer.write_all(content.as_ref()).map_err(|error| Error::io(path, error)))
}

/// Writes files into a folder, which is made where it is missing: `write` gets a folder to write them to, and they are seen under their
/// names only when all are complete.
///
/// # Errors
/// As [`beside`], and whatever `write` gives, its places named as they will be; nothing is left behind then.
pub fn write_folder<T>(folder: &Path, write: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
    let is_new = !folder.exists();
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
    let result = write_into(folder, write);
    if result.is_err() && is_new {
        // It may hold what others put there meanwhile.
        let _ = std::fs::remove_dir(folder);
    }
    result
}

fn write_into<T>(folder: &Path, write: impl FnOnce(&Path) -> Result<T>) -> Result<T> {
    let io = |error| Error::io(folder, error);
    let unfinished = tempfile::Builder::new()
        .prefix(".overlook-")
        .tempdir_in(folder)
        .map_err(|error| Error::io(folder, error.kind().into()))?;
    let result = write(unfinished.path()).map_err(|error| renamed(error, unfinished.path(), folder))?;
    let names: Result<Vec<_>, _> = std::fs::read_dir(unfinished.path())
        .map_err(io)?
        .map(|entry| entry.map(|entry| entry.file_name()))
        .collect();
    let names = names.map_err(io)?;
    names.iter().try_for_each(|name| refuse_other_than_file(&folder.join(name)))?;
    for name in names {
        let path = folder.join(&name);
        std::fs::rename(unfinished.path().join(name), place_of(&path))
            .map_err(|error| Error::io(path, error))?;
    }
    Ok(result)
}

/// An error that names places in `folder` instead of those in `unfinished`.
fn renamed(error: Error, unfinished: &Path, folder: &Path) -> Error {
    let (from, to) = (unfinished.display().to_string(), folder.display().to_string());
    match error {
        Error::Io { path, source } => {
            let path = path.strip_prefix(unfinished).map_or(path.clone(), |inside| folder.join(inside));
            Error::Io { path, source }
        }
        Error::Invalid { place, what } => Error::Invalid { place: place.replace(&from, &to), what },
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_a_folder_appear_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a/frames");
        let list = || {
            let mut names: Vec<_> =
                std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
            names.sort();
            names
        };
        let fails = |inside: &Path| {
            write_all(&inside.join("1"), "one")?;
            Err::<(), _>(Error::invalid(inside.join("2").display(), "is odd"))
        };
        let said = write_folder(&out, fails).unwrap_err().to_string();
        assert_eq!(said, format!("{}: is odd", out.join("2").display()));
        assert!(!out.exists());
        write_folder(&out, |inside| {
            write_all(&inside.join("1"), "one")?;
            write_all(&inside.join("2"), "two")
        })
        .unwrap();
        assert_eq!(list(), ["1", "2"]);
        // What is there stays where it fails, and is replaced where it does not.
        std::fs::write(out.join("other"), "kept").unwrap();
        assert!(write_folder(&out, fails).is_err());
        write_folder(&out, |inside| write_all(&inside.join("2"), "new")).unwrap();
        assert_eq!(list(), ["1", "2", "other"]);
        assert_eq!(std::fs::read_to_string(out.join("2")).unwrap(), "new");
        std::fs::create_dir(out.join("3")).unwrap();
        let said = write_folder(&out, |inside| write_all(&inside.join("3"), "")).unwrap_err().to_string();
        assert!(said.contains("name a file"), "{said}");
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kept");
        std::fs::write(&path, "old").unwrap();
        let result: Result<()> = write(&path, |writer| {
            writer.write_all(b"new").map_err(|error| Error::io("kept", error))?;
            Err(Error::Cancelled)
        });
        assert!(result.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    #[cfg(unix)]
    fn links_are_written_through_and_stay_whether_or_not_they_lead_to_a_file() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("far")).unwrap();
        std::fs::write(at("far/there"), "old").unwrap();
        for (to, link) in
            [("far/there", "link"), ("link", "second"), ("far/new", "to_nothing"), ("none/x", "lost")]
        {
            symlink(to, at(link)).unwrap();
        }
        for (link, to) in [("link", "far/there"), ("second", "far/there"), ("to_nothing", "far/new")] {
            write_all(&at(link), link).unwrap();
            assert!(at(link).is_symlink(), "{link}");
            assert_eq!(std::fs::read_to_string(at(to)).unwrap(), link);
        }
        assert_eq!(std::fs::read_dir(at("far")).unwrap().count(), 2);
        symlink("round", at("round")).unwrap();
        for link in ["lost", "round"] {
            let said = write_all(&at(link), "").unwrap_err().to_string();
            assert!(said.contains(link) && at(link).is_symlink(), "{said}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn no_file_takes_the_place_of_a_folder_or_of_a_device() {
        let folder = tempfile::tempdir().unwrap();
        for place in [folder.path(), Path::new("/dev/null")] {
            let said = beside(place, "").unwrap_err().to_string();
            assert!(said.starts_with(&place.display().to_string()) && said.contains("name a file"), "{said}");
        }
        let said = read_all(Path::new("/dev/zero")).unwrap_err().to_string();
        assert!(said.starts_with("/dev/zero: is a pipe or a device"), "{said}");
        assert!(refuse_pipe(folder.path()).is_ok() && refuse_pipe(&folder.path().join("none")).is_ok());
    }

    #[test]
    fn a_folder_that_is_not_there_is_said_without_the_name_of_a_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing/kept.ovl");
        let error = write_all(&path, "new").unwrap_err().to_string();
        let expected = format!("{}: there is no such file or folder; check the path", path.display());
        assert_eq!(error, expected);
    }
}
