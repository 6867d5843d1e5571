//! What was saved stays: writers that are killed, run out of disk, or fail at any byte; what a store carries along.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use overlook_engine::error::Error;
use overlook_engine::job::Job;
use overlook_engine::samples::SampleSet;
use overlook_engine::store;
use overlook_engine::store::file::{Extras, InputFiles, Provenance, Store};
use overlook_engine::store::playback::Playback;

use crate::builder::{any_set, moving_set, small_report, small_set};
use crate::draws::Draws;

/// Where the child that is to be killed writes.
const TARGET: &str = "OVERLOOK_TEST_STORE_TO_WRITE";

/// Moments at which a writer is killed.
const KILLS: u64 = 50;

/// Not a test of its own: the process that [`a_killed_writer_leaves_the_store_before_it_whole`] kills. Ignored, so that it counts
/// as no test that passed.
#[test]
#[ignore = "a child process of another test"]
fn a_child_writes_stores_until_it_is_killed() {
    let Some(path) = std::env::var_os(TARGET) else { return };
    let sets = [moving_set(), small_set()];
    std::fs::write(Path::new(&path).with_extension("started"), b"").unwrap();
    for set in sets.iter().cycle() {
        store::file::write(Path::new(&path), set, &small_report(), &Job::new()).unwrap();
    }
}

#[test]
fn a_killed_writer_leaves_the_store_before_it_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ovl");
    store::file::write(&path, &small_set(), &small_report(), &Job::new()).unwrap();
    let started = path.with_extension("started");
    let elsewhere = folder.path().join("elsewhere.ovl");
    let set_off = Instant::now();
    store::file::write(&elsewhere, &moving_set(), &small_report(), &Job::new()).unwrap();
    // Half of the children are killed within their first store, the others within one of the next.
    let longest_us = 2 * set_off.elapsed().as_micros().max(20_000) as u64;
    let mut draws = Draws(7);
    let mut replaced = 0;
    for nth in 0..KILLS {
        let changed = || std::fs::metadata(&path).unwrap().modified().unwrap();
        let before = changed();
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--ignored", "--exact", "trust::a_child_writes_stores_until_it_is_killed"])
            .env(TARGET, &path)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        // Every other child is killed at once when it has put a store in place of the one before, however slow it is.
        let is_late = nth % 2 == 1;
        let is_time = || started.exists() && !(is_late && changed() == before);
        while !is_time() {
            assert!(child.try_wait().unwrap().is_none(), "the child ended on its own");
            std::thread::sleep(Duration::from_micros(200));
        }
        if !is_late {
            std::thread::sleep(Duration::from_micros(draws.below(longest_us)));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        std::fs::remove_file(&started).unwrap();
        let (read, _) = store::read(&path, &Job::new()).unwrap();
        let is_small = read.images == small_set().images;
        assert!(is_small || read.images == moving_set().images);
        replaced += usize::from(!is_small);
    }
    assert!(replaced > 0, "no child came as far as writing a store");
}

/// A file in memory that takes so many bytes and no more.
struct Full {
    room: usize,
    position: usize,
}

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.position + bytes.len() > self.room {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.position += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Full {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        if let SeekFrom::Start(position) = to {
            self.position = position as usize;
        }
        Ok(self.position as u64)
    }
}

#[test]
fn a_disk_that_fills_at_any_byte_gives_an_error() {
    let extras = Extras { report: small_report(), ..Extras::default() };
    let write = |room| {
        let full = Full { room, position: 0 };
        store::file::write_to(full, Path::new("full.ovl"), &small_set(), &extras, &Job::new())
    };
    let size = write(usize::MAX).unwrap() as usize;
    for room in (0..size).step_by(97).chain([size - 1]) {
        let error = write(room).unwrap_err();
        assert!(matches!(error, Error::Io { .. }) && error.to_string().contains("full.ovl"), "{error}");
    }
    assert_eq!(write(size).unwrap() as usize, size);
}

