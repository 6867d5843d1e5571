//! The store as a contract: what is written comes back exactly; what was damaged is refused; what stood there before
//! stays until the new store is whole.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use half::f16;
use overlook_engine::capture::Camera;
use overlook_engine::error::Error;
use overlook_engine::job::Job;
use overlook_engine::preprocess::diagnostics::{CameraReport, Report};
use overlook_engine::samples::{DepthPlane, SampleImage, SampleSet};
use overlook_engine::store;
use overlook_engine::store::file::Store;
use proptest::prelude::*;

use crate::builder::{any_set, moving_set, small_report, small_set};

/// Bytes from the start of a store to its first chunk.
const FIRST_CHUNK: usize = 12;

fn assert_same(read: &(SampleSet, String), samples: &SampleSet, report: &str) {
    let (set, read_report) = read;
    assert_eq!(set.name, samples.name);
    assert_eq!(set.cameras, samples.cameras);
    assert_eq!(set.frame_numbers, samples.frame_numbers);
    assert_eq!(set.up_in_world, samples.up_in_world);
    assert_eq!(set.settings, samples.settings);
    assert_eq!(set.images, samples.images);
    assert_eq!(read_report, report);
}

/// A folder that is removed afterwards, and the path of a store in it.
fn scratch() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ovl");
    (folder, path)
}

fn small_store() -> (tempfile::TempDir, PathBuf, Vec<u8>) {
    let (folder, path) = scratch();
    store::file::write(&path, &small_set(), &small_report(), &Job::new()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    (folder, path, bytes)
}

fn read_bytes(path: &Path, bytes: &[u8]) -> Result<(SampleSet, String), Error> {
    std::fs::write(path, bytes).unwrap();
    store::read(path, &Job::new())
}

fn refusal(path: &Path, bytes: &[u8]) -> String {
    let message = read_bytes(path, bytes).map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("scene.ovl") && !message.contains('\n'), "{message}");
    message
}

/// Offset and payload length of the first chunk with this id.
fn chunk(bytes: &[u8], id: [u8; 4]) -> (usize, usize) {
    let mut offset = FIRST_CHUNK;
    loop {
        let length = u32::from_be_bytes(bytes[offset + 4..offset + 8].try_into().unwrap()) as usize;
        if bytes[offset..offset + 4] == id {
            return (offset, length);
        }
        offset += 8 + length + length % 2;
    }
}

/// Changes the payload of a chunk and mends its checksum.
fn tampered(bytes: &[u8], id: [u8; 4], change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let (offset, length) = chunk(bytes, id);
    let mut bytes = bytes.to_vec();
    let (start, end) = (offset + 8, offset + 8 + length - 4);
    change(&mut bytes[start..end]);
    let checksum = crc32fast::hash(&[id.as_slice(), &bytes[start..end]].concat());
    bytes[end..end + 4].copy_from_slice(&checksum.to_be_bytes());
    bytes
}

/// Puts a chunk before the index, and mends every length and offset.
fn with_unknown_chunk(bytes: &[u8], unknown: &[u8]) -> Vec<u8> {
    let (index, _) = chunk(bytes, *b"INDX");
    let longer = [&bytes[..index], unknown, &bytes[index..]].concat();
    let size = longer.len() as u64;
    with_form_length(tampered(&longer, *b"INDX", |index| {
        index[..8].copy_from_slice(&size.to_be_bytes());
        for entry in index[12..].chunks_mut(40) {
            let offset = u64::from_be_bytes(entry[24..32].try_into().unwrap()) + unknown.len() as u64;
            entry[24..32].copy_from_slice(&offset.to_be_bytes());
        }
    }))
}

fn with_form_length(mut bytes: Vec<u8>) -> Vec<u8> {
    let length = bytes.len() as u32 - 8;
    bytes[4..8].copy_from_slice(&length.to_be_bytes());
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_comes_back_exactly(samples in any_set()) {
        let (_folder, path) = scratch();
        let size = store::file::write(&path, &samples, &small_report(), &Job::new()).unwrap();
        prop_assert_eq!(size, std::fs::metadata(&path).unwrap().len());
        assert_same(&store::read(&path, &Job::new()).unwrap(), &samples, &small_report());
    }

    #[test]
    fn a_store_with_random_damage_never_panics(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let (_folder, path, mut bytes) = small_store();
        for (index, byte) in damage {
            let index = index.index(bytes.len());
            bytes[index] = byte;
        }
        let _ = read_bytes(&path, &bytes);
    }
}

