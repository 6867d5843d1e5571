//! Records one after the other in a file that is kept: what a [`Record`] needs to be read back, and its planes.
//!
//! ```text
//! bytes of the shape u32, bytes of the planes u64, shape (JSON), planes, one after the other        numbers little-endian
//! ```

use std::io::{Read, Seek, SeekFrom, Write};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::spill_file::Record;
use crate::error::{Error, Result};

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
