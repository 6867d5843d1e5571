//! What was wrong with a view that took no part, predicted by the cameras beside it.
//!
//! Purpose: poses of a recording drift, and its exposure follows what it sees: a held-out picture is wrong as the pictures just before
//! and after it are. Seen from its claimed pose, a capture that was corrected looks shifted. Source: none. Corrections of
//! cameras are interpolated at the view, along the numbers of the pictures' files or between the nearest poses. Whether that predicts
//! anything is cross-validated: each camera is left out and predicted by the others, and what is predicted has to correlate with
//! what was found. The picture of the view is never looked at.

use glam::{DAffine3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::picture_numbers::PictureNumber;
use crate::capture::{Camera, TruthView};

/// Corrections of fewer cameras predict nothing that could be told from chance.
const LEAST_CAMERAS: u32 = 6;
/// What is predicted correlates at least so well with what was found,
const LEAST_CORRELATION: f64 = 0.5;
/// and by so many standard deviations of the correlation of as many unrelated pairs.
const LEAST_SIGMAS: f64 = 2.0;

/// What was corrected of all cameras, and how well it predicts what is wrong with a view between them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewCorrections {
    /// Per camera, in the capture's order.
    pub cameras: Vec<CameraCorrection>,
    /// How far away surfaces typically are, in the capture's unit: what an angle is compared with a distance by.
    pub typical_depth: f64,
    /// What predicts poses.
    pub poses: Predictors,
    /// What predicts exposures.
    pub exposures: Predictors,
}

/// What was corrected of one camera; zeros where nothing was.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CameraCorrection {
    /// Name of its picture's file without folder and extension; `None` where it has no file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
    /// Its pose before the correction, through the color lens where one was found.
    pub world_from_camera: DAffine3,
    /// Rotation about its center: a rotation vector in world space, radians.
    pub turn: DVec3,
    /// Shift of its center in world space, in the capture's unit.
    pub shift: DVec3,
    /// Natural logarithms of what its red, green and blue were multiplied with.
    pub log_gain: [f64; 3],
}

/// Ways to predict a correction from those of the cameras beside it, as far as they hold for the cameras themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Predictors {
    /// Along the numbers in the names of pictures; `None` where that predicts nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_number: Option<CrossValidation>,
    /// Between the nearest poses; `None` where that predicts nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_pose: Option<CrossValidation>,
}

/// How well the cameras predict each one of them that is left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CrossValidation {
    /// Correlation of what is predicted and what was found.
    pub correlation: f64,
    /// The widest gap between neighbors over which it was tried: difference of numbers, or distance in the capture's unit.
    pub widest_gap: f64,
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

/// Where a picture was taken.
struct Place {
    number: Option<PictureNumber>,
    world_from_camera: DAffine3,
}

/// Cameras beside a place, with the share of each, and the gap that they leave.
struct Neighborhood {
    shares: [(usize, f64); 2],
    gap: f64,
}

#[derive(Clone, Copy)]
enum Along {
    Numbers,
    Poses,
}

impl CameraCorrection {
    pub(super) fn new(picture: Option<String>, then: &Camera, now: &Camera, log_gain: [f64; 3]) -> Self {
        let [before, after] = [then, now].map(|camera| camera.world_from_camera);
        let is_moved = before != after;
        let turn = DQuat::from_mat3(&(after.matrix3 * before.matrix3.transpose())).to_scaled_axis();
        Self {
            picture,
            world_from_camera: before,
            turn: if is_moved { turn } else { DVec3::ZERO },
            shift: if is_moved { after.translation - before.translation } else { DVec3::ZERO },
            log_gain,
        }
    }

    fn place(&self) -> Place {
        let number = self.picture.as_deref().and_then(PictureNumber::of);
        Place { number, world_from_camera: self.world_from_camera }
    }
}

impl ViewCorrections {
    /// What `cameras` predict; `None` where that is nothing. Depths are typically `typical_depth`.
    pub(super) fn new(cameras: Vec<CameraCorrection>, typical_depth: f64) -> Option<Self> {
        let mut corrections = Self { cameras, typical_depth, ..Self::default() };
        let pose = |correction: &CameraCorrection| {
            let [turn, shift] = [correction.turn * typical_depth, correction.shift];
            [turn.x, turn.y, turn.z, shift.x, shift.y, shift.z]
        };
        corrections.poses = corrections.predictors(pose);
        corrections.exposures = corrections.predictors(|correction| correction.log_gain);
        let is_any = |of: Predictors| of.by_number.is_some() || of.by_pose.is_some();
        (is_any(corrections.poses) || is_any(corrections.exposures)).then_some(corrections)
    }

    fn predictors<const N: usize>(&self, value: impl Fn(&CameraCorrection) -> [f64; N]) -> Predictors {
        let values: Vec<[f64; N]> = self.cameras.iter().map(value).collect();
        Predictors {
            by_number: self.cross_validated(Along::Numbers, &values),
            by_pose: self.cross_validated(Along::Poses, &values),
        }
    }

