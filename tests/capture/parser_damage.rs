//! Damaged bytes for every binary format of captures: an error of one line or a value, never a panic, and no more memory than a stated
//! multiple of the bytes.

use std::alloc::System;

use crate::draws::Draws;
use crate::folder::Folder;
use cap::Cap;
use overlook_engine::capture::{self, colmap, pictures};
use overlook_engine::error::Result;
use overlook_engine::settings::CaptureSettings;
use serde_json::json;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Bytes that parsing may allocate for each byte that there is: a value of 8 bits becomes a float, names and errors are copied.
const PER_BYTE: usize = 64;
/// Tables and messages, whatever there is.
const FIXED: usize = 1 << 20;

/// Damaged files of each format that are read in a second or two.
const CASES: u64 = 4_000;
/// One case in this many is a whole folder on disk.
const CASES_PER_FOLDER: u64 = 40;

/// Damaged files of each format: `OVERLOOK_FUZZ_CASES`, or [`CASES`].
fn fuzz_cases() -> u64 {
    std::env::var("OVERLOOK_FUZZ_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(CASES)
}

/// A parser: whether it takes these bytes.
type Parser = fn(&[u8]) -> Result<()>;

const PARSERS: [(&str, Parser); 8] = [
    ("cameras.bin", |bytes| colmap::cameras_of_bytes(bytes, "a").map(drop)),
    ("images.bin", |bytes| colmap::images_of_bytes(bytes, "a").map(drop)),
    ("cameras.txt", |bytes| colmap::cameras_of_text(&String::from_utf8_lossy(bytes), "a").map(drop)),
    ("images.txt", |bytes| colmap::images_of_text(&String::from_utf8_lossy(bytes), "a").map(drop)),
    ("COLMAP's map", |bytes| pictures::parse_colmap_map(bytes, 1, "a").map(drop)),
    ("npy", |bytes| pictures::parse_npy(bytes, "a").map(drop)),
    ("pgm", |bytes| pictures::parse_pgm(bytes, "a").map(drop)),
    ("pfm", |bytes| pictures::parse_pfm(bytes, "a").map(drop)),
];

fn seed(name: &str) -> Vec<u8> {
    let floats = |count: usize| (0..count).flat_map(|value| (value as f64 * 0.5).to_le_bytes());
    match name {
        "cameras.bin" => {
            let mut bytes = 2_u64.to_le_bytes().to_vec();
            for (id, model, parameters) in [(1_i32, 1_i32, 4), (2, 4, 8)] {
                bytes.extend(id.to_le_bytes().into_iter().chain(model.to_le_bytes()));
                bytes.extend(
                    [64_u64, 48].iter().flat_map(|side| side.to_le_bytes()).chain(floats(parameters)),
                );
            }
            bytes
        }
        "images.bin" => {
            let mut bytes = 2_u64.to_le_bytes().to_vec();
            for name in ["a.jpg\0", "left/b.jpg\0"] {
                bytes.extend(7_i32.to_le_bytes().into_iter().chain(floats(7)).chain(1_i32.to_le_bytes()));
                bytes.extend(name.bytes().chain(3_u64.to_le_bytes()).chain([0; 72]));
            }
            bytes
        }
        "cameras.txt" => b"# c\n1 PINHOLE 64 48 60 60 32 24\n2 SIMPLE_RADIAL 64 48 60 32 24 0.1\n".to_vec(),
        "images.txt" => b"# c\n1 1 0 0 0 1 2 3 1 a.jpg\n1 2 -1\n2 1 0 0 0 1 2 3 1 left/b.jpg\n\n".to_vec(),
        "COLMAP's map" => b"8&6&1&".iter().copied().chain([1; 192]).collect(),
        "npy" => {
            let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (6, 8), }";
            let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
            bytes.extend(
                (header.len() as u16).to_le_bytes().into_iter().chain(header.bytes()).chain([1; 192]),
            );
            bytes
        }
        "pfm" => b"Pf\n8 6\n-1.0\n".iter().copied().chain([1; 192]).collect(),
        _ => b"P5 8 6 65535\n".iter().copied().chain([1; 96]).collect(),
    }
}

