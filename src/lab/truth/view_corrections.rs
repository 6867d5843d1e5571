//! Corrects held-out views as the cameras beside them were corrected.
//!
//! Purpose: the poses of a recording drift, and its exposure adapts to the scene. So a held-out picture has the same errors as the
//! pictures just before and after it, and a corrected capture looks shifted from its claimed pose.
//!
//! Source: none. The corrections of the cameras are interpolated at the view, along the numbers of the pictures' files or between the
//! nearest poses. Cross-validation decides whether they are used: each camera is predicted by the others, and the predictions must
//! correlate with the corrections found. The picture of the view itself is never used.
//!
//! Counters and times in the names of picture files.
//!
//! Purpose: a recording by one moving camera is a sequence, and the number in a picture's name is its position in the sequence.

use glam::{DAffine3, DQuat, DVec3};
use serde::Serialize;

use overlook_engine::alignment::{AlignedLens, Alignment, CameraCorrection};
use overlook_engine::capture::TruthView;

/// With fewer cameras, a prediction cannot be distinguished from chance.
const LEAST_CAMERAS: u32 = 6;
/// The least correlation of predicted and found corrections.
const LEAST_CORRELATION: f64 = 0.5;
/// The same in standard deviations of the correlation of as many unrelated pairs.
const LEAST_SIGMAS: f64 = 2.0;

/// How views that were recorded with a capture are corrected. As JSON: how well the cameras predict each other.
#[derive(Clone, Debug, Serialize)]
pub struct ViewCorrections<'a> {
    #[serde(skip)]
    lenses: &'a [AlignedLens],
    #[serde(skip)]
    cameras: &'a [CameraCorrection],
    /// The number of each camera's picture.
    #[serde(skip)]
    numbers: Vec<Option<PictureNumber>>,
    /// How far away surfaces typically are, in the capture's unit.
    #[serde(skip)]
    typical_depth: f64,
    poses: Predictors,
    exposures: Predictors,
}

/// Ways to predict a correction from those of the cameras beside it, as far as they hold for the cameras themselves.
#[serde_with::skip_serializing_none]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct Predictors {
    /// Along the numbers in the names of pictures; `None` if that predicts nothing.
    by_number: Option<CrossValidation>,
    /// Between the nearest poses; `None` if that predicts nothing.
    by_pose: Option<CrossValidation>,
}

/// How well the cameras predict each one of them that is left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct CrossValidation {
    /// Correlation of predicted and found corrections.
    correlation: f64,
    /// The widest gap between neighbors over which it was tried: difference of numbers, or distance in the capture's unit.
    widest_gap: f64,
}

/// How many views were changed in which way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CorrectedViews {
    /// Seen through the color lens that was found.
    pub lenses: usize,
    /// Turned and moved.
    pub poses: usize,
    /// Exposed otherwise than the corrected cameras.
    pub exposures: usize,
}

/// The pose that a picture was taken from, and the number in the name of its file.
struct PicturePose<'a> {
    number: Option<&'a PictureNumber>,
    world_from_camera: DAffine3,
}

/// Cameras beside a pose, with the share of each, and the gap that they leave.
struct Neighborhood {
    shares: [(usize, f64); 2],
    gap: f64,
}

#[derive(Clone, Copy)]
enum Along {
    Numbers,
    Poses,
}

/// The views with the poses, lenses and exposures that the corrections of the cameras predict for them; without corrections, the views
/// as they are. See [`ViewCorrections::correct`].
#[must_use]
pub fn views_as_taken(corrected: Option<&Alignment>, views: &[TruthView]) -> Vec<TruthView> {
    let mut views = views.to_vec();
    if let Some(alignment) = corrected {
        ViewCorrections::of(alignment).correct(&mut views);
    }
    views
}

impl<'a> ViewCorrections<'a> {
    /// Finds out what the corrections of the cameras predict.
    #[must_use]
    pub fn of(alignment: &'a Alignment) -> Self {
        let corrections = alignment.corrections.as_ref();
        let cameras = corrections.map_or(&[][..], |corrections| &corrections.cameras);
        let number = |camera: &CameraCorrection| camera.picture.as_deref().and_then(PictureNumber::of);
        let mut found = Self {
            lenses: &alignment.lenses,
            cameras,
            numbers: cameras.iter().map(number).collect(),
            typical_depth: corrections.map_or(0.0, |corrections| corrections.typical_depth),
            poses: Predictors::default(),
            exposures: Predictors::default(),
        };
        let typical_depth = found.typical_depth;
        let pose = |correction: &CameraCorrection| {
            let [turn, shift] = [correction.turn * typical_depth, correction.shift];
            [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z]
        };
        let ways = [Along::Numbers, Along::Poses].map(|along| found.beside_each(along));
        found.poses = Predictors::new(&ways, &cameras.iter().map(pose).collect::<Vec<_>>());
        found.exposures = Predictors::new(&ways, &cameras.iter().map(|of| of.log_gain).collect::<Vec<_>>());
        found
    }

