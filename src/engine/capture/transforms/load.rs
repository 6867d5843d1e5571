//! One frame from its files: the channels of color, depth and normals.

use std::path::Path;

use super::depth_file;
use super::exr_picture::{DecodedPlanes, DepthChannels, DepthPart, ExrPicture, no_depth};
use super::files::PictureFiles;
use super::header_probe;
use super::normal_file;
use super::value_file;
use crate::capture::camera::Camera;
use crate::capture::exr::{AlphaPlane, ColorPlanes, DepthTrouble, Layers, Primaries};
use crate::capture::frame::{Frame, INVALID_INVERSE_DEPTH};
use crate::capture::pictures::{self, PictureFormat, format_of};
use crate::capture::values::Values;
use crate::color::linear_from_srgb;
use crate::error::Result;
use crate::grid::Grid;

/// What must be in the files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NeededPlanes {
    /// Color and depth, and normals if asked for.
    Geometry {
        /// Whether normals are read, and must be there.
        normals: bool,
    },
    /// Color, and depth if it holds some.
    ColorOnly,
}

/// The planes read so far.
struct PictureParts {
    color: ColorPlanes,
    alpha: Option<AlphaPlane>,
    depth: Option<DepthPart>,
    normal: Option<[Vec<f32>; 3]>,
}

impl PictureParts {
    /// Color, alpha and normals as a pinhole shows them; depth is registered already.
    fn undistort(&mut self, sources: &pictures::Sources) {
        let color = std::mem::replace(&mut self.color, ColorPlanes::Single([const { Vec::new() }; 3]));
        let planes = color.into_single();
        self.color = ColorPlanes::Single(planes.map(|plane| sources.linear(&plane)));
        if let Some(alpha) = &mut self.alpha {
            alpha.values = sources.linear(&alpha.values);
        }
        self.normal = self.normal.take().map(|planes| planes.map(|plane| sources.nearest(&plane, 0.0)));
    }
}

/// Takes the depth of pixels that a mask leaves out. It covers the picture as it was taken, and may have another size.
fn mask_out(
    path: &Path,
    files: &PictureFiles,
    camera: &Camera,
    place: &str,
    depth: &mut [f32],
) -> Result<()> {
    let place = &format!("{place}, mask {}", path.display());
    let ((columns, rows), mask) = pictures::mask(path, place)?;
    let (width, height) = camera.intrinsics.size();
    let at = |index: usize| mask[index / width * rows / height * columns + index % width * columns / width];
    let scaled: Vec<bool> = (0..width * height).map(at).collect();
    let mask = match &files.distortion {
        Some(distortion) => pictures::sources(&camera.intrinsics, distortion).nearest(&scaled, false),
        None => scaled,
    };
    for (inverse, _) in depth.iter_mut().zip(mask).filter(|(_, counts)| !counts) {
        *inverse = INVALID_INVERSE_DEPTH;
    }
    Ok(())
}

/// The frame of a picture that is left out, of a capture with so many channels of values.
pub(super) fn without_samples(camera: &Camera, normals: bool, values: usize) -> Frame {
    let (width, height) = camera.intrinsics.size();
    Frame {
        color: Grid::filled(width, height, [half::f16::ZERO; 3]),
        inverse_depth: Grid::filled(width, height, INVALID_INVERSE_DEPTH),
        normal_in_world: normals.then(|| Grid::filled(width, height, [0.0; 3])),
        depth_step_relative: 0.0,
        values: Values::missing(values, width * height),
    }
}

