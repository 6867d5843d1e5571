//! The files of one frame, and the manifest's keys for reading them.

use std::path::{Path, PathBuf};

use super::depth_camera::DepthCamera;
use super::manifest::{Keys, Manifest, NormalSpaceName};
use super::raw_video::RawVideo;
use super::same_camera::SimilarNames;
use super::value_places::ValueFile;
use super::view_list::ViewList;
use crate::capture::depth_claim::{DepthClaim, DepthMeasure};
use crate::capture::exr::{
    ChannelInfo, ChannelWishes, DepthKind, DepthRules, HALF_MAX, MISS_DEPTH, NormalSpace,
};
use crate::capture::pictures::{
    ColorReading, Distortion, PICTURE_EXTENSIONS, PictureFormat, PictureRows, RayCache, format_of,
};
use crate::error::{Error, Result};

/// nerfstudio's unit of depth in PNG, TIFF and `NumPy` files: millimeters.
const UNIT_SCALE: f64 = 1e-3;

/// The files of one frame, and how they are read.
#[derive(Clone, Debug)]
pub(crate) struct PictureFiles {
    /// Color, and whatever is not elsewhere.
    pub color: PathBuf,
    /// A file of its own.
    pub depth: Option<PathBuf>,
    /// A file of its own.
    pub normal: Option<PathBuf>,
    /// How sure the sensor is of each pixel of depth.
    pub confidence: Option<PathBuf>,
    /// Pixels that are 0 in it are left out.
    pub mask: Option<PathBuf>,
    /// Where scalar values are, channel by channel.
    pub values: Vec<ValueFile>,
    /// What the color camera's lens does to the picture; `None` where it is a pinhole.
    pub distortion: Option<Distortion>,
    /// The depth camera, where it is another one than color's.
    pub depth_camera: Option<DepthCamera>,
    /// The rays of depth cameras, shared by all pictures of a capture.
    pub rays: RayCache,
    wishes: ChannelWishes,
    /// The measure of depth, if the manifest has it.
    pub depth_kind: Option<DepthKind>,
    /// Whether the manifest gives the near plane.
    pub has_near_clip: bool,
    unit_scale: Option<f64>,
    /// Kind, scale and sample type are decided by the file.
    rules: DepthRules,
    /// `None` where normals are not to be read.
    pub normal_space: Option<NormalSpace>,
    /// Where the pictures are raw video, which of them and how it is read.
    pub raw_video: RawVideo,
    /// `None` leaves it to the format: EXR is linear, PNG is sRGB.
    pub is_linear: Option<bool>,
    /// What linear colors are multiplied by.
    pub color_factor: f32,
    /// Whether what is transparent is no sample.
    pub uses_alpha: bool,
    /// Whether the manifest names colors of Rec.709's primaries, so that what the picture says of its own does not count.
    pub are_colors_named: bool,
    /// Which rows are meant of a picture that is shown turned, if known.
    pub rows: Option<PictureRows>,
}

/// Most stops that a manifest may ask for: half floats hold no more.
const MOST_STOPS: f64 = 24.0;

/// What colors are multiplied by, for the manifest's key in stops.
///
/// # Errors
/// `Invalid` for stops beyond ±24, and what is no number.
fn color_factor(stops: Option<f64>, place: &str) -> Result<f32> {
    let stops = stops.unwrap_or(0.0);
    if !stops.is_finite() || stops.abs() > MOST_STOPS {
        return Err(Error::invalid(place, format!("exposure is {stops}; give stops from -24 to 24")));
    }
    Ok(stops.exp2() as f32)
}

/// The kind of depth that the manifest names; `None` where it names none.
fn depth_kind_of(keys: &Keys, place: &str) -> Result<Option<DepthKind>> {
    let kind = keys.depth_kind.as_deref().map(|name| {
        DepthKind::from_name(name).ok_or_else(|| {
            Error::invalid(
                place,
                format!(
                    "depth_kind '{name}' is unknown; there are planar_z, ray_distance, ray_distance_from_near_clip, position, world_z, z_buffer, reversed_z_buffer"
                ),
            )
        })
    });
    kind.transpose()
}

