//! What a reader is, and what it yields.

use std::path::PathBuf;

use serde::Serialize;

use super::place::SourceFolder;
use crate::capture::parts::Skipped;
use crate::capture::transforms::{Manifest, ManifestOrigin, places_of};
use crate::error::Result;
use crate::plural::counted;

/// Recognizes and reads the folders or files of one source. [`READERS`](super::READERS) lists all readers.
///
/// A reader decodes no picture. It makes a [`Manifest`] with the keys of CAPTURES.md. They are all that the pictures' decoders need:
/// so `overlook info --write-manifest` can write it, and a user can correct it.
pub(crate) struct Reader {
    /// What people call the source, as in `TUM RGB-D`.
    pub(super) source: &'static str,
    /// The files that the source is recognized by, for the message about a folder that no reader recognizes.
    pub(super) marks: &'static str,
    /// Whether a file of this name may be opened in place of its folder.
    pub(super) stands_for_folder: fn(&str) -> bool,
    /// Whether the place is of this source. Looks at names, and at most at the start of a small file.
    pub(super) is_here: fn(&SourceFolder) -> bool,
    /// The text of [`Description::poses`], unless `read` knows better; of the next two likewise.
    pub(super) poses: &'static str,
    pub(super) depth: &'static str,
    pub(super) lens: &'static str,
    /// Reads the place, which was recognized, and completes its description.
    pub(super) read: fn(&SourceFolder, Description) -> Result<ReadSource>,
}

impl Reader {
    /// Whether the place is of this source.
    pub(super) fn recognizes(&self, place: &SourceFolder) -> bool {
        place.file.as_deref().is_none_or(self.stands_for_folder) && (self.is_here)(place)
    }

    /// Reads the place, which it has recognized.
    ///
    /// # Errors
    /// `Io`, `Invalid`, `Unsupported`, with the file, its line or byte, the fault, and advice.
    pub(super) fn read(&self, place: &SourceFolder) -> Result<ReadSource> {
        let [source, poses, depth, lens] =
            [self.source, self.poses, self.depth, self.lens].map(str::to_owned);
        (self.read)(place, Description { source, poses, depth, lens, ..Description::default() })
    }
}

/// A source as it was understood.
#[derive(Clone, Debug)]
pub(crate) struct ReadSource {
    /// Every picture, and how it is read.
    pub manifest: Manifest,
    /// The origin of the manifest.
    pub origin: ManifestOrigin,
    /// The text and binary files that were read to make it; pictures are not among them.
    pub inputs: Vec<PathBuf>,
    /// How the source was understood.
    pub description: Description,
    /// The authority on how the capture is read.
    pub said_by: SaidBy,
}

/// The authority on how a capture is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SaidBy {
    /// A manifest of its own, which a user can correct.
    Manifest,
    /// The layout of the source.
    Layout,
}

impl ReadSource {
    /// Every place that the capture is read from, whether or not there is a file.
    pub(crate) fn places(&self) -> Vec<PathBuf> {
        let mut places = self.inputs.clone();
        places.extend(places_of(&self.manifest, &self.origin.folder));
        places
    }
}

/// How a source was understood, in words.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Description {
    /// The source, as in `TUM RGB-D`.
    pub source: String,
    /// The direction and the axes of the poses, as the source has them.
    pub poses: String,
    /// The measure of depth, its unit and its value for "no depth".
    pub depth: String,
    /// Where the lens comes from, and what it is.
    pub lens: String,
    /// Whether one moving camera took the pictures of a static scene. Each picture is a camera of its own then.
    pub is_recording: bool,
    /// Pictures that were found.
    pub found: usize,
    /// Pictures that are not read.
    pub skipped: Vec<Skipped>,
    /// What else a user should know, one line each.
    pub notes: Vec<String>,
    /// Whether nothing said which way is up, so that it was taken from the cameras; a note says so too.
    #[serde(skip)]
    pub up_is_estimated: bool,
}

impl Description {
    /// Notes that a picture is left out.
    pub(crate) fn skip(&mut self, reason: impl Into<String>, name: impl Into<String>) {
        Skipped::note(&mut self.skipped, reason, name);
    }

    /// All of it, one line each.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let named = [("poses", &self.poses), ("depth", &self.depth), ("lens", &self.lens)];
        let said = named.into_iter().filter(|(_, what)| !what.is_empty());
        let mut lines = vec![format!("read as {}, {}", self.source, counted(self.found, "picture"))];
        lines.extend(said.map(|(name, what)| format!("{name}: {what}")));
        if self.is_recording {
            lines.push(
                "one moving camera and a static scene: every picture is a camera of its own".to_owned(),
            );
        }
        lines.extend(self.skipped.iter().map(Skipped::line));
        lines.extend(self.notes.iter().map(|note| format!("note: {note}")));
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_counted_and_name_their_first_picture() {
        let mut description = Description { source: "a test".into(), found: 3, ..Description::default() };
        description.skip("without a pose", "a.png");
        description.skip("without a pose", "b.png");
        let lines = description.lines();
        assert_eq!(lines, ["read as a test, 3 pictures", "left out: 2 without a pose (first: a.png)"]);
    }
}
