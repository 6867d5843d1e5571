//! Normals in files of their own.

use std::path::Path;

use super::exr_picture::{DecodedPlanes, ExrPicture};
use super::files::PictureFiles;
use crate::capture::camera::Camera;
use crate::capture::pictures::{self, PictureFormat, format_of};
use crate::error::{Error, Result};

pub(super) fn place_of_normals(path: &Path, place: &str) -> String {
    format!("{place}, normal file {}", path.display())
}

/// Reads a file of normals: x, y and z, as recorded.
pub(super) fn read(path: &Path, files: &PictureFiles, camera: &Camera, place: &str) -> Result<[Vec<f32>; 3]> {
    let place = &place_of_normals(path, place);
    if format_of(path, place)? == PictureFormat::ColmapMap {
        return normal_map(path, camera, place);
    }
    let picture = open_normal_file(path, files, camera, place)?;
    Ok(DecodedPlanes::decode(&picture, &normals_of_own(&picture)?)?.take_three())
}

/// Normals of COLMAP's, which may have a smaller map than the picture has pixels.
fn normal_map(path: &Path, camera: &Camera, place: &str) -> Result<[Vec<f32>; 3]> {
    let ((columns, rows), planes) = pictures::read_colmap_map(path, 3, place)?;
    let (width, height) = camera.intrinsics.size();
    let at = |index: usize| index / width * rows / height * columns + index % width * columns / width;
    let scaled =
        |plane: &Vec<f32>| -> Vec<f32> { (0..width * height).map(|index| plane[at(index)]).collect() };
    Ok([scaled(&planes[0]), scaled(&planes[1]), scaled(&planes[2])])
}

pub(super) fn open_normal_file<'a>(
    path: &Path,
    files: &'a PictureFiles,
    camera: &Camera,
    place: &'a str,
) -> Result<ExrPicture<'a>> {
    if format_of(path, place)? != PictureFormat::Exr {
        return Err(Error::unsupported(place, "normals in PNG are too coarse; save them as EXR"));
    }
    ExrPicture::open(path, files, files.wishes_of_normal_file(), camera, place)
}

/// The channels of a file of its own, which may hold the normal as its picture.
pub(super) fn normals_of_own(picture: &ExrPicture) -> Result<[usize; 3]> {
    picture.normal().or_else(|error| picture.names.only_vector.ok_or(error))
}
