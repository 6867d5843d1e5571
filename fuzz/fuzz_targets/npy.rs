//! Any bytes as an array of `NumPy`, as PGM and as PFM: they are read or refused, and nothing panics.
#![no_main]

use libfuzzer_sys::fuzz_target;
use overlook::capture::pictures;

fuzz_target!(|bytes: &[u8]| {
    let _ = pictures::parse_npy(bytes, "depth.npy");
    let _ = pictures::parse_pgm(bytes, "depth.pgm");
    let _ = pictures::parse_pfm(bytes, "depth.pfm");
});
