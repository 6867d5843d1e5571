//! One frame from its files: which channel of which file is color, depth and normal.

use std::path::Path;

use super::depth_file;
use super::files::PictureFiles;
use super::normal_file;
use crate::capture::camera::Camera;
use crate::capture::exr::{
    ChannelNames, ChannelPlane, ChannelWishes, ColorPlanes, DataWindow, DepthKind, DepthRules, DepthTrouble,
    ExrFile, Layers,
};
use crate::capture::frame::{Frame, INVALID_INVERSE_DEPTH};
use crate::capture::pictures::{self, PictureFormat, format_of};
use crate::color::linear_from_srgb;
use crate::error::{Error, Result};
use crate::grid::Grid;

/// What must be in the files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NeededPlanes {
    /// Color and depth, and normals if asked for.
    Geometry {
        /// Whether normals are read, and must be there.
        normals: bool,
    },
    /// Color; depth where there is one.
    ColorOnly,
}

/// Where depth is in an EXR file.
#[derive(Clone, Copy)]
pub(super) enum DepthChannels {
    One(usize, DepthKind),
    Position([usize; 3]),
}

/// An EXR file with its channels recognized.
pub(super) struct ExrPicture<'a> {
    pub(super) file: ExrFile,
    pub(super) names: ChannelNames,
    window: DataWindow,
    files: &'a PictureFiles,
    wishes: ChannelWishes,
    pub(super) place: &'a str,
}

impl<'a> ExrPicture<'a> {
    pub(super) fn open(
        path: &Path,
        files: &'a PictureFiles,
        wishes: ChannelWishes,
        camera: &Camera,
        place: &'a str,
    ) -> Result<Self> {
        let file = ExrFile::open(path, place)?;
        let names =
            ChannelNames::find(file.channels().iter().map(|channel| channel.name.as_str()), &wishes, place)?;
        let window = file.window(Some(camera.intrinsics.size()))?;
        Ok(Self { file, names, window, files, wishes, place })
    }

    fn missing(&self, what: &str, key: &str) -> Error {
        const SHOWN: usize = 16;
        let names: Vec<&str> = self.file.channels().iter().map(|c| c.name.as_str()).take(SHOWN).collect();
        Error::invalid(self.place, format!("no {what} among the channels {}; {key}", names.join(", ")))
    }

    pub(super) fn color(&self) -> Result<[usize; 3]> {
        self.names.color.ok_or_else(|| {
            let names = self.file.channels().iter().map(|channel| channel.name.as_str());
            self.missing("color", &ChannelNames::advice_on_color(names, &self.wishes))
        })
    }

    pub(super) fn depth(&self) -> Result<DepthChannels> {
        const KEY: &str = "name one as \"depth_channel\" in the manifest";
        const LAYER_KEY: &str = "name the layer of its X, Y and Z as \"depth_channel\" in the manifest";
        let one = |kind| self.names.depth.map(|index| DepthChannels::One(index, kind));
        let position = || self.names.position.map(DepthChannels::Position);
        // Beside depth, red, green and blue are a picture.
        let unnamed = || {
            let is_picture = self.names.only_vector == self.names.color && self.names.depth.is_some();
            let vector = self.names.only_vector.filter(|_| self.wishes.is_apart && !is_picture);
            vector.map(DepthChannels::Position)
        };
        let found = match self.files.depth_kind {
            Some(DepthKind::WorldPosition) => position().or_else(unnamed),
            Some(kind) => one(kind),
            // Positions leave nothing open, a distance where it starts.
            None if self.names.depth_is_ray_distance && !self.files.names_depth_channel() => {
                position().or_else(|| one(DepthKind::RayDistanceFromNearClip))
            }
            None if self.names.depth_is_ray_distance => one(DepthKind::RayDistanceFromNearClip),
            None => one(DepthKind::PlanarZ).or_else(position),
        };
        let (what, key) = match self.files.depth_kind {
            Some(DepthKind::WorldPosition) => ("position", LAYER_KEY),
            _ => ("depth", KEY),
        };
        found.ok_or_else(|| self.missing(what, key))
    }

    pub(super) fn normal(&self) -> Result<[usize; 3]> {
        self.names
            .normal
            .ok_or_else(|| self.missing("normal", "name its layer as \"normal_channel\" in the manifest"))
    }
}

