//! Rendered pictures as files: linear EXR and, beside it, sRGB PNG.

use std::path::{Component, Path, PathBuf};

use overlook_engine::error::{Error, Result};
use overlook_engine::render::Picture;
use overlook_engine::render::output::{
    PictureValues, write_exr, write_exr_with_values, write_npy, write_png,
};

/// Paths of a view's picture: its own name below the output folder, once with each extension.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct PicturePaths {
    pub(crate) exr: PathBuf,
    pub(crate) png: PathBuf,
}

impl PicturePaths {
    /// Refuses a `file_path` that would leave `folder`.
    pub(crate) fn below(folder: &Path, file_path: &str) -> Result<Self> {
        let relative = Path::new(file_path);
        let stays_below =
            relative.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !stays_below || relative.file_name().is_none() {
            return Err(Error::invalid(
                format!("view '{file_path}'"),
                "file_path must be relative and without '..', so that the picture stays below the output folder",
            ));
        }
        // Only the two extensions that are written are replaced: 'r_0.5' is a name, not an extension.
        let is_picture = relative.extension().is_some_and(|extension| {
            ["exr", "png"].iter().any(|known| extension.eq_ignore_ascii_case(known))
        });
        let stem = if is_picture { relative.with_extension("") } else { relative.to_path_buf() };
        let with = |extension: &str| {
            let mut name = folder.join(&stem).into_os_string();
            name.push(extension);
            PathBuf::from(name)
        };
        Ok(Self { exr: with(".exr"), png: with(".png") })
    }

    /// Writes the picture as EXR with linear `R G B A Z` and as PNG for display. Alpha is 0 only in holes that were not filled.
    pub(crate) fn write(&self, picture: &Picture) -> Result<()> {
        if let Some(folder) = self.exr.parent() {
            std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
        }
        write_exr(&self.exr, picture)?;
        write_png(&self.png, picture)
    }

    /// Writes a picture that shows scalar values: as layers of the EXR, in the `colors` of one channel in the PNG, and with `as_arrays` as
    /// an array of `NumPy` for each channel beside it.
    pub(crate) fn write_with_values(
        &self,
        picture: &Picture,
        values: &PictureValues,
        colored: &Picture,
        as_arrays: bool,
    ) -> Result<()> {
        if let Some(folder) = self.exr.parent() {
            std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
        }
        write_exr_with_values(&self.exr, picture, values)?;
        if as_arrays {
            for (index, channel) in values.channels.iter().enumerate() {
                write_npy(&self.array(&channel.name), picture, values, index)?;
            }
        }
        write_png(&self.png, colored)
    }

    /// Where the array of a channel goes. What is no part of a file's name is written as addresses write it, so that names stay distinct.
    fn array(&self, channel: &str) -> PathBuf {
        let written = |letter: char| match letter {
            '/' | '\\' | ':' | '%' => format!("%{:02X}", u32::from(letter)),
            other => other.to_string(),
        };
        let name: String = channel.chars().map(written).collect();
        self.exr.with_extension(format!("{name}.npy"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_keeps_the_views_own_name() {
        let out = Path::new("out");
        let paths = PicturePaths::below(out, "novel0/0001.exr").unwrap();
        assert_eq!(paths.exr, Path::new("out/novel0/0001.exr"));
        assert_eq!(paths.png, Path::new("out/novel0/0001.png"));
        assert_eq!(PicturePaths::below(out, "./r_0.5").unwrap().png, Path::new("out/./r_0.5.png"));
        assert_eq!(PicturePaths::below(out, "a.PNG").unwrap().exr, Path::new("out/a.exr"));
    }

    #[test]
    fn arrays_of_values_whose_names_differ_have_files_that_differ() {
        let paths = PicturePaths::below(Path::new("out"), "0001").unwrap();
        let names = ["a/b", "a:b", "a\\b", "a_b", "a%2Fb", "p [Pa]"].map(|name| paths.array(name));
        assert_eq!(names[5], Path::new("out/0001.p [Pa].npy"));
        assert_eq!(names.iter().collect::<std::collections::HashSet<_>>().len(), names.len());
        assert!(names.iter().all(|path| path.parent() == Some(Path::new("out"))));
    }

    #[test]
    fn a_picture_never_leaves_the_output_folder() {
        for path in ["/etc/passwd", "../x.exr", "a/../../x.exr", "..", ".", ""] {
            let error = PicturePaths::below(Path::new("out"), path).unwrap_err().to_string();
            assert!(error.contains("output folder"), "{error}");
        }
    }
}
