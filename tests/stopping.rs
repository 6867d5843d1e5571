//! Ctrl-C: work that is stopped leaves nothing half-made behind.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Everything takes far less.
const PATIENCE: Duration = Duration::from_mins(1);

fn temporary_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_temporary = |path: &PathBuf| path.file_name().unwrap().to_string_lossy().starts_with(".overlook-");
    entries.filter(is_temporary).collect()
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

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args(["-s", name, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
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
    for name in ["INT", "TERM"] {
        let mut child = preprocess(folder.path());
        let wrote = wait_until(&mut child, || !temporary_files(folder.path()).is_empty());
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
