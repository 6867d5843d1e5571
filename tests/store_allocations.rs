//! What a file may make the reader allocate: twice what it holds where it is whole, and never more than a stated multiple of its own
//! size, whatever it says.

#[expect(dead_code, reason = "the builder serves other tests too")]
#[path = "common/builder.rs"]
mod builder;
#[path = "common/draws.rs"]
mod draws;

use std::alloc::System;
use std::path::Path;
use std::sync::Arc;

use cap::Cap;
use half::f16;
use overlook_engine::job::Job;
use overlook_engine::samples::{DepthPlane, SampleSet};
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::Playback;

use builder::{moving_set, small_report, small_set};
use draws::Draws;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Bytes that reading may allocate for each byte of the file, as FORMAT.md promises.
const PER_BYTE: usize = 3000;

/// Tables and the working memory of the one thread that reads here; the promise has 16 MiB, for many threads.
const FIXED: usize = 2 << 20;

/// Tables alone.
const TABLES: usize = 1 << 19;

/// Parts of an image and the image that they are put together to.
const TIMES: usize = 2;

/// Bytes of the samples and tiles of a set in memory at most, as FORMAT.md counts them.
fn held(set: &SampleSet) -> usize {
    set.images.iter().map(|image| 11 * image.color.len() + 88 * image.tiles.len()).sum()
}

/// Allows `bytes` more bytes to be allocated. An allocation beyond aborts the process.
fn limit_to(bytes: usize) {
    ALLOCATOR.set_limit(ALLOCATOR.allocated() + bytes).unwrap();
}

/// Reads all that can be read.
fn read(bytes: &[u8]) -> bool {
    let Ok(store) = Store::over(Path::new("fuzzed.ovl"), Box::new(bytes.to_vec())) else { return false };
    let _ = store.head(0);
    let whole = store.read_all(&Job::new()).is_ok();
    let playback = Playback::new(store, 0);
    if let Some(camera) = playback.outline().cameras.first().cloned() {
        let _ = playback.seen_from(&camera, 0, &Job::new());
    }
    whole
}

/// Makes every checksum right, as far as chunks can be followed.
fn mend(bytes: &mut [u8]) {
    let mut offset = 12;
    while let Some(header) = bytes.get(offset..offset + 8) {
        let id: [u8; 4] = header[..4].try_into().unwrap();
        let length = u32::from_be_bytes(header[4..].try_into().unwrap()) as usize;
        let Some(payload) = bytes.get_mut(offset + 8..(offset + 8).saturating_add(length)) else { return };
        if id != *b"IMAG"
            && let Some((payload, checksum)) = payload.split_last_chunk_mut::<4>()
        {
            *checksum = crc32fast::hash(&[&id, &*payload].concat()).to_be_bytes();
        }
        offset += 8 + length + length % 2;
    }
    // Heads and codes of images, where the index says they are.
    let Ok(store) = Store::over(Path::new("fuzzed.ovl"), Box::new(bytes.to_vec())) else { return };
    for image in store.info().images.clone() {
        let start = image.offset as usize + 8;
        let Some(payload) = bytes.get_mut(start..start.saturating_add(image.length as usize)) else {
            continue;
        };
        let Some((head, codes)) = payload.split_at_mut_checked(image.head as usize) else { continue };
        let Some((head, checksum)) = head.split_last_chunk_mut::<4>() else { continue };
        let camera = &store.info().cameras[image.camera as usize].intrinsics;
        let blocks = (camera.width.div_ceil(64) as usize * camera.height.div_ceil(64) as usize).div_ceil(8);
        let mut start = 0_usize;
        for entry in head.get_mut(2 + blocks..).unwrap_or_default().chunks_exact_mut(16) {
            let length = u32::from_be_bytes(entry[8..12].try_into().unwrap()) as usize;
            let code = codes.get(start..start.saturating_add(length)).unwrap_or_default();
            entry[12..].copy_from_slice(&crc32fast::hash(code).to_be_bytes());
            start = start.saturating_add(length);
        }
        *checksum = crc32fast::hash(&[b"IMAG", &*head].concat()).to_be_bytes();
    }
}

