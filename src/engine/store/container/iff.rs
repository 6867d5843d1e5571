//! Chunked files of bytes.
//!
//! Source: Morrison, *"EA IFF 85": Standard for Interchange Format Files*, Electronic Arts 1985. A file is one `FORM`:
//!
//! ```text
//! "FORM" length "TYPE"  { id length payload [0 where the length is odd] } …
//!    4     4      4        4    4
//! ```
//!
//! Lengths are 32-bit and big-endian; chunks with an unknown id are skipped. What differs: payloads written by
//! [`FormWriter::chunk`] end in a checksum, the CRC-32 (IEEE 802.3) of the id and of the payload before it; the `FORM` must fill
//! the file exactly, so that a cut or lengthened file is noticed; and a file beyond 4 GiB, which the length of the `FORM` cannot
//! say, has `FFFFFFFF` there, as RF64 does for RIFF (EBU Tech 3306). Chunks never pass 4 GiB.

use std::io::{self, Seek, SeekFrom, Write};

use super::source::ReadAt;

use crate::plural::{counted, either};

/// Four characters that say what a chunk holds.
pub(crate) type ChunkId = [u8; 4];

/// Bytes before a payload: id and length.
pub(crate) const CHUNK_HEADER: u64 = 8;

/// Bytes before the first chunk: `FORM`, length, type.
pub(crate) const FORM_HEADER: u64 = 12;

/// Bytes behind a payload.
pub(crate) const CHECKSUM: u64 = 4;

/// What can go wrong with a chunked file.
#[derive(Debug, thiserror::Error)]
pub(crate) enum IffError {
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file contradicts its format.
    #[error("at byte {offset}: {what}")]
    Malformed {
        /// Where, in bytes from the start of the file.
        offset: u64,
        /// What is wrong.
        what: String,
    },
    /// More bytes in a chunk than 32-bit lengths can count.
    #[error("a chunk of {bytes} bytes")]
    TooLarge {
        /// Bytes of the chunk.
        bytes: u64,
    },
}

fn malformed(offset: u64, what: impl Into<String>) -> IffError {
    IffError::Malformed { offset, what: what.into() }
}

/// The CRC-32 of a chunk's id and of its payload before the checksum.
pub(crate) fn checksum(id: ChunkId, payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&id);
    hasher.update(payload);
    hasher.finalize()
}

/// Whether a checksum is what it was stated to be. A program built for fuzzing takes any: no mutation would get past them.
pub(crate) fn agree(stated: &[u8], found: u32) -> bool {
    cfg!(fuzzing) || stated == found.to_be_bytes()
}

/// Length of a `FORM` that does not fit into 32 bits. Odd, as no file's is.
const LARGE: u32 = u32::MAX;

/// Writes a `FORM`, chunk by chunk.
pub(crate) struct FormWriter<W> {
    inner: W,
    /// Bytes written, always even.
    position: u64,
}

impl<W: Write + Seek> FormWriter<W> {
    /// Starts a `FORM` of the given type at the start of `inner`.
    pub(crate) fn new(mut inner: W, form_type: ChunkId) -> Result<Self, IffError> {
        inner.write_all(b"FORM\0\0\0\0")?;
        inner.write_all(&form_type)?;
        Ok(Self { inner, position: FORM_HEADER })
    }

    /// Bytes written so far.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// Appends a chunk with a checksum; gives the offset of its header from the start of the file.
    ///
    /// # Errors
    /// Where the chunk would outgrow 32-bit lengths, and where the file refuses.
    pub(crate) fn chunk(&mut self, id: ChunkId, payload: &[u8]) -> Result<u64, IffError> {
        self.parts(id, &[payload, &checksum(id, payload).to_be_bytes()])
    }

    /// Appends a chunk as it is, without a checksum.
    pub(crate) fn plain_chunk(&mut self, id: ChunkId, payload: &[u8]) -> Result<u64, IffError> {
        self.parts(id, &[payload])
    }

    fn parts(&mut self, id: ChunkId, parts: &[&[u8]]) -> Result<u64, IffError> {
        let offset = self.position;
        let length: u64 = parts.iter().map(|part| part.len() as u64).sum();
        let stated = u32::try_from(length).map_err(|_| IffError::TooLarge { bytes: length })?;
        self.inner.write_all(&id)?;
        self.inner.write_all(&stated.to_be_bytes())?;
        for part in parts {
            self.inner.write_all(part)?;
        }
        if length % 2 == 1 {
            self.inner.write_all(&[0])?;
        }
        self.position = offset + CHUNK_HEADER + length + length % 2;
        Ok(offset)
    }

