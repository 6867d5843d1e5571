//! Parts of a film: its pictures without loss, until they are encoded together.
//!
//! ```text
//! part: for each picture its length in bytes, u32 little-endian, and the picture as film_bytes gives it, deflated (zlib, RFC 1950)
//! ```

use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

use libdeflater::{CompressionLvl, Compressor, Decompressor};

use crate::cli::output::{Inputs, OpenPart, PartFiles};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::part::Part;
use overlook_engine::render::Picture;
use overlook_engine::render::film::film_bytes;
use overlook_engine::whole_file;

/// The parts of one film.
pub(super) struct FilmParts {
    files: PartFiles,
    /// Bytes of a picture.
    picture_bytes: usize,
}

impl FilmParts {
    /// The parts that lie beside the film `out`, whose pictures have so many bytes.
    pub(super) fn beside(out: &Path, inputs: Inputs, picture_bytes: usize) -> Self {
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        Self { files: PartFiles::new(whole_file::folder_of(out), &name, inputs), picture_bytes }
    }

    /// Where a part is, once it is complete.
    pub(super) fn path(&self, part: Part) -> PathBuf {
        self.files.path(part)
    }

    /// Writes a part, unless it is complete: `paint` passes on one picture after the other.
    ///
    /// # Errors
    /// Those of `paint`, and `Io`.
    pub(super) fn write(
        &self,
        part: Part,
        paint: impl FnOnce(&mut dyn FnMut(&Picture) -> Result<()>) -> Result<Option<String>>,
    ) -> Result<Option<String>> {
        if self.files.is_complete(part) {
            return Ok(None);
        }
        let (mut notice, path) = (None, self.path(part));
        let mut compressor = Compressor::new(CompressionLvl::fastest());
        self.files.write(part, |writer| {
            notice = paint(&mut |picture| {
                let picture = film_bytes(picture);
                let mut deflated = vec![0; compressor.zlib_compress_bound(picture.len())];
                let length = compressor
                    .zlib_compress(&picture, &mut deflated)
                    .map_err(|error| Error::invalid(path.display(), error.to_string()))?;
                let written = writer.write_all(&(length as u32).to_le_bytes());
                written
                    .and_then(|()| writer.write_all(&deflated[..length]))
                    .map_err(|error| Error::io(&path, error))
            })?;
            Ok(())
        })?;
        Ok(notice)
    }

    /// All of `of` parts, in their order.
    ///
    /// # Errors
    /// As [`PartFiles::open_all`].
    pub(super) fn open_all(&self, of: u32) -> Result<Vec<OpenPart>> {
        self.files.open_all(of)
    }

    /// Passes the pictures of the parts on, one after the other.
    ///
    /// # Errors
    /// Those of `take`, `Invalid` or `Io` where a part cannot be read, and `Cancelled`.
    pub(super) fn read(
        &self,
        parts: Vec<OpenPart>,
        job: &Job,
        mut take: impl FnMut(&[u8]) -> Result<()>,
    ) -> Result<()> {
        job.start("Encoding", parts.len());
        let mut decompressor = Decompressor::new();
        let mut picture = vec![0; self.picture_bytes];
        for OpenPart { path, mut reader, .. } in parts {
            let io = |error| Error::io(&path, error);
            while !reader.fill_buf().map_err(io)?.is_empty() {
                job.check()?;
                let mut length = [0; 4];
                reader.read_exact(&mut length).map_err(io)?;
                let mut deflated = Vec::new();
                reader
                    .by_ref()
                    .take(u32::from_le_bytes(length).into())
                    .read_to_end(&mut deflated)
                    .map_err(io)?;
                let inflated = decompressor.zlib_decompress(&deflated, &mut picture);
                if !inflated.is_ok_and(|bytes| bytes == picture.len()) {
                    return Err(Error::invalid(
                        path.display(),
                        "holds a picture that cannot be read; make the part again",
                    ));
                }
                take(&picture)?;
            }
            job.advance(1);
        }
        Ok(())
    }
}
