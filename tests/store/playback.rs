//! What is read of a store that plays from disk: what a vantage needs, wherever it stands in the file.

use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::render::{CpuRenderer, Vantage};
use overlook_engine::settings::{CaptureSettings, Fill, Kernel, RenderSettings, Settings};
use overlook_engine::store::file::Store;
use overlook_engine::store::playback::Playback;

use crate::builder::{moving_set, small_report};

/// A store of a built-in scene, with its cameras.
fn recorded(folder: &std::path::Path, cameras: usize, size: (u32, u32)) -> (std::path::PathBuf, Vec<Camera>) {
    let spec = DemoSpec::new("nine-cameras").cameras(cameras).frames(2).size(size).noise(0.0);
    let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
    let preprocessed = preprocess(&capture, &Settings::default(), &Job::new()).unwrap();
    let path = folder.join("scene.ovl");
    overlook_engine::store::file::write(
        &path,
        &preprocessed.samples,
        &preprocessed.report.to_json().unwrap(),
        &Job::new(),
    )
    .unwrap();
    (path, capture.cameras.clone())
}

#[test]
fn a_picture_of_the_blocks_that_its_vantage_needs_is_the_picture_of_all() {
    let folder = tempfile::tempdir().unwrap();
    let (path, cameras) = recorded(folder.path(), 3, (256, 192));
    let job = Job::new();
    let open = || Playback::new(Store::open(&path).unwrap(), 1 << 30);
    let whole = open();
    let all = [0, 1].map(|frame| whole.at(frame, &job).unwrap());
    let every_block = whole.store().blocks_read();

    // As a camera stood, aside and turned, and close to what it saw.
    let mut vantages = vec![cameras[0].clone()];
    for (step, angle) in [(0.4, 0.5), (-0.2, 0.15), (0.0, 0.08)] {
        let mut camera = cameras[1].clone();
        camera.intrinsics = Intrinsics::from_horizontal_angle(200, 150, angle);
        camera.world_from_camera.translation += camera.world_from_camera.matrix3.x_axis * step;
        vantages.push(camera);
    }
    for camera in vantages {
        let part = open();
        for frame in [0, 1] {
            let seen = part.seen_from(&camera, frame, &job).unwrap();
            let vantage = Vantage { camera: camera.clone(), frame };
            for (kernel, _) in Kernel::NAMES {
                for fill in [Fill::None, Fill::PushPull] {
                    let settings =
                        RenderSettings { kernel: kernel.parse().unwrap(), fill, ..RenderSettings::default() };
                    let paint = |set| CpuRenderer::new().render(set, &vantage, &settings, &job).unwrap().0;
                    assert!(paint(&seen) == paint(&all[frame]), "{kernel} from '{}'", camera.name);
                }
            }
        }
        // Asked for all, it gives all, and reads no block again.
        for frame in [0, 1] {
            assert_eq!(part.at(frame, &job).unwrap().images, all[frame].images);
        }
        assert_eq!(part.store().blocks_read(), every_block);
    }
}

#[test]
fn blocks_that_a_vantage_cannot_see_stay_undecoded() {
    let folder = tempfile::tempdir().unwrap();
    let (path, cameras) = recorded(folder.path(), 1, (512, 384));
    let job = Job::new();
    let read_from = |camera: &Camera| {
        let playback = Playback::new(Store::open(&path).unwrap(), 1 << 30);
        playback.seen_from(camera, 0, &job).unwrap();
        playback.store().blocks_read()
    };
    let everything = read_from(&cameras[0]);
    let mut close = cameras[0].clone();
    close.intrinsics = Intrinsics::from_horizontal_angle(200, 150, 0.08);
    let mut away = cameras[0].clone();
    let axes = &mut away.world_from_camera.matrix3;
    (axes.x_axis, axes.z_axis) = (-axes.x_axis, -axes.z_axis);
    let (part, nothing) = (read_from(&close), read_from(&away));
    assert!(nothing == 0 && 0 < part && part < everything, "{nothing}, {part} and {everything} blocks");
}