#[test]
fn one_image_is_read_without_the_others() {
    let (_folder, path, mut bytes) = small_store();
    let samples = small_set();
    // The first image is destroyed; the second is none the worse.
    let (first, length) = chunk(&bytes, *b"IMAG");
    bytes[first + 8..first + 8 + length].fill(0xEE);
    std::fs::write(&path, &bytes).unwrap();
    let store = Store::open(&path).unwrap();
    assert_eq!(store.info().images.len(), 2);
    assert_eq!(store.info().sample_count(), samples.sample_count());
    assert_eq!(store.info().span_count(), 2);
    assert_eq!(store.info().bytes, bytes.len() as u64);
    let record = [*b"SETT", *b"REPT", *b"PROV"].map(|id| 8 + chunk(&bytes, id).1.next_multiple_of(2) as u64);
    assert_eq!(store.info().record_bytes, record.iter().sum::<u64>());
    assert_eq!(store.image(1).unwrap(), *samples.images[1]);
    assert!(store.damage().is_empty());
    assert!(store.image(0).unwrap().is_empty());
    let damage = store.damage();
    assert!(damage.len() == 1 && damage[0].contains("'IMAG' of camera 'left'"), "{damage:?}");
    assert!(store.image(2).unwrap_err().to_string().contains("no image 2"));
}

#[test]
fn a_damaged_block_is_missing_and_all_others_are_there() {
    let (_folder, path) = scratch();
    let samples = moving_set();
    store::file::write(&path, &samples, &small_report(), &Job::new()).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let store = Store::open(&path).unwrap();
    let first = store.info().images[0];
    let head = store.head(0).unwrap();
    assert_eq!(head.blocks.len(), 4);
    // The last byte of the first image is in its last block, which the images after it are predicted from.
    let mut bytes = whole.clone();
    bytes[(first.offset + 8) as usize + first.length as usize - 1] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    let store = Store::open(&path).unwrap();
    let read = store.read_all(&Job::new()).unwrap();
    // The ninth image begins anew.
    assert_eq!(read.images[8..], samples.images[8..]);
    for (read, written) in read.images.iter().zip(&samples.images).take(8) {
        let in_last = |tile: &overlook_engine::samples::SampleTile| tile.tile_x >= 4 && tile.tile_y >= 4;
        let others: Vec<_> =
            written.tiles.iter().filter(|tile| !in_last(tile)).map(|tile| tile.rows).collect();
        assert_eq!(read.tiles.iter().map(|tile| tile.rows).collect::<Vec<_>>(), others);
        assert!(read.color.iter().all(|color| written.color.contains(color)));
    }
    let damage = store.damage();
    assert_eq!(damage.len(), 8);
    assert!(damage[0].contains("from (64, 64) are missing"), "{damage:?}");
    assert!(store::read(&path, &Job::new()).unwrap_err().to_string().contains("missing"));
}

#[test]
fn images_are_predicted_from_the_frames_before_and_no_chain_is_long() {
    let (_folder, path) = scratch();
    let samples = moving_set();
    store::file::write(&path, &samples, &small_report(), &Job::new()).unwrap();
    let store = Store::open(&path).unwrap();
    let references: Vec<_> = store.info().images.iter().map(|image| image.reference).collect();
    assert_eq!(references[..9], [None, Some(0), Some(1), Some(2), Some(3), Some(4), Some(5), Some(6), None]);
    for index in (0..samples.images.len()).rev() {
        assert_eq!(store.image(index).unwrap(), *samples.images[index]);
    }
    let alone: u32 = store.info().images.iter().filter(|i| i.reference.is_none()).map(|i| i.length).sum();
    let predicted: u32 = store.info().images.iter().filter(|i| i.reference.is_some()).map(|i| i.length).sum();
    assert!(predicted < alone * 3, "{predicted} bytes for eight images, {alone} for two");
}

#[test]
fn plain_coding_holds_the_same_samples() {
    let (_folder, path) = scratch();
    let mut samples = small_set();
    let modeled = store::file::write(&path, &moving_set(), &small_report(), &Job::new()).unwrap();
    samples.settings.set_text("store.coding=plain").unwrap();
    store::file::write(&path, &samples, &small_report(), &Job::new()).unwrap();
    assert_same(&store::read(&path, &Job::new()).unwrap(), &samples, &small_report());
    let mut moving = moving_set();
    moving.settings = samples.settings.clone();
    assert!(store::file::write(&path, &moving, &small_report(), &Job::new()).unwrap() > 2 * modeled);
}