/// Decodes one frame; `place` names file, camera and frame in errors.
///
/// # Errors
/// `Io`, `Invalid`, `Unsupported` for a file that is missing, damaged, of another size, or without a channel that is needed.
pub(super) fn frame(files: &PictureFiles, camera: &Camera, place: &str, need: NeededPlanes) -> Result<Frame> {
    let wants_normals = need == NeededPlanes::Geometry { normals: true };
    let mut parts = read_color_file(files, camera, place, need)?;
    if let Some(path) = &files.depth
        && (path.is_file() || need != NeededPlanes::ColorOnly)
    {
        parts.depth = Some(depth_file::read(path, files, camera, place)?);
    } else if let Some(depth) = &mut parts.depth {
        depth_file::register_own(depth, files, camera, place)?;
    }
    if let (Some(path), true) = (&files.normal, wants_normals) {
        parts.normal = Some(normal_file::read(path, files, camera, place)?);
    }
    if let Some(distortion) = &files.distortion {
        parts.undistort(&pictures::sources(&camera.intrinsics, distortion));
    }
    let mut depth = match (parts.depth, need) {
        (Some(depth), _) => depth,
        (None, NeededPlanes::Geometry { .. }) => return Err(no_depth(place)),
        (None, NeededPlanes::ColorOnly) => DepthPart {
            inverse_depth: vec![0.0; camera.intrinsics.pixel_count()],
            step_relative: 0.0,
            name: "color".to_owned(),
            trouble: DepthTrouble::default(),
        },
    };
    if let Some(mask) = &files.mask {
        mask_out(mask, files, camera, place, &mut depth.inverse_depth)?;
    }
    let layers = Layers {
        color: parts.color.multiplied_by(files.color_factor),
        alpha: parts.alpha.filter(|_| files.uses_alpha),
        inverse_depth: depth.inverse_depth,
        depth_step_relative: depth.step_relative,
        normal: parts.normal.zip(files.normal_space),
        depth_name: depth.name,
        depth_trouble: depth.trouble,
    };
    let mut frame = layers.into_frame(camera, place)?;
    if wants_normals {
        // The normals of a frame that alone has none are unknown.
        let (width, height) = camera.intrinsics.size();
        frame.normal_in_world.get_or_insert_with(|| Grid::filled(width, height, [0.0; 3]));
    }
    if need != NeededPlanes::ColorOnly {
        frame.values = value_file::read(files, camera, place)?;
    }
    Ok(frame)
}

/// Pixels of a picture that are no samples because they are transparent; `None` where alpha says nothing, or is not used.
///
/// # Errors
/// As [`frame`].
pub(super) fn transparent_pixels(
    files: &PictureFiles,
    camera: &Camera,
    place: &str,
) -> Result<Option<usize>> {
    if !files.uses_alpha || !header_probe::has_alpha(files, camera, place)? {
        return Ok(None);
    }
    let PictureParts { color, alpha, .. } = read_color_file(files, camera, place, NeededPlanes::ColorOnly)?;
    let (colors, _) = color.into_halves(&mut vec![0.0; camera.intrinsics.pixel_count()]);
    Ok(alpha.and_then(|alpha| alpha.transparent_pixels(&colors)))
}

fn read_color_file(
    files: &PictureFiles,
    camera: &Camera,
    place: &str,
    need: NeededPlanes,
) -> Result<PictureParts> {
    let size = camera.intrinsics.size();
    if format_of(&files.color, place)? == PictureFormat::Yuv {
        let color = ColorPlanes::Single(files.raw_video.color(&files.color, place, size)?);
        return Ok(PictureParts { color, alpha: None, depth: None, normal: None });
    }
    if format_of(&files.color, place)? != PictureFormat::Exr {
        let (color, alpha) = pictures::color(&files.color, place, size, files.color_reading())?;
        let alpha = alpha.map(|values| AlphaPlane { values, is_associated: false });
        return Ok(PictureParts { color: ColorPlanes::Single(color), alpha, depth: None, normal: None });
    }
    let picture = ExrPicture::open(&files.color, files, files.wishes_of_color_file(), camera, place)?;
    let depth = match (&files.depth, need) {
        (Some(_), _) => None,
        (None, NeededPlanes::Geometry { .. }) => Some(picture.depth()?),
        (None, NeededPlanes::ColorOnly) => picture.depth().ok(),
    };
    let wants_normals = need == NeededPlanes::Geometry { normals: true } && files.normal.is_none();
    let mut wanted = picture.color()?.to_vec();
    wanted.extend(picture.names.alpha);
    wanted.extend(depth.iter().flat_map(DepthChannels::indices));
    if wants_normals {
        wanted.extend(picture.normal()?);
    }
    let mut planes = DecodedPlanes::decode(&picture, &wanted)?;
    let primaries = if files.are_colors_named { Primaries::Rec709 } else { picture.file.primaries };
    let color = if files.is_linear == Some(false) {
        let mut encoded = planes.take_three();
        encoded.iter_mut().flatten().for_each(|value| *value = linear_from_srgb(*value));
        ColorPlanes::Single(encoded)
    } else if let Primaries::Others(_) = primaries {
        let mut others = planes.take_three();
        primaries.convert(&mut others);
        ColorPlanes::Single(others)
    } else {
        ColorPlanes::from([(); 3].map(|()| planes.take()))
    };
    let alpha = picture.names.alpha.map(|_| planes.take_single());
    let alpha = alpha.map(|values| AlphaPlane { values, is_associated: true });
    let depth = depth.map(|channels| planes.take_depth(channels, &picture, camera)).transpose()?;
    let normal = wants_normals.then(|| planes.take_three());
    Ok(PictureParts { color, alpha, depth, normal })
}