/// The space of the normals; `None` where they are not to be read.
fn normal_space_of(keys: &Keys, place: &str) -> Result<Option<NormalSpace>> {
    match &keys.normal_space {
        None => Ok(Some(NormalSpace::World)),
        Some(NormalSpaceName::Null) => Ok(None),
        Some(NormalSpaceName::Text(name)) => NormalSpace::from_name(name).map(Some).ok_or_else(|| {
            Error::invalid(
                place,
                format!("normal_space '{name}' is unknown; there are world, camera, camera_opencv, null"),
            )
        }),
    }
}

impl PictureFiles {
    /// Takes the values of the manifest's keys; `place` is the entry.
    ///
    /// # Errors
    /// `Invalid` for an unknown depth kind or normal space, and numbers that are no distances.
    pub(crate) fn new(
        color: PathBuf,
        depth: Option<PathBuf>,
        normal: Option<PathBuf>,
        keys: &Keys,
        place: &str,
    ) -> Result<Self> {
        let normal_space = normal_space_of(keys, place)?;
        let positive = |name: &str, value: Option<f64>| match value {
            Some(value) if !(value.is_finite() && value > 0.0) => {
                Err(Error::invalid(place, format!("{name} is {value}; it must be above 0")))
            }
            _ => Ok(value),
        };
        let depth_kind = depth_kind_of(keys, place)?;
        let holds_positions = depth_kind == Some(DepthKind::WorldPosition);
        let near_clip = keys.near_clip.filter(|near| *near != 0.0);
        Ok(Self {
            color,
            depth,
            normal,
            confidence: None,
            mask: None,
            values: Vec::new(),
            distortion: keys.distortion(place)?,
            depth_camera: keys
                .depth_camera
                .as_ref()
                .map(|depth| DepthCamera::new(depth, keys.pose_convention(), place))
                .transpose()?,
            rays: RayCache::default(),
            wishes: ChannelWishes {
                is_apart: false,
                layer: keys.layer.clone(),
                depth_channel: keys.depth_channel.clone().filter(|_| !holds_positions),
                position_channel: keys.depth_channel.clone().filter(|_| holds_positions),
                normal_channel: keys.normal_channel.clone(),
            },
            depth_kind,
            has_near_clip: keys.near_clip.is_some(),
            unit_scale: positive("depth_unit_scale_factor", keys.depth_unit_scale_factor)?,
            rules: DepthRules {
                miss_value: keys.depth_miss_value,
                invalid_value: keys.depth_invalid_value.map(|value| value as f32),
                near_clip: positive("near_clip", near_clip)?.unwrap_or(0.0),
                far_clip: positive("far_clip", keys.far_clip)?,
                ..DepthRules::default()
            },
            normal_space,
            raw_video: RawVideo::new(&keys.raw_video, depth_kind, place)?,
            is_linear: keys.color_space.as_deref().map(is_linear),
            color_factor: color_factor(keys.exposure, place)?,
            uses_alpha: keys.use_alpha.unwrap_or(true),
            are_colors_named: keys.color_space.as_deref().is_some_and(are_rec_709),
            rows: keys.picture_orientation,
        })
    }

    /// How the numbers and the rows of a picture of color are read.
    pub(crate) fn color_reading(&self) -> ColorReading {
        ColorReading { is_linear: self.is_linear, rows: self.rows }
    }

    /// The first of the files that is missing: which of them, and the error.
    pub(crate) fn missing(&self, place: &str) -> Option<(&'static str, Error)> {
        let more = [&self.depth, &self.normal, &self.confidence, &self.mask].map(Option::as_ref);
        let [depth, normal, confidence, mask] = more;
        let values = self.values.iter().map(|value| ("value", value.path.as_ref()));
        let fixed = [
            ("picture", Some(&self.color)),
            ("depth", depth),
            ("normal", normal),
            ("confidence", confidence),
            ("mask", mask),
        ];
        for (name, path) in fixed.into_iter().chain(values) {
            if let Some(path) = path
                && !path.is_file()
            {
                let what = format!(
                    "the {name} file {} is missing; put it back or take its entry out of the manifest",
                    path.display()
                );
                return Some((name, Error::invalid(place, what)));
            }
        }
        None
    }