pub(super) fn place_of_depth(path: &Path, place: &str) -> String {
    format!("{place}, depth file {}", path.display())
}

pub(super) fn no_depth(place: &str) -> Error {
    Error::invalid(place, "there is no depth; give depth_file_path, or write depth into an EXR picture")
}

/// The planes read so far.
struct PictureParts {
    color: ColorPlanes,
    alpha: Option<Vec<f32>>,
    depth: Option<DepthPart>,
    normal: Option<[Vec<f32>; 3]>,
}

impl PictureParts {
    /// Color, alpha and normals as a pinhole shows them; depth is registered already.
    fn undistort(&mut self, sources: &pictures::Sources) {
        let color = std::mem::replace(&mut self.color, ColorPlanes::Single([const { Vec::new() }; 3]));
        let planes = color.into_single();
        self.color = ColorPlanes::Single(planes.map(|plane| sources.linear(&plane)));
        self.alpha = self.alpha.take().map(|alpha| sources.linear(&alpha));
        self.normal = self.normal.take().map(|planes| planes.map(|plane| sources.nearest(&plane, 0.0)));
    }
}

/// Takes the depth of pixels whose mask is 0. A mask lies over the picture as it was taken, and may have another size.
fn mask_out(
    path: &Path,
    files: &PictureFiles,
    camera: &Camera,
    place: &str,
    depth: &mut [f32],
) -> Result<()> {
    let place = &format!("{place}, mask {}", path.display());
    let ((columns, rows), mask) = pictures::gray(path, place)?;
    let (width, height) = camera.intrinsics.size();
    let at = |index: usize| mask[index / width * rows / height * columns + index % width * columns / width];
    let scaled: Vec<u8> = (0..width * height).map(at).collect();
    let mask = match &files.distortion {
        Some(distortion) => pictures::sources(&camera.intrinsics, distortion).nearest(&scaled, 0),
        None => scaled,
    };
    for (inverse, _) in depth.iter_mut().zip(mask).filter(|(_, mask)| *mask == 0) {
        *inverse = INVALID_INVERSE_DEPTH;
    }
    Ok(())
}

pub(super) struct DepthPart {
    pub(super) inverse_depth: Vec<f32>,
    pub(super) step_relative: f32,
    pub(super) name: String,
    pub(super) trouble: DepthTrouble,
}

/// Decodes one frame; `place` names file, camera and frame in errors.
///
/// # Errors
/// `Io`, `Invalid`, `Unsupported`: a file that is missing, damaged, of another size, or lacks what is needed.
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
        color: parts.color,
        alpha: parts.alpha,
        inverse_depth: depth.inverse_depth,
        depth_step_relative: depth.step_relative,
        normal: parts.normal.zip(files.normal_space),
        depth_name: depth.name,
        depth_trouble: depth.trouble,
    };
    let mut frame = layers.into_frame(camera, place)?;
    if wants_normals {
        // Where this frame alone says that it has none, its normals are unknown.
        let (width, height) = camera.intrinsics.size();
        frame.normal_in_world.get_or_insert_with(|| Grid::filled(width, height, [0.0; 3]));
    }
    Ok(frame)
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
        let (color, alpha) = pictures::color(&files.color, place, size, files.is_linear.unwrap_or(false))?;
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
    let color = if files.is_linear == Some(false) {
        let mut encoded = planes.take_three();
        encoded.iter_mut().flatten().for_each(|value| *value = linear_from_srgb(*value));
        ColorPlanes::Single(encoded)
    } else {
        ColorPlanes::from([(); 3].map(|()| planes.take()))
    };
    let alpha = picture.names.alpha.map(|_| planes.take_single());
    let depth = depth.map(|channels| planes.take_depth(channels, &picture, camera)).transpose()?;
    let normal = wants_normals.then(|| planes.take_three());
    Ok(PictureParts { color, alpha, depth, normal })
}

/// The relative error of depth in whole units grows toward the camera. That of nearly the nearest depth is taken, so that a few
/// stray hits do not decide.
pub(super) fn step_of_whole_units(rules: &DepthRules, inverse_depth: &[f32]) -> f32 {
    0.5 * rules.unit_scale as f32 * quantile_of_hits(inverse_depth, NEARLY_ALL)
}

/// How far positions may project from the pixels that they stand in, in the middle: filters and lens shifts stay below.
const MAX_DISTANCE_FROM_RAYS_PX: f64 = 2.0;

