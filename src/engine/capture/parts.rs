//! A capture: its facts, its frames on demand, and views whose true pictures are known.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::camera::Camera;
use super::depth_claim::DepthClaim;
use super::frame::{Frame, FrameCache};
use super::pose_convention::PoseConvention;
use super::values::ValueChannel;
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::plural::counted;

/// Where the frames of a capture come from: files, or a scene that is rendered on demand.
pub trait FrameSource: Send + Sync {
    /// Decodes or renders one frame. Called from many threads at once.
    ///
    /// # Errors
    /// Name the file and the frame, with advice.
    fn load(&self, camera: usize, frame: usize) -> Result<Frame>;

    /// Where the frame comes from, for messages: a path, or the scene's name and frame.
    fn place(&self, camera: usize, frame: usize) -> String;

    /// Pixels of a frame that are no samples because its picture is transparent there; `None` where it has no alpha channel, or that
    /// says nothing or is not used.
    ///
    /// # Errors
    /// As [`FrameSource::load`].
    fn transparent_pixels(&self, _camera: usize, _frame: usize) -> Result<Option<usize>> {
        Ok(None)
    }

    /// Whether frames are numbered by the order of times that are fractions.
    fn frames_are_ranked(&self) -> bool {
        false
    }

    /// How the numbers of depth files were read.
    fn depth_claim(&self) -> DepthClaim {
        DepthClaim::default()
    }

    /// Whether the source says that color and depth have no noise, as those of rasterizers: what differs is no noise then. Sources that
    /// change frames may add some, and do not say so.
    fn is_noise_free(&self) -> bool {
        false
    }

    /// Whether a program made the frames, so that poses, lenses, colors and times are exact: by the source's own word. `None` where it
    /// leaves that open, and depth has to show it.
    fn is_rendered(&self) -> Option<bool> {
        Some(false)
    }

    /// The channels of scalar values that every frame has; none as a rule.
    fn value_channels(&self) -> &[ValueChannel] {
        &[]
    }

    /// What the matrices of the poses were taken for.
    fn pose_convention(&self) -> PoseConvention {
        PoseConvention::default()
    }

    /// Lets go of what it holds of frames, beside the capture's own cache.
    fn forget_frames(&self) {}

    /// The files that the frame is read from; none where it is rendered.
    fn files(&self, _camera: usize, _frame: usize) -> Vec<PathBuf> {
        Vec::new()
    }
}

/// What is known of a capture, and where its frames come from.
#[derive(Clone)]
pub struct CaptureParts {
    /// Name for titles: the folder's, or the scene's.
    pub name: String,
    /// The cameras, in the order that ties are settled by.
    pub cameras: Vec<Camera>,
    /// The number each frame bears in the capture (`time` in the manifest), ascending; as many as there are frames.
    pub frame_numbers: Vec<i64>,
    /// Up in world space, unit length.
    pub up_in_world: DVec3,
    /// Whether the capture gives normals.
    pub has_normals: bool,
    /// Whether color is filtered across silhouettes (depth never is).
    pub antialiased_color: bool,
    /// Recoverable trouble met while opening, one line each.
    pub warnings: Vec<String>,
    /// Where frames come from.
    pub source: Arc<dyn FrameSource>,
}

/// A capture: its [`CaptureParts`], which it dereferences to, and a bounded cache of decoded frames.
///
/// Cloning is cheap; clones share frames and cache.
#[derive(Clone)]
pub struct Capture {
    parts: CaptureParts,
    cache: Arc<FrameCache>,
    /// Index of each camera in the source: differs from its own index where cameras are held out.
    source_cameras: Vec<usize>,
}

impl std::ops::Deref for Capture {
    type Target = CaptureParts;

    fn deref(&self) -> &CaptureParts {
        &self.parts
    }
}

impl Capture {
    /// Wraps a source of frames with a cache of at most `cache_bytes` of decoded frames.
    #[must_use]
    pub fn new(parts: CaptureParts, cache_bytes: usize) -> Self {
        let source_cameras = (0..parts.cameras.len()).collect();
        Self { parts, cache: Arc::new(FrameCache::new(cache_bytes)), source_cameras }
    }

