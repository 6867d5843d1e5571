//! Files that are seen under their names only when they are complete: whatever stood there stays until then.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// Makes a file beside `path`, in the folder and so on the disk where that lies, which is removed unless it is renamed. Temporary
/// files are private by default; this one is for everybody the umask allows, as any new file is.
///
/// # Errors
/// `Io` naming `path`.
pub(crate) fn beside(path: &Path, suffix: &str) -> Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".overlook-").suffix(suffix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // What tempfile says names a file that nobody asked for.
    builder.tempfile_in(folder).map_err(|error| Error::io(path, error.kind().into()))
}

/// Writes a file by `write`, and gives what that gave.
///
/// # Errors
/// `Io`, and whatever `write` gives; nothing is left behind then.
pub(crate) fn write<T>(path: &Path, write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<T>) -> Result<T> {
    let mut file = beside(path, ".part")?;
    let mut writer = BufWriter::new(file.as_file_mut());
    let result = write(&mut writer)?;
    writer.flush().map_err(|error| Error::io(path, error))?;
    drop(writer);
    file.persist(path).map_err(|error| Error::io(path, error.error))?;
    Ok(result)
}

/// Writes a file of this content.
///
/// # Errors
/// `Io`; nothing is left behind then.
pub(crate) fn write_all(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    write(path, |writer| writer.write_all(content.as_ref()).map_err(|error| Error::io(path, error)))
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_folder_that_is_not_there_is_said_without_the_name_of_a_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing/kept.ovl");
        let error = write_all(&path, "new").unwrap_err().to_string();
        let expected = format!("{}: there is no such file or folder; check the path", path.display());
        assert_eq!(error, expected);
    }
}