    /// What depth is taken for: where the manifest leaves it open, and of positions, planar z.
    pub(crate) fn depth_claim(&self) -> DepthClaim {
        let file = self.depth.as_ref().unwrap_or(&self.color);
        let is_exr = matches!(format_of(file, ""), Ok(PictureFormat::Exr));
        // Levels are even in 1/z whichever program wrote them.
        let is_planar = self.depth_kind.is_none_or(|kind| kind == DepthKind::PlanarZ || kind.is_buffer());
        let has_levels = !is_exr || self.raw_video.buffer().is_some();
        if let (Some((measure, planes)), true) = (self.raw_video.claim(), is_planar && has_levels) {
            return DepthClaim { measure, planes: Some(planes), ..DepthClaim::default() };
        }
        let measure = match self.depth_kind {
            None | Some(DepthKind::PlanarZ | DepthKind::WorldPosition) => DepthMeasure::PlanarZ,
            Some(DepthKind::RayDistance) => DepthMeasure::RayDistance,
            Some(DepthKind::RayDistanceFromNearClip) => DepthMeasure::RayDistanceFromNearClip,
            Some(DepthKind::WorldZ) => DepthMeasure::WorldZ,
            Some(DepthKind::ZBuffer) => DepthMeasure::ZBuffer,
            Some(DepthKind::ReversedZBuffer) => DepthMeasure::ReversedZBuffer,
        };
        let file = self.depth.as_ref().unwrap_or(&self.color);
        let in_world_units = [PictureFormat::Exr, PictureFormat::Pfm];
        let is_in_world_units = self.raw_video.has_range()
            || format_of(file, "").is_ok_and(|format| in_world_units.contains(&format));
        let unit = self.unit_scale.unwrap_or(if is_in_world_units { 1.0 } else { UNIT_SCALE });
        DepthClaim { measure, unit, near_clip: self.rules.near_clip, planes: None }
    }

    /// Whether the manifest leaves open the channel, the kind and the unit of depth.
    pub(crate) fn leaves_depth_open(&self) -> bool {
        self.depth_kind.is_none() && self.unit_scale.is_none() && !self.names_depth_channel()
    }

    /// Whether the manifest names the channel of depth.
    pub(crate) fn names_depth_channel(&self) -> bool {
        self.wishes.depth_channel.is_some()
    }

    /// The channels to look for in the color file: those that have no files of their own.
    pub(crate) fn wishes_of_color_file(&self) -> ChannelWishes {
        ChannelWishes {
            is_apart: false,
            layer: self.wishes.layer.clone(),
            depth_channel: self.wishes.depth_channel.clone().filter(|_| self.depth.is_none()),
            position_channel: self.wishes.position_channel.clone().filter(|_| self.depth.is_none()),
            normal_channel: self.wishes.normal_channel.clone().filter(|_| self.normal.is_none()),
        }
    }

    /// What to look for in a depth file, which need not have the picture's layers.
    pub(crate) fn wishes_of_depth_file(&self) -> ChannelWishes {
        ChannelWishes { is_apart: true, normal_channel: None, ..self.wishes.clone() }
    }

    /// What to look for in a normal file.
    pub(crate) fn wishes_of_normal_file(&self) -> ChannelWishes {
        ChannelWishes { is_apart: true, depth_channel: None, position_channel: None, ..self.wishes.clone() }
    }

    /// The rules for a file of depth alone, whose whole numbers go up to `whole_up_to`, or which holds floats.
    ///
    /// # Errors
    /// `Invalid` for positions, which take three channels.
    pub(crate) fn map_depth_rules(&self, whole_up_to: Option<f32>, place: &str) -> Result<DepthRules> {
        let kind = self.depth_kind.unwrap_or_default();
        if kind == DepthKind::WorldPosition {
            return Err(Error::invalid(
                place,
                "a file of depth alone holds no positions, which take three channels; save them as EXR, or name another depth_kind",
            ));
        }
        Ok(DepthRules {
            kind,
            unit_scale: self.depth_claim().unit,
            zero_is_unknown: true,
            misses_from: whole_up_to.unwrap_or(MISS_DEPTH),
            ..self.rules
        })
    }

    /// The rules for depth between a near and a far plane, which is in world units already.
    ///
    /// # Errors
    /// `Invalid` for positions, which take three channels.
    pub(crate) fn level_rules(&self, place: &str) -> Result<DepthRules> {
        let rules = self.map_depth_rules(None, place)?;
        let kind = if rules.kind.is_buffer() { DepthKind::PlanarZ } else { rules.kind };
        Ok(DepthRules { kind, unit_scale: 1.0, misses_from: f32::MAX, ..rules })
    }

