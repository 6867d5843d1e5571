//! How a test says that this machine lacks what it needs.

use std::io::Write;

/// Says why a test checks nothing, on the terminal itself: what a passing test prints is shown to nobody. Where the variable
/// `required` is set the test fails instead, so that a check that is meant to run it cannot pass without.
pub(crate) fn skip(required: Option<&str>, why: &str) {
    if let Some(variable) = required {
        assert!(std::env::var_os(variable).is_none(), "{variable} is set, but {why}");
    }
    // Where stderr is closed there is nobody to tell.
    let _ = std::io::stderr().write_all(format!("SKIPPED: {why}\n").as_bytes());
}
