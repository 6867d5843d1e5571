//! How far two pictures of one place are apart, as a display shows both: a map, and figures.

use std::sync::Arc;

use egui::{Color32, ColorImage};

use crate::app::colormap::{diverging, opaque, sequential};
use crate::app::model::{Content, OpenScene};
use crate::app::rooms::compare::state::{
    CompareKey, CompareMeasure, CompareVantage, DisplayColors, PictureDifference,
};
use crate::app::theme::Tokens;
use overlook_engine::capture::{Capture, Frame, TruthView};
use overlook_engine::color::{linear_from_srgb, srgb8_from_linear, steps_from_linear};
use overlook_engine::error::{Error, Result};
use overlook_engine::grid::Grid;
use overlook_engine::render::{NO_IMAGE, Picture, Vantage};
use overlook_lab::metrics::{self, ClassMap, DEFAULT_PIXELS_PER_DEGREE, flip, ssim};
use overlook_lab::truth::ViewCorrections;

/// Share of pixels that may differ by more than a fitted range.
const BEYOND: f32 = 0.01;

/// One side as displayed.
#[derive(Clone)]
pub(crate) struct DisplayedSide {
    /// `None` in holes that were not filled.
    pub shown: DisplayColors,
    /// The compared colors; `None` in all holes, since colors that fill them were not recorded.
    pub known: DisplayColors,
}

/// What a camera recorded, as displayed.
pub(crate) fn of_frame(frame: &Frame) -> DisplayedSide {
    let shown =
        frame.color.map(|color| Some(color.map(|c| steps_from_linear(c).clamp(0.0, 255.0).round() as u8)));
    DisplayedSide { known: shown.clone(), shown }
}

/// What was painted, as displayed.
pub(crate) fn of_picture(picture: &Picture) -> DisplayedSide {
    let colors_where = |wanted: &dyn Fn((usize, usize)) -> bool| {
        Grid::from_fn(picture.color.width(), picture.color.height(), |x, y| {
            wanted((x, y)).then(|| picture.color[(x, y)].map(srgb8_from_linear))
        })
    };
    DisplayedSide {
        shown: colors_where(&|at| picture.shows(at)),
        known: colors_where(&|at| picture.image[at] != NO_IMAGE),
    }
}

/// A side as it is displayed, as a picture.
pub(crate) fn as_picture(side: &DisplayedSide) -> Picture {
    let mut picture = Picture::empty(side.shown.width(), side.shown.height());
    picture.color = side
        .shown
        .map(|pixel| pixel.unwrap_or_default().map(|step| linear_from_srgb(f32::from(step) / 255.0)));
    // What is shown is no hole, and its depth is not known.
    picture.inverse_depth = side.shown.map(|pixel| if pixel.is_some() { 0.0 } else { -1.0 });
    picture
}

/// Compares two sides. `range` is the difference at the map's upper end; `None` fits it. `Invalid` where the sides differ in size.
pub(crate) fn between(
    sides: [DisplayedSide; 2],
    measure: CompareMeasure,
    range: Option<f32>,
    dark: bool,
) -> Result<PictureDifference> {
    let [
        DisplayedSide { shown: shown_left, known: left },
        DisplayedSide { shown: shown_right, known: right },
    ] = sides;
    if left.size() != right.size() {
        let ((a, b), (c, d)) = (left.size(), right.size());
        return Err(refused(format!(
            "One side has {a}×{b} pixels and the other {c}×{d}: they cannot be laid over each other."
        )));
    }
    let tokens = Tokens::of(dark);
    let apart = apart(&left, &right, measure);
    let range = range.unwrap_or_else(|| fitted(&apart, measure));
    let color = |apart: f32| match measure {
        CompareMeasure::Brightness => diverging(apart / range),
        _ => sequential(apart / range),
    };
    let one_sided = pairs(&left, &right).filter(|(a, b)| a.is_some() != b.is_some()).count();
    Ok(PictureDifference {
        images: [shown_left, shown_right].map(|shown| image_of(&shown, tokens.hole, opaque)),
        // A gray, which no color of the maps is: the holes' own purple is near their lower end.
        difference: image_of(&apart, tokens.raised, color),
        measure,
        range,
        mean: mean_of(&apart),
        apart,
        psnr_db: psnr_db(&left, &right),
        ssim: similarity(&left, &right),
        flicker_steps: None,
        by_class: None,
        one_sided: one_sided as f64 / left.len().max(1) as f64,
        sides: [left, right],
    })
}

