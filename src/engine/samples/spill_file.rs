//! Records that are held in memory up to a bound, and beyond it in a temporary file without a name, which grows at its end, is
//! read anywhere and is gone with its last user. It is in the system's folder for such files (`TMPDIR`).
//!
//! Records one after the other in a file that is kept: what a [`Record`] needs to be read back, and its planes.
//!
//! ```text
//! bytes of the shape u32, bytes of the planes u64, shape (JSON), planes, one after the other        numbers little-endian
//! ```

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;
use serde::de::DeserializeOwned;

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
    settings.capture.memory_bytes() / SHARE
}

/// What is read from anywhere.
pub trait ReadSeek: Read + Seek {}

impl<T: Read + Seek> ReadSeek for T {}

/// Longer shapes, and JSON, are not read.
const MOST_JSON_BYTES: u64 = 1 << 30;

/// Writes records, and other things, to a file that is called `place` in errors.
pub struct RecordWriter<'a> {
    writer: &'a mut dyn Write,
    place: String,
}

impl<'a> RecordWriter<'a> {
    /// Nothing is written yet.
    ///
    /// # Errors
    /// `Unsupported` on a machine that stores numbers in another order.
    pub fn new(writer: &'a mut dyn Write, place: impl Into<String>) -> Result<Self> {
        let place = place.into();
        if cfg!(target_endian = "big") {
            return Err(Error::unsupported(
                place,
                "parts are written and read on little-endian machines alone",
            ));
        }
        Ok(Self { writer, place })
    }

    /// Writes a record.
    ///
    /// # Errors
    /// `Io`.
    pub(crate) fn record<T: Record>(&mut self, record: &T) -> Result<()>
    where
        T::RecordShape: Serialize,
    {
        let shape = self.to_json(&record.shape())?;
        let planes = record.planes();
        let bytes: u64 = planes.iter().map(|plane| plane.len() as u64).sum();
        self.bytes(&(shape.len() as u32).to_le_bytes())?;
        self.bytes(&bytes.to_le_bytes())?;
        self.bytes(&shape)?;
        planes.into_iter().try_for_each(|plane| self.bytes(plane))
    }

    /// Writes a document.
    ///
    /// # Errors
    /// `Io`; `Invalid` where it cannot be JSON.
    pub fn json(&mut self, document: &impl Serialize) -> Result<()> {
        let json = self.to_json(document)?;
        self.number(json.len() as u64)?;
        self.bytes(&json)
    }

    /// Writes a number.
    ///
    /// # Errors
    /// `Io`.
    pub(crate) fn number(&mut self, number: u64) -> Result<()> {
        self.bytes(&number.to_le_bytes())
    }

    fn to_json(&self, document: &impl Serialize) -> Result<Vec<u8>> {
        serde_json::to_vec(document).map_err(|error| Error::invalid(&self.place, error.to_string()))
    }

    fn bytes(&mut self, bytes: &[u8]) -> Result<()> {
        self.writer.write_all(bytes).map_err(|error| Error::io(&self.place, error))
    }
}

/// Reads what [`RecordWriter`] wrote, in the same order.
pub struct RecordReader<'a> {
    reader: Box<dyn ReadSeek + 'a>,
    place: String,
}

impl<'a> RecordReader<'a> {
    /// At the first byte.
    pub fn new(reader: Box<dyn ReadSeek + 'a>, place: impl Into<String>) -> Self {
        Self { reader, place: place.into() }
    }

    /// Reads a record.
    ///
    /// # Errors
    /// `Io`; `Invalid` where it is none.
    pub(crate) fn record<T: Record>(&mut self) -> Result<T>
    where
        T::RecordShape: DeserializeOwned,
    {
        let (shape, bytes) = self.record_head()?;
        let shape: T::RecordShape = self.json_of(shape)?;
        let Self { reader, place } = self;
        T::read(&shape, |planes| {
            if planes.iter().map(|plane| plane.len() as u64).sum::<u64>() != bytes {
                return Err(Error::invalid(&*place, "holds a record of another length; make it again"));
            }
            planes
                .iter_mut()
                .try_for_each(|plane| reader.read_exact(plane))
                .map_err(|error| Error::io(&*place, error))
        })
    }

    /// Passes over a record.
    ///
    /// # Errors
    /// `Io`.
    pub(crate) fn skip_record(&mut self) -> Result<()> {
        let (shape, bytes) = self.record_head()?;
        let passed = self.reader.seek(SeekFrom::Current((shape + bytes) as i64));
        passed.map(|_| ()).map_err(|error| Error::io(&self.place, error))
    }

    /// Reads a document.
    ///
    /// # Errors
    /// `Io`; `Invalid` where it is none.
    pub fn json<T: DeserializeOwned>(&mut self) -> Result<T> {
        let bytes = self.number()?;
        self.json_of(bytes)
    }

    /// Reads a number.
    ///
    /// # Errors
    /// `Io`.
    pub(crate) fn number(&mut self) -> Result<u64> {
        let mut number = [0; 8];
        self.exact(&mut number)?;
        Ok(u64::from_le_bytes(number))
    }

    /// Bytes of the shape and of the planes.
    fn record_head(&mut self) -> Result<(u64, u64)> {
        let mut shape = [0; 4];
        self.exact(&mut shape)?;
        Ok((u64::from(u32::from_le_bytes(shape)), self.number()?))
    }

    fn json_of<T: DeserializeOwned>(&mut self, bytes: u64) -> Result<T> {
        let mut json = Vec::new();
        let read = self.reader.by_ref().take(bytes.min(MOST_JSON_BYTES)).read_to_end(&mut json);
        read.map_err(|error| Error::io(&self.place, error))?;
        serde_json::from_slice(&json)
            .map_err(|error| Error::invalid(&self.place, format!("{error}; make it again")))
    }

    fn exact(&mut self, bytes: &mut [u8]) -> Result<()> {
        self.reader.read_exact(bytes).map_err(|error| Error::io(&self.place, error))
    }
}