#[test]
fn the_same_set_gives_the_same_bytes_whatever_the_threads_and_the_time_it_took() {
    let (_folder, path) = scratch();
    let write_with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let report = Report { seconds: threads as f64, ..Report::default() }.to_json().unwrap();
        pool.install(|| store::file::write(&path, &small_set(), &report, &Job::new())).unwrap();
        std::fs::read(&path).unwrap()
    };
    assert_eq!(write_with(1), write_with(5));
}

#[test]
fn a_store_cut_short_anywhere_is_refused() {
    let (_folder, path, bytes) = small_store();
    for length in 0..bytes.len() {
        refusal(&path, &bytes[..length]);
        if length >= 8 {
            // The cut is hidden from the check of the whole file's length.
            refusal(&path, &with_form_length(bytes[..length].to_vec()));
        }
    }
}

#[test]
fn no_damaged_byte_goes_unnoticed() {
    let (_folder, path, bytes) = small_store();
    for position in 0..bytes.len() {
        let mut damaged = bytes.clone();
        // From one flipped bit to all eight, all over the file.
        damaged[position] ^= (position % 255) as u8 + 1;
        if let Ok(read) = read_bytes(&path, &damaged) {
            assert_same(&read, &small_set(), &small_report());
        }
    }
}

#[test]
fn trailing_bytes_are_refused() {
    let (_folder, path, bytes) = small_store();
    assert!(refusal(&path, &[bytes.as_slice(), b"\0"].concat()).contains("bytes but has"));
}

#[test]
fn other_files_are_refused() {
    let (_folder, path, bytes) = small_store();
    assert!(refusal(&path, b"").contains("too few"));
    assert!(refusal(&path, b"FORM").contains("too few"));
    let image = [b"FORM".as_slice(), &bytes[4..8], b"ILBM", &bytes[12..]].concat();
    assert!(refusal(&path, &image).contains("type 'OVLK'"));
    assert!(refusal(&path, &[b"RIFF", &bytes[4..]].concat()).contains("type 'OVLK'"));
    assert!(!Store::is_store(&path).unwrap());
    std::fs::write(&path, &bytes).unwrap();
    assert!(Store::is_store(&path).unwrap());
}

#[test]
fn a_folder_and_a_missing_file_are_refused() {
    let (folder, path) = scratch();
    assert!(store::read(folder.path(), &Job::new()).is_err());
    assert!(!Store::is_store(folder.path()).unwrap());
    assert!(Store::is_store(&path).is_err());
    assert!(matches!(store::read(&path, &Job::new()), Err(Error::Io { .. })));
}

#[test]
fn another_major_version_is_unsupported_and_a_minor_one_is_read() {
    let (_folder, path, bytes) = small_store();
    let newer = tampered(&bytes, *b"HEAD", |head| head[1] = 5);
    assert!(matches!(read_bytes(&path, &newer), Err(Error::Unsupported { .. })));
    assert!(refusal(&path, &newer).contains("version 5.1"));
    let minor = tampered(&bytes, *b"HEAD", |head| head[3] = 9);
    assert_same(&read_bytes(&path, &minor).unwrap(), &small_set(), &small_report());
}

#[test]
fn a_setting_that_is_no_more_is_told_and_the_samples_are_read() {
    let (_folder, path, bytes) = small_store();
    let renamed = tampered(&bytes, *b"SETT", |settings| {
        let text = String::from_utf8(settings.to_vec()).unwrap();
        let position = text.find("across_spans").unwrap();
        settings[position..position + 12].copy_from_slice(b"across_bands");
    });
    assert_same(&read_bytes(&path, &renamed).unwrap(), &small_set(), &small_report());
    let warnings = Store::open(&path).unwrap().info().warnings.clone();
    assert!(warnings.len() == 1 && warnings[0].contains("pruning.across_bands"), "{warnings:?}");
    assert!(refusal(&path, &tampered(&bytes, *b"SETT", |settings| settings[0] = b'!')).contains("TOML"));
}

#[test]
fn a_value_that_a_setting_takes_no_more_is_told_and_the_default_stands_for_it() {
    let (_folder, path, bytes) = small_store();
    let textured = tampered(&bytes, *b"SETT", |settings| {
        let text = String::from_utf8(settings.to_vec()).unwrap();
        let position = text.find("pushpull\"").unwrap();
        settings[position..position + 9].copy_from_slice(b"texture\" ");
    });
    assert_same(&read_bytes(&path, &textured).unwrap(), &small_set(), &small_report());
    let warnings = Store::open(&path).unwrap().info().warnings.clone();
    assert!(warnings.len() == 1 && warnings[0].contains("render.fill = \"texture\""), "{warnings:?}");
}

