//! What pictures are compared with: views with known truth, or every camera left out in turn.
//!
//! ```text
//! Truth::Views ──────── one fold:  all cameras,       the views that came with the capture
//! Truth::HoldOut ────── n folds:   all but camera k,  frames of camera k
//!                                  each truth masked to what the fold's cameras could see
//! ```
//!
//! No method can render what no camera of a fold saw: such pixels are removed from the truth, so that a hole counts only where a
//! method made it. The surfaces of a true picture without any depth are unknown: it stays whole, and unseen pixels count against every
//! method alike.

use std::sync::Arc;

use glam::DVec2;
use rayon::prelude::*;

use super::error_classes::class_map;
use super::hold_out;
use crate::metrics::ClassMap;
use crate::rivals::RecordedView;
use crate::scoring::{nothing_to_compare, unknown_truth_warning, vantage_order, with_truth};
use overlook_engine::capture::{
    Camera, Capture, Frame, INVALID_INVERSE_DEPTH, PixelSide, TruthLoader, TruthView,
};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;

/// Where the truth comes from.
#[derive(Clone)]
pub enum Truth {
    /// Vantages with true pictures; views without are passed over.
    Views(Vec<TruthView>),
    /// Each camera is left out in turn, and some of its own frames are the truth.
    HoldOut,
}

/// Cameras to make a model of, and views to score it at.
#[derive(Clone)]
pub struct Fold {
    /// The camera that is left out, where one is.
    pub held_out: Option<String>,
    /// The cameras to make a model of.
    pub capture: Capture,
    /// Views whose truth is masked to what those cameras saw, ordered by vantage and frame.
    pub views: Vec<TruthView>,
    /// Classes of error of each view; `None` if its truth has no depth, or if classes were not requested.
    pub(crate) classes: Vec<Option<Arc<ClassMap>>>,
}

/// What was recorded and the true scene, which differ under a disturbance.
#[derive(Clone)]
pub struct Recorded {
    /// What models are made of.
    pub capture: Capture,
    /// What the cameras would have recorded without the disturbance: where surfaces truly are.
    pub clean: Capture,
    /// All cameras, also those that a disturbance removes: each is left out in turn.
    pub all_cameras: Capture,
    /// Changes the truth where the disturbance changes the scene itself.
    pub edit_truth: Option<TruthEdit>,
}

/// Changes a true picture, given its camera and frame number.
pub type TruthEdit = Arc<dyn Fn(&Camera, i64, &mut Frame) + Send + Sync>;

impl Recorded {
    /// A capture as it is.
    #[must_use]
    pub fn undisturbed(capture: &Capture) -> Self {
        Self {
            capture: capture.clone(),
            clean: capture.clone(),
            all_cameras: capture.clone(),
            edit_truth: None,
        }
    }
}

impl Truth {
    /// The fewest cameras needed: if each is left out in turn, one must remain.
    #[must_use]
    pub fn least_cameras(&self) -> usize {
        match self {
            Self::Views(_) => 1,
            Self::HoldOut => 2,
        }
    }

    /// Loads and masks the truth of every fold. Views without a known pixel are dropped, and folds without views.
    ///
    /// # Errors
    /// Those of loading frames and truth; `Invalid` if nothing is left, or if a single camera would be left out; `Cancelled`.
    pub fn folds(&self, recorded: &Recorded, job: &Job) -> Result<Vec<Fold>> {
        let (folds, unseen) = self.folds_left(recorded, job)?;
        for view in unseen {
            job.warn(view);
        }
        if folds.is_empty() { Err(nothing_to_compare(&recorded.capture.name)) } else { Ok(folds) }
    }

