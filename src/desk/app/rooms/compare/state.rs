//! What is compared with what, from where and how, and what came of it.

use std::sync::Arc;

use egui::{Color32, ColorImage, Rect, pos2};

use crate::app::colormap::{diverging, sequential};
use crate::app::model::picture::PictureZoom;
use crate::app::model::same::Same;
use crate::app::model::scene::OpenScene;
use crate::text::significant;
use overlook_engine::capture::TruthLoader;
use overlook_engine::capture::transforms::OtherPictures;
use overlook_engine::grid::Grid;
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::render::Vantage;
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::Settings;
use overlook_lab::metrics::ErrorClass;
use overlook_lab::rivals::Rival;

/// From where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum CompareVantage {
    /// The pose of the live view.
    Live,
    /// A vantage whose truth is known, by its place among those.
    Truth(usize),
    /// A camera, whose own samples are left out.
    HoldOut(usize),
}

/// What one side shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum CompareSide {
    Kept,
    Everything,
    AsClaimed,
    A,
    B,
    Before,
    Truth,
    Point,
    Block,
    Surfel,
    Gather,
    Cpu,
    Gpu,
    TriangleMesh,
    Tsdf,
    NearestCamera,
    LayeredDepthImage,
    /// What another program made: a [`PictureFolder`] by its number.
    Pictures(u64),
}

impl CompareSide {
    /// Every side that is always there, in the order of the list: name and what it is.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 17] = [
        (Self::Kept, "Kept samples", "After pruning, with the settings on the sliders."),
        (Self::Everything, "All samples", "Before pruning: every pixel of this frame."),
        (
            Self::AsClaimed,
            "Uncorrected poses and exposure",
            "After pruning, with poses, lens and exposure as the capture claims them.",
        ),
        (Self::A, "Settings A", "After pruning with settings A."),
        (Self::B, "Settings B", "After pruning with settings B."),
        (Self::Before, "Before the change", "After pruning with the settings before the last change."),
        (
            Self::Truth,
            "Truth",
            "What a camera recorded there; known at viewpoints with a true picture and at cameras that are held out.",
        ),
        (Self::Point, "Points", "The kept samples, one pixel each (the kernel point)."),
        (Self::Block, "2×2 blocks", "The kept samples, blended over 2×2 pixels (the kernel block)."),
        (Self::Surfel, "Surfels", "The kept samples as oriented footprints (the kernel surfel)."),
        (
            Self::Gather,
            "Interpolated cameras",
            "The kept samples, surface first and color second (the kernel gather).",
        ),
        (Self::Cpu, "CPU", "The kept samples, rendered by the CPU."),
        (Self::Gpu, "GPU", "The kept samples, rendered by the GPU."),
        (
            Self::TriangleMesh,
            "Triangle meshes",
            "All pixels as others show them: a mesh for each camera, blended by distance and stretch (RVS, 2018).",
        ),
        (
            Self::Tsdf,
            "TSDF volume",
            "All pixels as others show them: a volume of signed distances, ray-cast (Curless and Levoy, 1996).",
        ),
        (
            Self::NearestCamera,
            "Nearest camera",
            "The pixels of the nearest camera alone, carried to the viewpoint (McMillan and Bishop, 1995).",
        ),
        (
            Self::LayeredDepthImage,
            "Layered depth image",
            "All pixels as others show them: one picture with several samples along each ray (Shade et al., 1998).",
        ),
    ];

    pub(crate) fn rival(self) -> Option<Rival> {
        match self {
            Self::TriangleMesh => Some(Rival::TriangleMesh),
            Self::Tsdf => Some(Rival::Tsdf(4)),
            Self::NearestCamera => Some(Rival::NearestCamera),
            Self::LayeredDepthImage => Some(Rival::LayeredDepthImage),
            _ => None,
        }
    }
}

/// How the two are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum CompareMode {
    Wipe,
    Flip,
    Beside,
    Difference,
}

impl CompareMode {
    /// Every mode: name and what it does.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Wipe, "Wipe", "One over the other, cut at a line that is dragged."),
        (Self::Flip, "Flip", "One at a time: hold X for the other."),
        (Self::Beside, "Side by side", "The two beside each other, with one zoom."),
        (Self::Difference, "Difference", "Where and how much they differ."),
    ];
}

/// What the map of a difference shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) enum CompareMeasure {
    Steps,
    Brightness,
    Flip,
    Class,
    Flicker,
}