    /// Leaves each camera out and predicts it by the others; `None` where that does not hold.
    fn cross_validated<const N: usize>(&self, along: Along, values: &[[f64; N]]) -> Option<CrossValidation> {
        let (mut products, mut predicted_squares, mut found_squares) = (0.0, 0.0, 0.0);
        let (mut count, mut widest_gap) = (0_u32, 0.0_f64);
        for (camera, found) in values.iter().enumerate() {
            let place = self.cameras[camera].place();
            let Some(beside) = self.beside(along, &place, Some(camera)) else { continue };
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
        (correlation > least).then_some(CrossValidation { correlation, widest_gap })
    }

    fn beside(&self, along: Along, place: &Place, without: Option<usize>) -> Option<Neighborhood> {
        let others = (0..self.cameras.len()).filter(|index| Some(*index) != without);
        match along {
            Along::Numbers => self.beside_number(place.number.as_ref()?, others),
            Along::Poses => self.beside_pose(&place.world_from_camera, others),
        }
    }

    /// The pictures just before and after a number.
    fn beside_number(&self, at: &PictureNumber, others: impl Iterator<Item = usize>) -> Option<Neighborhood> {
        let mut before: Option<(usize, f64)> = None;
        let mut after = before;
        for index in others {
            let Some(other) = self.cameras[index].place().number.filter(|other| other.is_beside(at)) else {
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

    /// The cameras that predict what is wrong with a view; `None` where none do.
    fn predicting(&self, by: &Predictors, place: &Place) -> Option<Neighborhood> {
        let ways = [(Along::Numbers, by.by_number), (Along::Poses, by.by_pose)];
        ways.into_iter().find_map(|(along, validation)| {
            let widest = validation?.widest_gap;
            self.beside(along, place, None).filter(|beside| beside.gap <= widest)
        })
    }

    /// Corrects a view as the cameras beside it were, where they predict it. Returns whether its pose and its exposure changed.
    pub(super) fn correct(&self, view: &mut TruthView) -> [bool; 2] {
        let number = view.picture.as_deref().and_then(PictureNumber::of);
        let place = Place { number, world_from_camera: view.camera.world_from_camera };
        let pose = self.predicting(&self.poses, &place);
        if let Some(beside) = &pose {
            let [turn, shift] =
                [|of: &CameraCorrection| of.turn, |of: &CameraCorrection| of.shift].map(|part| -> DVec3 {
                    beside.shares.iter().map(|(index, share)| *share * part(&self.cameras[*index])).sum()
                });
            let DAffine3 { matrix3, translation } = place.world_from_camera;
            let rotation = (DQuat::from_scaled_axis(turn) * DQuat::from_mat3(&matrix3)).normalize();
            view.camera.world_from_camera =
                DAffine3::from_rotation_translation(rotation, translation + shift);
        }
        let exposure = self.predicting(&self.exposures, &place);
        if let Some(beside) = &exposure {
            view.gain = std::array::from_fn(|channel| {
                let shares = beside.shares.iter();
                let parts = shares.map(|(index, share)| share * self.cameras[*index].log_gain[channel]);
                (-parts.sum::<f64>()).exp() as f32
            });
        }
        [pose.is_some(), exposure.is_some()]
    }

    /// How views are corrected, for people; `None` where nothing is predicted.
    pub(super) fn sentence(&self) -> Option<String> {
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;

    /// Cameras along a line, the corrections of which follow `wave`.
    fn cameras(wave: impl Fn(usize) -> f64) -> Vec<CameraCorrection> {
        let of = |index: usize| CameraCorrection {
            picture: Some(format!("frame-{:04}.color", 10 * index)),
            world_from_camera: DAffine3::from_translation(DVec3::X * index as f64),
            turn: DVec3::Z * 0.01 * wave(index),
            shift: DVec3::Y * 0.1 * wave(index),
            log_gain: [0.2 * wave(index); 3],
        };
        (0..16).map(of).collect()
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
        let corrections = ViewCorrections::new(cameras(drift), 2.0).unwrap();
        assert!(corrections.poses.by_number.unwrap().correlation > 0.8, "{:?}", corrections.poses);
        let expected = 0.5 * (drift(3) + drift(4));
        // By its number, wherever it claims to stand, and without one by its pose.
        for (picture, at) in [(Some("frame-0035.color"), 9.0), (None, 3.5)] {
            let mut view = view(picture, at);
            assert_eq!(corrections.correct(&mut view), [true; 2], "{picture:?}");
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
        assert_eq!(ViewCorrections::new(cameras(alternating), 2.0), None);
        assert_eq!(ViewCorrections::new(cameras(|_| 0.0), 2.0), None);
        assert_eq!(ViewCorrections::new(cameras(|_| 1.0).split_off(11), 2.0), None);
    }

    #[test]
    fn views_far_from_all_pictures_stay() {
        let corrections = ViewCorrections::new(cameras(|index| (0.5 * index as f64).sin()), 2.0).unwrap();
        for (picture, at) in [(Some("frame-0900.color"), 90.0), (Some("other-0035"), 90.0)] {
            let (mut corrected, claimed) = (view(picture, at), view(picture, at));
            assert_eq!(corrections.correct(&mut corrected), [false; 2], "{picture:?}");
            assert_eq!((corrected.camera, corrected.gain), (claimed.camera, claimed.gain));
        }
    }
}
