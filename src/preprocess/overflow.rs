//! What is more than memory may hold: a temporary file without a name, which grows at its end, is read anywhere and is gone with
//! its last user. It lies where the system keeps such files (`TMPDIR`).

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};

/// Made when something is first written.
#[derive(Debug, Default)]
pub(super) struct Overflow {
    file: Mutex<Option<File>>,
    bytes: u64,
}

impl Overflow {
    /// Writes planes one after another, in the machine's byte order; gives where they begin.
    ///
    /// # Errors
    /// `Io` naming the folder of temporary files.
    pub(super) fn append(&mut self, planes: &[&[u8]]) -> Result<u64> {
        let offset = self.bytes;
        let mut write = || {
            let file = self.file.get_mut().unwrap_or_else(PoisonError::into_inner);
            let file = match file {
                Some(file) => file,
                none => none.insert(tempfile::tempfile()?),
            };
            file.seek(SeekFrom::Start(offset))?;
            planes.iter().try_for_each(|plane| file.write_all(plane))
        };
        write().map_err(at_place)?;
        self.bytes += planes.iter().map(|plane| plane.len() as u64).sum::<u64>();
        Ok(offset)
    }

    /// Reads planes back.
    ///
    /// # Errors
    /// As [`Overflow::append`].
    pub(super) fn read(&self, offset: u64, planes: &mut [&mut [u8]]) -> Result<()> {
        let mut read = || {
            let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
            let file = file.as_mut().ok_or(std::io::ErrorKind::NotFound)?;
            file.seek(SeekFrom::Start(offset))?;
            planes.iter_mut().try_for_each(|plane| file.read_exact(plane))
        };
        read().map_err(at_place)
    }
}

fn at_place(error: std::io::Error) -> Error {
    Error::io(std::env::temp_dir().join("(a temporary file of samples)"), error)
}
