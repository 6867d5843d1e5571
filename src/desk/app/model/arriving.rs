//! Parts of a piece of work that other machines are doing, as far as they have arrived in a folder.

use std::path::PathBuf;

use overlook_engine::plural::counted;
use overlook_lab::stress::StressPoint;
use overlook_lab::sweep::Point;

/// The parts of one kind of work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct WorkInParts {
    /// Its name, as in `sweep` or `scene.ovl.prune`.
    pub name: String,
    /// How many parts it is cut into.
    pub of: u32,
    /// Numbers of those that are complete, ascending.
    pub complete: Vec<u32>,
}

impl WorkInParts {
    /// Parts that are missing.
    pub(crate) fn missing(&self) -> usize {
        self.of as usize - self.complete.len()
    }

    /// How far it came, as in `sweep: 2 of 4 parts, 2 missing`.
    fn words(&self) -> String {
        let (name, complete) = (&self.name, self.complete.len());
        match self.missing() {
            0 => format!("{name}: all {}", counted(self.of, "part")),
            missing => format!("{name}: {complete} of {}, {missing} missing", counted(self.of, "part")),
        }
    }
}

/// What has arrived in a folder that parts are written to.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ArrivedParts {
    pub folder: PathBuf,
    pub works: Vec<WorkInParts>,
    /// Points of a sweep, of parts that are complete and of those under way.
    pub sweep: Vec<Point>,
    /// The same of a stress test.
    pub stress: Vec<StressPoint>,
}

impl ArrivedParts {
    /// How far the work came, all in one line.
    pub(crate) fn words(&self) -> String {
        let name = self.folder.file_name().unwrap_or(self.folder.as_os_str());
        let works: Vec<String> = self.works.iter().map(WorkInParts::words).collect();
        let works = if works.is_empty() { "no part yet".to_owned() } else { works.join("; ") };
        format!("Following {}: {works}", name.to_string_lossy())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_told_work_by_work() {
        let work = |name: &str, of, complete: &[u32]| WorkInParts {
            name: name.to_owned(),
            of,
            complete: complete.to_vec(),
        };
        let mut arrived = ArrivedParts { folder: "/far/out".into(), ..ArrivedParts::default() };
        assert_eq!(arrived.words(), "Following out: no part yet");
        arrived.works = vec![work("scan", 2, &[1, 2]), work("sweep", 4, &[3])];
        assert_eq!(arrived.words(), "Following out: scan: all 2 parts; sweep: 1 of 4 parts, 3 missing");
    }
}
