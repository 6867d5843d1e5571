//! How one plane of bytes is written: the seam at which codecs are exchanged.

use super::rle;

/// A lossless coding of a plane of bytes.
pub trait PlaneCodec: Sync {
    /// What stands in the file before a plane of this codec.
    fn id(&self) -> u8;

    /// Codes `bytes`; the same bytes give the same code, always.
    fn encode(&self, bytes: &[u8]) -> Vec<u8>;

    /// Gives exactly `expected_len` bytes back from all of `coded`.
    ///
    /// # Errors
    /// Says what is wrong with `coded`. Implementations never panic, and allocate nothing before they know that
    /// `coded` is long enough to hold `expected_len` bytes.
    fn decode(&self, coded: &[u8], expected_len: usize) -> Result<Vec<u8>, String>;
}

/// No coding at all: the off form.
pub struct Raw;

impl PlaneCodec for Raw {
    fn id(&self) -> u8 {
        0
    }

    fn encode(&self, bytes: &[u8]) -> Vec<u8> {
        bytes.to_vec()
    }

    fn decode(&self, coded: &[u8], expected_len: usize) -> Result<Vec<u8>, String> {
        if coded.len() != expected_len {
            return Err(format!("{} bytes instead of {expected_len}", coded.len()));
        }
        Ok(coded.to_vec())
    }
}

/// The paper's run-length encoding: see [`rle`].
pub struct RunLength;

impl PlaneCodec for RunLength {
    fn id(&self) -> u8 {
        1
    }

    fn encode(&self, bytes: &[u8]) -> Vec<u8> {
        rle::encode(bytes)
    }

    fn decode(&self, coded: &[u8], expected_len: usize) -> Result<Vec<u8>, String> {
        rle::decode(coded, expected_len)
    }
}

/// Every codec a store may use. Where two are equally short the earlier is written.
pub const CODECS: [&dyn PlaneCodec; 2] = [&Raw, &RunLength];

/// Bytes before each plane: the codec's id and the length of the code.
const PLANE_HEADER: usize = 1 + 4;

/// Appends `plane` in whichever of [`CODECS`] is shortest: id, big-endian 32-bit length, code.
pub fn append_plane(target: &mut Vec<u8>, plane: &[u8]) {
    let coded = CODECS.iter().map(|codec| (codec.id(), codec.encode(plane)));
    if let Some((id, code)) = coded.min_by_key(|(_, code)| code.len()) {
        target.push(id);
        target.extend_from_slice(&(code.len() as u32).to_be_bytes());
        target.extend_from_slice(&code);
    }
}

/// Takes a plane of `expected_len` bytes off the front of `rest`.
///
/// # Errors
/// Says what is wrong: an unknown codec, a length beyond `rest`, a code that does not decode.
pub fn take_plane(rest: &mut &[u8], expected_len: usize) -> Result<Vec<u8>, String> {
    let (header, after) = rest.split_at_checked(PLANE_HEADER).ok_or("a plane is cut short")?;
    let length = u32::from_be_bytes([header[1], header[2], header[3], header[4]]) as usize;
    let (coded, after) =
        after.split_at_checked(length).ok_or("a plane is longer than the chunk it stands in")?;
    let codec = CODECS.iter().find(|codec| codec.id() == header[0]).ok_or_else(|| {
        format!("a plane has the unknown codec {}; a newer Overlook may read it", header[0])
    })?;
    *rest = after;
    codec.decode(coded, expected_len)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shorter_code_is_written() {
        let mut coded = Vec::new();
        append_plane(&mut coded, &[5; 100]);
        append_plane(&mut coded, &[1, 2, 3]);
        append_plane(&mut coded, &[]);
        assert_eq!(coded, [1, 0, 0, 0, 2, 157, 5, 0, 0, 0, 0, 3, 1, 2, 3, 0, 0, 0, 0, 0]);
        let mut rest = coded.as_slice();
        assert_eq!(take_plane(&mut rest, 100).unwrap(), [5; 100]);
        assert_eq!(take_plane(&mut rest, 3).unwrap(), [1, 2, 3]);
        assert_eq!(take_plane(&mut rest, 0).unwrap(), [0_u8; 0]);
        assert!(take_plane(&mut rest, 0).is_err());
    }

    #[test]
    fn an_unknown_codec_and_a_wrong_length_are_refused() {
        assert!(take_plane(&mut [9, 0, 0, 0, 1, 7].as_slice(), 1).unwrap_err().contains("codec 9"));
        assert!(take_plane(&mut [0, 0, 0, 0, 1, 7].as_slice(), 2).is_err());
        assert!(take_plane(&mut [0, 255, 255, 255, 255, 7].as_slice(), 1).is_err());
    }
}
