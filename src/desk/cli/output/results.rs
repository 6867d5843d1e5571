//! Files of results: a journal that a run goes on from, CSV, JSON.

use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{progress, text};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::whole_file;
use overlook_lab::chart::Chart;
use overlook_lab::sweep::Point;

/// The measurements of a run so far: a line that identifies their input, then one JSON document per line. The file is locked
/// while it is open, so that two runs do not mix.
pub(crate) struct Journal {
    path: PathBuf,
    file: Mutex<File>,
    lines: Vec<String>,
    /// The renamed journal of another input, kept locked against a run that opened it under its old name.
    _aside: Option<File>,
}

impl Journal {
    /// Opens `DIR/NAME.journal`. A journal of another input is renamed, and a new one is started.
    pub(crate) fn open(folder: &Path, name: &str, fingerprint: &str) -> Result<Self> {
        fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
        let path = folder.join(format!("{name}.journal"));
        let io = |error| Error::io(&path, error);
        let mut file = locked(&path)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(io)?;
        // A run that was killed while it wrote may have left half a line, and half a character.
        let text = String::from_utf8_lossy(&bytes);
        let head = serde_json::Value::from(fingerprint).to_string();
        let is_other = text.lines().next().is_some_and(|first| first != head);
        let mut lines: Vec<String> = text.lines().skip(1).map(str::to_owned).collect();
        let mut before = None;
        if is_other {
            put_aside(&path, std::mem::take(&mut lines).is_empty())?;
            before = Some(std::mem::replace(&mut file, locked(&path)?));
        }
        if text.is_empty() || is_other {
            write_line(&mut file, &head).map_err(io)?;
        } else if !text.ends_with('\n') {
            write_line(&mut file, "").map_err(io)?;
        }
        Ok(Self { file: Mutex::new(file), lines, _aside: before, path })
    }

    /// The known points; lines that cannot be read are measured again.
    pub(crate) fn points<T: DeserializeOwned>(&self) -> Vec<T> {
        self.lines.iter().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }

    /// Adds what was just measured.
    pub(crate) fn add(&self, point: &impl Serialize) -> Result<()> {
        let line = serde_json::to_string(point)
            .map_err(|error| Error::invalid(self.path.display(), error.to_string()))?;
        let io = |error| Error::io(&self.path, error);
        let Ok(mut file) = self.file.lock() else { return Ok(()) };
        write_line(&mut file, &line).map_err(io)
    }
}