#[test]
fn a_cache_that_holds_hardly_anything_gives_the_same_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let (path, cameras) = recorded(folder.path(), 3, (256, 192));
    let job = Job::new();
    let [large, small] = [1 << 30, 1000].map(|bytes| Playback::new(Store::open(&path).unwrap(), bytes));
    for frame in [1, 0, 1] {
        let [a, b] = [&large, &small].map(|playback| playback.seen_from(&cameras[2], frame, &job).unwrap());
        assert_eq!(a.images, b.images);
        assert!(small.cached_bytes() <= 1000);
    }
}

/// Bytes that are put between what a store says of itself and its images: more than 32 bits can count.
#[cfg(unix)]
const GAP: u64 = 5 << 30;

/// The store with two chunks of zeros before its images, which take no room on the disk.
#[cfg(unix)]
fn stretched(bytes: &[u8], path: &std::path::Path) {
    use std::os::unix::fs::FileExt;
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    let mut front = bytes.to_vec();
    let mut at = 12;
    while &bytes[at..at + 4] != b"IMAG" {
        let length = number(at + 4) as usize;
        if &bytes[at..at + 4] == b"INDX" {
            let payload = &mut front[at + 8..at + 8 + length - 4];
            payload[..8].copy_from_slice(&(bytes.len() as u64 + GAP).to_be_bytes());
            for entry in payload[12..].chunks_exact_mut(40) {
                let offset = u64::from_be_bytes(entry[24..32].try_into().unwrap()) + GAP;
                entry[24..32].copy_from_slice(&offset.to_be_bytes());
            }
            let checksum = crc32fast::hash(&[b"INDX", &*payload].concat());
            front[at + 8 + length - 4..at + 8 + length].copy_from_slice(&checksum.to_be_bytes());
        }
        at += 8 + length + length % 2;
    }
    front[4..8].copy_from_slice(&u32::MAX.to_be_bytes());
    let file = std::fs::File::create(path).unwrap();
    file.set_len(bytes.len() as u64 + GAP).unwrap();
    file.write_all_at(&front[..at], 0).unwrap();
    for (half, offset) in [(0, at as u64), (1, at as u64 + GAP / 2)] {
        let length = (GAP / 2 - 8) as u32;
        file.write_all_at(&[b"GAP".as_slice(), &[b'0' + half], &length.to_be_bytes()].concat(), offset)
            .unwrap();
    }
    file.write_all_at(&bytes[at..], at as u64 + GAP).unwrap();
}

#[cfg(unix)]
#[test]
fn images_beyond_four_gibibytes_are_found_and_read() {
    use std::os::unix::fs::MetadataExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ovl");
    overlook_engine::store::file::write(&path, &moving_set(), &small_report(), &Job::new()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    stretched(&bytes, &path);
    let file = std::fs::metadata(&path).unwrap();
    assert!(file.len() > GAP && file.blocks() * 512 < 1 << 20, "{} blocks on the disk", file.blocks());

    let store = Store::open(&path).unwrap();
    assert!(store.info().images.iter().all(|image| image.offset > u64::from(u32::MAX)));
    let read = store.read_all(&Job::new()).unwrap();
    assert_eq!(read.images, moving_set().images);
    let verified = overlook_engine::store::playback::verify(&path, &Job::new()).unwrap();
    assert_eq!((verified.damage, verified.bytes), (Vec::new(), bytes.len() as u64 + GAP));

    // The last byte of the last image is checked there as anywhere.
    let last = verified.bytes - 2;
    let file = std::fs::File::options().write(true).read(true).open(&path).unwrap();
    let mut byte = [0];
    std::os::unix::fs::FileExt::read_exact_at(&file, &mut byte, last).unwrap();
    std::os::unix::fs::FileExt::write_all_at(&file, &[byte[0] ^ 0x40], last).unwrap();
    let damage = overlook_engine::store::playback::verify(&path, &Job::new()).unwrap().damage;
    assert!(damage.len() == 1 && damage[0].contains("IMAG"), "{damage:?}");
}