fn off_the_rays(apart_px: f64, camera: &Camera, place: &str) -> Error {
    let median = if apart_px.is_finite() {
        format!("median {apart_px:.0} px")
    } else {
        "most lie behind it".to_owned()
    };
    let what = format!(
        "positions do not lie on the rays of camera '{}' ({median}); are they in world space, and in the unit and axes of transform_matrix?",
        camera.name
    );
    Error::invalid(place, what)
}

/// The share of hits that are no nearer than the depth whose quantization step is taken for all.
pub(super) const NEARLY_ALL: f64 = 0.99;

/// What a share of the finite values above 0 stays below, or 0.
pub(super) fn quantile_of_hits(values: &[f32], share: f64) -> f32 {
    let mut hits: Vec<f32> =
        values.iter().copied().filter(|value| *value > 0.0 && value.is_finite()).collect();
    let rank = (hits.len() as f64 * share) as usize;
    if hits.is_empty() { 0.0 } else { *hits.select_nth_unstable_by(rank, f32::total_cmp).1 }
}

impl DepthChannels {
    pub(super) fn kind(&self) -> DepthKind {
        match self {
            Self::One(_, kind) => *kind,
            Self::Position(_) => DepthKind::WorldPosition,
        }
    }

    pub(super) fn indices(&self) -> Vec<usize> {
        match self {
            Self::One(index, _) => vec![*index],
            Self::Position(indices) => indices.to_vec(),
        }
    }
}

/// Decoded planes, taken in the order of the request.
pub(super) struct DecodedPlanes(std::vec::IntoIter<ChannelPlane>);

impl DecodedPlanes {
    pub(super) fn decode(picture: &ExrPicture, wanted: &[usize]) -> Result<Self> {
        Ok(Self(picture.file.decode(wanted, picture.window)?.into_iter()))
    }

    fn take(&mut self) -> ChannelPlane {
        self.0.next().unwrap_or(ChannelPlane::Single(Vec::new()))
    }

    fn take_single(&mut self) -> Vec<f32> {
        self.take().into_single()
    }

    pub(super) fn take_three(&mut self) -> [Vec<f32>; 3] {
        [(); 3].map(|()| self.take_single())
    }

    pub(super) fn take_depth(
        &mut self,
        channels: DepthChannels,
        picture: &ExrPicture,
        camera: &Camera,
    ) -> Result<DepthPart> {
        match channels {
            DepthChannels::One(index, kind) => {
                let channel = &picture.file.channels()[index];
                let rules = picture.files.depth_rules(kind, channel);
                let values = self.take_single();
                let is_negative = rules.are_negative(&values);
                let trouble = if is_negative { DepthTrouble::Negative } else { DepthTrouble::Unknown };
                let inverse_depth = rules.inverse_depth_plane(values, camera);
                let step_relative = if channel.is_whole {
                    step_of_whole_units(&rules, &inverse_depth)
                } else {
                    channel.step_relative
                };
                Ok(DepthPart { inverse_depth, step_relative, name: channel.name.clone(), trouble })
            }
            DepthChannels::Position([x, ..]) => {
                let channel = &picture.file.channels()[x];
                let planes = self.take_three();
                let xyz = planes.each_ref().map(Vec::as_slice);
                let rules = picture.files.depth_rules(DepthKind::WorldPosition, channel);
                let inverse_depth = rules.inverse_depth_from_positions(xyz, camera);
                let apart = rules.distance_from_rays_px(xyz, &inverse_depth, channel.step_relative, camera);
                if let Some(apart) = apart.filter(|apart| *apart > MAX_DISTANCE_FROM_RAYS_PX) {
                    return Err(off_the_rays(apart, camera, picture.place));
                }
                // A position errs by a share of its coordinates, which may be larger than its depth.
                let scale = rules.unit_scale as f32;
                let coordinate_per_depth = xyz
                    .map(|axis| {
                        axis.iter().zip(&inverse_depth).map(|(value, w)| value.abs() * scale * w).collect()
                    })
                    .map(|shares: Vec<f32>| quantile_of_hits(&shares, 0.5))
                    .into_iter()
                    .fold(1.0, f32::max);
                Ok(DepthPart {
                    inverse_depth,
                    step_relative: channel.step_relative * coordinate_per_depth,
                    name: channel.name.clone(),
                    trouble: DepthTrouble::default(),
                })
            }
        }
    }
}