    /// Frames per camera.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.frame_numbers.len()
    }

    /// Pixels of all frames of all cameras.
    #[must_use]
    pub fn pixel_count(&self) -> u64 {
        let per_frame: usize = self.cameras.iter().map(|c| c.intrinsics.pixel_count()).sum();
        per_frame as u64 * self.frame_count() as u64
    }

    /// One frame of one camera, from the cache or its source.
    ///
    /// # Errors
    /// Whatever the source gives (naming file and frame), and [`Error::Invalid`] where the frame's size is not the
    /// camera's.
    pub fn frame(&self, camera: usize, frame: usize) -> Result<Arc<Frame>> {
        let source_camera = self.source_cameras[camera];
        let loaded =
            self.cache.get_or_load((source_camera, frame), || self.source.load(source_camera, frame))?;
        let expected = self.cameras[camera].intrinsics.size();
        if loaded.size() != expected {
            let (width, height) = loaded.size();
            let what = format!(
                "the picture is {width}×{height} but camera '{}' is {}×{}; every frame of a camera must have the same size",
                self.cameras[camera].name, expected.0, expected.1
            );
            return Err(Error::invalid(self.place(camera, frame), what));
        }
        let (given, channels) = (loaded.values.channels(), self.value_channels().len());
        if given != channels
            || loaded.values.len() != if channels > 0 { loaded.inverse_depth.len() } else { 0 }
        {
            let what =
                format!("it has {} of values where the capture has {channels}", counted(given, "channel"));
            return Err(Error::invalid(self.place(camera, frame), what));
        }
        Ok(loaded)
    }

    /// Lets go of all decoded frames, for work that needs the memory and few of them. They are decoded again when they are asked for.
    pub(crate) fn forget_frames(&self) {
        self.cache.clear();
        self.source.forget_frames();
    }

    /// Pixels of a frame that are no samples because they are transparent, as [`FrameSource::transparent_pixels`].
    ///
    /// # Errors
    /// As [`FrameSource::load`].
    pub fn transparent_pixels(&self, camera: usize, frame: usize) -> Result<Option<usize>> {
        self.source.transparent_pixels(self.source_cameras[camera], frame)
    }

    /// The share of the pixels that are no samples because they are transparent, in the middle frame of some cameras; `None` where no
    /// picture of these has an alpha channel that counts.
    ///
    /// # Errors
    /// As [`FrameSource::load`].
    pub fn transparent_share(&self) -> Result<Option<f64>> {
        /// Pictures that are looked at, at most.
        const SOME: usize = 24;
        let cameras = self.cameras.len();
        let some = cameras.min(SOME);
        let of_camera = |index: usize| {
            let camera = index * cameras / some;
            let pixels = self.cameras[camera].intrinsics.pixel_count();
            Ok(self.transparent_pixels(camera, self.frame_count() / 2)?.map(|count| (count, pixels)))
        };
        let counts: Vec<Option<(usize, usize)>> =
            (0..some).into_par_iter().map(of_camera).collect::<Result<_>>()?;
        let sum = counts.into_iter().flatten().reduce(|a, b| (a.0 + b.0, a.1 + b.1));
        Ok(sum.map(|(transparent, pixels)| transparent as f64 / pixels.max(1) as f64))
    }

    /// Where a frame comes from, for messages.
    #[must_use]
    pub fn place(&self, camera: usize, frame: usize) -> String {
        self.source.place(self.source_cameras[camera], frame)
    }

    /// The files that one frame is read from.
    #[must_use]
    pub fn files_of(&self, camera: usize, frame: usize) -> Vec<PathBuf> {
        self.source.files(self.source_cameras[camera], frame)
    }

    /// Name of a frame's picture, as [`TruthView::picture`]; `None` if it is in no file.
    #[must_use]
    pub fn picture_stem(&self, camera: usize, frame: usize) -> Option<String> {
        self.files_of(camera, frame).first().and_then(|file| stem_of(file))
    }

    /// Every file that a frame is read from, each once.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        let frames = 0..self.frame_count();
        let of_camera =
            |&camera: &usize| frames.clone().flat_map(move |frame| self.source.files(camera, frame));
        let files: std::collections::BTreeSet<_> = self.source_cameras.iter().flat_map(of_camera).collect();
        files.into_iter().collect()
    }

    /// Whether the frame numbers are the order of times that are fractions, as nerfstudio's 0 to 1.
    #[must_use]
    pub fn frames_are_ranked(&self) -> bool {
        self.source.frames_are_ranked()
    }

    /// Whether color and depth are known to have no noise.
    #[must_use]
    pub fn is_noise_free(&self) -> bool {
        self.source.is_noise_free()
    }

    /// The channels of scalar values that every frame has.
    #[must_use]
    pub fn value_channels(&self) -> &[ValueChannel] {
        self.source.value_channels()
    }

    /// The index of the frame that bears `number`, or `None`.
    #[must_use]
    pub fn frame_index(&self, number: i64) -> Option<usize> {
        self.frame_numbers.binary_search(&number).ok()
    }

    /// The same capture with only the cameras for which `keep` is true, sharing frames and cache: for hold-outs.
    #[must_use]
    pub fn with_cameras(&self, mut keep: impl FnMut(usize, &Camera) -> bool) -> Self {
        let kept: Vec<usize> =
            (0..self.cameras.len()).filter(|&index| keep(index, &self.cameras[index])).collect();
        let cameras = kept.iter().map(|&index| self.cameras[index].clone()).collect();
        Self {
            parts: CaptureParts { cameras, ..self.parts.clone() },
            source_cameras: kept.iter().map(|&index| self.source_cameras[index]).collect(),
            ..self.clone()
        }
    }

    /// The same capture with cameras that claim something else, sharing frames and cache. `change` is given each camera and its index.
    /// [`Capture::frame`] refuses the frames of a camera that gets another size.
    #[must_use]
    pub fn with_changed_cameras(mut self, mut change: impl FnMut(usize, &mut Camera)) -> Self {
        for (index, camera) in self.parts.cameras.iter_mut().enumerate() {
            change(index, camera);
        }
        self
    }

    /// The same capture with these numbers for its first frames, ascending; frames beyond them are left out. The source must have as
    /// many frames as there are numbers.
    #[must_use]
    pub fn with_frame_numbers(mut self, numbers: Vec<i64>) -> Self {
        self.parts.frame_numbers = numbers;
        self
    }

    /// The same capture with one more [warning](CaptureParts::warnings).
    #[must_use]
    pub fn with_warning(mut self, warning: String) -> Self {
        self.parts.warnings.push(warning);
        self
    }

    /// The same capture, marked as one without normals.
    #[must_use]
    pub fn without_normals(mut self) -> Self {
        self.parts.has_normals = false;
        self
    }

    /// The same capture, marked as one whose color is, or is not, filtered across silhouettes.
    #[must_use]
    pub fn with_antialiased_color(mut self, antialiased_color: bool) -> Self {
        self.parts.antialiased_color = antialiased_color;
        self
    }
}

