//! The viewpoint of a comparison, its frame, and what was recorded there.

use std::sync::Arc;

use crate::app::model::{Content, OpenScene};
use crate::app::rooms::compare::model::{CompareKey, CompareVantage};
use overlook_engine::capture::{Capture, Frame, TruthView};
use overlook_engine::error::{Error, Result};
use overlook_engine::render::{Picture, Vantage};
use overlook_engine::settings::AlignSettings;
use overlook_lab::truth::ViewCorrections;

/// A viewpoint at a frame, and the frame that was recorded there where it is known.
pub(crate) struct Viewpoint {
    pub(crate) from: CompareVantage,
    pub(crate) vantage: Vantage,
    /// What was recorded there, where that is known.
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
                let there = capture
                    .cameras
                    .get(camera)
                    .ok_or_else(|| Error::invalid("comparison", "there is no such camera"))?;
                let vantage = Vantage { camera: there.clone(), frame };
                Ok(Self { from, vantage, truth: Some(capture.frame(camera, frame)?), view: None })
            }
            CompareVantage::Truth(index) => {
                let capture = capture_of(&key.scene)?;
                let views = views_with_truth(&key.scene)?;
                let view = views
                    .get(index)
                    .ok_or_else(|| Error::invalid("comparison", "there is no such viewpoint"))?;
                let mut view = TruthView::clone(view);
                if let Some(alignment) = key.scan.as_ref().and_then(|scan| scan.alignment()) {
                    ViewCorrections::of(alignment).correct(std::slice::from_mut(&mut view));
                }
                let frame = capture.frame_index(view.frame_number).ok_or_else(|| {
                    Error::invalid(&view.file_path, format!("there is no frame {}", view.frame_number))
                })?;
                let load = view.truth.as_ref().map(|load| load()).transpose()?;
                let vantage = Vantage { camera: view.camera.clone(), frame };
                Ok(Self { from, vantage, truth: load.map(Arc::new), view: Some(view) })
            }
        }
    }

    /// The same viewpoint at the frame before, or at the last earlier frame with truth; `Invalid` at the first.
    pub(crate) fn before(&self, key: &CompareKey) -> Result<Self> {
        let first = || {
            Error::invalid(
                "comparison",
                "Flicker is between two frames, and there is none before this one: go to a later frame or viewpoint.",
            )
        };
        if let CompareVantage::Truth(index) = self.from {
            let views = views_with_truth(&key.scene)?;
            let here = views.get(index).ok_or_else(first)?;
            let earlier = views
                .iter()
                .enumerate()
                .filter(|(_, view)| view.camera == here.camera && view.frame_number < here.frame_number);
            let (index, _) = earlier.max_by_key(|(_, view)| view.frame_number).ok_or_else(first)?;
            return Self::of(key, CompareVantage::Truth(index), 0);
        }
        Self::of(key, self.from, self.vantage.frame.checked_sub(1).ok_or_else(first)?)
    }

    /// The same view at the pose that its file claims; `None` for the live view.
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
        return Err(Error::invalid("comparison", "a store has no viewpoints with true pictures"));
    };
    Ok(truth.iter().filter(|view| view.truth.is_some()).collect())
}

pub(crate) fn unknown_truth() -> Error {
    Error::invalid(
        "comparison",
        "The truth is known only at viewpoints with a true picture and at cameras that are held out: choose one in the last list above.",
    )
}

/// The camera whose place the comparison is made from, so that its own samples are left out.
pub(crate) fn left_out(key: &CompareKey) -> Option<usize> {
    match key.choice.from {
        CompareVantage::HoldOut(camera) => Some(camera),
        _ => None,
    }
}

/// The capture without a left-out camera.
pub(crate) fn cameras_left(key: &CompareKey) -> Result<Capture> {
    let left_out = left_out(key);
    Ok(corrected_capture(key)?.with_cameras(|index, _| Some(index) != left_out))
}

pub(crate) fn capture_of(scene: &OpenScene) -> Result<&Capture> {
    scene.capture().ok_or_else(|| {
        Error::invalid(
            "comparison",
            "A store holds no source frames to compare with: open the capture it was made from.",
        )
    })
}

/// The capture as it is shown: with corrected cameras, once the corrections are known.
pub(crate) fn corrected_capture(key: &CompareKey) -> Result<&Capture> {
    let recorded = capture_of(&key.scene)?;
    Ok(key.scan.as_ref().map_or(recorded, |scan| scan.capture()))
}

/// What [`corrected_capture`] was corrected by.
pub(crate) fn corrected_by(key: &CompareKey) -> Option<AlignSettings> {
    key.scan.as_ref().map(|scan| scan.align_settings().clone())
}
