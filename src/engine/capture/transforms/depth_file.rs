//! Depth from its files, on the pixels of the color camera.

use std::path::Path;

use glam::DAffine3;

use super::depth_camera::shared_grid;
use super::exr_picture::{
    DecodedPlanes, DepthPart, ExrPicture, of_levels, place_of_depth, step_of_whole_units,
};
use super::files::PictureFiles;
use crate::capture::camera::Camera;
use crate::capture::exr::{DepthKind, DepthTrouble, ExrFile};
use crate::capture::pictures::{
    DepthGrid, DepthMap, PictureFormat, depth_size, drop_unsure, format_of, gray, register,
};
use crate::error::{Error, Result};

/// Reads a file of depth.
pub(super) fn read(path: &Path, files: &PictureFiles, camera: &Camera, place: &str) -> Result<DepthPart> {
    let place = &place_of_depth(path, place);
    if format_of(path, place)? == PictureFormat::Exr {
        let grid = grid_of(exr_size(path, camera, place)?, files, camera, place)?;
        let own = camera_of(&grid, camera);
        let picture = ExrPicture::open(path, files, files.wishes_of_depth_file(), &own, place)?;
        let channels = picture.depth()?;
        refuse_bent_rays(channels.kind(), &grid, place)?;
        let mut planes = DecodedPlanes::decode(&picture, &channels.indices())?;
        let mut depth = planes.take_depth(channels, &picture, &own)?;
        return finish(&mut depth, &grid, files, camera, place).map(|()| depth);
    }
    if format_of(path, place)? == PictureFormat::Yuv {
        let grid = grid_of(camera.intrinsics.size(), files, camera, place)?;
        let (values, half_step) = files.raw_video.depth(path, place, camera.intrinsics.size())?;
        let rules = files.level_rules(place)?;
        refuse_bent_rays(rules.kind, &grid, place)?;
        let mut depth =
            of_levels(values, half_step, &rules, &camera_of(&grid, camera), path.display().to_string());
        return finish(&mut depth, &grid, files, camera, place).map(|()| depth);
    }
    let map = DepthMap::read(path, files.raw_video.has_range(), place)?;
    let grid = grid_of(map.size, files, camera, place)?;
    if files.raw_video.has_range() {
        let Some((values, half_step)) = files.raw_video.depth_of_map(&map) else {
            return Err(Error::invalid(
                place,
                "depth_range is of depth in whole numbers, and these are floats; leave it out, or write \"depth_kind\": \"z_buffer\" or \"reversed_z_buffer\" if they are a depth buffer",
            ));
        };
        let rules = files.level_rules(place)?;
        refuse_bent_rays(rules.kind, &grid, place)?;
        let mut depth =
            of_levels(values, half_step, &rules, &camera_of(&grid, camera), path.display().to_string());
        return finish(&mut depth, &grid, files, camera, place).map(|()| depth);
    }
    let rules = files.map_depth_rules(map.whole_up_to, place)?;
    refuse_bent_rays(rules.kind, &grid, place)?;
    let inverse_depth = rules.inverse_depth_plane(map.values, &camera_of(&grid, camera));
    let is_whole = map.whole_up_to.is_some();
    let mut depth = DepthPart {
        step_relative: if is_whole { step_of_whole_units(&rules, &inverse_depth) } else { map.step_relative },
        inverse_depth,
        name: path.display().to_string(),
        trouble: DepthTrouble::MayBeUnmeasured,
    };
    finish(&mut depth, &grid, files, camera, place).map(|()| depth)
}

/// Registers depth that came with the color, where the lens bends both.
pub(super) fn register_own(
    depth: &mut DepthPart,
    files: &PictureFiles,
    camera: &Camera,
    place: &str,
) -> Result<()> {
    let grid = shared_grid(camera.intrinsics.size(), camera, files.distortion, place)?;
    finish(depth, &grid, files, camera, place)
}

/// Checks the header of a file of depth, and gives the kind of its values.
pub(super) fn probe(path: &Path, files: &PictureFiles, camera: &Camera, place: &str) -> Result<DepthKind> {
    let place = &place_of_depth(path, place);
    if format_of(path, place)? == PictureFormat::Exr {
        let grid = grid_of(exr_size(path, camera, place)?, files, camera, place)?;
        let own = camera_of(&grid, camera);
        let picture = ExrPicture::open(path, files, files.wishes_of_depth_file(), &own, place)?;
        return Ok(picture.depth()?.kind());
    }
    if format_of(path, place)? == PictureFormat::Yuv {
        grid_of(camera.intrinsics.size(), files, camera, place)?;
        files.raw_video.check_depth(path, place, camera.intrinsics.size())?;
        return Ok(files.level_rules(place)?.kind);
    }
    grid_of(depth_size(path, files.raw_video.has_range(), place)?, files, camera, place)?;
    Ok(files.map_depth_rules(None, place)?.kind)
}

