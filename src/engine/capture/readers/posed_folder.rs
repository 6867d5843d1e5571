//! Folders of color, of depth, and of a pose for every picture: one reader, and a row of facts for each source.
//!
//! ```text
//! row ─ its `find` ─ Found: lens, pictures ─ recording
//! ```
//!
//! Each row is in the file that finds its pictures: `poses_by_name`, `poses_by_order`, `poses_by_time`.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::place::SourceFolder;
use super::reader::{Description, ReadSource, Reader};
use super::text::TextFile;
use super::views::{json, lens, mean_up, nearest_axis, recording};
use crate::capture::transforms::{Keys, PictureEntry};
use crate::error::Result;

/// One such source.
pub(super) struct PosedFolder {
    pub(super) source: &'static str,
    pub(super) marks: &'static str,
    /// Whether a file of this name may be opened in place of its folder.
    pub(super) stands_for_folder: fn(&str) -> bool,
    /// Whether a folder is of this source.
    pub(super) is_here: fn(&SourceFolder) -> bool,
    /// The text of [`Description::poses`].
    pub(super) poses: &'static str,
    /// The text of [`Description::depth`], unless `find` knows better.
    pub(super) depth: &'static str,
    /// Finds lens and pictures.
    pub(super) find: fn(&mut Found<'_>) -> Result<()>,
}

/// What was found so far.
pub(super) struct Found<'a> {
    pub(super) place: &'a SourceFolder,
    pub(super) description: Description,
    /// Files that were read; the first is what an error about all of them names.
    pub(super) inputs: Vec<PathBuf>,
    /// Keys of all pictures.
    pub(super) keys: Keys,
    frames: Vec<PictureEntry>,
}

impl Reader for PosedFolder {
    fn source(&self) -> &'static str {
        self.source
    }

    fn marks(&self) -> &'static str {
        self.marks
    }

    fn recognizes(&self, place: &SourceFolder) -> bool {
        place.file.as_deref().is_none_or(self.stands_for_folder) && (self.is_here)(place)
    }

    fn read(&self, place: &SourceFolder) -> Result<ReadSource> {
        let [source, poses, depth] = [self.source, self.poses, self.depth].map(str::to_owned);
        let description = Description { source, poses, depth, ..Description::default() };
        let (inputs, keys, frames) = (Vec::new(), Keys::default(), Vec::new());
        let mut found = Found { place, description, inputs, keys, frames };
        (self.find)(&mut found)?;
        found.description.up_is_estimated = found.keys.up.is_none();
        if let Some(up) = mean_up(&found.frames).filter(|_| found.keys.up.is_none()).map(nearest_axis) {
            // Lists of poses do not say it, and few worlds are as askew as the cameras in them.
            found.keys.up = Some(up.to_array());
            found
                .description
                .notes
                .push(format!("up is {}, the axis nearest to the mean of the cameras' up", axis_name(up)));
        }
        recording(place, found.keys, found.frames, found.description, found.inputs)
    }
}

/// The name of an axis of the world, as in `−y`.
fn axis_name(axis: DVec3) -> String {
    let sign = if axis.element_sum() < 0.0 { '−' } else { '+' };
    let name = ["x", "y", "z"].into_iter().zip(axis.to_array()).find(|(_, part)| *part != 0.0);
    format!("{sign}{}", name.map_or("z", |(name, _)| name))
}

impl Found<'_> {
    /// Whether there is such a file below the folder.
    pub(super) fn has_file(&self, name: &str) -> bool {
        self.place.join(name).is_file()
    }

    /// The file of this name in the folder, or else the one beside the folder.
    pub(super) fn here_or_above(&self, name: &str) -> Option<PathBuf> {
        let near = [self.place.join(name), self.place.folder.join("..").join(name)];
        near.into_iter().find(|path| path.is_file())
    }

    /// Reads all numbers of an input.
    pub(super) fn numbers(&mut self, path: &Path) -> Result<Vec<f64>> {
        self.inputs.push(path.to_path_buf());
        TextFile::read(path)?.numbers()
    }

    /// Reads an input in JSON.
    pub(super) fn json<T: serde::de::DeserializeOwned>(&mut self, path: &Path) -> Result<T> {
        self.inputs.push(path.to_path_buf());
        json(path)
    }

    /// Takes a pinhole `fx fy cx cy` for all pictures, pixel centers at whole numbers, and meters for a unit of depth.
    pub(super) fn set_lens(&mut self, [fx, fy, cx, cy]: [f64; 4], meters: f64) {
        self.keys = Keys { depth_unit_scale_factor: Some(meters), ..lens(fx, fy, cx, cy, 0.0) };
    }

    /// Adds a picture, or notes under its name why it is left out.
    pub(super) fn add(
        &mut self,
        name: impl Into<String>,
        picture: std::result::Result<PictureEntry, &'static str>,
    ) {
        match picture {
            Ok(picture) => self.frames.push(picture),
            Err(reason) => self.description.skip(reason, name),
        }
    }
}
