//! A scan with the last results that no tolerance changes, so that inspecting frame after frame, or changing one threshold,
//! pays once for what stays.

use std::ops::Deref;
use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::interactive::FrameLayers;
use super::layers::CameraLayer;
use super::normals::{NormalErrors, compare_with_given};
use super::pruning::{SpanStack, StaticLayer, rated, static_layers};
use super::temporal::{self, TemporalScan};
use crate::alignment::{self, Aligned, Alignment, CaptureCorrection};
use crate::capture::conventions::{self, Finding};
use crate::capture::{Camera, Capture};
use crate::edits::{self, EditList};
use crate::error::Result;
use crate::job::Job;
use crate::settings::{
    AgreementRule, AlignSettings, MixedPixels, NormalSettings, PruningMethod, RateModel, Settings,
    SpanSettings,
};

/// The pass over all frames of one capture, with the last results made from it.
#[derive(Debug)]
pub struct PreparedScan {
    scan: TemporalScan,
    aligned: Aligned,
    conventions: Option<Finding>,
    align: AlignSettings,
    removed_pixels: Vec<u64>,
    static_layers: Last<StaticKey, Arc<Vec<StaticLayer>>>,
    frame: Last<PreparedFrameKey, Arc<FrameLayers>>,
    normal_errors: Last<f32, AllNormalErrors>,
}

impl PreparedScan {
    /// Asks whether the capture is read as it is meant, corrects the rig's errors, and passes over all frames.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), `Io` where a temporary file cannot be written, and `Cancelled`.
    pub(crate) fn new(capture: &Capture, settings: &Settings, job: &Job) -> Result<Self> {
        Self::edited(capture, settings, &EditList::default(), job)
    }

    /// The same of a capture from which edits remove pixels, after the rig's errors are corrected.
    ///
    /// # Errors
    /// As [`PreparedScan::new`].
    pub(crate) fn edited(
        capture: &Capture,
        settings: &Settings,
        edits: &EditList,
        job: &Job,
    ) -> Result<Self> {
        let aligned = alignment::align(capture, &settings.align, job)?;
        let conventions = better_conventions(capture, &aligned.correction)?;
        Self::without_removed(aligned, conventions, settings, edits, job)
    }

    /// The scan that [`PreparedScan::edited`] gives of the same capture and `settings.align`, where this one was made without edits:
    /// the rig's errors are known.
    ///
    /// # Errors
    /// As [`PreparedScan::new`].
    pub(crate) fn edited_again(&self, settings: &Settings, edits: &EditList, job: &Job) -> Result<Self> {
        Self::without_removed(self.aligned.clone(), self.conventions.clone(), settings, edits, job)
    }

    fn without_removed(
        mut aligned: Aligned,
        conventions: Option<Finding>,
        settings: &Settings,
        edits: &EditList,
        job: &Job,
    ) -> Result<Self> {
        let frames = 0..aligned.capture.frame_count();
        let removed = edits::count_removed_pixels(&aligned.capture, edits, frames, job)?;
        aligned.capture =
            edits::without_removed_pixels(&aligned.capture, edits, settings.capture.edited_cache_bytes());
        let scan = temporal::scan(&aligned.capture, settings, job)?;
        let scanned = Self::of(scan, aligned, conventions, &settings.align);
        Ok(Self { removed_pixels: removed, ..scanned })
    }

    /// A scan of a capture that was aligned with these settings; `conventions` are those that would fit far better than its own.
    pub(crate) fn of(
        scan: TemporalScan,
        aligned: Aligned,
        conventions: Option<Finding>,
        align: &AlignSettings,
    ) -> Self {
        Self {
            scan,
            aligned,
            conventions,
            align: align.clone(),
            removed_pixels: Vec::new(),
            static_layers: Last::default(),
            frame: Last::default(),
            normal_errors: Last::default(),
        }
    }

    /// The capture that was scanned: the one that was given, without what the rig got wrong.
    #[must_use]
    pub fn capture(&self) -> &Capture {
        &self.aligned.capture
    }

    /// The corrections to the rig; `None` if nothing was corrected.
    #[must_use]
    pub fn alignment(&self) -> Option<&Alignment> {
        self.aligned.alignment.as_ref()
    }

    /// For each camera the pixels with depth that edits removed, over all frames; empty where no edit was asked.
    pub(crate) fn removed_pixels(&self) -> &[u64] {
        &self.removed_pixels
    }

    /// How poses and depth would fit far better between cameras than as the capture says, where they would.
    #[must_use]
    pub fn conventions(&self) -> Option<&Finding> {
        self.conventions.as_ref()
    }

    /// The settings that the capture was aligned with.
    #[must_use]
    pub fn align_settings(&self) -> &AlignSettings {
        &self.align
    }

    /// Whether the scan serves these settings, or the frames have to be passed over again.
    #[must_use]
    pub fn serves(&self, settings: &Settings) -> bool {
        self.align == settings.align && self.scan.serves(&settings.spans)
    }

