//! Files of results: a journal that a run goes on from, CSV, JSON.

use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{output, progress};
use crate::error::{Error, Result};
use crate::evaluate::chart::Chart;
use crate::evaluate::sweep::Point;
use crate::job::Job;
use crate::whole_file;

/// What a run has measured so far, one JSON document a line below a line that says what it was measured on.
pub(super) struct Journal {
    path: PathBuf,
    file: Mutex<File>,
    lines: Vec<String>,
}

impl Journal {
    /// Opens `DIR/NAME.journal`, and starts a new one where it was measured on something else: that is kept beside it.
    pub(super) fn open(folder: &Path, name: &str, fingerprint: &str) -> Result<Self> {
        fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
        let path = folder.join(format!("{name}.journal"));
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(Error::io(path, error)),
        };
        let head = serde_json::Value::from(fingerprint).to_string();
        let mut known = text.lines();
        let is_same = known.next() == Some(head.as_str());
        let mut lines: Vec<String> = known.map(str::to_owned).collect();
        if !is_same && !lines.is_empty() {
            put_aside(&path)?;
            lines.clear();
        }
        let io = |error| Error::io(&path, error);
        let mut file = if lines.is_empty() {
            let mut file = File::create(&path).map_err(io)?;
            writeln!(file, "{head}").map_err(io)?;
            file
        } else {
            OpenOptions::new().append(true).open(&path).map_err(io)?
        };
        // A run that was killed while it wrote may have left half a line.
        if !text.is_empty() && !text.ends_with('\n') && !lines.is_empty() {
            writeln!(file).map_err(io)?;
        }
        Ok(Self { file: Mutex::new(file), path, lines })
    }

    /// What is known already; lines that cannot be read are measured again.
    pub(super) fn points<T: DeserializeOwned>(&self) -> Vec<T> {
        self.lines.iter().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }

    /// Adds what was just measured.
    pub(super) fn add(&self, point: &impl Serialize) -> Result<()> {
        let line = serde_json::to_string(point)
            .map_err(|error| Error::invalid(self.path.display(), error.to_string()))?;
        let io = |error| Error::io(&self.path, error);
        let Ok(mut file) = self.file.lock() else { return Ok(()) };
        writeln!(file, "{line}").and_then(|()| file.flush()).map_err(io)
    }
}

/// Gives a journal another name, so that what took hours to measure is not lost to a word that changed.
fn put_aside(path: &Path) -> Result<()> {
    let mut aside = path.with_extension("journal.old");
    let mut number = 1;
    while aside.exists() {
        number += 1;
        aside = path.with_extension(format!("journal.old{number}"));
    }
    fs::rename(path, &aside).map_err(|error| Error::io(path, error))?;
    output::warn(&[format!(
        "{} was measured on another state of the capture, with another truth or by another version; it is kept as {}, and \
         everything is measured anew",
        path.display(),
        aside.display()
    )]);
    Ok(())
}

/// Does `work` under a progress bar, adding each point it measures to `journal`; stops where that cannot be written.
pub(super) fn recorded<P: Serialize, T>(
    journal: Option<&Journal>,
    work: impl FnOnce(&Job, &mut dyn FnMut(&P)) -> Result<T>,
) -> Result<T> {
    let mut trouble = None;
    let outcome = progress::watched(|job| {
        work(job, &mut |point| {
            if let Some(Err(error)) = journal.map(|journal| journal.add(point)) {
                trouble = Some(error);
                job.cancel();
            }
        })
    });
    trouble.map_or(outcome, Err)
}

/// Writes one JSON document.
pub(super) fn write_json(path: &Path, document: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(document)
        .map_err(|error| Error::invalid(path.display(), error.to_string()))?;
    whole_file::write_all(path, text + "\n")
}

/// Writes a chart as PNG.
pub(super) fn write_chart(path: &Path, chart: &Chart) -> Result<()> {
    whole_file::write_all(path, chart.png()?)
}