/// The name of a file without folder and extension.
pub(super) fn stem_of(file: &Path) -> Option<String> {
    file.file_stem().map(|stem| stem.to_string_lossy().into_owned())
}

/// Loads the true picture of a [`TruthView`].
pub type TruthLoader = Arc<dyn Fn() -> Result<Frame> + Send + Sync>;

/// A vantage to be rendered, with its true picture if that is known.
#[derive(Clone)]
pub struct TruthView {
    /// Name of the picture, relative, with its extension as the manifest has it.
    pub file_path: String,
    /// Where from.
    pub camera: Camera,
    /// Number of the frame, as in [`CaptureParts::frame_numbers`].
    pub frame_number: i64,
    /// The true picture, if it is known.
    pub truth: Option<TruthLoader>,
    /// Name of the recorded picture's file without folder and extension, which has its place in a sequence. `None` if it is in no file.
    pub picture: Option<String>,
    /// What colors of the capture are multiplied with to look as this view was exposed, per channel of linear color.
    pub gain: [f32; 3],
}

impl TruthView {
    /// A view exposed as the capture's cameras, with its picture in no file.
    #[must_use]
    pub fn new(file_path: String, camera: Camera, frame_number: i64, truth: Option<TruthLoader>) -> Self {
        Self { file_path, camera, frame_number, truth, picture: None, gain: [1.0; 3] }
    }

    /// Exposes colors of the capture, linear, as this view was.
    pub fn expose(&self, colors: &mut Grid<[f32; 3]>) {
        if self.gain != [1.0; 3] {
            for color in colors.as_mut_slice() {
                *color = std::array::from_fn(|channel| color[channel] * self.gain[channel]);
            }
        }
    }
}

impl std::fmt::Debug for Capture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Capture")
            .field("name", &self.name)
            .field("cameras", &self.cameras)
            .field("frames", &self.frame_count())
            .finish_non_exhaustive()
    }
}

/// Pictures that are not read, for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// How many.
    pub count: usize,
    /// Why.
    pub reason: String,
    /// The first of them.
    pub first: String,
}

impl Skipped {
    /// Notes one more picture that is left out.
    pub(crate) fn note(all: &mut Vec<Self>, reason: impl Into<String>, name: impl Into<String>) {
        let reason = reason.into();
        match all.iter_mut().find(|skipped| skipped.reason == reason) {
            Some(skipped) => skipped.count += 1,
            None => all.push(Self { count: 1, reason, first: name.into() }),
        }
    }

    /// In words.
    #[must_use]
    pub fn line(&self) -> String {
        format!("left out: {} {} (first: {})", self.count, self.reason, self.first)
    }
}