/// Pixels as an image, unknown ones in a color of their own.
fn image_of<T: Copy>(
    pixels: &Grid<Option<T>>,
    unknown: Color32,
    color: impl Fn(T) -> Color32,
) -> Arc<ColorImage> {
    let colors = pixels.map(|pixel| pixel.map_or(unknown, &color));
    Arc::new(ColorImage::new(pixels.size().into(), colors.into_vec()))
}

/// Mean of how far pixels are apart, signs aside.
fn mean_of(apart: &Grid<Option<f32>>) -> f64 {
    let known = || apart.as_slice().iter().flatten();
    known().map(|apart| f64::from(apart.abs())).sum::<f64>() / known().count().max(1) as f64
}

/// Compares two sides by how their difference changes from the frame `before` to the one `now`, where both have a sample at both:
/// at each pixel that of the channel where it changes most, 8-bit steps. `Invalid` where sizes differ.
pub(crate) fn flicker(
    [before, now]: [[DisplayedSide; 2]; 2],
    range: Option<f32>,
    dark: bool,
) -> Result<PictureDifference> {
    let measure = CompareMeasure::Flicker;
    let [before_left, before_right] = before.map(|side| side.known);
    let compared = between(now, CompareMeasure::Steps, None, dark)?;
    let [left, right] = &compared.sides;
    if [&before_left, &before_right].iter().any(|side| side.size() != left.size()) {
        return Err(refused("The pictures of the frame before have another size."));
    }
    let (mut squares, mut count) = (0.0, 0_u64);
    let apart = Grid::from_fn(left.width(), left.height(), |x, y| {
        let at = (x, y);
        let [a, b, c, d] = [left[at]?, right[at]?, before_left[at]?, before_right[at]?];
        let change: [f32; 3] = std::array::from_fn(|channel| {
            let [a, b, c, d] = [a, b, c, d].map(|color| f32::from(color[channel]));
            ((a - b) - (c - d)).abs()
        });
        squares += change.iter().map(|change| f64::from(change * change)).sum::<f64>();
        count += 3;
        change.into_iter().reduce(f32::max)
    });
    let range = range.unwrap_or_else(|| fitted(&apart, measure));
    let difference = image_of(&apart, Tokens::of(dark).raised, |apart| sequential(apart / range));
    let flicker_steps = (count > 0).then(|| (squares / count as f64).sqrt());
    let mean = mean_of(&apart);
    Ok(PictureDifference { difference, measure, apart, range, mean, flicker_steps, ..compared })
}

/// Colors the map of a comparison by the class of each pixel, and computes the share of each class. `Invalid` if sizes differ.
pub(crate) fn by_class(
    compared: PictureDifference,
    classes: &ClassMap,
    dark: bool,
) -> Result<PictureDifference> {
    if classes.size() != compared.apart.size() {
        return Err(refused("The truth has another size than the pictures."));
    }
    let raised = Tokens::of(dark).raised;
    let mut squares = [0.0; 3];
    let both = pairs(&compared.sides[0], &compared.sides[1]).zip(compared.apart.as_slice());
    let colors = both.zip(classes.as_slice()).map(|((pair, apart), class)| {
        let Some(class) = class else { return raised };
        if let (Some(left), Some(right)) = pair {
            squares[*class as usize] += squared(left, right);
        }
        let strength = apart.map_or(0.0, |apart| (apart / compared.range).clamp(0.0, 1.0).sqrt());
        Color32::BLACK.lerp_to_gamma(opaque(class.color()), strength)
    });
    let difference = Arc::new(ColorImage::new(classes.size().into(), colors.collect()));
    let all: f64 = squares.iter().sum();
    let by_class = (all > 0.0).then(|| squares.map(|of_class| of_class / all));
    Ok(PictureDifference { difference, by_class, ..compared })
}

fn pairs<'a>(
    left: &'a DisplayColors,
    right: &'a DisplayColors,
) -> impl Iterator<Item = (Option<[u8; 3]>, Option<[u8; 3]>)> + 'a {
    left.as_slice().iter().copied().zip(right.as_slice().iter().copied())
}

/// Sum of the squared differences of the channels of two colors.
fn squared(left: [u8; 3], right: [u8; 3]) -> f64 {
    (0..3).map(|c| f64::from(left[c].abs_diff(right[c])).powi(2)).sum()
}

/// A side with the colors of the other where it has none, from 0 to 1 a channel: what one side alone shows differs by nothing.
fn completed<T>(own: &DisplayColors, other: &DisplayColors, of: impl Fn([f32; 3]) -> T) -> Grid<T> {
    let colors = pairs(own, other).map(|(own, other)| own.or(other).unwrap_or_default());
    let values = colors.map(|color| of(color.map(|step| f32::from(step) / 255.0)));
    Grid::from_vec(own.width(), own.height(), values.collect())
}

