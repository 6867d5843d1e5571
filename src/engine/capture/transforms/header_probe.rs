//! Facts from the headers of a frame's files, known before a picture is decoded.

use std::path::Path;

use super::depth_file;
use super::exr_picture::{ExrPicture, no_depth};
use super::files::PictureFiles;
use super::normal_file::{normals_of_own, open_normal_file, place_of_normals};
use crate::capture::camera::Camera;
use crate::capture::exr::{DepthKind, ExrFile, Primaries};
use crate::capture::pictures::{self, PictureFormat, PictureRows, format_of};
use crate::error::{Error, Result};

/// Columns and rows of a picture, from its header. Where a tag turns the picture, `rows` says which rows are meant, or the file of depth
/// beside it does.
pub(crate) fn picture_size(
    path: &Path,
    rows: Option<PictureRows>,
    depth: Option<&Path>,
    place: &str,
) -> Result<(usize, usize)> {
    let format = format_of(path, place)?;
    if !path.is_file() {
        let what = "the picture is missing, and the manifest does not give its size; give w and h, or put the picture there";
        return Err(Error::invalid(place, what));
    }
    match format {
        PictureFormat::Yuv => Err(Error::invalid(place, "raw video does not hold its size; give w and h")),
        PictureFormat::Exr => {
            let window = ExrFile::open(path, place)?.window(None)?;
            Ok((window.width, window.height))
        }
        _ => pictures::size_of_rows(path, rows, depth.and_then(size_of_depth), place),
    }
}

/// Columns and rows of a file of depth; `None` where it cannot be read, which is told later.
fn size_of_depth(path: &Path) -> Option<(usize, usize)> {
    if format_of(path, "").ok()? == PictureFormat::Exr {
        let window = ExrFile::open(path, "").ok()?.window(None).ok()?;
        return Some((window.width, window.height));
    }
    pictures::depth_size(path, true, "").ok()
}

/// Width of a pixel over its height by the picture's header; 1 where it states none.
pub(crate) fn pixel_aspect(path: &Path) -> f64 {
    let is_exr = format_of(path, "").is_ok_and(|format| format == PictureFormat::Exr);
    is_exr.then(|| ExrFile::pixel_aspect(path)).flatten().unwrap_or(1.0)
}

/// Whether a picture has an alpha channel.
pub(super) fn has_alpha(files: &PictureFiles, camera: &Camera, place: &str) -> Result<bool> {
    match format_of(&files.color, place)? {
        PictureFormat::Yuv | PictureFormat::Jpeg => Ok(false),
        PictureFormat::Exr => {
            let wishes = files.wishes_of_color_file();
            Ok(ExrPicture::open(&files.color, files, wishes, camera, place)?.names.alpha.is_some())
        }
        _ => pictures::has_alpha(&files.color, place),
    }
}

/// Facts from the headers of a frame's files.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HeaderFacts {
    /// Whether there are normals, and they are to be read.
    pub has_normals: bool,
    /// Whether depth is measured from a near plane that the manifest does not give.
    pub lacks_near_clip: bool,
    /// Whether the header states primaries that no colors have.
    pub has_absurd_primaries: bool,
}

/// Checks the headers of a frame's files.
pub(crate) fn probe(files: &PictureFiles, camera: &Camera, place: &str) -> Result<HeaderFacts> {
    let size = camera.intrinsics.size();
    let mut probe = HeaderFacts { has_normals: files.normal.is_some(), ..HeaderFacts::default() };
    let mut kind = None;
    match format_of(&files.color, place)? {
        PictureFormat::Yuv if files.depth.is_some() => {
            files.raw_video.check_color(&files.color, place, size)?;
        }
        PictureFormat::Exr => {
            let picture = ExrPicture::open(&files.color, files, files.wishes_of_color_file(), camera, place)?;
            picture.color()?;
            if files.depth.is_none() {
                kind = Some(picture.depth()?.kind());
            }
            probe.has_normals |= picture.names.normal.is_some();
            probe.has_absurd_primaries = picture.file.primaries == Primaries::Absurd;
        }
        _ if files.depth.is_none() => return Err(no_depth(place)),
        _ => pictures::check(&files.color, place, size, files.rows)?,
    }
    if let Some(path) = &files.depth {
        kind = Some(depth_file::probe(path, files, camera, place)?);
    }
    probe.lacks_near_clip = kind == Some(DepthKind::RayDistanceFromNearClip) && !files.has_near_clip;
    probe.has_normals &= files.normal_space.is_some();
    if let (Some(path), true) = (&files.normal, probe.has_normals) {
        let place = &place_of_normals(path, place);
        if format_of(path, place)? == PictureFormat::ColmapMap {
            pictures::read_colmap_map(path, 3, place)?;
            return Ok(probe);
        }
        normals_of_own(&open_normal_file(path, files, camera, place)?)?;
    }
    Ok(probe)
}