    /// The rules for a depth channel of an EXR file.
    pub(crate) fn depth_rules(&self, kind: DepthKind, channel: &ChannelInfo) -> DepthRules {
        let misses_from = if channel.is_half {
            HALF_MAX
        } else if channel.is_whole {
            u32::MAX as f32
        } else {
            MISS_DEPTH
        };
        DepthRules { kind, misses_from, unit_scale: self.unit_scale.unwrap_or(1.0), ..self.rules }
    }
}

fn is_linear(color_space: &str) -> bool {
    !color_space.to_ascii_lowercase().contains("srgb") || color_space.to_ascii_lowercase().contains("linear")
}

/// Whether a color space is known to have the primaries of Rec.709.
fn are_rec_709(color_space: &str) -> bool {
    let lower = color_space.to_ascii_lowercase();
    ["srgb", "709", "raw"].iter().any(|known| lower.contains(known))
}

/// The path of a picture that a manifest names; manifests from Windows may have `\\` where others have `/`. A name without extension may
/// mean several: `others` come last.
pub(crate) fn picture_path(folder: &Path, name: &str, others: &[&Path]) -> PathBuf {
    let path = with_extension(folder.join(name), others);
    if path.is_file() || !name.contains('\\') {
        return path;
    }
    let elsewhere = with_extension(folder.join(name.replace('\\', "/")), others);
    if elsewhere.is_file() { elsewhere } else { path }
}

/// As [`picture_path`], and where no file has that name the only one whose name other systems take for the same.
pub(super) fn named_path(folder: &Path, name: &str, others: &[&Path], similar: &SimilarNames) -> PathBuf {
    let path = picture_path(folder, name, others);
    if path.is_file() {
        return path;
    }
    let spellings = std::iter::once(folder.join(name.replace('\\', "/"))).chain(extended(&path));
    spellings.into_iter().find_map(|path| similar.file(folder, &path)).unwrap_or(path)
}

/// The first data sets of radiance fields name pictures without extension. The text behind a dot may be a number.
fn with_extension(path: PathBuf, others: &[&Path]) -> PathBuf {
    if path.is_file() {
        return path;
    }
    let files: Vec<PathBuf> = extended(&path).into_iter().filter(|it| it.is_file()).collect();
    let own = files.iter().find(|it| !others.contains(&it.as_path())).or(files.first());
    own.cloned().unwrap_or(path)
}

/// The last part of a picture's name without the extension of a picture.
pub(crate) fn without_extension(name: &str) -> &str {
    path_without_extension(name.rsplit(['/', '\\']).next().unwrap_or(name))
}

/// A picture's name without the extension of a picture.
pub(super) fn path_without_extension(name: &str) -> &str {
    let known =
        |extension: &str| PICTURE_EXTENSIONS.iter().any(|known| extension.eq_ignore_ascii_case(known));
    name.rsplit_once('.').filter(|(_, extension)| known(extension)).map_or(name, |(stem, _)| stem)
}

/// Possible paths of a picture that is named without its extension; none for one that is named with it.
fn extended(path: &Path) -> Vec<PathBuf> {
    let is_whole = path
        .extension()
        .is_some_and(|own| PICTURE_EXTENSIONS.iter().any(|known| own.eq_ignore_ascii_case(known)));
    if is_whole {
        return Vec::new();
    }
    let with = |extension: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(".");
        name.push(extension);
        PathBuf::from(name)
    };
    PICTURE_EXTENSIONS.map(with).to_vec()
}

/// Every place that pictures of a manifest are read from, whether or not there is a file.
///
/// # Errors
/// `Io` and `Invalid` where the manifest cannot be read.
pub fn picture_places(path: &Path) -> Result<Vec<PathBuf>> {
    let list = ViewList::read(path)?;
    Ok(places_of(&list.manifest, list.path.parent().unwrap_or(Path::new(""))))
}

/// Every place that the pictures of a manifest are read from, whose paths are relative to `folder`.
pub(crate) fn places_of(manifest: &Manifest, folder: &Path) -> Vec<PathBuf> {
    let mut pictures = Vec::new();
    let similar = SimilarNames::default();
    for entry in &manifest.frames {
        let spellings = entry.paths().flat_map(|name| [name.clone(), name.replace('\\', "/")]);
        for picture in spellings.map(|name| folder.join(name)) {
            pictures.extend(extended(&picture));
            if !picture.is_file() {
                pictures.extend(similar.file(folder, &picture));
            }
            pictures.push(picture);
        }
    }
    pictures
}
