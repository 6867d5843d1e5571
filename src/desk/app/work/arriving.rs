//! Watches a folder that other machines write parts to.
//!
//! ```text
//! DIR/sweep.part-2-of-6           a part that is complete: a line that says what it is, then a point per line, then its checksum
//! DIR/sweep.part-3-of-6.journal   a part under way: the same but for the checksum
//! ```
//!
//! A part appears whole, so that nothing but its name is needed to know that it is there. Whether it was made of what is open is for the
//! command that puts parts together: here they are only looked at.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use serde::de::DeserializeOwned;

use super::worker::{Outbox, Supersede, Worker};
use crate::app::model::{ArrivedParts, Message, WorkInParts, WorkKind};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::part::Part;

/// How often the folder is looked at, and whether the watch goes on.
const LOOK: Duration = Duration::from_secs(1);
const CHECK: Duration = Duration::from_millis(50);

/// The folder to watch for the scene that is open.
pub(crate) struct FollowRequest {
    pub scene: u64,
    pub folder: PathBuf,
}

/// A file of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
struct PartFile {
    path: PathBuf,
    /// Name of the work.
    name: String,
    part: Part,
    is_complete: bool,
    /// Its length and time, by which a change shows.
    state: (u64, Option<SystemTime>),
}

/// Name of the work, its part, and whether that is complete, by the name of a file.
fn part_of(file_name: &str) -> Option<(&str, Part, bool)> {
    let (is_complete, stem) =
        file_name.strip_suffix(".journal").map_or((true, file_name), |stem| (false, stem));
    let (name, part) = Part::of_file_name(stem)?;
    Some((name, part, is_complete))
}

/// The files of parts in a folder, by name, number and path.
fn part_files(folder: &Path) -> Result<Vec<PartFile>> {
    let io = |error| Error::io(folder, error);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        let file_name = entry.file_name();
        let (Some((name, part, is_complete)), Ok(facts)) =
            (file_name.to_str().and_then(part_of), entry.metadata())
        else {
            continue;
        };
        let state = (facts.len(), facts.modified().ok());
        files.push(PartFile { path: entry.path(), name: name.to_owned(), part, is_complete, state });
    }
    files.sort_by(|a, b| {
        (&a.name, a.part.of(), a.part, &a.path).cmp(&(&b.name, b.part.of(), b.part, &b.path))
    });
    Ok(files)
}

/// The points of a part; lines that hold none are its head and its checksum, or were cut short.
fn points<P: DeserializeOwned>(file: &PartFile) -> Vec<P> {
    let text = std::fs::read(&file.path).unwrap_or_default();
    let lines = text.split(|byte| *byte == b'\n');
    lines.filter_map(|line| serde_json::from_slice(line).ok()).collect()
}

/// What has arrived. Where work was cut in several ways, the one counts of which most is there.
fn arrived(folder: &Path, files: &[PartFile]) -> ArrivedParts {
    let mut cuts: BTreeMap<(&str, u32), Vec<&PartFile>> = BTreeMap::new();
    for file in files {
        cuts.entry((&file.name, file.part.of())).or_default().push(file);
    }
    let mut works: Vec<(WorkInParts, Vec<&PartFile>)> = Vec::new();
    for ((name, of), files) in cuts {
        let complete: Vec<u32> =
            files.iter().filter(|file| file.is_complete).map(|file| file.part.number()).collect();
        let work = WorkInParts { name: name.to_owned(), of, complete };
        match works.last_mut().filter(|(last, _)| last.name == name) {
            Some(last) if work.complete.len() > last.0.complete.len() => *last = (work, files),
            Some(_) => {}
            None => works.push((work, files)),
        }
    }
    let files_of = |name: &str| -> Vec<&PartFile> {
        works.iter().filter(|(work, _)| work.name == name).flat_map(|(_, files)| files.clone()).collect()
    };
    ArrivedParts {
        folder: folder.to_path_buf(),
        sweep: files_of("sweep").into_iter().flat_map(points).collect(),
        stress: files_of("stress").into_iter().flat_map(points).collect(),
        works: works.into_iter().map(|(work, _)| work).collect(),
    }
}

/// The worker that watches folders, one at a time.
pub(super) fn follower(outbox: &Outbox) -> Result<Worker<FollowRequest>> {
    let parts = outbox.clone();
    Worker::start(WorkKind::FollowParts, Supersede::Always, outbox, move |request, job| {
        follow(&request, &parts, job)
    })
}

/// Watches a folder until it is told to stop, and sends what has arrived whenever that changes.
///
/// # Errors
/// `Io` where the folder cannot be read, and `Cancelled`.
fn follow(request: &FollowRequest, outbox: &Outbox, job: &Job) -> Result<Message> {
    let mut known: Option<Vec<PartFile>> = None;
    loop {
        let files = part_files(&request.folder)?;
        if known.as_ref() != Some(&files) {
            let parts = Box::new(arrived(&request.folder, &files));
            if !outbox.send(Message::PartsArrived { scene: request.scene, parts }) {
                return Err(Error::Cancelled);
            }
            known = Some(files);
        }
        let looked = Instant::now();
        while looked.elapsed() < LOOK {
            job.check()?;
            std::thread::sleep(CHECK);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::settings::Settings;
    use overlook_lab::sweep::{Point, Series};
    use overlook_lab::trial::{Trial, TrialResult};

    #[test]
    fn files_of_parts_are_known_by_their_names() {
        let part = |name, number, of, is_complete| Some((name, Part::new(number, of).unwrap(), is_complete));
        assert_eq!(part_of("sweep.part-2-of-6"), part("sweep", 2, 6, true));
        assert_eq!(part_of("sweep.part-2-of-6.journal"), part("sweep", 2, 6, false));
        assert_eq!(part_of("a.ovl.scan.part-6-of-6"), part("a.ovl.scan", 6, 6, true));
        for other in
            ["sweep.json", "sweep.part-7-of-6", "sweep.part-0-of-6", "x.part-1-of-2.tmp", "part-1-of-2"]
        {
            assert_eq!(part_of(other), None, "{other}");
        }
    }

    #[test]
    fn points_are_read_of_complete_parts_and_of_those_under_way_and_of_one_cut_alone() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let line = |label: &str| {
            let trial = Trial::new(label, Settings::default());
            let point = Point::new(&trial, Series::Variation, &TrialResult::default());
            serde_json::to_string(&point).unwrap()
        };
        let write =
            |name: &str, lines: &[String]| std::fs::write(folder.join(name), lines.join("\n")).unwrap();
        let head = "{\"overlook\":\"0\"}".to_owned();
        write("sweep.part-1-of-3", &[head.clone(), line("a"), line("b"), format!("{:020} 00000000", 7)]);
        write("sweep.part-3-of-3.journal", &["\"state\"".to_owned(), line("c"), "{\"label\":\"d".to_owned()]);
        write("sweep.part-1-of-2.journal", &["\"state\"".to_owned(), line("of another cut")]);
        write("scene.ovl.scan.part-2-of-2", &["bytes".to_owned()]);
        let found = arrived(folder, &part_files(folder).unwrap());
        let labels: Vec<&str> = found.sweep.iter().map(|point| point.label.as_str()).collect();
        assert_eq!(labels, ["a", "b", "c"]);
        let works: Vec<_> = found.works.iter().map(|work| (work.name.as_str(), work.missing())).collect();
        assert_eq!(works, [("scene.ovl.scan", 1), ("sweep", 2)]);
    }
}