#[test]
fn unknown_chunks_are_skipped() {
    let (_folder, path, bytes) = small_store();
    let comment = b"ANNO\0\0\0\x05hello\0";
    let longer = with_unknown_chunk(&bytes, comment);
    assert_same(&read_bytes(&path, &longer).unwrap(), &small_set(), &small_report());
}

#[test]
fn a_long_report_is_deflated_and_comes_back_and_damage_to_it_is_refused() {
    let (_folder, path) = scratch();
    let report = format!("{{\"cameras\":[{}1]}}", "12345,".repeat(20_000));
    store::file::write(&path, &small_set(), &report, &Job::new()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_same(&read_bytes(&path, &bytes).unwrap(), &small_set(), &report);
    let (offset, length) = chunk(&bytes, *b"RPTZ");
    assert!(20 * length < report.len(), "{length}");
    for at in [offset + 8, offset + 12, offset + 8 + length / 2] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        assert!(refusal(&path, &damaged).contains("RPTZ"));
    }
    // A reader that does not know the chunk finds a report that says nothing.
    let mut unknown = bytes.clone();
    unknown[offset..offset + 4].copy_from_slice(b"ANNO");
    assert_same(&read_bytes(&path, &unknown).unwrap(), &small_set(), "{}");
}

#[test]
fn missing_doubled_and_misplaced_chunks_are_refused() {
    let (_folder, path, bytes) = small_store();
    for id in [*b"HEAD", *b"SETT", *b"REPT", *b"PROV", *b"PALT", *b"MODL", *b"INDX"] {
        let (offset, _) = chunk(&bytes, id);
        let mut renamed = bytes.clone();
        renamed[offset..offset + 4].copy_from_slice(b"ANNO");
        refusal(&path, &renamed);
    }
    let (head, length) = chunk(&bytes, *b"HEAD");
    let end = head + 8 + length + length % 2;
    let doubled = [&bytes[..end], &bytes[head..]].concat();
    assert!(refusal(&path, &with_form_length(doubled)).contains("two of them"));
    let comment = [&bytes[..head], b"ANNO\0\0\0\0", &bytes[head..]].concat();
    assert!(refusal(&path, &with_form_length(comment)).contains("first chunk"));
}

#[test]
fn huge_lengths_are_refused_without_being_allocated() {
    let (_folder, path, bytes) = small_store();
    for id in [*b"HEAD", *b"SETT", *b"REPT", *b"PROV", *b"PALT", *b"MODL", *b"INDX", *b"IMAG"] {
        let (offset, _) = chunk(&bytes, id);
        for length in [u32::MAX, u32::MAX - 1, 0x8000_0000, bytes.len() as u32, 0, 3] {
            let mut absurd = bytes.clone();
            absurd[offset + 4..offset + 8].copy_from_slice(&length.to_be_bytes());
            refusal(&path, &absurd);
        }
    }
    // Counts inside chunks: cameras' name, images, an image's samples, tiles and lengths.
    let huge = u32::MAX.to_be_bytes();
    let index = [8, 24, 28, 32, 36, 40, 44, 48].map(|position| (*b"INDX", position));
    for (id, position) in [(*b"HEAD", 4)].into_iter().chain(index) {
        let absurd = tampered(&bytes, id, |payload| payload[position..position + 4].copy_from_slice(&huge));
        // A reference of all ones is none at all.
        if (id, position) != (*b"INDX", 32) {
            refusal(&path, &absurd);
        }
    }
}