    /// Corrects views that were recorded with the capture, without looking at their pictures. A view with the claimed lens of a camera
    /// gets the color lens that was found for that camera, because both used the same sensor. Its pose and exposure are corrected if the
    /// cameras beside it predict how.
    pub fn correct(&self, views: &mut [TruthView]) -> CorrectedViews {
        let mut corrected = CorrectedViews::default();
        for view in views {
            if let Some(lens) = self.lenses.iter().find(|lens| lens.claimed == view.camera.intrinsics) {
                view.camera = lens.color_camera(&view.camera);
                corrected.lenses += 1;
            }
            let [pose, exposure] = self.correct_as_predicted(view);
            corrected.poses += usize::from(pose);
            corrected.exposures += usize::from(exposure);
        }
        corrected
    }

    /// How views are corrected, in a sentence; `None` if nothing is predicted.
    #[must_use]
    pub fn sentence(&self) -> Option<String> {
        let of = |what: &str, by: &Predictors| {
            let (how, validation) = match by {
                Predictors { by_number: Some(validation), .. } => ("just before and after it", validation),
                Predictors { by_pose: Some(validation), .. } => ("nearest to it", validation),
                _ => return None,
            };
            Some(format!("{what} as the pictures {how} (correlation {:.2})", validation.correlation))
        };
        let parts = [of("moved", &self.poses), of("exposed", &self.exposures)];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| format!("views beside the capture: each {}", parts.join(", ")))
    }

    fn pose(&self, camera: usize) -> PicturePose<'_> {
        PicturePose {
            number: self.numbers[camera].as_ref(),
            world_from_camera: self.cameras[camera].world_from_camera,
        }
    }

    /// The neighbors of each camera, itself left out; `None` where it has none.
    fn beside_each(&self, along: Along) -> Vec<Option<Neighborhood>> {
        let cameras = 0..self.cameras.len();
        cameras.map(|camera| self.beside(along, &self.pose(camera), Some(camera))).collect()
    }

    fn beside(&self, along: Along, at: &PicturePose, without: Option<usize>) -> Option<Neighborhood> {
        let others = (0..self.cameras.len()).filter(|index| Some(*index) != without);
        match along {
            Along::Numbers => self.beside_number(at.number?, others),
            Along::Poses => self.beside_pose(&at.world_from_camera, others),
        }
    }

    /// The pictures just before and after a number.
    fn beside_number(&self, at: &PictureNumber, others: impl Iterator<Item = usize>) -> Option<Neighborhood> {
        let mut before: Option<(usize, f64)> = None;
        let mut after = before;
        for index in others {
            let Some(other) = self.numbers[index].as_ref().filter(|other| other.is_beside(at)) else {
                continue;
            };
            let number = other.number;
            if number <= at.number && before.is_none_or(|(_, known)| number > known) {
                before = Some((index, number));
            }
            if number >= at.number && after.is_none_or(|(_, known)| number < known) {
                after = Some((index, number));
            }
        }
        let ((before, from), (after, to)) = before.zip(after)?;
        let share = if to > from { (at.number - from) / (to - from) } else { 0.0 };
        Some(Neighborhood { shares: [(before, 1.0 - share), (after, share)], gap: to - from })
    }

    /// The two cameras whose poses differ least.
    fn beside_pose(&self, at: &DAffine3, others: impl Iterator<Item = usize>) -> Option<Neighborhood> {
        let distance = |index: usize| {
            let pose = self.cameras[index].world_from_camera;
            let turn = DQuat::from_mat3(&(pose.matrix3.transpose() * at.matrix3)).to_scaled_axis().length();
            pose.translation.distance(at.translation) + turn * self.typical_depth
        };
        let mut by_distance: Vec<(usize, f64)> = others.map(|index| (index, distance(index))).collect();
        by_distance.sort_by(|a, b| a.1.total_cmp(&b.1));
        let [(first, near), (second, far), ..] = by_distance[..] else { return None };
        let share = if near + far > 0.0 { near / (near + far) } else { 0.0 };
        Some(Neighborhood { shares: [(first, 1.0 - share), (second, share)], gap: near + far })
    }

    /// The cameras that predict the errors of a view; `None` if none do.
    fn predicting(&self, by: &Predictors, at: &PicturePose) -> Option<Neighborhood> {
        let ways = [(Along::Numbers, by.by_number), (Along::Poses, by.by_pose)];
        ways.into_iter().find_map(|(along, validation)| {
            let widest = validation?.widest_gap;
            self.beside(along, at, None).filter(|beside| beside.gap <= widest)
        })
    }

    /// Corrects pose and exposure of a view as far as the cameras beside it predict them. Returns whether the pose and the exposure
    /// changed.
    fn correct_as_predicted(&self, view: &mut TruthView) -> [bool; 2] {
        let number = view.picture.as_deref().and_then(PictureNumber::of);
        let at = PicturePose { number: number.as_ref(), world_from_camera: view.camera.world_from_camera };
        let pose = self.predicting(&self.poses, &at);
        if let Some(beside) = &pose {
            let [turn, shift] =
                [|of: &CameraCorrection| of.turn, |of: &CameraCorrection| of.shift].map(|part| -> DVec3 {
                    beside.shares.iter().map(|(index, share)| *share * part(&self.cameras[*index])).sum()
                });
            let DAffine3 { matrix3, translation } = at.world_from_camera;
            let rotation = (DQuat::from_scaled_axis(turn) * DQuat::from_mat3(&matrix3)).normalize();
            view.camera.world_from_camera =
                DAffine3::from_rotation_translation(rotation, translation + shift);
        }
        let exposure = self.predicting(&self.exposures, &at);
        if let Some(beside) = &exposure {
            view.gain = std::array::from_fn(|channel| {
                let shares = beside.shares.iter();
                let parts = shares.map(|(index, share)| share * self.cameras[*index].log_gain[channel]);
                (-parts.sum::<f64>()).exp() as f32
            });
        }
        [pose.is_some(), exposure.is_some()]
    }
}