#[test]
#[cfg(unix)]
fn a_full_disk_leaves_the_old_store_and_no_half_file() {
    let folder = tempfile::tempdir().unwrap();
    let [from, to] = ["from.ovl", "to.ovl"].map(|name| folder.path().join(name));
    store::file::write(&from, &moving_set(), &small_report(), &Job::new()).unwrap();
    store::file::write(&to, &small_set(), &small_report(), &Job::new()).unwrap();
    let before = std::fs::read(&to).unwrap();
    // Files of this process and its children end after 2 KiB.
    let script = "trap '' XFSZ; ulimit -f 4; exec \"$0\" export store \"$1\" --out \"$2\"";
    let output = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_overlook")])
        .args([&from, &to])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("to.ovl") && said.trim().lines().count() == 1, "{said}");
    assert_eq!(std::fs::read(&to).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn provenance_and_unknown_chunks_stay_when_a_store_is_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first.ovl", "second.ovl"].map(|name| folder.path().join(name));
    let provenance = Provenance {
        inputs: Some(InputFiles { files: 3, bytes: 12_345, crc32: 0xDEAD_BEEF }),
        ..Provenance::default()
    };
    let unknown = vec![(*b"ANNO", b"by hand".to_vec()), (*b"XTRA", Vec::new())];
    let extras = Extras {
        report: small_report(),
        provenance: provenance.clone(),
        unknown: unknown.clone(),
        ..Extras::default()
    };
    store::file::write_with(&first, &moving_set(), &extras, &Job::new()).unwrap();

    let output = Command::new(env!("CARGO_BIN_EXE_overlook"))
        .args(["export", "store"])
        .arg(&first)
        .arg("--out")
        .arg(&second)
        .args(["--set", "store.precision=bits8"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let written = Store::open(&second).unwrap();
    // What the planes take is said by the writer.
    let planes = written.info().provenance.planes;
    assert!(planes.is_some_and(|planes| planes.depth > 0));
    assert_eq!(written.info().provenance, Provenance { planes, ..provenance });
    assert_eq!(written.unknown_chunks().unwrap(), unknown);
    assert!(written.info().bytes < Store::open(&first).unwrap().info().bytes);
    assert_eq!(written.info().settings.to_toml().lines().filter(|line| line.contains("bits8")).count(), 1);
}

#[test]
fn verify_says_which_chunk_is_bad() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ovl");
    store::file::write(&path, &moving_set(), &small_report(), &Job::new()).unwrap();
    let verify = || Command::new(env!("CARGO_BIN_EXE_overlook")).arg("verify").arg(&path).output().unwrap();
    let whole = verify();
    assert_eq!(whole.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&whole.stdout).contains("is whole"));

    let bytes = std::fs::read(&path).unwrap();
    let image = Store::open(&path).unwrap().info().images[3];
    let mut damaged = bytes.clone();
    damaged[(image.offset + 8) as usize + image.length as usize - 1] ^= 0x10;
    std::fs::write(&path, &damaged).unwrap();
    let bad = verify();
    assert_eq!(bad.status.code(), Some(1));
    let said = String::from_utf8_lossy(&bad.stderr).into_owned();
    assert!(said.contains(&format!("at byte {}: chunk 'IMAG' of camera 'one'", image.offset)), "{said}");

    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    assert_eq!(verify().status.code(), Some(1));
}

#[test]
fn a_store_plays_frame_by_frame_with_a_cache_that_holds_hardly_anything() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ovl");
    let set = moving_set();
    store::file::write(&path, &set, &small_report(), &Job::new()).unwrap();
    let playback = Playback::new(Store::open(&path).unwrap(), 40_000);
    let job = Job::new();
    for frame in [9, 0, 3, 4, 5, 1, 8] {
        let shown = playback.at(frame, &job).unwrap();
        assert_eq!(shown.images.len(), set.images.len());
        for (index, image) in shown.images.iter().enumerate() {
            if index == frame {
                assert_eq!(image, &set.images[index]);
            } else {
                assert!(image.is_empty() && image.span == set.images[index].span);
            }
        }
        assert!(playback.cached_bytes() <= 40_000);
    }
    assert!(playback.at(10, &job).unwrap_err().to_string().contains("no frame 10"));
    let cached = Playback::new(Store::open(&path).unwrap(), 1 << 20);
    cached.read_ahead_from(&set.cameras[0], 2..20, &job).unwrap();
    let [first, again] = [cached.at(3, &job).unwrap(), cached.at(3, &job).unwrap()];
    assert!(first.shares(&again, &[3]) && !first.shares(&cached.at(4, &job).unwrap(), &[3]));
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(24))]

    #[test]
    fn what_is_left_out_is_within_the_precision_that_is_set(
        mut set in any_set(),
        bits in proptest::sample::select(vec![8_u32, 10, 12, 16]),
        footprints in 0.002_f32..1.0,
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.ovl");
        set.settings.set_text(&format!("store.precision=bits{bits}")).unwrap();
        set.settings.set_text(&format!("store.depth_precision={footprints}")).unwrap();
        store::file::write(&path, &set, &small_report(), &Job::new()).unwrap();
        let (read, _) = store::read(&path, &Job::new()).unwrap();
        // What a store leaves out, it leaves out once.
        store::write_again(&path, &Store::open(&path).unwrap(), None, &Job::new()).unwrap();
        proptest::prop_assert_eq!(&store::read(&path, &Job::new()).unwrap().0.images, &read.images);
        let steps = overlook_engine::color::steps_from_linear;
        let half_step = 127.5 / ((1_u64 << bits) - 1) as f32;
        proptest::prop_assert_eq!(read.images.len(), set.images.len());
        for (read, image) in read.images.iter().zip(&set.images) {
            proptest::prop_assert_eq!(&read.tiles, &image.tiles);
            for (a, b) in read.color.iter().flatten().zip(image.color.iter().flatten()) {
                proptest::prop_assert!((steps(*a) - steps(*b)).abs() <= half_step, "{} for {}", a, b);
            }
            let intrinsics = &set.cameras[image.camera as usize].intrinsics;
            let allowed = f64::from(footprints) / intrinsics.fx.max(intrinsics.fy);
            for (a, b) in read.inverse_depths().into_iter().zip(image.inverse_depths()) {
                let (a, b) = (f64::from(a), f64::from(b));
                proptest::prop_assert!(
                    (a - b).abs() <= allowed * b || b < f64::from(f32::MIN_POSITIVE), "{} for {}", a, b
                );
            }
        }
    }
}