impl CompareMeasure {
    /// Every measure: name and what it shows.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 5] = [
        (Self::Steps, "Absolute", "The largest difference of a color channel, in 8-bit steps."),
        (
            Self::Brightness,
            "Signed",
            "Where the right side is brighter (orange) or darker (purple), in 8-bit steps of luma.",
        ),
        (
            Self::Flip,
            "FLIP",
            "The difference that a person sees when flipping between the two, from 0 to 1 (LDR-FLIP, 67 pixels per degree).",
        ),
        (
            Self::Class,
            "Where",
            "The absolute difference, colored by its place: on surfaces that no camera saw (pink), at edges of the truth (orange), \
             elsewhere (blue).",
        ),
        (
            Self::Flicker,
            "Flicker",
            "By how much the difference changes from the frame before to this one, in 8-bit steps: beside the truth, error that comes and \
             goes.",
        ),
    ];

    /// What the ends of the map's colors mean, where its upper end is at `range`.
    pub(crate) fn ends(self, range: f32) -> [String; 2] {
        let range = significant(f64::from(range));
        match self {
            Self::Steps | Self::Class | Self::Flicker => ["0".to_owned(), format!("{range} 8-bit steps")],
            Self::Brightness => [format!("darker −{range}"), format!("+{range} brighter, 8-bit steps")],
            Self::Flip => ["FLIP 0".to_owned(), range],
        }
    }

    /// The color of the map at a position from 0, its lower end, to 1.
    pub(crate) fn color(self, position: f32) -> Color32 {
        match self {
            Self::Brightness => diverging(2.0 * position - 1.0),
            _ => sequential(position),
        }
    }
}

/// Where differences lie, as [`CompareMeasure::Class`] colors them, and what that is called.
pub(crate) const CLASSES: [(ErrorClass, &str); 3] =
    [(ErrorClass::Unseen, "unseen"), (ErrorClass::Edge, "edge"), (ErrorClass::Inner, "inner")];

/// The compared sides, and the measure on the map of the difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompareChoice {
    pub sides: [CompareSide; 2],
    pub from: CompareVantage,
    pub measure: CompareMeasure,
    /// The difference at the map's upper end, in the unit of the measure; `None` to fit it.
    pub range: Option<f32>,
}

/// How the comparison looks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CompareLook {
    pub choice: CompareChoice,
    pub mode: CompareMode,
    /// Where the line is, as a share of the width.
    pub wipe: f32,
    pub part: PictureZoom,
    /// What of it is seen, as the view was drawn last.
    pub in_view: CompareInView,
}

/// What the view has of both pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompareInView {
    /// The part of the pictures that is in view, as shares of their size.
    pub part: Rect,
    /// Where the line of a wipe is, as a share of the pictures' width; beyond 0 and 1 it lies beside them.
    pub line: f32,
    /// Whether the right side stands in the place of the left one as long as a key is held.
    pub flipped: bool,
}

impl Default for CompareInView {
    fn default() -> Self {
        Self { part: Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), line: 0.5, flipped: false }
    }
}

impl Default for CompareLook {
    fn default() -> Self {
        let sides = [CompareSide::Everything, CompareSide::Kept];
        let (from, measure) = (CompareVantage::Live, CompareMeasure::Steps);
        let choice = CompareChoice { sides, from, measure, range: None };
        let (part, in_view) = (PictureZoom::default(), CompareInView::default());
        Self { choice, mode: CompareMode::Wipe, wipe: 0.5, part, in_view }
    }
}

/// What a comparison is made from; an equal key gives an equal comparison.
#[derive(Clone, PartialEq)]
pub(crate) struct CompareKey {
    pub scene: Arc<OpenScene>,
    pub choice: CompareChoice,
    /// Where the live view stands, and when.
    pub vantage: Vantage,
    /// The kept samples that the live view shows.
    pub samples: Same<SampleSet>,
    /// Whether those show every frame, and not only the one that the live view shows.
    pub whole: bool,
    /// The pass over all frames, where it is done.
    pub scan: Option<Same<PreparedScan>>,
    /// The settings on the sliders, A, B, and those before the last change.
    pub settings: [Settings; 4],
    pub pictures: Vec<PictureFolder>,
    /// Dark or light, as holes use a color of the theme.
    pub dark: bool,
}

pub(crate) struct ShownComparison {
    pub choice: CompareChoice,
    /// What its sides are called.
    pub names: [String; 2],
    pub comparison: PictureDifference,
    /// Left, right and difference on the graphics card.
    pub textures: [egui::TextureHandle; 3],
}

/// Displayed colors (0 to 255 a channel); `None` in holes.
pub(crate) type DisplayColors = Grid<Option<[u8; 3]>>;