/// Writes documents as CSV (RFC 4180): one a row, a column for every number, text or truth value, nested ones by the path to
/// them.
pub(super) fn write_csv(path: &Path, rows: &[impl Serialize]) -> Result<()> {
    let mut head: Vec<String> = Vec::new();
    let mut table = Vec::new();
    for row in rows {
        let value =
            serde_json::to_value(row).map_err(|error| Error::invalid(path.display(), error.to_string()))?;
        let mut cells = Vec::new();
        flatten("", &value, &mut cells);
        for (name, _) in &cells {
            if !head.contains(name) {
                head.push(name.clone());
            }
        }
        table.push(cells);
    }
    let mut text = head.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(",") + "\r\n";
    for cells in table {
        let cell = |name: &String| {
            let found = cells.iter().find(|(known, _)| known == name);
            found.map_or_else(String::new, |(_, value)| quoted(value))
        };
        text += &(head.iter().map(cell).collect::<Vec<_>>().join(",") + "\r\n");
    }
    whole_file::write_all(path, text)
}

fn flatten(prefix: &str, value: &serde_json::Value, cells: &mut Vec<(String, String)>) {
    use serde_json::Value;
    match value {
        Value::Object(map) => {
            for (name, value) in map {
                let path = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
                flatten(&path, value, cells);
            }
        }
        Value::Null => cells.push((prefix.to_owned(), String::new())),
        Value::String(text) => cells.push((prefix.to_owned(), text.clone())),
        other => cells.push((prefix.to_owned(), other.to_string())),
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// One line per point; a star marks the Pareto front.
pub(super) fn table(points: &[Point]) -> String {
    let mut text = format!(
        "{:<52} {:>15} {:>15} {:>7} {:>7} {:>7} {:>12} {:>10} {:>8}",
        "setting", "filled dB ± SE", "PSNR dB ± SE", "SSIM", "FLIP", "cover", "samples", "bytes", "ms"
    );
    for point in points {
        let star = if point.pareto { '*' } else { ' ' };
        let _ = write!(
            text,
            "\n{star} {:<50} {:>8.2} ± {:>4.2} {:>8.2} ± {:>4.2} {:>7.4} {:>7.4} {:>7.4} {:>12} {:>10} {:>8.1}",
            point.label,
            point.psnr_filled_db,
            point.psnr_filled_db_se,
            point.psnr_db,
            point.psnr_db_se,
            point.ssim,
            point.flip,
            point.coverage,
            output::count(point.samples),
            output::bytes(point.bytes),
            point.milliseconds
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_has_a_column_for_everything_and_quotes_what_needs_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let rows = [
            serde_json::json!({"label": "a, \"b\"", "settings": {"x": {"y": 1.5}}}),
            serde_json::json!({"label": "c", "more": null}),
        ];
        write_csv(&path, &rows).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text, "label,settings.x.y,more\r\n\"a, \"\"b\"\"\",1.5,\r\nc,,\r\n");
    }

    #[test]
    fn a_journal_goes_on_where_it_stopped_and_starts_anew_for_something_else() {
        let folder = tempfile::tempdir().unwrap();
        let numbers = |fingerprint: &str| Journal::open(folder.path(), "t", fingerprint).unwrap();
        let journal = numbers("one");
        journal.add(&1).unwrap();
        journal.add(&2).unwrap();
        let path = folder.path().join("t.journal");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text + "{\"half").unwrap();
        let journal = numbers("one");
        assert_eq!(journal.points::<i32>(), [1, 2]);
        journal.add(&3).unwrap();
        assert_eq!(numbers("one").points::<i32>(), [1, 2, 3]);
        assert!(numbers("two").points::<i32>().is_empty());
        assert!(fs::read_to_string(folder.path().join("t.journal.old")).unwrap().contains("\n3\n"));
        numbers("two").add(&4).unwrap();
        assert!(numbers("three").points::<i32>().is_empty());
        assert!(fs::read_to_string(folder.path().join("t.journal.old2")).unwrap().ends_with("\n4\n"));
        assert!(numbers("four").points::<i32>().is_empty());
        assert!(!folder.path().join("t.journal.old3").exists(), "nothing was measured that could be lost");
    }
}