#[test]
fn two_images_of_a_camera_and_a_span_are_neither_written_nor_read() {
    let (_folder, path, bytes) = small_store();
    let mut samples = small_set();
    samples.images.insert(1, Arc::clone(&samples.images[0]));
    let error = store::file::write(&path, &samples, &small_report(), &Job::new()).unwrap_err();
    assert!(error.to_string().contains("two images of camera 0"), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
    let twice = tampered(&bytes, *b"INDX", |index| index.copy_within(12..24, 52));
    assert!(refusal(&path, &twice).contains("two images of camera 0"));
}

#[test]
fn a_bomb_is_refused() {
    let (_folder, path, bytes) = small_store();
    // A picture of 2^14 × 2^14 pixels would have 8 KiB of block bits; the head in the file has one byte.
    let name = small_set().name.len();
    let width = 4 + 4 + name + 24 + 4 + 4 + "left".len();
    let of_side = |side: u32| {
        tampered(&bytes, *b"HEAD", |head| {
            head[width..width + 4].copy_from_slice(&side.to_be_bytes());
            head[width + 4..width + 8].copy_from_slice(&side.to_be_bytes());
        })
    };
    assert!(refusal(&path, &of_side(1 << 14)).contains("'IMAG'"));
    for side in [(1 << 14) + 1, 1 << 20] {
        assert!(refusal(&path, &of_side(side)).contains("'HEAD'"));
    }
    // Both index entries for one chunk.
    let twice = tampered(&bytes, *b"INDX", |index| index.copy_within(24..52, 64));
    assert!(refusal(&path, &twice).contains("overlap"));
    // An image that is predicted from itself, and one from another camera's.
    for reference in [0_u32, 1] {
        let ring = tampered(&bytes, *b"INDX", |index| {
            index[32..36].copy_from_slice(&reference.to_be_bytes());
        });
        assert!(refusal(&path, &ring).contains("predicted"));
    }
}

#[test]
fn heads_that_break_the_promises_are_neither_written_nor_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ovl");
    let refused = |change: &dyn Fn(&mut SampleSet), word: &str| {
        let mut samples = small_set();
        change(&mut samples);
        let error =
            store::file::write(&path, &samples, &small_report(), &Job::new()).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    };
    refused(&|set| set.up_in_world *= 2.0, "up");
    refused(&|set| set.cameras[1].name = set.cameras[0].name.clone(), "are called 'left'");
    refused(&|set| set.cameras[0].world_from_camera.matrix3 *= 1.01, "rotation");
    refused(&|set| set.cameras[0].world_from_camera.matrix3.x_axis *= -1.0, "rotation");
    refused(&|set| set.cameras[0].intrinsics.fx = f64::NAN, "finite");
    let many = |set: &mut SampleSet| {
        let mut large = set.cameras[0].clone();
        (large.intrinsics.width, large.intrinsics.height) = (1 << 14, 1 << 14);
        set.cameras.extend((0..65).map(|index| Camera { name: format!("l{index}"), ..large.clone() }));
    };
    refused(&many, "together");
}

#[test]
fn values_that_break_the_promises_are_neither_written_nor_read() {
    let (_folder, path, before) = small_store();
    let broken = |change: &dyn Fn(&mut SampleImage)| {
        let mut samples = small_set();
        let mut image = (*samples.images[0]).clone();
        change(&mut image);
        samples.images[0] = Arc::new(image);
        let error = store::file::write(&path, &samples, &small_report(), &Job::new()).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), before);
    };
    for depth in [f32::NAN, -1.0] {
        broken(&|image| {
            let mut depths = image.inverse_depths();
            depths[0] = depth;
            image.depth = DepthPlane::pack(&image.tiles, &depths);
        });
    }
    broken(&|image| image.depth = DepthPlane::pack(&image.tiles[..1], &image.inverse_depths()));
    broken(&|image| image.color[0][1] = f16::INFINITY);
    broken(&|image| image.camera = 2);
    broken(&|image| image.span.end = 3);
    broken(&|image| image.tiles.swap(0, 1));
    broken(&|image| image.tiles[1].rows[0] = 0x8000);
    broken(&|image| image.color.truncate(1));
    let camera = CameraReport { color_noise_steps: f32::NAN, ..CameraReport::default() };
    assert!(Report { cameras: vec![camera], ..Report::default() }.to_json().is_err());
}

#[test]
fn the_old_store_stays_until_the_new_one_is_whole() {
    let (folder, path, before) = small_store();
    let job = Job::new();
    job.cancel();
    let error = store::file::write(&path, &small_set(), "{}", &job).unwrap_err();
    assert!(matches!(error, Error::Cancelled));
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");

    store::file::write(&path, &small_set(), "{}", &Job::new()).unwrap();
    assert_eq!(store::read(&path, &Job::new()).unwrap().1, "{}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_store_that_cannot_be_put_there_leaves_nothing_behind() {
    let (folder, path) = scratch();
    // A folder stands where the store should go, which no store replaces.
    std::fs::create_dir(&path).unwrap();
    std::fs::write(path.join("precious"), b"1").unwrap();
    let error = store::file::write(&path, &small_set(), &small_report(), &Job::new()).unwrap_err();
    assert!(matches!(error, Error::Invalid { .. }), "{error}");
    assert_eq!(std::fs::read(path.join("precious")).unwrap(), b"1");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    let nowhere = folder.path().join("no/such/folder/scene.ovl");
    let error = store::file::write(&nowhere, &small_set(), &small_report(), &Job::new()).unwrap_err();
    assert!(error.to_string().contains("no/such/folder"), "{error}");
}

#[test]
fn reading_can_be_cancelled() {
    let (_folder, path, _) = small_store();
    let job = Job::new();
    job.cancel();
    assert!(matches!(store::read(&path, &job), Err(Error::Cancelled)));
}
