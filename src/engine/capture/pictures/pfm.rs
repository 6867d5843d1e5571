//! Depth in PFM (`Pf`), as programs for stereo write it.
//!
//! Source: Debevec's *PFM Portable `FloatMap` Image Format*: `Pf`, columns and rows, and a scale in text, each followed by one white
//! space; then floats row by row, the lowest row first. The bytes of each are in Intel's order where the scale is negative. What
//! differs: the size of the scale is not used, as nobody writes one on purpose.

use crate::capture::camera::is_believable_size;
use crate::error::{Error, Result};
use crate::plural::counted;

/// Columns, rows, and values row by row, the uppermost first.
///
/// # Errors
/// `Invalid` for a broken header or missing samples, and for three channels, which are no depth.
pub fn parse(bytes: &[u8], place: &str) -> Result<((usize, usize), Vec<f32>)> {
    let broken =
        |what: &str| Error::invalid(place, format!("damaged, or not a PFM picture ({what}); save it again"));
    if bytes.starts_with(b"PF") {
        return Err(Error::unsupported(place, "the PFM picture has three channels; depth has one"));
    }
    if !bytes.starts_with(b"Pf") {
        return Err(broken("it does not start with Pf"));
    }
    let mut at = 2;
    let mut word = || {
        at += bytes[at..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let length = bytes[at..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        at += length;
        std::str::from_utf8(&bytes[at - length..at]).unwrap_or_default()
    };
    let (width, height, scale) = (word().parse(), word().parse(), word().parse());
    let (Ok(width), Ok(height), Ok(scale)): (Result<usize, _>, Result<usize, _>, Result<f64, _>) =
        (width, height, scale)
    else {
        return Err(broken("its header has no size and scale"));
    };
    if !is_believable_size(width, height) || !scale.is_finite() || scale == 0.0 {
        return Err(broken(&format!("its header claims {width}×{height} pixels and a scale of {scale}")));
    }
    let samples = bytes.get(at + 1..).unwrap_or_default();
    let (needed, found) = (width * height * 4, samples.len());
    if found < needed {
        return Err(broken(&format!("{} of samples where {needed} are needed", counted(found, "byte"))));
    }
    let (samples, _) = samples[..needed].as_chunks::<4>();
    let value = |bytes: &[u8; 4]| {
        if scale < 0.0 { f32::from_le_bytes(*bytes) } else { f32::from_be_bytes(*bytes) }
    };
    Ok(((width, height), samples.chunks(width).rev().flatten().map(value).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lowest_row_comes_first_and_the_scale_tells_the_order_of_bytes() {
        let file = |scale: &str, bytes: fn(f32) -> [u8; 4]| -> Vec<u8> {
            let head = format!("Pf\n2 2\n{scale}\n").into_bytes();
            head.into_iter().chain([3.0, 4.0, 1.0, f32::INFINITY].into_iter().flat_map(bytes)).collect()
        };
        for file in [file("-1.0", f32::to_le_bytes), file("1", f32::to_be_bytes)] {
            assert_eq!(parse(&file, "test").unwrap(), ((2, 2), vec![1.0, f32::INFINITY, 3.0, 4.0]));
        }
    }
}
