//! Maps of depth and normals of COLMAP's dense reconstruction.
//!
//! Source: COLMAP's `mvs/mat.h`: columns, rows and channels in text, each followed by `&`, then `f32`, least significant byte
//! first, channel after channel, each row by row.

use std::path::Path;

use crate::capture::camera::is_believable_size;
use crate::error::{Error, Result};
use crate::plural::{counted, either};
use crate::whole_file;

/// Columns and rows, and each channel row by row.
pub type ColmapMap = ((usize, usize), Vec<Vec<f32>>);

/// Reads a map of `channels` channels from its bytes.
///
/// # Errors
/// `Invalid` for a broken header, another number of channels, and missing values.
pub fn parse(bytes: &[u8], channels: usize, place: &str) -> Result<ColmapMap> {
    let broken = |what: &str| {
        Error::invalid(place, format!("damaged, or not a map of COLMAP ({what}); compute it again"))
    };
    let (mut at, mut header) = (0, [0_usize; 3]);
    for number in &mut header {
        let digits = bytes[at..].iter().take_while(|byte| byte.is_ascii_digit()).take(9).count();
        let text = std::str::from_utf8(&bytes[at..at + digits]).unwrap_or_default();
        *number = text.parse().map_err(|_| broken(&format!("byte {at} is no number")))?;
        at += digits;
        if bytes.get(at) != Some(&b'&') {
            return Err(broken(&format!("byte {at} is no '&'")));
        }
        at += 1;
    }
    let [width, height, found] = header;
    if found != channels || !is_believable_size(width, height) {
        let what = format!(
            "its header claims {width}×{height} with {}; {channels} {} expected",
            counted(found, "channel"),
            either(channels, "is", "are")
        );
        return Err(broken(&what));
    }
    let (needed, there) = (width * height * channels * 4, bytes.len() - at);
    if there < needed {
        return Err(broken(&format!("{} of values where {needed} are needed", counted(there, "byte"))));
    }
    let value = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let plane = |bytes: &[u8]| bytes.chunks_exact(4).map(value).collect();
    Ok(((width, height), bytes[at..at + needed].chunks_exact(width * height * 4).map(plane).collect()))
}

/// Reads a map from a file.
///
/// # Errors
/// `Io`, and as [`parse`].
pub(crate) fn read(path: &Path, channels: usize, place: &str) -> Result<ColmapMap> {
    parse(&whole_file::read_all(path)?, channels, place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_follow_each_other() {
        let values = [1.0_f32, 2.0, 3.0, 4.0].iter().flat_map(|value| value.to_le_bytes());
        let bytes: Vec<u8> = b"2&1&2&".iter().copied().chain(values).collect();
        assert_eq!(parse(&bytes, 2, "").unwrap(), ((2, 1), vec![vec![1.0, 2.0], vec![3.0, 4.0]]));
        for bad in [&bytes[..bytes.len() - 1], b"", b"2&1", b"2&1&2", b"0&1&2&", b"x", b"99999999999&1&2&"] {
            assert!(parse(bad, 2, "a.bin").unwrap_err().to_string().starts_with("a.bin: "));
        }
        assert!(parse(&bytes, 1, "").is_err());
    }
}
