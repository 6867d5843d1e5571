//! What the program says: run with arguments in a folder, it has to succeed, or to fail as expected.

use std::path::Path;

use crate::command::{self, overlook};

/// What a command that must succeed prints.
pub(crate) fn succeed(folder: &Path, arguments: &[&str]) -> String {
    String::from_utf8(command::succeed(overlook(folder, arguments)).stdout).unwrap()
}

/// What a command that must fail with this code says. Trouble with the input (code 1) takes one line beside warnings, usage may take
/// more.
pub(crate) fn fail(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = overlook(folder, arguments).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    let troubles = said.lines().filter(|line| !line.starts_with("overlook: warning: ")).count();
    assert!(code != 1 || troubles == 1, "{arguments:?}: {said}");
    said
}
