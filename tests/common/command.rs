//! The program as tests start it.

use std::path::Path;
use std::process::{Command, Output};

/// The program with these arguments in a folder.
pub(crate) fn overlook(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_overlook"));
    command.current_dir(folder).args(arguments);
    command
}

/// What a command gives, which must be a success.
pub(crate) fn succeed(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// A folder with a small capture of two cameras called `scene`, truth views beside it.
pub(crate) fn scene(frames: &str, size: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let demo = ["demo", "orrery", "--out", "scene", "--cameras", "2", "--frames", frames, "--size", size];
    succeed(overlook(folder.path(), &demo));
    folder
}