/// How far each pixel of the right is from the left.
fn apart(left: &DisplayColors, right: &DisplayColors, measure: CompareMeasure) -> Grid<Option<f32>> {
    let both = |of: &dyn Fn([u8; 3], [u8; 3]) -> f32| {
        let values = pairs(left, right).map(|(a, b)| Some(of(a?, b?)));
        Grid::from_vec(left.width(), left.height(), values.collect())
    };
    match measure {
        CompareMeasure::Steps | CompareMeasure::Class | CompareMeasure::Flicker => {
            both(&|a, b| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0).into())
        }
        CompareMeasure::Brightness => both(&|a, b| luma(b) - luma(a)),
        CompareMeasure::Flip => {
            let linear = |own, other| completed(own, other, |color| color.map(linear_from_srgb));
            let map = flip(&linear(right, left), &linear(left, right), DEFAULT_PIXELS_PER_DEGREE);
            let known = pairs(left, right).zip(map.as_slice());
            let values = known.map(|((a, b), flip)| a.and(b).map(|_| *flip));
            Grid::from_vec(left.width(), left.height(), values.collect())
        }
    }
}

/// Luma of displayed colors (Rec. 709), 8-bit steps.
fn luma([r, g, b]: [u8; 3]) -> f32 {
    0.2126 * f32::from(r) + 0.7152 * f32::from(g) + 0.0722 * f32::from(b)
}

/// A range that holds nearly all differences.
fn fitted(apart: &Grid<Option<f32>>, measure: CompareMeasure) -> f32 {
    let mut sorted: Vec<f32> = apart.as_slice().iter().flatten().map(|apart| apart.abs()).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let most = sorted.get((sorted.len() as f32 * (1.0 - BEYOND)) as usize).copied().unwrap_or(0.0);
    let least = if measure == CompareMeasure::Flip { 0.01 } else { 1.0 };
    most.max(least)
}

fn psnr_db(left: &DisplayColors, right: &DisplayColors) -> f64 {
    let (mut squares, mut count) = (0.0, 0_u64);
    for (a, b) in pairs(left, right).filter_map(|(a, b)| a.zip(b)) {
        squares += squared(a, b);
        count += 3;
    }
    10.0 * (255.0 * 255.0 * count.max(1) as f64 / squares).log10()
}

/// Structural similarity of luma over pixels with a sample on both sides; elsewhere the sides count as equal.
fn similarity(left: &DisplayColors, right: &DisplayColors) -> f64 {
    let of = |own, other| completed(own, other, |encoded| metrics::luma(&encoded));
    let counts = |x: usize, y: usize| left[(x, y)].is_some() && right[(x, y)].is_some();
    ssim(&of(left, right), &of(right, left), counts)
}

/// A viewpoint at a frame, and the frame that was recorded there where it is known.
pub(crate) struct Viewpoint {
    pub(crate) from: CompareVantage,
    pub(crate) vantage: Vantage,
    pub(crate) truth: Option<Arc<Frame>>,
    /// The recorded view, where its exposure may be another than the capture's.
    view: Option<TruthView>,
}

impl Viewpoint {
    /// The chosen viewpoint. `frame` counts for viewpoints that exist at every frame. `Invalid` if the scene has no such viewpoint.
    pub(crate) fn of(key: &CompareKey, from: CompareVantage, frame: usize) -> Result<Self> {
        match from {
            CompareVantage::Live => {
                let vantage = Vantage { camera: key.vantage.camera.clone(), frame };
                Ok(Self { from, vantage, truth: None, view: None })
            }
            CompareVantage::HoldOut(camera) => {
                let capture = corrected_capture(key)?;
                let there = capture.cameras.get(camera).ok_or_else(|| refused("there is no such camera"))?;
                let vantage = Vantage { camera: there.clone(), frame };
                Ok(Self { from, vantage, truth: Some(capture.frame(camera, frame)?), view: None })
            }
            CompareVantage::Truth(index) => {
                let capture = capture_of(&key.scene)?;
                let views = views_with_truth(&key.scene)?;
                let view = *views.get(index).ok_or_else(|| refused("there is no such viewpoint"))?;
                let mut view = view.clone();
                if let Some(alignment) = key.scan.as_ref().and_then(|scan| scan.alignment()) {
                    ViewCorrections::of(alignment).correct(std::slice::from_mut(&mut view));
                }
                let frame = capture.frame_index(view.frame_number).ok_or_else(|| {
                    Error::invalid(&view.file_path, format!("there is no frame {}", view.frame_number))
                })?;
                let truth = view.truth.as_ref().map(|load| load()).transpose()?.map(Arc::new);
                let vantage = Vantage { camera: view.camera.clone(), frame };
                Ok(Self { from, vantage, truth, view: Some(view) })
            }
        }
    }