    /// As [`Truth::folds`], with no fold where nothing is left, and a line on each view that was dropped.
    pub(crate) fn folds_left(&self, recorded: &Recorded, job: &Job) -> Result<(Vec<Fold>, Vec<String>)> {
        let folds = match self {
            Self::Views(views) => vec![(None, with_truth(views, job).into_iter().cloned().collect())],
            Self::HoldOut => {
                let names = recorded.all_cameras.cameras.iter().map(|camera| camera.name.clone());
                let split = |name: String| {
                    let (_, views) = hold_out::split(&recorded.all_cameras, std::slice::from_ref(&name))?;
                    Ok((Some(name), views))
                };
                names.map(split).collect::<Result<Vec<_>>>()?
            }
        };
        job.start("Loading the truth", folds.iter().map(|(_, views)| views.len()).sum());
        let mut dropped = Vec::new();
        let mask = |(held_out, views): (Option<String>, Vec<TruthView>)| {
            let keep = |_: usize, camera: &Camera| Some(&camera.name) != held_out.as_ref();
            let fold = Recorded {
                capture: recorded.capture.with_cameras(keep),
                clean: recorded.clean.with_cameras(keep),
                ..recorded.clone()
            };
            let masked: Vec<MaskedView> = views
                .into_par_iter()
                .map(|view| {
                    job.check()?;
                    let view = masked(&fold, view);
                    job.advance(1);
                    view
                })
                .collect::<Result<_>>()?;
            let (known, unseen): (Vec<_>, Vec<_>) = masked.into_iter().partition(|masked| masked.has_truth);
            dropped.extend(unseen.iter().map(|masked| unknown_truth_warning(&masked.view)));
            let (views, classes) = ordered(&known);
            Ok(Fold { held_out, capture: fold.capture, views, classes })
        };
        let mut folds = folds.into_iter().map(mask).collect::<Result<Vec<_>>>()?;
        folds.retain(|fold| !fold.views.is_empty());
        Ok((folds, dropped))
    }
}

/// Views of one vantage after each other, each by frame; vantages in the order in which they first come.
fn ordered(views: &[MaskedView]) -> (Vec<TruthView>, Vec<Option<Arc<ClassMap>>>) {
    let order = vantage_order(&views.iter().map(|masked| &masked.view).collect::<Vec<_>>());
    order.into_iter().map(|index| (views[index].view.clone(), views[index].classes.clone())).unzip()
}

/// A view with its truth loaded and masked.
struct MaskedView {
    view: TruthView,
    /// Whether any pixel of the truth is left.
    has_truth: bool,
    /// By the whole truth.
    classes: Option<Arc<ClassMap>>,
}

/// The view with its truth loaded, masked to what the recorded cameras saw unless it has no depth.
fn masked(recorded: &Recorded, view: TruthView) -> Result<MaskedView> {
    let (Some(load), Some(frame)) = (&view.truth, recorded.capture.frame_index(view.frame_number)) else {
        return Err(Error::invalid(
            format!("view '{}'", view.file_path),
            format!("'{}' has no frame {}", recorded.capture.name, view.frame_number),
        ));
    };
    let mut truth = load()?;
    // Before the edit, which may insert surfaces into a picture without depth.
    let has_depth = truth.inverse_depth.as_slice().iter().any(|inverse_depth| *inverse_depth > 0.0);
    if let Some(edit) = &recorded.edit_truth {
        edit(&view.camera, view.frame_number, &mut truth);
    }
    let mut classes = None;
    if has_depth {
        let camera_views = (0..recorded.capture.cameras.len())
            .map(|camera| CameraView::new(recorded, camera, frame))
            .collect::<Result<Vec<_>>>()?;
        let recorded =
            |seen: &CameraView| RecordedView { camera: seen.camera.clone(), frame: seen.clean.clone() };
        let seen: Vec<RecordedView> = camera_views.iter().map(recorded).collect();
        classes = class_map(&view.camera, &truth, &seen).map(Arc::new);
        mask_unseen(&mut truth, &view.camera, &camera_views);
    }
    let has_truth = truth.inverse_depth.as_slice().iter().any(|inverse_depth| *inverse_depth >= 0.0);
    let truth = Arc::new(truth);
    let view = TruthView { truth: Some(Arc::new(move || Ok((*truth).clone()))), ..view };
    Ok(MaskedView { view, has_truth, classes })
}

/// Takes what nothing saw out of what `camera` truly sees.
fn mask_unseen(truth: &mut Frame, camera: &Camera, camera_views: &[CameraView]) {
    let width = truth.size().0;
    truth.inverse_depth.as_mut_slice().par_iter_mut().enumerate().for_each(|(pixel, inverse_depth)| {
        let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
        if !camera_views.iter().any(|view| view.sees(camera, center, *inverse_depth)) {
            *inverse_depth = INVALID_INVERSE_DEPTH;
        }
    });
}

