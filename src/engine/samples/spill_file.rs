//! Records that are held in memory up to a bound, and beyond it in a temporary file without a name, which grows at its end, is
//! read anywhere and is gone with its last user. It is in the system's folder for such files (`TMPDIR`).

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::{Error, Result};
use crate::settings::Settings;

/// What may be written to the file: planes of plain numbers, and what is needed to read them back.
pub(crate) trait Record: Sized {
    /// What is kept in memory of a record in the file.
    type RecordShape: std::fmt::Debug;

    /// Bytes that it takes in memory.
    fn bytes(&self) -> usize;

    /// What is kept of it in memory.
    fn shape(&self) -> Self::RecordShape;

    /// Its planes, in the order of the file.
    fn planes(&self) -> Vec<&[u8]>;

    /// A record of a shape, whose planes `fill` reads in the order of the file.
    ///
    /// # Errors
    /// Whatever `fill` gives.
    fn read(shape: &Self::RecordShape, fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>) -> Result<Self>;
}

/// Where a record is.
#[derive(Debug)]
pub(crate) enum RecordPlace<T: Record> {
    /// Within the bound.
    Memory(Arc<T>),
    /// In the file, from a byte on.
    File(u64, T::RecordShape),
}

/// A bound on memory, and the file for what is beyond it.
#[derive(Debug)]
pub(crate) struct SpillFile {
    /// Bytes that are held in memory, and how many may be.
    held: usize,
    pub(crate) bound: usize,
    file: TemporaryFile,
}

impl SpillFile {
    /// Nothing is held yet, and at most `bound` bytes will be.
    pub(crate) fn new(bound: usize) -> Self {
        Self { held: 0, bound, file: TemporaryFile::default() }
    }

    /// Takes a record: into memory while there is room, else into the file.
    ///
    /// # Errors
    /// `Io` naming the folder of temporary files.
    pub(crate) fn put<T: Record>(&mut self, record: impl Into<Arc<T>>) -> Result<RecordPlace<T>> {
        let record = record.into();
        let held = self.held.saturating_add(record.bytes());
        if held <= self.bound {
            self.held = held;
            return Ok(RecordPlace::Memory(record));
        }
        Ok(RecordPlace::File(self.file.append(&record.planes())?, record.shape()))
    }

    /// Puts a record in the place of another one of the same shape.
    ///
    /// # Errors
    /// As [`SpillFile::put`].
    pub(crate) fn replace<T: Record>(&mut self, place: &mut RecordPlace<T>, record: T) -> Result<()> {
        match place {
            RecordPlace::Memory(held) => *held = Arc::new(record),
            RecordPlace::File(offset, _) => self.file.write(*offset, &record.planes())?,
        }
        Ok(())
    }

    /// A record, bit for bit as it was put.
    ///
    /// # Errors
    /// As [`SpillFile::put`].
    pub(crate) fn get<T: Record>(&self, place: &RecordPlace<T>) -> Result<Arc<T>> {
        match place {
            RecordPlace::Memory(record) => Ok(record.clone()),
            RecordPlace::File(offset, shape) => {
                T::read(shape, |planes| self.file.read(*offset, planes)).map(Arc::new)
            }
        }
    }
}

impl SpillFile {
    /// Fills `planes` with those of a record, in the order of [`Record::planes`]: each is as long as the record's.
    ///
    /// # Errors
    /// As [`SpillFile::put`].
    pub(crate) fn fill<T: Record>(&self, place: &RecordPlace<T>, planes: &mut [&mut [u8]]) -> Result<()> {
        match place {
            RecordPlace::Memory(record) => {
                planes.iter_mut().zip(record.planes()).for_each(|(to, from)| to.copy_from_slice(from));
                Ok(())
            }
            RecordPlace::File(offset, _) => self.file.read(*offset, planes),
        }
    }
}

/// Made when something is first written.
#[derive(Debug, Default)]
struct TemporaryFile {
    file: Mutex<Option<File>>,
    bytes: u64,
}

impl TemporaryFile {
    /// Writes planes one after another, in the machine's byte order; gives where they begin.
    ///
    /// # Errors
    /// `Io` naming the folder of temporary files.
    fn append(&mut self, planes: &[&[u8]]) -> Result<u64> {
        let offset = self.bytes;
        self.write(offset, planes)?;
        self.bytes += planes.iter().map(|plane| plane.len() as u64).sum::<u64>();
        Ok(offset)
    }

    /// Writes planes one after another from a byte on.
    ///
    /// # Errors
    /// As [`TemporaryFile::append`].
    fn write(&mut self, offset: u64, planes: &[&[u8]]) -> Result<()> {
        let mut write = || {
            let file = self.file.get_mut().unwrap_or_else(PoisonError::into_inner);
            let file = match file {
                Some(file) => file,
                none => none.insert(tempfile::tempfile()?),
            };
            file.seek(SeekFrom::Start(offset))?;
            planes.iter().try_for_each(|plane| file.write_all(plane))
        };
        write().map_err(at_place)
    }

    /// Reads planes back.
    ///
    /// # Errors
    /// As [`TemporaryFile::append`].
    fn read(&self, offset: u64, planes: &mut [&mut [u8]]) -> Result<()> {
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

/// Bytes of the memory setting that samples take, before pruning and after, until they go to a temporary file.
pub(crate) fn samples_in_memory(settings: &Settings) -> usize {
    const SHARE: usize = 16;
    ((settings.capture.memory as usize) << 20) / SHARE
}