    /// This viewpoint at the frame before, or at the last earlier frame with truth; `Invalid` at the first.
    pub(crate) fn before(&self, key: &CompareKey) -> Result<Self> {
        let first = || {
            refused(
                "Flicker is between two frames, and there is none before this one: go to a later frame or viewpoint.",
            )
        };
        if let CompareVantage::Truth(index) = self.from {
            let views = views_with_truth(&key.scene)?;
            let here = views.get(index).ok_or_else(first)?;
            let is_earlier =
                |view: &TruthView| view.camera == here.camera && view.frame_number < here.frame_number;
            let earlier = views.iter().enumerate().filter(|(_, view)| is_earlier(view));
            let (index, _) = earlier.max_by_key(|(_, view)| view.frame_number).ok_or_else(first)?;
            return Self::of(key, CompareVantage::Truth(index), 0);
        }
        Self::of(key, self.from, self.vantage.frame.checked_sub(1).ok_or_else(first)?)
    }

    /// This view at the pose that its file claims; `None` for the live view.
    pub(crate) fn as_claimed(&self, key: &CompareKey) -> Option<Self> {
        let camera = match self.from {
            CompareVantage::Live => return None,
            CompareVantage::HoldOut(camera) => capture_of(&key.scene).ok()?.cameras.get(camera)?.clone(),
            CompareVantage::Truth(index) => views_with_truth(&key.scene).ok()?.get(index)?.camera.clone(),
        };
        let vantage = Vantage { camera, frame: self.vantage.frame };
        Some(Self { from: self.from, vantage, truth: None, view: None })
    }

    /// Exposes a picture as what was recorded there.
    pub(crate) fn expose(&self, picture: &mut Picture) {
        if let Some(view) = &self.view {
            view.expose(&mut picture.color);
        }
    }
}

fn views_with_truth(scene: &OpenScene) -> Result<Vec<&TruthView>> {
    let Content::Capture { truth, .. } = &scene.content else {
        return Err(refused("a store has no viewpoints with true pictures"));
    };
    Ok(truth.iter().filter(|view| view.truth.is_some()).collect())
}

/// Why two sides cannot be compared.
pub(crate) fn refused(reason: impl Into<String>) -> Error {
    Error::invalid("comparison", reason)
}

pub(crate) fn unknown_truth() -> Error {
    refused(
        "The truth is known only at viewpoints with a true picture and at cameras that are held out: choose one in the last list above.",
    )
}

/// The camera whose place the comparison is made from, so that its own samples are left out.
pub(crate) fn left_out(key: &CompareKey) -> Option<usize> {
    if let CompareVantage::HoldOut(camera) = key.choice.from { Some(camera) } else { None }
}

pub(crate) fn cameras_left(key: &CompareKey) -> Result<Capture> {
    let left_out = left_out(key);
    Ok(corrected_capture(key)?.with_cameras(|index, _| Some(index) != left_out))
}

pub(crate) fn capture_of(scene: &OpenScene) -> Result<&Capture> {
    let stored = "A store holds no source frames to compare with: open the capture it was made from.";
    scene.capture().ok_or_else(|| refused(stored))
}