/// Views masked to what the cameras of a capture saw, as in a [`Fold`]. Only the picture of one camera is in memory at a time. Views
/// without a remaining pixel are dropped.
///
/// # Errors
/// Those of loading frames and truth; `Cancelled`.
pub(crate) fn masked_one_by_one(
    capture: &Capture,
    views: Vec<TruthView>,
    job: &Job,
) -> Result<Vec<TruthView>> {
    let recorded = Recorded::undisturbed(capture);
    let mask = |view: TruthView| {
        let (Some(load), Some(frame)) = (&view.truth, capture.frame_index(view.frame_number)) else {
            return Ok(None);
        };
        let mut truth = load()?;
        let width = truth.size().0;
        let depths = &mut truth.inverse_depth;
        if depths.as_slice().iter().any(|inverse_depth| *inverse_depth > 0.0) {
            let mut unseen: Vec<usize> = (0..depths.as_slice().len()).collect();
            for camera in 0..capture.cameras.len() {
                job.check()?;
                let seen = CameraView::new(&recorded, camera, frame)?;
                unseen.retain(|&pixel| {
                    let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
                    !seen.sees(&view.camera, center, depths.as_slice()[pixel])
                });
            }
            for pixel in unseen {
                depths.as_mut_slice()[pixel] = INVALID_INVERSE_DEPTH;
            }
        }
        job.advance(1);
        let is_known = depths.as_slice().iter().any(|inverse_depth| *inverse_depth >= 0.0);
        let truth = Arc::new(truth);
        let truth = Some(Arc::new(move || Ok((*truth).clone())) as TruthLoader);
        Ok(is_known.then_some(TruthView { truth, ..view }))
    };
    let masked: Vec<Option<TruthView>> = views.into_par_iter().map(mask).collect::<Result<_>>()?;
    let masked: Vec<TruthView> = masked.into_iter().flatten().collect();
    let order = vantage_order(&masked.iter().collect::<Vec<_>>());
    Ok(order.into_iter().map(|index| masked[index].clone()).collect())
}

/// What one camera saw at one frame.
struct CameraView {
    camera: Camera,
    clean: Arc<Frame>,
    recorded: Arc<Frame>,
}

/// A camera saw a point if its recorded surface is within this many of its pixel widths of the point: the extent of the paper's
/// 4-pixel neighborhood on a surface seen at 75°.
const SEEN_WITHIN_PX: f64 = 4.0;

impl CameraView {
    fn new(recorded: &Recorded, camera: usize, frame: usize) -> Result<Self> {
        Ok(Self {
            camera: recorded.clean.cameras[camera].clone(),
            clean: recorded.clean.frame(camera, frame)?,
            recorded: recorded.capture.frame(camera, frame)?,
        })
    }