impl Predictors {
    /// How well `values` of the cameras follow those of their neighbors along numbers and between poses.
    fn new<const N: usize>(ways: &[Vec<Option<Neighborhood>>; 2], values: &[[f64; N]]) -> Self {
        let [by_number, by_pose] = ways.each_ref().map(|neighbors| CrossValidation::of(neighbors, values));
        Self { by_number, by_pose }
    }
}

impl CrossValidation {
    /// Predicts the values of each camera by its neighbors; `None` if the predictions do not correlate with the values.
    fn of<const N: usize>(neighbors: &[Option<Neighborhood>], values: &[[f64; N]]) -> Option<Self> {
        let (mut products, mut predicted_squares, mut found_squares) = (0.0, 0.0, 0.0);
        let (mut count, mut widest_gap) = (0_u32, 0.0_f64);
        for (beside, found) in neighbors.iter().zip(values) {
            let Some(beside) = beside else { continue };
            for (axis, found) in found.iter().enumerate() {
                let shares = beside.shares.iter();
                let predicted: f64 = shares.map(|(index, share)| share * values[*index][axis]).sum();
                products += predicted * found;
                predicted_squares += predicted * predicted;
                found_squares += found * found;
            }
            count += 1;
            widest_gap = widest_gap.max(beside.gap);
        }
        if count < LEAST_CAMERAS || predicted_squares * found_squares == 0.0 {
            return None;
        }
        let correlation = products / (predicted_squares * found_squares).sqrt();
        let least = LEAST_CORRELATION.max(LEAST_SIGMAS / f64::from(count).sqrt());
        (correlation > least).then_some(Self { correlation, widest_gap })
    }
}

/// A file name taken apart at its last number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PictureNumber {
    pub(super) number: f64,
    /// The text before and after the number, which is the same in all names of one sequence.
    around: [String; 2],
}

impl PictureNumber {
    /// Reads a file's name without folder and extension; `None` where it holds no number.
    pub(super) fn of(stem: &str) -> Option<Self> {
        let is_digit = |letter: u8| letter.is_ascii_digit();
        let bytes = stem.as_bytes();
        let end = 1 + bytes.iter().rposition(|letter| is_digit(*letter))?;
        let run = |end: usize| {
            bytes[..end].iter().rposition(|letter| !is_digit(*letter)).map_or(0, |before| before + 1)
        };
        let mut start = run(end);
        // A time in seconds has its fraction after a point.
        if start >= 2 && bytes[start - 1] == b'.' && is_digit(bytes[start - 2]) {
            start = run(start - 1);
        }
        let number = stem[start..end].parse().ok()?;
        Some(Self { number, around: [stem[..start].to_owned(), stem[end..].to_owned()] })
    }