fn written(set: &SampleSet) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let extras = overlook_engine::store::file::Extras { report: small_report(), ..Default::default() };
    overlook_engine::store::file::write_to(&mut bytes, Path::new("memory.ovl"), set, &extras, &Job::new())
        .unwrap();
    bytes.into_inner()
}

/// Full pictures of one color and depth: as many samples a byte as there can be.
fn bomb() -> SampleSet {
    let mut set = moving_set();
    let flat = set.images[0].clone();
    let tiles = flat.tiles.iter().map(|tile| {
        let inside = |row: usize| (tile.tile_y as usize * 16 + row) < 70;
        let columns = if tile.tile_x == 5 { 0x03FF } else { 0xFFFF };
        (tile.tile_x, tile.tile_y, std::array::from_fn(|row| if inside(row) { columns } else { 0 }))
    });
    let mut first = 0;
    let tiles: Vec<_> = tiles
        .map(|(tile_x, tile_y, rows)| {
            let tile = overlook_engine::samples::SampleTile { tile_x, tile_y, first, rows };
            first += tile.count() as u32;
            tile
        })
        .collect();
    let depth = DepthPlane::pack(&tiles, &vec![0.5; first as usize]);
    for image in &mut set.images {
        let color = vec![[f16::ONE; 3]; first as usize];
        *image = Arc::new(overlook_engine::samples::SampleImage {
            tiles: tiles.clone(),
            color,
            depth: depth.clone(),
            ..(**image).clone()
        });
    }
    set
}

/// As many damaged stores as are read in about three seconds in a development build.
const CASES: u64 = 600;

/// Damaged stores that are read: `OVERLOOK_FUZZ_CASES`, or [`CASES`].
fn fuzz_cases() -> u64 {
    std::env::var("OVERLOOK_FUZZ_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(CASES)
}

#[test]
fn stores_allocate_twice_what_they_hold_and_damaged_ones_never_more_than_a_multiple_of_their_size() {
    let thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let read = |bytes: &[u8]| thread.install(|| read(bytes));
    let sets = [small_set(), moving_set(), bomb()];
    let seeds = sets.each_ref().map(written);
    for (set, seed) in sets.iter().zip(&seeds) {
        // The first time the thread keeps its working memory.
        assert!(read(seed));
        limit_to(TABLES + 2 * seed.len() + TIMES * held(set));
        assert!(read(seed));
        ALLOCATOR.set_limit(usize::MAX).unwrap();
    }
    let (cases, mut opened) = (fuzz_cases(), 0);
    for case in 0..cases {
        // A seed for each case: none depends on those before it.
        let mut draws = Draws(case);
        let mut random = |below: usize| draws.below(below as u64) as usize;
        let mut bytes = seeds[random(seeds.len())].clone();
        limit_to(FIXED + PER_BYTE * bytes.len());
        for _ in 0..=random(4) {
            let (at, length) = (random(bytes.len()), 1 + random(6));
            let (end, to) = ((at + length).min(bytes.len()), random(bytes.len() - length));
            match random(5) {
                0 => bytes[at] ^= 1 << random(8),
                1 => bytes[at] = [0, 1, 0x7F, 0x80, 0xFF][random(5)],
                2 => (at..end).for_each(|at| bytes[at] = 0xFF),
                3 => bytes.copy_within(at..end, to),
                _ => (at..end).for_each(|at| bytes[at] = 0),
            }
        }
        if random(8) > 0 {
            mend(&mut bytes);
        }
        opened += u64::from(read(&bytes));
    }
    println!("{cases} damaged stores read, {opened} of them to the end");
    assert!(opened > cases / 20, "damage is found before it is of interest: {opened} of {cases}");
    ALLOCATOR.set_limit(usize::MAX).unwrap();
}