/// Two pictures and their difference.
pub(crate) struct PictureDifference {
    /// The two sides, of one size, as they are compared: without the colors that fill holes.
    pub sides: [DisplayColors; 2],
    /// The two as shown: holes filled, or in a color of their own.
    pub images: [Arc<ColorImage>; 2],
    /// The map of where and how much they differ.
    pub difference: Arc<ColorImage>,
    pub measure: CompareMeasure,
    /// How far every pixel is apart, in the unit of the measure; `None` where a side has no sample.
    pub apart: Grid<Option<f32>>,
    /// The difference at the map's upper end.
    pub range: f32,
    /// Mean of the map, signs aside, where both sides have a sample.
    pub mean: f64,
    /// Peak signal-to-noise ratio of one side against the other where both have a sample; infinite where equal.
    pub psnr_db: f64,
    /// Structural similarity of luma where both have a sample, −1 to 1.
    pub ssim: f64,
    /// Root mean square change of the difference since the frame before, 8-bit steps; `None` where that is not measured.
    pub flicker_steps: Option<f64>,
    /// Shares of the squared difference where both have a sample: unseen, edge and inner; `None` where that is not measured.
    pub by_class: Option<[f64; 3]>,
    /// Share of pixels that only one side has a sample for.
    pub one_sided: f64,
}

/// Which pictures are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ShownSides {
    /// The left one, the right one or their difference, by its index.
    One(usize),
    /// The left one up to so many columns of the part in view, then the right one.
    Wiped(usize),
    Beside,
}

/// What a figure of a comparison is drawn from.
#[derive(Clone, Debug)]
pub(crate) struct ComparisonFigure {
    /// Left, right and their difference, of one size.
    pub images: [Arc<ColorImage>; 3],
    pub names: [String; 2],
    pub mode: CompareMode,
    pub in_view: CompareInView,
    pub measure: CompareMeasure,
    /// The difference at the map's upper end, in the unit of the measure.
    pub range: f32,
    /// Whether the map is that of the dark theme.
    pub dark: bool,
}

impl ComparisonFigure {
    pub(crate) fn of(compared: &ShownComparison, look: &CompareLook, dark: bool) -> Self {
        let comparison = &compared.comparison;
        let [left, right] = comparison.images.clone();
        Self {
            images: [left, right, comparison.difference.clone()],
            names: compared.names.clone(),
            mode: look.mode,
            in_view: look.in_view,
            measure: comparison.measure,
            range: comparison.range,
            dark,
        }
    }

    /// The part in view in pixels: the first column and row, columns and rows.
    pub(crate) fn part(&self) -> [usize; 4] {
        let [width, height] = self.images[0].size;
        let span = |from: f32, to: f32, side: usize| {
            let first = ((from * side as f32).floor().max(0.0) as usize).min(side.saturating_sub(1));
            let end = ((to * side as f32).ceil().max(0.0) as usize).clamp(first + 1, side.max(first + 1));
            (first, end - first)
        };
        let part = self.in_view.part;
        let (left, columns) = span(part.left(), part.right(), width);
        let (top, rows) = span(part.top(), part.bottom(), height);
        [left, top, columns, rows]
    }

    pub(crate) fn shown(&self) -> ShownSides {
        match self.mode {
            CompareMode::Difference => ShownSides::One(2),
            CompareMode::Beside => ShownSides::Beside,
            CompareMode::Flip | CompareMode::Wipe if self.in_view.flipped => ShownSides::One(1),
            CompareMode::Flip => ShownSides::One(0),
            CompareMode::Wipe => {
                let [left, _, columns, _] = self.part();
                let line = (self.in_view.line * self.images[0].size[0] as f32).round() - left as f32;
                if line <= 0.0 {
                    ShownSides::One(1)
                } else if line >= columns as f32 {
                    ShownSides::One(0)
                } else {
                    ShownSides::Wiped(line as usize)
                }
            }
        }
    }
}

/// A folder of pictures by another program.
#[derive(Clone)]
pub(crate) struct PictureFolder {
    /// Differs between any two folders that were ever opened.
    pub id: u64,
    /// Pictures of the viewpoints with truth, in their order; `None` without any.
    pub of_views: Option<Arc<OtherPictures>>,
    /// Pictures of every camera at every frame, camera by camera; `None` without any.
    pub of_cameras: Option<Arc<OtherPictures>>,
    pub frame_count: usize,
}

impl PartialEq for PictureFolder {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl PictureFolder {
    /// What is known of it: of viewpoints, or else of cameras.
    pub(crate) fn known(&self) -> impl Iterator<Item = &Arc<OtherPictures>> {
        self.of_views.iter().chain(&self.of_cameras)
    }

    /// The last part of its path.
    pub(crate) fn name(&self) -> String {
        self.known().next().map(|pictures| pictures.name()).unwrap_or_default()
    }

