//! The one door: any path that may be a capture.

use std::path::{Component, Path, PathBuf};

use super::parts::Capture;
use super::readers::{self, Description, ReadSource, SaidBy};
use super::transforms::{PictureEntry, capture_of};
use crate::error::{Error, Result};
use crate::settings::CaptureSettings;
use crate::whole_file;

/// A path that was found to be a capture, and how it was understood.
#[derive(Clone, Debug)]
pub struct Source {
    read: ReadSource,
}

impl Source {
    /// Finds out what a folder or a file is. No picture is decoded.
    ///
    /// # Errors
    /// `Io`, `Invalid`, `Unsupported`, with the expected files or the fault, and with advice.
    pub fn find(path: &Path) -> Result<Self> {
        Ok(Self { read: readers::read(path)? })
    }

    /// How it was understood.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.read.description
    }

    /// The files that list the pictures and their poses.
    #[must_use]
    pub fn inputs(&self) -> &[PathBuf] {
        &self.read.inputs
    }

    /// Every place that the capture is read from, whether or not there is a file.
    #[must_use]
    pub fn places(&self) -> Vec<PathBuf> {
        self.read.places()
    }

    /// The manifest of its own that decides how it is read; `None` if its layout decides.
    #[must_use]
    pub fn manifest(&self) -> Option<&Path> {
        match self.read.said_by {
            SaidBy::Manifest => Some(self.read.origin.path.as_path()),
            SaidBy::Layout => None,
        }
    }

    /// The same source, read otherwise: these keys of the manifest, with their values as JSON, replace those of every picture. Files
    /// stay as they are.
    ///
    /// # Errors
    /// `Invalid` for a value that its key cannot have.
    pub fn read_as(mut self, keys: &[(String, String)]) -> Result<Self> {
        self.read.manifest = self.read.manifest.with_keys(keys)?;
        Ok(self)
    }

    /// Opens it. Every file is looked for, and the first one of each camera has its header read; pictures are decoded on demand.
    ///
    /// # Errors
    /// `Io`, `Invalid`, `Unsupported`: what, where, what to do.
    pub fn open(&self, settings: &CaptureSettings) -> Result<Capture> {
        let capture = capture_of(&self.read.manifest, &self.read.origin, settings)?;
        let most = settings.views as usize;
        if most == 0 || most >= capture.cameras.len() {
            return Ok(capture);
        }
        let read: Vec<usize> = (0..most).map(|nth| nth * capture.cameras.len() / most).collect();
        Ok(capture.with_cameras(|index, _| read.binary_search(&index).is_ok()))
    }

    /// The usual path for [`Source::write_manifest`]: a `transforms.json` in the capture's folder.
    #[must_use]
    pub fn manifest_path(&self) -> PathBuf {
        self.read.origin.folder.join(super::transforms::MANIFEST_NAME)
    }

    /// Writes the manifest that this amounts to, with all paths relative to it. It opens as the same capture.
    ///
    /// # Errors
    /// `Invalid` if the path exists already, `Io` if it cannot be written.
    pub fn write_manifest(&self, path: &Path) -> Result<()> {
        if path.exists() {
            let what = "is there already; move it away, or name another file";
            return Err(Error::invalid(path.display(), what));
        }
        let mut manifest = self.read.manifest.clone();
        let from = path.parent().unwrap_or(Path::new(""));
        let folder = &self.read.origin.folder;
        for name in manifest.frames.iter_mut().flat_map(PictureEntry::paths_mut) {
            *name = relative(from, &folder.join(name.as_str()))?;
        }
        whole_file::write_all(path, manifest.to_json(&path.display().to_string())?)
    }
}

/// Opens a capture, whatever it is: the one door.
///
/// # Errors
/// As [`Source::find`] and [`Source::open`].
pub fn open(path: &Path, settings: &CaptureSettings) -> Result<Capture> {
    Source::find(path)?.open(settings)
}

/// The path of `to` as seen from the folder `from`, with `/` between its parts.
fn relative(from: &Path, to: &Path) -> Result<String> {
    let absolute = |path: &Path| {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        std::path::absolute(path).map_err(|error| Error::io(path, error))
    };
    let (from, to) = (absolute(from)?, absolute(to)?);
    let parts = |path: &Path| -> Vec<String> {
        let is_part = |part: &Component| !matches!(part, Component::CurDir);
        path.components()
            .filter(is_part)
            .map(|part| part.as_os_str().to_string_lossy().into_owned())
            .collect()
    };
    let (from, to) = (parts(&from), parts(&to));
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = from[common..].iter().map(|_| "..".to_owned());
    Ok(up.chain(to[common..].iter().cloned()).collect::<Vec<_>>().join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_seen_from_the_folder_of_the_manifest() {
        let seen = |from: &str, to: &str| relative(Path::new(from), Path::new(to)).unwrap();
        assert_eq!(seen("/a/b", "/a/b/c/1.png"), "c/1.png");
        assert_eq!(seen("/a/b/d", "/a/b/c/1.png"), "../c/1.png");
        assert_eq!(seen("", "c/./1.png"), "c/1.png");
    }
}