/// Opens or creates the file with a lock, or without one if the file system has none.
fn locked(path: &Path) -> Result<File> {
    let options = OpenOptions::new().read(true).append(true).create(true).open(path);
    let file = options.map_err(|error| Error::io(path, error))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(Error::invalid(
            path.display(),
            "another run is writing here; wait until it is done, or name another folder",
        )),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// Adds a line in one write, so that lines of two runs stay whole even without a lock.
fn write_line(file: &mut File, line: &str) -> std::io::Result<()> {
    file.write_all(format!("{line}\n").as_bytes())
}

/// Renames the journal of another input, so that hours of measurements are not lost, with a warning; removes an empty one.
fn put_aside(path: &Path, is_empty: bool) -> Result<()> {
    let mut aside = path.with_extension("journal.old");
    let mut number = 1;
    while aside.exists() {
        number += 1;
        aside = path.with_extension(format!("journal.old{number}"));
    }
    fs::rename(path, &aside).map_err(|error| Error::io(path, error))?;
    if is_empty {
        return fs::remove_file(&aside).map_err(|error| Error::io(aside, error));
    }
    text::warn(&[format!(
        "{} was measured on another state of the capture, with another truth, with other threads or by another version; it is \
         kept as {}, and everything is measured anew",
        path.display(),
        aside.display()
    )]);
    Ok(())
}

/// Runs `work` with a progress bar and adds each point to `journal`; stops if that fails.
pub(crate) fn recorded<P: Serialize, T>(
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
fn write_json(path: &Path, document: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(document)
        .map_err(|error| Error::invalid(path.display(), error.to_string()))?;
    whole_file::write_all(path, text + "\n")
}

/// Writes `NAME.json` and `NAME.csv` into a folder, and the chart as PNG under a name of its own, and as SVG and PDF beside it.
pub(crate) fn write_results(
    folder: &Path,
    name: &str,
    document: &impl Serialize,
    rows: &[impl Serialize],
    picture: &str,
    chart: &Chart,
) -> Result<()> {
    write_json(&folder.join(format!("{name}.json")), document)?;
    write_csv(&folder.join(format!("{name}.csv")), rows)?;
    let picture = folder.join(picture);
    whole_file::write_all(&picture.with_extension("svg"), chart.svg())?;
    whole_file::write_all(&picture.with_extension("pdf"), chart.pdf()?)?;
    whole_file::write_all(&picture, chart.png()?)
}

/// Writes documents as CSV (RFC 4180): one per row, a column per number, text or truth value, named by its path. Lists are left
/// out.
fn write_csv(path: &Path, rows: &[impl Serialize]) -> Result<()> {
    let mut head: Vec<String> = Vec::new();
    let mut table = Vec::new();
    for row in rows {
        // Through text, where a single float is as short as it can be.
        let value = serde_json::to_string(row).and_then(|text| serde_json::from_str(&text));
        let value: serde_json::Value =
            value.map_err(|error| Error::invalid(path.display(), error.to_string()))?;
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
        Value::Array(_) => {}
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

/// One line per point; a star marks the Pareto front, and a tilde times that were taken while other programs used the machine.
pub(crate) fn sweep_table(points: &[Point]) -> String {
    let mut text = format!(
        "{:<52} {:>9} {:>13} {:>15} {:>7} {:>7} {:>7} {:>12} {:>10} {:>8}",
        "setting",
        "filled dB",
        "behind ± SE",
        "PSNR dB ± SE",
        "SSIM",
        "FLIP",
        "cover",
        "samples",
        "bytes",
        "ms"
    );
    for point in points {
        let star = if point.pareto { '*' } else { ' ' };
        let Point {
            label,
            psnr_filled_db,
            behind_best_db,
            behind_best_db_se,
            psnr_db,
            psnr_db_se,
            ssim,
            flip,
            coverage,
            ..
        } = point;
        let (samples, bytes) = (text::count(point.samples), text::bytes(point.bytes));
        let milliseconds = point.milliseconds_text();
        let _ = write!(
            text,
            "\n{star} {label:<50} {psnr_filled_db:>9.2} {behind_best_db:>6.2} ± {behind_best_db_se:>4.2} {psnr_db:>8.2} ± {psnr_db_se:>4.2} \
             {ssim:>7.4} {flip:>7.4} {coverage:>7.4} {samples:>12} {bytes:>10} {milliseconds:>8}"
        );
    }
    if points.iter().any(Point::is_timed_under_load) {
        text += "\n~ times that were taken while other programs used more than a tenth of the machine";
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
            serde_json::json!({"label": "a, \"b\"", "settings": {"x": {"y": 1.5}}, "list": [1]}),
            serde_json::json!({"label": "c", "more": null}),
        ];
        write_csv(&path, &rows).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text, "label,settings.x.y,more\r\n\"a, \"\"b\"\"\",1.5,\r\nc,,\r\n");
    }

    #[test]
    fn numbers_in_a_table_read_as_in_a_document() {
        #[derive(Serialize)]
        struct Row {
            single: f32,
            double: f64,
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let row = Row { single: 0.001, double: 0.1 + 0.2 };
        write_csv(&path, std::slice::from_ref(&row)).unwrap();
        let table = fs::read_to_string(&path).unwrap();
        assert_eq!(table, "double,single\r\n0.30000000000000004,0.001\r\n");
        let document = serde_json::to_string(&row).unwrap();
        assert!(table.trim().lines().nth(1).unwrap().split(',').all(|number| document.contains(number)));
    }

    fn journal(folder: &Path, fingerprint: &str) -> Journal {
        Journal::open(folder, "t", fingerprint).unwrap()
    }

    #[test]
    fn a_journal_goes_on_where_it_stopped_and_starts_anew_for_something_else() {
        let folder = tempfile::tempdir().unwrap();
        let points = |fingerprint| journal(folder.path(), fingerprint).points::<i32>();
        let add = |fingerprint, point| journal(folder.path(), fingerprint).add(&point).unwrap();
        add("one", 1);
        add("one", 2);
        let path = folder.path().join("t.journal");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text + "{\"half").unwrap();
        assert_eq!(points("one"), [1, 2]);
        add("one", 3);
        assert_eq!(points("one"), [1, 2, 3]);
        assert!(points("two").is_empty());
        assert!(fs::read_to_string(folder.path().join("t.journal.old")).unwrap().contains("\n3\n"));
        add("two", 4);
        assert!(points("three").is_empty());
        assert!(fs::read_to_string(folder.path().join("t.journal.old2")).unwrap().ends_with("\n4\n"));
        assert!(points("four").is_empty());
        assert!(!folder.path().join("t.journal.old3").exists(), "nothing was measured that could be lost");
    }

    #[test]
    fn a_journal_that_ends_inside_a_character_goes_on_without_that_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.journal");
        journal(folder.path(), "one").add(&"whole").unwrap();
        let mut bytes = fs::read(&path).unwrap();
        bytes.extend("\"cut ö".as_bytes());
        bytes.pop();
        fs::write(&path, bytes).unwrap();
        assert_eq!(journal(folder.path(), "one").points::<String>(), ["whole"]);
        journal(folder.path(), "one").add(&"after").unwrap();
        assert_eq!(journal(folder.path(), "one").points::<String>(), ["whole", "after"]);
    }
}