#[test]
fn a_store_that_is_held_to_less_again_keeps_the_bound_of_the_capture_and_none_becomes_more_precise() {
    let folder = tempfile::tempdir().unwrap();
    let (path, coarser) = (folder.path().join("scene.ovl"), folder.path().join("coarser.ovl"));
    let mut set = moving_set();
    set.settings.set_text("store.precision=bits10").unwrap();
    store::file::write(&path, &set, &small_report(), &Job::new()).unwrap();
    let store = Store::open(&path).unwrap();
    let again = |text: &str| {
        let mut settings = set.settings.clone();
        settings.set_text(text).unwrap();
        store::write_again(&coarser, &store, Some(&settings.store), &Job::new())
    };
    for text in ["store.precision=bits12", "store.precision=lossless", "store.depth_precision=0.01"] {
        let refused = again(text).unwrap_err().to_string();
        assert!(refused.contains("any more") || refused.contains("cannot hold depth"), "{refused}");
        assert!(!coarser.exists());
    }
    again("store.precision=bits8").unwrap();
    let (read, _) = store::read(&coarser, &Job::new()).unwrap();
    let steps = overlook_engine::color::steps_from_linear;
    let colors =
        |set: &SampleSet| set.images.iter().flat_map(|image| image.color.clone()).collect::<Vec<_>>();
    let (before, after) = (colors(&set), colors(&read));
    let pairs = before.iter().flatten().zip(after.iter().flatten());
    assert!(pairs.clone().any(|(a, b)| a != b));
    assert!(pairs.into_iter().all(|(a, b)| (steps(*a) - steps(*b)).abs() <= 0.5));
}

#[test]
fn normals_are_left_out_of_a_store_that_is_written_again_where_none_are_asked_for_and_not_made_up() {
    let folder = tempfile::tempdir().unwrap();
    let [with, without, again] =
        ["with.ovl", "without.ovl", "again.ovl"].map(|name| folder.path().join(name));
    let mut set = small_set();
    set.settings.set_text("store.normals=true").unwrap();
    set.images.retain(|image| image.normal.is_some());
    store::file::write(&with, &set, &small_report(), &Job::new()).unwrap();
    let write_again = |from: &Path, to: &Path, normals: bool| {
        let store = Store::open(from).unwrap();
        let mut settings = store.info().settings.clone();
        settings.store.normals = normals;
        store::write_again(to, &store, Some(&settings.store), &Job::new())
    };
    let read = |path: &Path| store::read(path, &Job::new()).unwrap().0;
    write_again(&with, &again, true).unwrap();
    assert!(read(&again).images == set.images);
    assert!(write_again(&with, &without, false).unwrap() < std::fs::metadata(&with).unwrap().len());
    let plain = read(&without);
    assert!(!plain.settings.store.normals && plain.images.iter().all(|image| image.normal.is_none()));
    assert_eq!(plain.sample_count(), set.sample_count());
    write_again(&without, &again, false).unwrap();
    assert!(read(&again).images == plain.images);
    let refused = write_again(&without, &again, true).unwrap_err().to_string();
    assert!(refused.contains("cannot have normals: the store holds none"), "{refused}");
    assert!(read(&again).images == plain.images);
}

#[test]
fn what_depth_errs_by_adds_up_over_stores_that_are_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut set = moving_set();
    // A focal length at which the granted error is no power of two of a float's units.
    for camera in &mut set.cameras {
        (camera.intrinsics.fx, camera.intrinsics.fy) = (80.0, 80.0);
    }
    set.settings.set_text("store.precision=bits10").unwrap();
    set.settings.set_text("store.depth_precision=0.0625").unwrap();
    let written = |name: &str| folder.path().join(name);
    store::file::write(&written("0"), &set, &small_report(), &Job::new()).unwrap();
    let depths =
        |set: &SampleSet| set.images.iter().flat_map(|image| image.inverse_depths()).collect::<Vec<f32>>();
    let (mut last, mut held) = ("0".to_owned(), 0);
    for footprints in ["0.125", "0.08", "0.25", "0.5", "1"] {
        let mut settings = set.settings.clone();
        settings.set_text(&format!("store.depth_precision={footprints}")).unwrap();
        let store = Store::open(&written(&last)).unwrap();
        if store::write_again(&written(footprints), &store, Some(&settings.store), &Job::new()).is_err() {
            continue;
        }
        (last, held) = (footprints.to_owned(), held + 1);
        let (read, _) = store::read(&written(footprints), &Job::new()).unwrap();
        let granted = footprints.parse::<f32>().unwrap() / 80.0;
        for (true_w, w) in depths(&set).iter().zip(depths(&read)) {
            assert!((w - true_w).abs() <= granted * true_w, "{footprints}: {true_w} became {w}");
        }
    }
    assert!(held > 0, "every store was refused");
}