    /// Its path, and how its pictures were found.
    pub(crate) fn words(&self) -> String {
        let parts = [(&self.of_views, "viewpoints"), (&self.of_cameras, "frames of cameras")];
        let words = |(pictures, of): (&Option<Arc<OtherPictures>>, &str)| {
            let pictures = pictures.as_ref()?;
            let (count, all, by) = (pictures.count(), pictures.pictures.len(), pictures.matched_by);
            Some(format!("{count} of {all} {of}, matched by {by}"))
        };
        let parts: Vec<String> = parts.into_iter().filter_map(words).collect();
        let folder = self.known().next().map(|pictures| pictures.folder.display().to_string());
        format!("{}: pictures of {}.", folder.unwrap_or_default(), parts.join("; and of "))
    }

    /// The picture of a viewpoint at a frame, or a sentence on why it is missing.
    pub(crate) fn picture(&self, from: CompareVantage, frame: usize) -> Result<TruthLoader, String> {
        let (pictures, index) = match from {
            CompareVantage::Live => (None, 0),
            CompareVantage::Truth(index) => (self.of_views.as_ref(), index),
            CompareVantage::HoldOut(camera) => (self.of_cameras.as_ref(), camera * self.frame_count + frame),
        };
        let Some(picture) = pictures.and_then(|pictures| pictures.pictures.get(index)) else {
            let views = self.of_views.iter().map(|_| "viewpoints with true pictures");
            let known = views.chain(self.of_cameras.iter().map(|_| "cameras that are held out"));
            let known = known.collect::<Vec<_>>().join(" and ");
            let name = self.name();
            return Err(format!("{name} has pictures of {known} alone: choose one in the last list above."));
        };
        picture.clone().map_err(|reason| format!("{} {reason}.", self.name()))
    }

    /// The first viewpoint that it has a picture of, at a frame where it is a camera's.
    pub(crate) fn first(&self, frame: usize) -> Option<CompareVantage> {
        let known = |pictures: &Option<Arc<OtherPictures>>| -> Vec<usize> {
            let all = pictures.iter().flat_map(|it| it.pictures.iter().enumerate());
            all.filter(|(_, picture)| picture.is_ok()).map(|(index, _)| index).collect()
        };
        if let Some(view) = known(&self.of_views).first() {
            return Some(CompareVantage::Truth(*view));
        }
        let frames = self.frame_count.max(1);
        let of_cameras = known(&self.of_cameras);
        let here = of_cameras.iter().find(|index| *index % frames == frame);
        here.or(of_cameras.first()).map(|index| CompareVantage::HoldOut(index / frames))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::capture::transforms::MatchedBy;

    /// A folder with pictures of the second of two viewpoints and of the second of two cameras at the first of three frames.
    fn folder() -> PictureFolder {
        let pictures = |known: usize, all: usize| {
            let load: TruthLoader = Arc::new(|| Err(overlook_engine::error::Error::Cancelled));
            let of =
                |index: usize| if index == known { Ok(load.clone()) } else { Err(format!("lacks {index}")) };
            Some(Arc::new(OtherPictures {
                folder: "/made/rvs".into(),
                matched_by: MatchedBy::FileName,
                pictures: (0..all).map(of).collect(),
                left_over: Vec::new(),
            }))
        };
        PictureFolder { id: 1, of_views: pictures(1, 2), of_cameras: pictures(3, 6), frame_count: 3 }
    }

    #[test]
    fn a_folder_says_what_it_has_pictures_of_and_what_it_lacks() {
        let folder = folder();
        assert!(folder.picture(CompareVantage::Truth(1), 0).is_ok());
        assert!(folder.picture(CompareVantage::HoldOut(1), 0).is_ok());
        let trouble = |from, frame| folder.picture(from, frame).err().unwrap();
        assert_eq!(trouble(CompareVantage::Truth(0), 0), "rvs lacks 0.");
        assert_eq!(trouble(CompareVantage::HoldOut(1), 2), "rvs lacks 5.");
        assert!(trouble(CompareVantage::Live, 0).contains(
            "rvs has pictures of viewpoints with true pictures and cameras that are held out alone"
        ));
        assert_eq!(folder.first(2), Some(CompareVantage::Truth(1)));
        let words = folder.words();
        assert!(
            words.contains("1 of 2 viewpoints, matched by file name; and of 1 of 6 frames of cameras"),
            "{words}"
        );
        let cameras = PictureFolder { of_views: None, ..folder };
        assert_eq!(cameras.first(2), Some(CompareVantage::HoldOut(1)));
    }
}
