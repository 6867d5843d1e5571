//! Depth in PGM (`P5`), as Kinect programs write it.
//!
//! Source: Netpbm's pgm(5): `P5`, columns, rows and the largest value in text, one white space, then samples row by row, of two
//! bytes, the most significant first, where the largest value is above 255.

use crate::capture::camera::is_believable_size;
use crate::error::{Error, Result};
use crate::plural::counted;

/// Columns, rows, and values row by row.
///
/// # Errors
/// `Invalid` for a broken header or missing samples, and for 8 bits: that is a picture of depth, not depth.
pub fn parse(bytes: &[u8], place: &str) -> Result<((usize, usize), Vec<f32>)> {
    let broken =
        |what: &str| Error::invalid(place, format!("damaged, or not a PGM picture ({what}); save it again"));
    let mut at = 2;
    if !bytes.starts_with(b"P5") {
        return Err(broken("it does not start with P5"));
    }
    let mut header = [0_usize; 3];
    for number in &mut header {
        at = skip_space(bytes, at);
        let digits = bytes[at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let text = std::str::from_utf8(&bytes[at..at + digits]).unwrap_or_default();
        *number = text.parse().map_err(|_| broken(&format!("byte {at} is no number")))?;
        at += digits;
    }
    let [width, height, largest] = header;
    if !is_believable_size(width, height) || !(1..=65535).contains(&largest) {
        return Err(broken(&format!("its header claims {width}×{height} pixels up to {largest}")));
    }
    if largest < 256 {
        return Err(Error::unsupported(place, "depth in PGM must have 16 bits; save it so, or as PNG"));
    }
    let samples = bytes.get(at + 1..).unwrap_or_default();
    let (needed, found) = (width * height * 2, samples.len());
    if found < needed {
        return Err(broken(&format!("{} of samples where {needed} are needed", counted(found, "byte"))));
    }
    let value = |pair: &[u8]| f32::from(u16::from_be_bytes([pair[0], pair[1]]));
    Ok(((width, height), samples[..needed].chunks_exact(2).map(value).collect()))
}

/// Past white space and comments.
fn skip_space(bytes: &[u8], mut at: usize) -> usize {
    while let Some(byte) = bytes.get(at) {
        if *byte == b'#' {
            at += bytes[at..].iter().take_while(|byte| **byte != b'\n').count();
        } else if byte.is_ascii_whitespace() {
            at += 1;
        } else {
            break;
        }
    }
    at.min(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_bytes_a_sample_most_significant_first() {
        let bytes = [b"P5\n# depth\n2 1\n65535\n".as_slice(), &[1, 2, 0, 7]].concat();
        assert_eq!(parse(&bytes, "").unwrap(), ((2, 1), vec![258.0, 7.0]));
    }
}
