//! The report of a store, deflated where it is long.
//!
//! Purpose: a report says something of each camera, so that of hundreds of small views it would be longer than their samples. Source: zlib
//! (RFC 1950). What differs: a short report stays as it is, so that other programs read it without inflating it.

use libdeflater::{CompressionLvl, Compressor, Decompressor};

use crate::plural::counted;

/// Shorter reports stay as they are, bytes.
const LONG: usize = 1 << 16;

/// What readers find in place of a long report where they do not know the chunk that holds it.
pub(super) const EMPTY: &str = "{}";

/// Deflate makes at most this many bytes of one.
const MOST_PER_BYTE: usize = 1032;

/// Bytes before the deflated report: a `u32`, its length once inflated.
const LENGTH: usize = 4;

/// The payload of the chunk that holds a report (JSON); `None` for one that stays as it is.
pub(super) fn packed(report: &str) -> Option<Vec<u8>> {
    let length = u32::try_from(report.len()).ok().filter(|_| report.len() >= LONG)?;
    let mut compressor = Compressor::new(CompressionLvl::best());
    let mut payload = vec![0; LENGTH + compressor.zlib_compress_bound(report.len())];
    payload[..LENGTH].copy_from_slice(&length.to_be_bytes());
    let bytes = compressor.zlib_compress(report.as_bytes(), &mut payload[LENGTH..]).ok()?;
    payload.truncate(LENGTH + bytes);
    Some(payload)
}

/// The report in such a payload.
///
/// # Errors
/// What is wrong with the payload.
pub(super) fn unpacked(payload: &[u8]) -> Result<String, String> {
    let (length, deflated) = payload.split_first_chunk::<LENGTH>().ok_or("it is too short")?;
    let length = u32::from_be_bytes(*length) as usize;
    if length > deflated.len().saturating_mul(MOST_PER_BYTE) {
        return Err(format!("{} cannot hold {length}", counted(deflated.len(), "byte")));
    }
    let mut report = vec![0; length];
    let bytes = Decompressor::new().zlib_decompress(deflated, &mut report);
    let bytes = bytes.map_err(|error| format!("it cannot be inflated: {error}"))?;
    if bytes != length {
        return Err(format!("it holds {} in place of {length}", counted(bytes, "byte")));
    }
    String::from_utf8(report).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn long() -> String {
        let numbers: Vec<String> = (0..20_000).map(|number| (number * number % 9973).to_string()).collect();
        format!("{{\"numbers\":[{}]}}", numbers.join(","))
    }

    #[test]
    fn a_long_report_takes_less_and_comes_back_and_a_short_one_stays() {
        let report = long();
        let payload = packed(&report).unwrap();
        assert!(2 * payload.len() < report.len());
        assert_eq!(unpacked(&payload).unwrap(), report);
        assert_eq!(packed(&report[..LONG - 1]), None);
    }

    #[test]
    fn a_damaged_payload_is_an_error_and_makes_no_large_buffer() {
        let payload = packed(&long()).unwrap();
        for cut in [0, 3, 4, 5, payload.len() / 2, payload.len() - 1] {
            assert!(unpacked(&payload[..cut]).is_err(), "{cut}");
        }
        let mut lies = payload.clone();
        lies[..LENGTH].fill(0xff);
        assert!(unpacked(&lies).unwrap_err().contains("cannot hold"));
        lies[..LENGTH].copy_from_slice(&70_000_u32.to_be_bytes());
        assert!(unpacked(&lies).is_err());
    }
}