    /// Whether one of the four pixels around the point that `from` sees at `pixel` shows it, and was recorded.
    fn sees(&self, from: &Camera, pixel: DVec2, inverse_depth: f32) -> bool {
        if inverse_depth < 0.0 {
            return false;
        }
        let ray = from.intrinsics.ray_in_camera(pixel);
        let at_infinity = inverse_depth == 0.0;
        let (position, depth) = if at_infinity && self.camera.intrinsics.is_orthographic() {
            // It sees one direction at infinity.
            return false;
        } else if at_infinity {
            let direction = from.world_from_camera.transform_vector3(ray);
            let in_camera = self.camera.camera_from_world().transform_vector3(direction);
            let Some(position) = self.camera.intrinsics.project(in_camera) else { return false };
            (position, f64::INFINITY)
        } else {
            let in_camera = if from.intrinsics.is_orthographic() {
                from.intrinsics.point_in_camera(pixel, f64::from(inverse_depth).recip())
            } else {
                ray / f64::from(inverse_depth)
            };
            let point = from.world_from_camera.transform_point3(in_camera);
            let Some(projected) = self.camera.project(point) else { return false };
            projected
        };
        let (width, height) = self.clean.size();
        let corner = (position - 0.5).floor();
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].iter().any(|&(dx, dy)| {
            let (x, y) = (corner.x + dx, corner.y + dy);
            if !(0.0..width as f64).contains(&x) || !(0.0..height as f64).contains(&y) {
                return false;
            }
            let at = (x as usize, y as usize);
            let recorded = self.recorded.inverse_depth[at];
            let there = f64::from(self.clean.inverse_depth[at]);
            if recorded < 0.0 || there < 0.0 {
                return false;
            }
            if at_infinity {
                return there == 0.0;
            }
            let width_of_pixel = self.camera.intrinsics.pixel_width(depth, PixelSide::Mean);
            there > 0.0 && (1.0 / there - depth).abs() <= SEEN_WITHIN_PX * width_of_pixel
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_engine::settings::CaptureSettings;

    fn true_pixels(views: Vec<TruthView>, capture: &Capture) -> usize {
        let folds = Truth::Views(views).folds(&Recorded::undisturbed(capture), &Job::new()).unwrap();
        let pictures = folds[0].views.iter().map(|view| view.truth.as_ref().unwrap()().unwrap());
        pictures
            .map(|truth| truth.inverse_depth.as_slice().iter().filter(|depth| **depth >= 0.0).count())
            .sum()
    }

    fn demo_of_two() -> (Capture, Vec<TruthView>) {
        let spec = DemoSpec::new("orrery").cameras(2).frames(1).size((32, 24));
        let demo = Demo::new(&spec).unwrap();
        (demo.capture(&CaptureSettings::default()), demo.truth_views())
    }

    #[test]
    fn a_view_that_shows_nothing_that_a_camera_saw_is_dropped_by_name_and_all_such_are_no_truth() {
        let (capture, mut views) = demo_of_two();
        let load = views[1].truth.clone().unwrap();
        views[1].truth = Some(Arc::new(move || {
            let mut truth = load()?;
            // A kilometer away, where nobody recorded anything.
            truth.inverse_depth.as_mut_slice().fill(1e-3);
            Ok(truth)
        }));
        views[2].truth = None;
        let (recorded, job) = (Recorded::undisturbed(&capture), Job::new());
        let folds = Truth::Views(views.clone()).folds(&recorded, &job).unwrap();
        let names: Vec<_> = folds[0].views.iter().map(|view| &view.file_path).collect();
        assert_eq!(names, [&views[0].file_path]);
        let [missing, left_out] = job.warnings().try_into().unwrap();
        assert!(missing.contains(&views[2].file_path) && missing.starts_with("1 of 3 views"), "{missing}");
        assert!(left_out.contains(&views[1].file_path) && left_out.contains("left out"), "{left_out}");

        let Err(error) = Truth::Views(views[1..2].to_vec()).folds(&recorded, &Job::new()) else {
            panic!("a view that shows nothing passed for truth")
        };
        assert!(error.to_string().contains("no view has a true picture"), "{error}");
    }

    #[test]
    fn views_masked_with_one_picture_in_memory_are_those_of_a_fold() {
        let (capture, views) = demo_of_two();
        let folds = Truth::Views(views.clone()).folds(&Recorded::undisturbed(&capture), &Job::new()).unwrap();
        let masked = masked_one_by_one(&capture, views, &Job::new()).unwrap();
        assert_eq!(masked.len(), folds[0].views.len());
        for (one_by_one, of_fold) in masked.iter().zip(&folds[0].views) {
            assert_eq!(one_by_one.file_path, of_fold.file_path);
            let truths = [one_by_one, of_fold].map(|view| view.truth.as_ref().unwrap()().unwrap());
            assert_eq!(truths[0], truths[1]);
        }
    }

    #[test]
    fn a_true_picture_without_depth_counts_whole_and_one_with_depth_where_a_camera_saw_it() {
        let (capture, views) = demo_of_two();
        let pixels: usize = views.iter().map(|view| view.camera.intrinsics.pixel_count()).sum();
        let masked = true_pixels(views.clone(), &capture);
        assert!(masked > pixels / 2 && masked < pixels, "{masked} of {pixels}");

        let color_only = |view: TruthView| {
            let load = view.truth.clone().unwrap();
            let without_depth = move || {
                let mut truth = load()?;
                truth.inverse_depth.as_mut_slice().fill(0.0);
                Ok(truth)
            };
            TruthView { truth: Some(Arc::new(without_depth)), ..view }
        };
        assert_eq!(true_pixels(views.into_iter().map(color_only).collect(), &capture), pixels);
    }
}