    /// Begins a chunk without a checksum, whose length is not known yet; gives where.
    pub(crate) fn begin(&mut self, id: ChunkId) -> Result<u64, IffError> {
        self.parts(id, &[])
    }

    /// Goes on with the chunk that was begun.
    pub(crate) fn append(&mut self, bytes: &[u8]) -> Result<(), IffError> {
        self.inner.write_all(bytes)?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    /// Ends the chunk that was begun at `offset`.
    pub(crate) fn end(&mut self, offset: u64) -> Result<(), IffError> {
        let length = self.position - offset - CHUNK_HEADER;
        let stated = u32::try_from(length).map_err(|_| IffError::TooLarge { bytes: length })?;
        self.append(&[0][..(length % 2) as usize])?;
        self.inner.seek(SeekFrom::Start(offset + 4))?;
        self.inner.write_all(&stated.to_be_bytes())?;
        self.inner.seek(SeekFrom::Start(self.position))?;
        Ok(())
    }

    /// Replaces the chunk at `offset` by one of the same length.
    pub(crate) fn replace(&mut self, offset: u64, id: ChunkId, payload: &[u8]) -> Result<(), IffError> {
        self.inner.seek(SeekFrom::Start(offset + CHUNK_HEADER))?;
        self.inner.write_all(payload)?;
        self.inner.write_all(&checksum(id, payload).to_be_bytes())?;
        self.inner.seek(SeekFrom::Start(self.position))?;
        Ok(())
    }

    /// Writes the length of the `FORM`; gives the file back and its size in bytes.
    pub(crate) fn finish(mut self) -> Result<(W, u64), IffError> {
        self.inner.seek(SeekFrom::Start(4))?;
        let length = u32::try_from(self.position - CHUNK_HEADER).unwrap_or(LARGE);
        self.inner.write_all(&length.to_be_bytes())?;
        self.inner.flush()?;
        Ok((self.inner, self.position))
    }
}

/// The position of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChunkHeader {
    /// What it holds.
    pub(crate) id: ChunkId,
    /// Bytes from the start of the file to its id.
    pub(crate) offset: u64,
    /// Bytes of its payload, checksum included.
    pub(crate) length: u64,
}

impl ChunkHeader {
    /// Where the next chunk begins.
    pub(crate) fn end(&self) -> u64 {
        self.offset + CHUNK_HEADER + self.length + self.length % 2
    }
}

/// Reads a `FORM`, chunk by chunk, in any order.
#[derive(Debug)]
pub(crate) struct FormReader<R> {
    inner: R,
    size: u64,
}

impl<R: ReadAt> FormReader<R> {
    /// Checks that `inner` is exactly one `FORM` of the given type.
    ///
    /// # Errors
    /// Where it is not, and where `inner` refuses.
    pub(crate) fn open(inner: R, form_type: ChunkId) -> Result<Self, IffError> {
        let size = inner.size()?;
        let mut header = [0; FORM_HEADER as usize];
        if size < FORM_HEADER {
            return Err(malformed(
                0,
                format!("{} {} too few for an IFF file", counted(size, "byte"), either(size, "is", "are")),
            ));
        }
        inner.read_exact_at(&mut header, 0)?;
        if header[..4] != *b"FORM" || header[8..] != form_type {
            return Err(malformed(0, format!("not an IFF file of type {}", name(form_type))));
        }
        let length = u32::from_be_bytes([header[4], header[5], header[6], header[7]]);
        let is_large = length == LARGE && size - CHUNK_HEADER > u64::from(LARGE);
        if !is_large && u64::from(length) + CHUNK_HEADER != size {
            let stated = u64::from(length) + CHUNK_HEADER;
            return Err(malformed(
                4,
                format!("the file should have {} but has {size}; copy it again", counted(stated, "byte")),
            ));
        }
        Ok(Self { inner, size })
    }

    /// Size of the file, bytes.
    pub(crate) fn size(&self) -> u64 {
        self.size
    }

    /// The header of the chunk at `offset`, or `None` at the end of the file.
    ///
    /// # Errors
    /// Where the chunk does not fit into the file.
    pub(crate) fn header_at(&self, offset: u64) -> Result<Option<ChunkHeader>, IffError> {
        if offset == self.size {
            return Ok(None);
        }
        if offset < FORM_HEADER || offset.saturating_add(CHUNK_HEADER) > self.size {
            return Err(malformed(offset, "a chunk is cut short"));
        }
        let mut header = [0; CHUNK_HEADER as usize];
        self.inner.read_exact_at(&mut header, offset)?;
        let [a, b, c, d, length @ ..] = header;
        let header = ChunkHeader { id: [a, b, c, d], offset, length: u64::from(u32::from_be_bytes(length)) };
        if header.end() > self.size {
            return Err(malformed(
                offset,
                format!("chunk {} is longer than the rest of the file", name(header.id)),
            ));
        }
        Ok(Some(header))
    }

