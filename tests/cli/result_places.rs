//! Where commands write: no pipe and no input is replaced, links are written through, and what cannot be written is told before
//! the work rather than after it.

use std::path::Path;
use std::process::Command;

use crate::command::{overlook, scene, succeed};

/// The one line of a command that is refused.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = overlook(folder, arguments).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), said.lines().count()), (Some(1), 1), "{arguments:?}: {said}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    said
}

#[test]
#[cfg(unix)]
fn a_pipe_stays_a_pipe() {
    let folder = scene("1", "24x16");
    let folder = folder.path();
    assert!(Command::new("mkfifo").arg(folder.join("pipe.ovl")).status().unwrap().success());
    for command in [["preprocess", "scene"], ["tune", "scene"]] {
        let said = refused(folder, &[&command[..], &["--out", "pipe.ovl"]].concat());
        assert!(said.contains("pipe.ovl: is a folder, a pipe or a device"), "{said}");
        assert!(!std::fs::metadata(folder.join("pipe.ovl")).unwrap().is_file());
    }
}

#[test]
#[cfg(unix)]
fn nothing_waits_for_a_pipe_or_reads_a_device_in_place_of_a_manifest() {
    let folder = scene("1", "24x16");
    let folder = folder.path();
    let manifest = folder.join("scene/transforms.json");
    std::fs::remove_file(&manifest).unwrap();
    assert!(Command::new("mkfifo").arg(&manifest).status().unwrap().success());
    let expected = "transforms.json: is a pipe or a device, and is read more than once; name a file\n";
    assert!(refused(folder, &["info", "scene"]).ends_with(expected));
    assert!(refused(folder, &["info", "scene/transforms.json"]).ends_with(expected));
    std::fs::remove_file(&manifest).unwrap();
    std::os::unix::fs::symlink("/dev/zero", &manifest).unwrap();
    assert!(refused(folder, &["info", "scene"]).ends_with(expected));
}

#[test]
#[cfg(unix)]
fn a_store_is_written_through_a_link_to_it() {
    let folder = scene("1", "24x16");
    let folder = folder.path();
    std::fs::create_dir(folder.join("far")).unwrap();
    std::os::unix::fs::symlink("far/scene.ovl", folder.join("link.ovl")).unwrap();
    for stale in [None, Some("what was there before")] {
        if let Some(stale) = stale {
            std::fs::write(folder.join("far/scene.ovl"), stale).unwrap();
        }
        succeed(overlook(folder, &["preprocess", "scene", "--out", "link.ovl"]));
        assert!(folder.join("link.ovl").is_symlink());
        assert!(std::fs::read(folder.join("far/scene.ovl")).unwrap().starts_with(b"FORM"));
        assert_eq!(std::fs::read_dir(folder.join("far")).unwrap().count(), 1);
    }
    succeed(overlook(folder, &["verify", "far/scene.ovl"]));
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_takes_no_file_is_told_before_anything_is_read() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        ["preprocess", "nowhere", "--out", "/proc/x.ovl"].as_slice(),
        &["tune", "nowhere", "--out", "/proc/x.toml"],
        &["export", "store", "nowhere", "--out", "/proc/x.ovl"],
        &["export", "points", "nowhere", "--static", "--out", "/proc/x.ply"],
        &["export", "video", "nowhere", "--path", "nowhere", "--out", "/proc/x.mp4"],
    ] {
        let said = refused(folder.path(), arguments);
        assert!(said.contains("/proc/x.") && said.contains("no file can be made there"), "{said}");
    }
}

#[test]
fn no_command_writes_over_the_settings_that_it_reads() {
    let folder = scene("1", "24x16");
    let folder = folder.path();
    succeed(overlook(folder, &["preprocess", "scene", "--out", "scene.ovl"]));
    let settings = "[pruning]\ndepth_tolerance = 2.0\n";
    std::fs::write(folder.join("same.toml"), settings).unwrap();
    for command in [["preprocess", "scene"].as_slice(), &["tune", "scene"], &["export", "store", "scene.ovl"]]
    {
        let said = refused(folder, &[command, &["--settings", "same.toml", "--out", "./same.toml"]].concat());
        assert!(said.contains("is what is read; name another file with --out"), "{said}");
        assert_eq!(std::fs::read_to_string(folder.join("same.toml")).unwrap(), settings);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn where_stderr_takes_nothing_the_exit_code_and_the_results_are_what_they_would_be() {
    let folder = scene("1", "24x16");
    let folder = folder.path();
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for (arguments, code) in [
        (["info", "nowhere"].as_slice(), 1),
        (&["info", "scene", "--nonsense"], 2),
        (&["export", "store", "nowhere", "--out", "x.ovl", "--set", "render.kernel=block"], 2),
    ] {
        let output = overlook(folder, arguments).stderr(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    }
    // A settings file that changes nothing is a warning.
    std::fs::write(folder.join("same.toml"), "").unwrap();
    let mut sweep = overlook(folder, &["sweep", "scene", "--with", "same.toml", "--out", "sweep"]);
    sweep.stderr(full());
    succeed(sweep);
    assert!(folder.join("sweep/sweep.json").is_file());
}

#[test]
#[cfg(unix)]
fn views_that_can_be_read_but_once_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        ["render", "nowhere.ovl", "--views", "/dev/null", "--out", "pictures"].as_slice(),
        &["export", "pictures", "nowhere.ovl", "--path", "/dev/null", "--out", "pictures"],
        &["export", "video", "nowhere.ovl", "--path", "/dev/null", "--out", "film.mp4"],
    ] {
        let said = refused(folder.path(), arguments);
        assert!(said.contains("/dev/null: is a pipe or a device"), "{said}");
    }
}
