//! What one EXR file holds: which of its channels are color, depth and normals, and their planes.

use std::path::Path;

use super::files::PictureFiles;
use crate::capture::camera::Camera;
use crate::capture::exr::{
    ChannelInfo, ChannelNames, ChannelPlane, ChannelWishes, DataWindow, DepthKind, DepthRules, DepthTrouble,
    ExrFile,
};
use crate::capture::yuv::LevelRange;
use crate::error::{Error, Result};

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
        // A picture of one channel is a picture or depth, and not both.
        let is_gray = |index: usize| !self.wishes.is_apart && self.names.color == Some([index; 3]);
        let own = self.names.depth.filter(|index| !is_gray(*index));
        let one = |kind| own.map(|index| DepthChannels::One(index, kind));
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

/// Depth on the pixels of a camera.
pub(super) struct DepthPart {
    pub(super) inverse_depth: Vec<f32>,
    pub(super) step_relative: f32,
    pub(super) name: String,
    pub(super) trouble: DepthTrouble,
}

/// The relative error of depth in whole units grows toward the camera. That of nearly the nearest depth is taken, so that a few
/// stray hits do not decide.
pub(super) fn step_of_whole_units(rules: &DepthRules, inverse_depth: &[f32]) -> f32 {
    0.5 * rules.unit_scale as f32 * quantile_of_hits(inverse_depth, NEARLY_ALL)
}

/// Depth in world units that was given in levels. Half a level is `half_step` of inverse depth.
pub(super) fn of_levels(
    values: Vec<f32>,
    half_step: f32,
    rules: &DepthRules,
    camera: &Camera,
    name: String,
) -> DepthPart {
    let inverse_depth = rules.inverse_depth_plane(values, camera);
    // Levels are even in 1/z: their relative error grows with distance.
    let farthest = quantile_of_hits(&inverse_depth, 1.0 - NEARLY_ALL);
    DepthPart {
        step_relative: if farthest > 0.0 { half_step / farthest } else { 0.0 },
        inverse_depth,
        name,
        trouble: DepthTrouble::MayBeUnmeasured,
    }
}

/// A channel that holds a depth buffer.
fn of_buffer(
    values: &[f32],
    channel: &ChannelInfo,
    range: &LevelRange,
    picture: &ExrPicture,
    camera: &Camera,
) -> Result<DepthPart> {
    let largest = if channel.is_whole { u32::MAX as f32 } else { 1.0 };
    let depth = values.iter().map(|value| range.depth(*value, largest)).collect();
    let rules = picture.files.level_rules(picture.place)?;
    let half_step = range.half_step_of(channel.step_relative);
    let part = of_levels(depth, half_step, &rules, camera, channel.name.clone());
    Ok(DepthPart { trouble: DepthTrouble::Unknown, ..part })
}

/// The most that positions may project away from their pixels, by the median: filters and lens shifts stay below.
const MAX_DISTANCE_FROM_RAYS_PX: f64 = 2.0;

fn off_the_rays(apart_px: f64, camera: &Camera, place: &str) -> Error {
    let median = if apart_px.is_finite() {
        format!("median {apart_px:.0} px")
    } else {
        "most lie behind it".to_owned()
    };
    let what = format!(
        "positions are not on the rays of camera '{}' ({median}); are they in world space, and in the unit and axes of transform_matrix?",
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

    pub(super) fn take(&mut self) -> ChannelPlane {
        self.0.next().unwrap_or(ChannelPlane::Single(Vec::new()))
    }

    pub(super) fn take_single(&mut self) -> Vec<f32> {
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
                let values = self.take_single();
                if let Some(range) = picture.files.raw_video.buffer() {
                    return of_buffer(&values, channel, &range, picture, camera);
                }
                let rules = picture.files.depth_rules(kind, channel);
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