    /// The payload of a chunk that [`FormReader::header_at`] gave, its checksum checked and taken off.
    pub(crate) fn payload(&self, header: &ChunkHeader) -> Result<Vec<u8>, IffError> {
        let mut payload = self.plain_payload(header, 0..header.length)?;
        let damaged = || {
            malformed(
                header.offset,
                format!("chunk {} is damaged; copy or make the file again", name(header.id)),
            )
        };
        let stated = payload.split_off(payload.len().checked_sub(CHECKSUM as usize).ok_or_else(damaged)?);
        if !agree(&stated, checksum(header.id, &payload)) {
            return Err(damaged());
        }
        Ok(payload)
    }

    /// Some bytes of the payload of a chunk that [`FormReader::header_at`] gave, as they are.
    ///
    /// # Errors
    /// Where there are no such bytes, and where the file refuses.
    pub(crate) fn plain_payload(
        &self,
        header: &ChunkHeader,
        range: std::ops::Range<u64>,
    ) -> Result<Vec<u8>, IffError> {
        if range.start > range.end || range.end > header.length {
            return Err(malformed(header.offset, format!("chunk {} is too short", name(header.id))));
        }
        // `header_at` has held the length against the size of the file.
        let mut bytes = vec![0; (range.end - range.start) as usize];
        self.inner.read_exact_at(&mut bytes, header.offset + CHUNK_HEADER + range.start)?;
        Ok(bytes)
    }
}

fn name(id: ChunkId) -> String {
    format!("'{}'", id.escape_ascii())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn two_chunks() -> Vec<u8> {
        let mut form = FormWriter::new(Cursor::new(Vec::new()), *b"TEST").unwrap();
        let first = form.chunk(*b"ONE ", &[0; 3]).unwrap();
        form.plain_chunk(*b"TWO ", b"even").unwrap();
        form.replace(first, *b"ONE ", &[1, 2, 3]).unwrap();
        let (file, size) = form.finish().unwrap();
        assert_eq!(size, file.get_ref().len() as u64);
        file.into_inner()
    }

    #[test]
    fn chunks_are_padded_to_even_offsets_and_come_back() {
        let bytes = two_chunks();
        assert_eq!(bytes.len(), 12 + (8 + 3 + 4 + 1) + (8 + 4));
        let form = FormReader::open(bytes, *b"TEST").unwrap();
        let one = form.header_at(FORM_HEADER).unwrap().unwrap();
        let two = form.header_at(one.end()).unwrap().unwrap();
        assert_eq!((one.id, two.id), (*b"ONE ", *b"TWO "));
        assert_eq!(form.plain_payload(&two, 0..4).unwrap(), b"even");
        assert_eq!(form.plain_payload(&two, 1..3).unwrap(), b"ve");
        assert!(form.plain_payload(&two, 1..5).is_err());
        assert_eq!(form.payload(&one).unwrap(), [1, 2, 3]);
        assert_eq!(form.header_at(two.end()).unwrap(), None);
    }

    #[test]
    fn another_type_a_cut_and_a_lengthened_file_are_refused() {
        let bytes = two_chunks();
        assert!(FormReader::open(bytes.clone(), *b"ELSE").is_err());
        assert!(FormReader::open(bytes[..bytes.len() - 1].to_vec(), *b"TEST").is_err());
        assert!(FormReader::open([bytes, vec![0]].concat(), *b"TEST").is_err());
    }

    /// Counts bytes and keeps none.
    struct Counted(u64, u64);

    impl Write for Counted {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 += bytes.len() as u64;
            self.1 = self.1.max(self.0);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Counted {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            if let SeekFrom::Start(offset) = to {
                self.0 = offset;
            }
            Ok(self.0)
        }
    }

    #[test]
    fn offsets_go_on_beyond_four_gibibytes() {
        let mut form = FormWriter::new(Counted(0, 0), *b"TEST").unwrap();
        let megabyte = vec![7; 1 << 26];
        let last = (0..70).map(|_| form.plain_chunk(*b"MANY", &megabyte).unwrap()).last().unwrap();
        assert_eq!(last, 12 + 69 * (8 + (1 << 26)));
        let (file, size) = form.finish().unwrap();
        assert!(size > 1 << 32 && file.1 == size);
    }
}
