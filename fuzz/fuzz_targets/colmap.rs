//! Any bytes as COLMAP's cameras, images and maps: they are read or refused, and nothing panics.
#![no_main]

use libfuzzer_sys::fuzz_target;
use overlook::capture::{colmap, pictures};

fuzz_target!(|bytes: &[u8]| {
    let _ = colmap::cameras_of_bytes(bytes, "cameras.bin");
    let _ = colmap::images_of_bytes(bytes, "images.bin");
    let _ = pictures::parse_colmap_map(bytes, 1, "depth.bin");
    let _ = pictures::parse_colmap_map(bytes, 3, "normal.bin");
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = colmap::cameras_of_text(text, "cameras.txt");
        let _ = colmap::images_of_text(text, "images.txt");
    }
});