fn damage(bytes: &mut Vec<u8>, random: &mut impl FnMut(usize) -> usize) {
    for _ in 0..=random(3) {
        let length = bytes.len();
        if length < 9 {
            return;
        }
        let at = random(length - 8);
        match random(7) {
            0 => bytes[at] ^= 1 << random(8),
            1 => bytes[at] = [0, 1, b'9', b'\n', b'&', 0x7F, 0x80, 0xFF][random(8)],
            2 => bytes[at..at + 8].fill([0, 0x7F, 0xFF][random(3)]),
            3 => bytes.copy_within(at..at + 8, random(length - 8)),
            4 => bytes.truncate(at),
            5 => drop(bytes.drain(at..at + 1 + random(8))),
            _ => drop(bytes.splice(at..at, [b'1', b' ', 0, 0xFF][random(4)..].iter().copied())),
        }
    }
}

/// What was said of bad bytes is one line that names its place.
fn check(result: &Result<()>, place: &str) -> bool {
    if let Err(error) = result {
        let said = error.to_string();
        assert!(said.starts_with(place) && !said.contains('\n') && said.len() < 2_000, "{said}");
    }
    result.is_ok()
}

/// Raw video has no header: what describes it is damaged, or there are too few bytes.
fn read_raw_video(case: u64) -> bool {
    let mut draws = Draws(case);
    let mut random = |below: usize| draws.below(below as u64) as usize;
    let folder = Folder::new();
    let mut camera = json!({
        "Name": "v0", "Position": [0, 0, 0], "Rotation": [0, 0, 0], "Resolution": [8, 6], "Projection": "Perspective",
        "Focal": [8, 8], "Principle_point": [4, 3], "Depth_range": [0.5, 25.0], "BitDepthColor": 8, "BitDepthDepth": 16,
        "ColorSpace": "YUV420", "DepthColorSpace": "YUV420", "HasInvalidDepth": true,
    });
    let keys: Vec<String> = camera.as_object().unwrap().keys().cloned().collect();
    let values = [
        json!(null),
        json!(-1),
        json!(1e300),
        json!([0, 0]),
        json!([1e9, 7]),
        json!("inf"),
        json!(17),
        json!([25.0, 0.5]),
    ];
    for _ in 0..random(3) {
        camera[&keys[random(keys.len())]] = values[random(values.len())].clone();
    }
    let mut document = json!({
        "Version": "4.0", "Content_name": "c", "Fps": 25, "Frames_number": 1 + random(3), "cameras": [camera],
    })
    .to_string()
    .into_bytes();
    if random(4) == 0 {
        damage(&mut document, &mut random);
    }
    folder.put("c.json", &document);
    let fewer = [0, 0, 1, 72][random(4)];
    folder.put("c/v0_texture_8x6_yuv420p.yuv", &[128; 2 * 72][fewer..]);
    folder.put("c/v0_depth_8x6_yuv420p16le.yuv", &vec![200; 2 * 144 - fewer]);
    let path = folder.path("");
    let result = capture::open(&path, &CaptureSettings::default()).and_then(|capture| {
        (0..capture.frame_count()).try_for_each(|frame| capture.frame(0, frame).map(drop))
    });
    check(&result, &path.display().to_string())
}

#[test]
fn damaged_files_of_every_binary_format_give_one_line_and_take_little_memory() {
    let cases = fuzz_cases();
    for (name, parse) in PARSERS {
        let seed = seed(name);
        parse(&seed).unwrap();
        let mut taken = 0;
        for case in 0..cases {
            // A seed for each case: none depends on those before it.
            let mut draws = Draws(case);
            let mut random = |below: usize| draws.below(below as u64) as usize;
            let mut bytes = seed.clone();
            damage(&mut bytes, &mut random);
            // A single allocation above this aborts the process.
            ALLOCATOR.set_limit(ALLOCATOR.allocated() + FIXED + PER_BYTE * bytes.len()).unwrap();
            taken += u64::from(check(&parse(&bytes), "a"));
            ALLOCATOR.set_limit(usize::MAX).unwrap();
        }
        assert!(taken > 0 && taken < cases, "{name}: {taken} of {cases} are taken");
    }
    let folders = cases / CASES_PER_FOLDER;
    let taken = (0..folders).filter(|case| read_raw_video(*case)).count() as u64;
    assert!(taken > 0 && taken < folders, "raw video: {taken} of {folders} are taken");
}
