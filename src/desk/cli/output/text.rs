//! Printing, and numbers as text.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use indicatif::{DecimalBytes, HumanCount};
use serde::Serialize;

use super::command_error::CommandError;
use overlook_engine::capture::ValueChannel;
use overlook_engine::edits::CutByHand;
use overlook_engine::error::Error;
use overlook_engine::part::Part;
use overlook_engine::plural::{counted, noun};
use overlook_engine::preprocess::diagnostics::Report;

/// Prints lines of text.
pub(crate) fn print(text: &str) -> Result<(), CommandError> {
    let mut stdout = std::io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        // The reader has read enough.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => Ok(result.map_err(|error| Error::io("stdout", error))?),
    }
}

/// Prints one JSON document.
pub(crate) fn print_json(document: &impl Serialize) -> Result<(), CommandError> {
    let text = serde_json::to_string_pretty(document)
        .map_err(|error| Error::invalid("JSON output", error.to_string()))?;
    print(&text)
}

/// Prints where the files of a part are.
pub(crate) fn print_parts(part: Part, files: &[PathBuf], json: bool) -> Result<(), CommandError> {
    if json {
        return print_json(&serde_json::json!({ "part": part.to_string(), "files": files }));
    }
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    let of = part.of();
    print(&format!(
        "Part {part} is complete: {}\nNext: once all parts are, the same command with --join {of}",
        names.join(", ")
    ))
}

/// Prints one line on stderr. Failing to do so must not end the work.
pub(crate) fn print_error(line: &str) {
    let _ = writeln!(std::io::stderr(), "overlook: {line}");
}

/// Prints warnings on stderr, one line each.
pub(crate) fn warn(warnings: &[String]) {
    for warning in warnings {
        print_error(&format!("warning: {warning}"));
    }
}

/// Says that a form holds no scalar values, where there are any.
pub(crate) fn warn_of_values(channels: &[ValueChannel], form: &str) {
    if !channels.is_empty() {
        let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
        let names = names.join(", ");
        warn(&[format!("{form} holds no scalar values: {names} stay in the capture and the store")]);
    }
}

/// That pictures were written into a folder.
pub(crate) fn wrote_pictures(count: usize, folder: &Path) -> String {
    format!("Wrote {} (EXR and PNG) to {}", counted(count, "picture"), folder.display())
}

/// A count with separators: 1,234,567.
pub(crate) fn count(number: u64) -> String {
    HumanCount(number).to_string()
}

/// A count with separators and its noun: `1 sample`, `1,234,567 samples`.
pub(crate) fn count_of(number: u64, singular: &str) -> String {
    format!("{} {}", count(number), noun(number, singular))
}

/// Bytes in powers of a thousand: `12 B`, `1.54 kB`.
pub(crate) fn bytes(number: u64) -> String {
    DecimalBytes(number).to_string()
}

/// A line with the number of pixels without depth, if there are any.
pub(crate) fn without_depth(report: &Report) -> Option<String> {
    let pixels = report.without_depth();
    (pixels > 0).then(|| format!("  without depth {:>10}\n", count(pixels)))
}

/// A line for each time that something was cut by hand.
pub(crate) fn cut_by_hand(report: &Report) -> String {
    let line = |cut: &CutByHand| {
        let mut parts = Vec::new();
        if !cut.cameras.is_empty() {
            parts.push(format!("without {}", cut.cameras.join(", ")));
        }
        if cut.pixels > 0 {
            parts.push(format!("{} before pruning", count_of(cut.pixels, "pixel")));
        }
        if cut.samples > 0 || parts.is_empty() {
            parts.push(count_of(cut.samples, "sample"));
        }
        format!("  cut by hand: {}\n", parts.join("; "))
    };
    report.cut.iter().map(line).collect()
}

/// `part` of `whole` in percent.
pub(crate) fn percent(part: u64, whole: u64) -> String {
    if whole == 0 { "0 %".to_owned() } else { format!("{:.1} %", 100.0 * part as f64 / whole as f64) }
}

/// A number that may be unknown, right-aligned.
pub(crate) fn number(value: Option<f64>, decimals: usize, width: usize) -> String {
    value.map_or_else(|| format!("{:>width$}", "–"), |value| format!("{value:>width$.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!([count(0), count(999), count(1_234_567)], ["0", "999", "1,234,567"]);
        assert_eq!([bytes(12), bytes(1536), bytes(5 << 30)], ["12 B", "1.54 kB", "5.37 GB"]);
        assert_eq!([percent(1, 8), percent(1, 0)], ["12.5 %", "0 %"]);
        assert_eq!([number(Some(1.25), 1, 5), number(None, 1, 3)], ["  1.2", "  –"]);
    }
}