    /// Whether both are of one sequence.
    pub(super) fn is_beside(&self, other: &Self) -> bool {
        self.around == other.around
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::alignment::CameraCorrections;
    use overlook_engine::capture::{Camera, Intrinsics};

    /// `count` cameras along a line, whose corrections follow `wave`.
    fn aligned(count: usize, wave: impl Fn(usize) -> f64) -> Alignment {
        let of = |index: usize| CameraCorrection {
            picture: Some(format!("frame-{:04}.color", 10 * index)),
            world_from_camera: DAffine3::from_translation(DVec3::X * index as f64),
            turn: DVec3::Z * 0.01 * wave(index),
            shift: DVec3::Y * 0.1 * wave(index),
            log_gain: [0.2 * wave(index); 3],
        };
        let corrections = CameraCorrections { cameras: (0..count).map(of).collect(), typical_depth: 2.0 };
        Alignment { corrections: Some(corrections), ..Alignment::default() }
    }

    fn view(picture: Option<&str>, at: f64) -> TruthView {
        let lens = Intrinsics::from_horizontal_angle(8, 6, 1.0);
        let mut camera = Camera::look_at("v", lens, DVec3::ZERO, DVec3::Y, DVec3::Z);
        camera.world_from_camera = DAffine3::from_translation(DVec3::X * at);
        TruthView {
            picture: picture.map(str::to_owned),
            ..TruthView::new("v.png".to_owned(), camera, 0, None)
        }
    }

    #[test]
    fn a_view_between_two_pictures_is_wrong_as_they_are() {
        let drift = |index: usize| (0.5 * index as f64).sin();
        let alignment = aligned(16, drift);
        let corrections = ViewCorrections::of(&alignment);
        assert!(corrections.poses.by_number.unwrap().correlation > 0.8, "{:?}", corrections.poses);
        let expected = 0.5 * (drift(3) + drift(4));
        // By its number, wherever it claims to stand, and without one by its pose.
        for (picture, at) in [(Some("frame-0035.color"), 9.0), (None, 3.5)] {
            let mut view = view(picture, at);
            assert_eq!(corrections.correct_as_predicted(&mut view), [true; 2], "{picture:?}");
            let moved = view.camera.world_from_camera.translation - DVec3::X * at;
            assert!((moved - DVec3::Y * 0.1 * expected).length() < 1e-9, "{picture:?}: {moved}");
            let turn = DQuat::from_mat3(&view.camera.world_from_camera.matrix3).to_scaled_axis();
            assert!((turn.z - 0.01 * expected).abs() < 1e-9, "{picture:?}: {turn}");
            let dark = (-0.2 * expected).exp() as f32;
            assert!(view.gain.iter().all(|gain| (gain - dark).abs() < 1e-6), "{:?}", view.gain);
        }
    }

    #[test]
    fn what_does_not_follow_its_neighbors_predicts_nothing() {
        let alternating = |index: usize| if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        for alignment in [aligned(16, alternating), aligned(16, |_| 0.0), aligned(5, |_| 1.0)] {
            let corrections = ViewCorrections::of(&alignment);
            assert_eq!([corrections.poses, corrections.exposures], [Predictors::default(); 2]);
            assert_eq!(corrections.sentence(), None);
        }
    }

    #[test]
    fn views_far_from_all_pictures_stay() {
        let alignment = aligned(16, |index| (0.5 * index as f64).sin());
        let corrections = ViewCorrections::of(&alignment);
        for (picture, at) in [(Some("frame-0900.color"), 90.0), (Some("other-0035"), 90.0)] {
            let (mut corrected, claimed) = (view(picture, at), view(picture, at));
            assert_eq!(corrections.correct_as_predicted(&mut corrected), [false; 2], "{picture:?}");
            assert_eq!((corrected.camera, corrected.gain), (claimed.camera, claimed.gain));
        }
    }

    #[test]
    fn names_of_recordings_are_taken_apart_at_the_number_that_counts() {
        let of = |stem: &str| PictureNumber::of(stem).map(|found| found.number);
        assert_eq!(of("229529"), Some(229_529.0));
        assert_eq!(of("1305031102.175304"), Some(1_305_031_102.175_304));
        assert_eq!(of("frame-000123.color"), Some(123.0));
        assert_eq!(of("IMG_2041"), Some(2041.0));
        assert_eq!(of("left"), None);
        let found = |stem: &str| PictureNumber::of(stem).unwrap();
        assert!(found("frame-1.color").is_beside(&found("frame-12.color")));
        assert!(!found("frame-1.color").is_beside(&found("frame-1.depth")));
    }
}
