//! Bytes at any place of a file, read from many threads at once.
//!
//! Positioned reads rather than a memory map: a map of a file that somebody cuts short while it plays ends the program with a
//! signal, and needs `unsafe`; a read gives an error with the reason. The system's cache serves both alike.

use std::fs::File;
use std::io;

/// Something with bytes at offsets. It may shrink while it is read; reads then fail.
pub trait ReadAt: Send + Sync {
    /// Bytes there are.
    ///
    /// # Errors
    /// Where the file refuses.
    fn size(&self) -> io::Result<u64>;

    /// Fills `bytes` with what begins at `offset`.
    ///
    /// # Errors
    /// If the file has fewer bytes, or cannot be read.
    fn read_exact_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()>;
}

impl ReadAt for File {
    fn size(&self) -> io::Result<u64> {
        self.metadata().map(|metadata| metadata.len())
    }

    #[cfg(unix)]
    fn read_exact_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(self, bytes, offset)
    }

    #[cfg(windows)]
    fn read_exact_at(&self, mut bytes: &mut [u8], mut offset: u64) -> io::Result<()> {
        while !bytes.is_empty() {
            match std::os::windows::fs::FileExt::seek_read(self, bytes, offset)? {
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                read => {
                    bytes = &mut bytes[read..];
                    offset += read as u64;
                }
            }
        }
        Ok(())
    }
}

impl ReadAt for Vec<u8> {
    fn size(&self) -> io::Result<u64> {
        Ok(self.len() as u64)
    }

    fn read_exact_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        let start = usize::try_from(offset).unwrap_or(usize::MAX);
        let there = self.get(start..).and_then(|rest| rest.get(..bytes.len()));
        bytes.copy_from_slice(there.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }
}

impl ReadAt for Box<dyn ReadAt> {
    fn size(&self) -> io::Result<u64> {
        self.as_ref().size()
    }

    fn read_exact_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        self.as_ref().read_exact_at(bytes, offset)
    }
}