    /// The settings closest to these that the scan serves.
    pub(crate) fn served(&self, settings: &Settings) -> Settings {
        let spans = self.scan.served(&settings.spans);
        Settings { spans, align: self.align.clone(), ..settings.clone() }
    }
}

/// How poses and depth would fit far better between the cameras of a capture than as it says, where they would. A color lens that is
/// corrected leaves nothing to say of lenses, and is corrected of no capture that is misread otherwise.
///
/// # Errors
/// Those of reading a few frames.
pub(crate) fn better_conventions(
    capture: &Capture,
    correction: &CaptureCorrection,
) -> Result<Option<Finding>> {
    if capture.cameras.len() < 2 || capture.frame_count() == 0 || correction.is_of_a_lens() {
        return Ok(None);
    }
    Ok(Some(conventions::check(capture)?).filter(|found| found.alternative().is_some()))
}

impl Deref for PreparedScan {
    type Target = TemporalScan;

    fn deref(&self) -> &TemporalScan {
        &self.scan
    }
}

type StaticKey = (NormalSettings, SpanSettings);

/// Per camera.
type AllNormalErrors = Arc<Vec<Vec<NormalErrors>>>;

/// Everything that the layers of a frame depend on.
#[derive(Clone, Debug, PartialEq)]
struct PreparedFrameKey {
    frame: usize,
    normals: NormalSettings,
    spans: SpanSettings,
    rate: RateModel,
    cosine_floor: f32,
    first_camera: bool,
    mixed_pixels: MixedPixels,
    agreement: AgreementRule,
}

/// The last result, with the key that it was made for.
#[derive(Debug)]
struct Last<K, V>(Mutex<Option<(K, V)>>);

impl<K, V> Default for Last<K, V> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<K: PartialEq, V: Clone> Last<K, V> {
    fn get(&self, key: &K) -> Option<V> {
        let last = self.0.lock().ok()?;
        last.as_ref().filter(|(made_with, _)| made_with == key).map(|(_, value)| value.clone())
    }

    fn set(&self, key: K, value: V) {
        if let Ok(mut last) = self.0.lock() {
            *last = Some((key, value));
        }
    }
}

impl PreparedScan {
    /// The layers of `frame` under `settings`, which the scan serves: made once for as long as the settings that touch them and
    /// the frame stay.
    pub(crate) fn frame_layers(
        &self,
        settings: &Settings,
        frame: usize,
        job: &Job,
    ) -> Result<Arc<FrameLayers>> {
        let key = PreparedFrameKey {
            frame,
            normals: settings.normals.clone(),
            spans: settings.spans.clone(),
            rate: settings.pruning.rate,
            cosine_floor: settings.pruning.cosine_floor,
            first_camera: settings.pruning.method == PruningMethod::FirstCamera,
            mixed_pixels: settings.pruning.mixed_pixels,
            agreement: settings.pruning.agreement,
        };
        if let Some(layers) = self.frame.get(&key) {
            return Ok(layers);
        }
        let background = self.rated_layers(settings, job)?;
        let stack = SpanStack::new(self.capture(), Some(&self.scan), settings, background);
        let layers = Arc::new(FrameLayers::at(frame, stack, job)?);
        self.frame.set(key, layers.clone());
        Ok(layers)
    }

    /// Every camera's static pixels, ready to be pruned.
    fn rated_layers(&self, settings: &Settings, job: &Job) -> Result<Vec<CameraLayer>> {
        let key = (settings.normals.clone(), settings.spans.clone());
        let layers = if let Some(layers) = self.static_layers.get(&key) {
            layers
        } else {
            let layers = Arc::new(static_layers(self.capture(), &self.scan, settings, job)?);
            self.static_layers.set(key, layers.clone());
            layers
        };
        rated(self.capture(), layers.as_ref().clone(), settings, job)
    }

    /// Per camera, estimated against given normals on the first frame; empty where none are given. That frame is read again where
    /// the edge threshold is another than that of the scan.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), and `Cancelled`.
    pub(crate) fn normal_errors(&self, settings: &NormalSettings, job: &Job) -> Result<AllNormalErrors> {
        let capture = self.capture();
        if self.edge == settings.edge || !capture.has_normals {
            return Ok(Arc::new(self.cameras.iter().map(|camera| camera.normal_errors.clone()).collect()));
        }
        if let Some(errors) = self.normal_errors.get(&settings.edge) {
            return Ok(errors);
        }
        let of_camera = |(index, camera): (usize, &Camera)| {
            job.check()?;
            Ok(compare_with_given(&*capture.frame(index, 0)?, camera, settings))
        };
        let errors: Result<Vec<_>> = capture.cameras.par_iter().enumerate().map(of_camera).collect();
        let errors = Arc::new(errors?);
        self.normal_errors.set(settings.edge, errors.clone());
        Ok(errors)
    }
}