/// Why a picture has no depth, as the end of a sentence; `None` where its values do not tell.
pub(super) fn why_none(files: &PictureFiles, camera: &Camera, place: &str) -> Option<String> {
    let values = raw_values(files, camera, place).ok()?;
    let count = |is_so: fn(&f32) -> bool| values.iter().filter(|value| is_so(value)).count();
    let [unknown, zero, positive] =
        [count(|value| value.is_nan()), count(|value| *value == 0.0), count(|value| *value > 0.0)];
    let cause = if unknown == values.len() {
        ": every value is NaN, which is no number; save the depth again"
    } else if positive == 0 && unknown + zero < values.len() {
        ": every depth is negative, as z of cameras that look along −z is; change its sign, so that it is the distance forward"
    } else if positive == 0 {
        ": every value is 0, which means that nothing was measured; save the depth again"
    } else if files.raw_video.buffer().is_some() {
        ": no value is between 0 and 1, as those of a depth buffer are; check depth_kind"
    } else {
        ": its values mean that nothing was hit or measured, or masks, confidence or transparency leave all of them out; check depth_kind, depth_miss_value and depth_invalid_value"
    };
    Some(cause.to_owned())
}

/// The values of depth as the file has them.
fn raw_values(files: &PictureFiles, camera: &Camera, place: &str) -> Result<Vec<f32>> {
    let (path, wishes) = match &files.depth {
        Some(path) => (path, files.wishes_of_depth_file()),
        None => (&files.color, files.wishes_of_color_file()),
    };
    match format_of(path, place)? {
        PictureFormat::Exr => {
            let size = exr_size(path, camera, place)?;
            let own = camera_of(&grid_of(size, files, camera, place)?, camera);
            let picture = ExrPicture::open(path, files, wishes, &own, place)?;
            let indices = picture.depth()?.indices();
            Ok(DecodedPlanes::decode(&picture, &indices)?.take_single())
        }
        PictureFormat::Yuv => Ok(files.raw_video.depth(path, place, camera.intrinsics.size())?.0),
        _ => Ok(DepthMap::read(path, files.raw_video.has_range(), place)?.values),
    }
}

/// The size of an EXR picture of depth: the color camera's, where one of its windows has it.
fn exr_size(path: &Path, camera: &Camera, place: &str) -> Result<(usize, usize)> {
    let file = ExrFile::open(path, place)?;
    let window = file.window(Some(camera.intrinsics.size())).or_else(|_| file.window(None))?;
    Ok((window.width, window.height))
}

/// The grid of a depth picture of this size.
fn grid_of(size: (usize, usize), files: &PictureFiles, camera: &Camera, place: &str) -> Result<DepthGrid> {
    match &files.depth_camera {
        Some(depth_camera) => Ok(depth_camera.grid(size, camera)),
        None if camera.intrinsics.is_orthographic() && size != camera.intrinsics.size() => {
            let what = format!(
                "the depth is {}×{} and the color of its orthographic camera {}×{}; write both at one size",
                size.0, size.1, camera.intrinsics.width, camera.intrinsics.height
            );
            Err(Error::unsupported(place, what))
        }
        None => shared_grid(size, camera, files.distortion, place),
    }
}

/// The camera of a grid, as a pinhole.
fn camera_of(grid: &DepthGrid, color: &Camera) -> Camera {
    Camera {
        name: color.name.clone(),
        intrinsics: grid.intrinsics,
        world_from_camera: color.world_from_camera * grid.color_from_depth,
    }
}

fn refuse_bent_rays(kind: DepthKind, grid: &DepthGrid, place: &str) -> Result<()> {
    if grid.distortion.is_none() || matches!(kind, DepthKind::PlanarZ | DepthKind::WorldPosition) {
        return Ok(());
    }
    let what = "distances along the rays of a lens with distortion are not read; write planar_z, or undistort the pictures";
    Err(Error::unsupported(place, what))
}

/// Drops what the sensor is unsure of, and carries the rest into the color camera's pixels.
fn finish(
    depth: &mut DepthPart,
    grid: &DepthGrid,
    files: &PictureFiles,
    camera: &Camera,
    place: &str,
) -> Result<()> {
    if let Some(path) = &files.confidence {
        let place = &format!("{place}, confidence {}", path.display());
        let (size, confidence) = gray(path, place)?;
        if size != grid.intrinsics.size() {
            let what = format!(
                "the confidence is {}×{}, and the depth is not; they belong pixel to pixel",
                size.0, size.1
            );
            return Err(Error::invalid(place, what));
        }
        drop_unsure(&mut depth.inverse_depth, &confidence);
    }
    let is_colors_own = grid.distortion.is_none()
        && grid.intrinsics == camera.intrinsics
        && grid.color_from_depth == DAffine3::IDENTITY;
    if !is_colors_own {
        depth.inverse_depth =
            register(&depth.inverse_depth, grid, &files.rays.rays(grid), &camera.intrinsics);
    }
    Ok(())
}
