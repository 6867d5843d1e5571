//! Folders of color, of depth, and of a pose for every picture.
//!
//! ```text
//! place ─ the source's `find` ─ Found: lens, pictures ─ recording
//! ```
//!
//! Sources are in `poses_by_name`, `poses_by_order` and `poses_by_time`.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::place::SourceFolder;
use super::reader::{Description, ReadSource};
use super::text::TextFile;
use super::views::{INTRINSICS, json, lens, mean_up, nearest_axis, recording};
use crate::capture::transforms::{Keys, PictureEntry, picture_size};
use crate::error::{Error, Result};

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

/// The lens of a benchmark, for folders in its layout that do not state their own.
pub(super) struct Benchmark {
    /// Whose lens it is, in words.
    pub(super) name: &'static str,
    /// Columns and rows of its pictures.
    pub(super) size: (usize, usize),
    /// `fx fy cx cy`, pixel centers at whole numbers.
    pub(super) lens: [f64; 4],
}

/// The sensor of the first Kinect, by what its programs take for its lens.
pub(super) const PRIME_SENSE: Benchmark =
    Benchmark { name: "the default of the sensor", size: (640, 480), lens: [525.0, 525.0, 319.5, 239.5] };

/// Reads such a place, of which `find` finds lens and pictures.
pub(super) fn posed(
    place: &SourceFolder,
    description: Description,
    find: fn(&mut Found<'_>) -> Result<()>,
) -> Result<ReadSource> {
    let (inputs, keys, frames) = (Vec::new(), Keys::default(), Vec::new());
    let mut found = Found { place, description, inputs, keys, frames };
    find(&mut found)?;
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

    /// Takes the lens that no file states but [`INTRINSICS`], or else that of the benchmark whose layout this is, for its pictures alone.
    ///
    /// # Errors
    /// `Unsupported` where no file states it and pictures have another size; `Io` and `Invalid` where one cannot be read.
    pub(super) fn set_lens_of(&mut self, benchmark: &Benchmark, meters: f64) -> Result<()> {
        if let Some(path) = self.here_or_above(INTRINSICS) {
            let numbers = self.numbers(&path)?;
            let [fx, _, cx, _, fy, cy, ..] = numbers[..] else {
                return Err(Error::invalid(path.display(), "there are no 3×3 numbers"));
            };
            self.description.lens = format!("{INTRINSICS}: {numbers:?}");
            self.set_lens([fx, fy, cx, cy], meters);
            return Ok(());
        }
        let Benchmark { name, size: (columns, rows), lens: [fx, fy, cx, cy] } = *benchmark;
        self.description.lens = format!("{fx} {fy} {cx} {cy}, of {name}, as no file states it");
        self.set_lens(benchmark.lens, meters);
        let first =
            self.frames.iter().map(|entry| self.place.join(&entry.file_path)).find(|path| path.is_file());
        let Some(first) = first else { return Ok(()) };
        let (width, height) = picture_size(&first, None, None, &first.display().to_string())?;
        if (width, height) == (columns, rows) {
            return Ok(());
        }
        let scale = width as f64 / columns as f64;
        let is_scaled = (rows as f64 * scale - height as f64).abs() < 1.0;
        let center = |at: f64| (at + 0.5) * scale - 0.5;
        let made_smaller = format!(
            "; if these are the benchmark's own pictures in another size, it is {} 0 {} 0 {} {} 0 0 1",
            fx * scale,
            center(cx),
            fy * scale,
            center(cy)
        );
        let what = format!(
            "no file states the lens, and the one of this layout ({fx} {fy} {cx} {cy}, {name}) is of {columns}×{rows} pixels, while these pictures have {width}×{height}; write your camera's as {INTRINSICS} into the folder: the 9 numbers fx 0 cx 0 fy cy 0 0 1, pixel centers at whole numbers{}",
            if is_scaled { made_smaller } else { String::new() }
        );
        Err(Error::unsupported(self.place.folder.display(), what))
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
