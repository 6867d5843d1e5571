//! Ctrl-C and Cancel: work that is stopped ends before it is done and leaves nothing half-made behind.
#![cfg(unix)]

#[path = "common/draws.rs"]
mod draws;
#[path = "common/scene.rs"]
mod scene;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::DVec3;
use overlook_engine::capture::Capture;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::preprocess::{prune, scan};
use overlook_engine::settings::Settings;
use rustix::process::{Pid, Signal, kill_process};
use scene::{Scene, arc};

/// Everything takes far less.
const PATIENCE: Duration = Duration::from_mins(1);

fn temporary_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_temporary = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().starts_with(".overlook-");
    entries.filter(is_temporary).collect()
}

/// Whether a store is being written; whether one can be is tried at once, with a file of another name.
fn is_writing(folder: &Path) -> bool {
    temporary_files(folder).iter().any(|path| path.extension().is_some_and(|extension| extension == "tmp"))
}

fn preprocess(folder: &Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_overlook"))
        .args(["preprocess", "scene", "--out", "scene.ovl", "--threads", "1", "--set", "pruning.method=off"])
        .current_dir(folder)
        .env_remove("RUST_LOG")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for `what`; gives whether it came before the program ended.
fn wait_until(child: &mut Child, what: impl Fn() -> bool) -> bool {
    let asked = Instant::now();
    loop {
        if what() {
            return true;
        }
        if child.try_wait().unwrap().is_some() {
            return false;
        }
        assert!(asked.elapsed() < PATIENCE, "nothing happens");
        std::thread::sleep(Duration::from_micros(200));
    }
}

fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

fn capture(folder: &Path) {
    let arguments =
        ["demo", "orrery", "--cameras", "3", "--frames", "6", "--size", "320x240", "--out", "scene"];
    let written =
        Command::new(env!("CARGO_BIN_EXE_overlook")).args(arguments).current_dir(folder).output().unwrap();
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
}

#[test]
fn what_is_stopped_while_it_writes_leaves_no_temporary_file_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    capture(folder.path());
    for name in [Signal::INT, Signal::TERM] {
        let mut child = preprocess(folder.path());
        let wrote = wait_until(&mut child, || is_writing(folder.path()));
        assert!(wrote, "the store was written before it could be stopped");
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{stderr}");
        assert_eq!(stderr, "overlook: cancelled\n");
        assert!(output.stdout.is_empty());
        assert_eq!(temporary_files(folder.path()), Vec::<PathBuf>::new());
        assert!(!folder.path().join("scene.ovl").exists());
    }
}

/// Three cameras that see a sphere pass by.
fn passing_sphere() -> Capture {
    let mut scene = Scene::still_life();
    scene.spheres[1].center = Arc::new(|frame| Some(DVec3::new(0.05 * frame as f64 - 1.0, -0.6, 0.4)));
    scene.record(arc(3, 96), 40)
}

/// Runs `work`, and cancels it from another thread as soon as part of the stage called `stage` is done. Gives how much of it was
/// done when the work ended; `None` where all was done before that.
fn cancelled_within<T>(stage: &str, work: impl FnOnce(&Job) -> Result<T>) -> Option<f32> {
    let (job, has_ended) = (Job::new(), AtomicBool::new(false));
    let result = std::thread::scope(|threads| {
        threads.spawn(|| {
            while !has_ended.load(Ordering::Relaxed) {
                let progress = job.progress();
                if progress.stage == stage && progress.done > 0 {
                    job.cancel();
                    return;
                }
                std::thread::yield_now();
            }
        });
        let result = work(&job);
        has_ended.store(true, Ordering::Relaxed);
        result.map(|_| ())
    });
    let progress = job.progress();
    match result {
        Err(Error::Cancelled) => {
            assert_eq!(progress.stage, stage);
            Some(progress.fraction())
        }
        Err(error) => panic!("{stage}: {error}"),
        Ok(()) => None,
    }
}

/// Tries a few times: on a machine that is busy, work may be done before the other thread has looked even once.
fn assert_cancelled_within<T>(stage: &str, mut work: impl FnMut(&Job) -> Result<T>) {
    let done = (0..5).find_map(|_| cancelled_within(stage, &mut work));
    assert!(done.is_some_and(|done| done < 1.0), "{stage}: {done:?} of it was done");
}

#[test]
fn scanning_pruning_and_writing_end_within_the_stage_in_which_they_are_cancelled() {
    let (capture, settings) = (passing_sphere(), Settings::default());
    assert_cancelled_within("Reading frames", |job| scan(&capture, &settings, job));
    let scanned = scan(&capture, &settings, &Job::new()).unwrap();
    assert_cancelled_within("Pruning frames", |job| prune(&capture, &scanned, &settings, job));
    let preprocessed = prune(&capture, &scanned, &settings, &Job::new()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ovl");
    std::fs::write(&path, "what was there before").unwrap();
    let mut wrote_whole = false;
    assert_cancelled_within("Writing the store", |job| {
        let written = overlook_engine::store::file::write(&path, &preprocessed.samples, "{}", job);
        wrote_whole |= written.is_ok();
        written
    });
    assert_eq!(temporary_files(folder.path()), Vec::<PathBuf>::new());
    assert!(wrote_whole || std::fs::read(&path).unwrap() == b"what was there before");
}