/// The capture as it is shown: with corrected cameras, once the corrections are known.
pub(crate) fn corrected_capture(key: &CompareKey) -> Result<&Capture> {
    let recorded = capture_of(&key.scene)?;
    Ok(key.scan.as_ref().map_or(recorded, |scan| scan.capture()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_lab::metrics::ErrorClass;

    fn side(pixels: [Option<u8>; 4]) -> DisplayedSide {
        let known = Grid::from_vec(4, 1, pixels.map(|gray| gray.map(|gray| [gray; 3])).to_vec());
        DisplayedSide { shown: known.clone(), known }
    }

    fn compared(measure: CompareMeasure) -> PictureDifference {
        let sides =
            [side([Some(10), Some(200), None, Some(50)]), side([Some(30), Some(190), Some(9), Some(50)])];
        between(sides, measure, None, true).unwrap()
    }

    #[test]
    fn brightness_tells_which_side_is_brighter_and_steps_how_far_they_are_apart() {
        let steps = compared(CompareMeasure::Steps);
        assert_eq!(steps.apart.as_slice(), [Some(20.0), Some(10.0), None, Some(0.0)]);
        assert_eq!((steps.range, steps.mean, steps.one_sided), (20.0, 10.0, 0.25));
        assert!(steps.ssim < 1.0);
        assert!((steps.psnr_db - 10.0 * (255.0_f64.powi(2) / (500.0 / 3.0)).log10()).abs() < 1e-9);
        let brightness = compared(CompareMeasure::Brightness);
        let signed: Vec<_> = brightness.apart.as_slice().iter().map(|apart| apart.map(f32::round)).collect();
        assert_eq!(signed, [Some(20.0), Some(-10.0), None, Some(0.0)]);
    }

    #[test]
    fn flicker_is_how_the_difference_changes_and_a_constant_one_has_none() {
        let truth = [Some(10), Some(20), Some(30), None];
        let sides = |painted| [side(painted), side(truth)];
        let before = sides([Some(14), Some(20), Some(30), Some(9)]);
        let now = sides([Some(14), Some(24), None, Some(9)]);
        let compared = flicker([before.clone(), now], None, true).unwrap();
        assert_eq!(compared.apart.as_slice(), [Some(0.0), Some(4.0), None, None]);
        assert!((compared.flicker_steps.unwrap() - 8.0_f64.sqrt()).abs() < 1e-9);
        let still = flicker([before.clone(), before], None, true).unwrap();
        assert_eq!((still.flicker_steps, still.mean), (Some(0.0), 0.0));
    }

    #[test]
    fn what_one_side_alone_shows_is_a_hole_of_the_map_and_changes_no_other_pixel() {
        let alone = |pixel| {
            let sides =
                [side([Some(90), Some(90), None, Some(90)]), side([Some(90), Some(90), pixel, Some(90)])];
            between(sides, CompareMeasure::Flip, None, true).unwrap()
        };
        let [bright, none] = [alone(Some(255)), alone(None)];
        assert_eq!(bright.apart.as_slice(), [Some(0.0), Some(0.0), None, Some(0.0)]);
        assert_eq!(bright.apart, none.apart);
        assert!(compared(CompareMeasure::Flip).apart.as_slice()[0].is_some_and(|flip| flip > 0.05));
    }

    #[test]
    fn what_fills_a_hole_is_shown_but_not_compared() {
        let mut painted = Picture {
            color: Grid::filled(4, 1, [1.0; 3]),
            inverse_depth: Grid::filled(4, 1, 0.5),
            image: Grid::filled(4, 1, 0),
            fronts: Vec::new(),
            coverage: Vec::new(),
        };
        painted.image[(2, 0)] = NO_IMAGE;
        let sides = [of_picture(&painted), side([Some(255), Some(255), Some(0), Some(255)])];
        let compared = between(sides, CompareMeasure::Steps, None, true).unwrap();
        assert_eq!(compared.images[0].pixels[2], Color32::WHITE);
        assert_eq!(compared.apart.as_slice(), [Some(0.0), Some(0.0), None, Some(0.0)]);
        assert!(compared.psnr_db.is_infinite() && compared.one_sided == 0.25);
        painted.inverse_depth[(2, 0)] = -1.0;
        assert_eq!(of_picture(&painted).shown[(2, 0)], None);
    }

    #[test]
    fn sides_of_different_sizes_are_refused() {
        let other = DisplayedSide { shown: Grid::filled(2, 2, None), known: Grid::filled(2, 2, None) };
        let sides = [side([None; 4]), other];
        let error = between(sides, CompareMeasure::Steps, None, true).err().unwrap().to_string();
        assert!(error.contains("4×1") && error.contains("2×2"), "{error}");
    }

    #[test]
    fn the_map_of_where_differences_lie_tells_the_share_of_each_class() {
        let sides = [
            side([Some(90), Some(90), Some(90), Some(90)]),
            side([Some(100), Some(110), Some(90), Some(250)]),
        ];
        let compared = between(sides, CompareMeasure::Class, Some(20.0), true).unwrap();
        let classes = [Some(ErrorClass::Unseen), Some(ErrorClass::Edge), Some(ErrorClass::Inner), None];
        let told = by_class(compared, &Grid::from_vec(4, 1, classes.to_vec()), true).unwrap();
        let [unseen, edge, inner] = told.by_class.unwrap();
        assert!((unseen - 0.2).abs() < 1e-9 && (edge - 0.8).abs() < 1e-9 && inner == 0.0);
        assert_eq!(told.difference.pixels[1], opaque(ErrorClass::Edge.color()));
        assert_eq!(told.difference.pixels[2], Color32::BLACK);
        let other = Grid::filled(2, 2, None);
        assert!(by_class(told, &other, true).is_err());
    }
}
