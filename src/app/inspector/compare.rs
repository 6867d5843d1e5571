//! Two pictures of one place, side by side: before and after pruning, two settings, the truth, kernels, painters.
//!
//! Works on a lane of its own with a renderer of its own, so that neither view waits.

use std::sync::Arc;

use super::super::scene::{Content, Scene};
use super::super::state::method_of;
use super::compare_look::{Measure, Place, Side};
use super::difference::{self, Comparison};
use crate::capture::{Capture, Frame};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::{self, SampleSet, TemporalScan};
use crate::render::{Renderer, Vantage};
use crate::settings::{Backend, Kernel, PruningMethod, Settings, SpanLevels};

/// What a comparison is made from; an equal key gives an equal comparison.
#[derive(Clone)]
pub(crate) struct CompareKey {
    /// What is open.
    pub scene: Arc<Scene>,
    /// The sides.
    pub sides: [Side; 2],
    /// From where.
    pub place: Place,
    /// Where the live view stands, and when.
    pub vantage: Vantage,
    /// The kept samples that the live view shows.
    pub samples: Arc<SampleSet>,
    /// The pass over all frames, where it is done.
    pub scan: Option<Arc<TemporalScan>>,
    /// The settings on the sliders, A and B.
    pub settings: [Settings; 3],
    /// What the map of their difference shows.
    pub measure: Measure,
    /// The difference that the map's upper end stands for, in the unit of the measure; `None` to fit it.
    pub range: Option<f32>,
    /// Dark or light, as holes use a color of the theme.
    pub dark: bool,
}

impl PartialEq for CompareKey {
    fn eq(&self, other: &Self) -> bool {
        let uses = |side: Side| self.sides.contains(&side);
        self.scene.id == other.scene.id
            && self.sides == other.sides
            && self.place == other.place
            && Arc::ptr_eq(&self.samples, &other.samples)
            && self.scan.is_some() == other.scan.is_some()
            && self.settings[0] == other.settings[0]
            && (!uses(Side::A) || self.settings[1] == other.settings[1])
            && (!uses(Side::B) || self.settings[2] == other.settings[2])
            && self.measure == other.measure
            && self.range == other.range
            && self.dark == other.dark
            && self.vantage.frame == other.vantage.frame
            && (self.place != Place::Live || self.vantage == other.vantage)
    }
}

/// A comparison that is shown.
pub(crate) struct Compared {
    /// What came of it.
    pub comparison: Comparison,
    /// Left, right and difference on the graphics card.
    pub textures: [egui::TextureHandle; 3],
}

/// Samples made for comparisons: the last few are kept.
#[derive(Default)]
pub(crate) struct Comparer {
    renderer: Renderer,
    made: Vec<(Made, Arc<SampleSet>)>,
}

/// What samples were made from.
#[derive(Clone, PartialEq)]
struct Made {
    scene: u64,
    frame: usize,
    method: Settings,
    left_out: Option<usize>,
    with_scan: bool,
}

/// Sample sets that are kept.
const KEPT: usize = 4;

impl Comparer {
    /// Makes the comparison.
    ///
    /// # Errors
    /// `Invalid` where a side cannot be shown there; whatever loading, pruning and rendering give; `Cancelled`.
    pub(crate) fn compare(&mut self, key: &CompareKey, job: &Job) -> Result<Comparison> {
        let (vantage, truth) = place(key)?;
        let left = self.side(key, key.sides[0], &vantage, truth.as_deref(), job)?;
        job.check()?;
        let right = self.side(key, key.sides[1], &vantage, truth.as_deref(), job)?;
        Comparison::new([left, right], key.measure, key.range, key.dark)
    }

    fn side(
        &mut self,
        key: &CompareKey,
        side: Side,
        vantage: &Vantage,
        truth: Option<&Frame>,
        job: &Job,
    ) -> Result<difference::Side> {
        if side == Side::Truth {
            let frame = truth.ok_or_else(|| {
                Error::invalid(
                    "comparison",
                    "The truth is known at truth vantages and hold-out cameras only: choose one in the last list above.",
                )
            })?;
            return Ok(difference::of_frame(frame));
        }
        let mut settings = match side {
            Side::A => key.settings[1].clone(),
            Side::B => key.settings[2].clone(),
            _ => key.settings[0].clone(),
        };
        let mut render = settings.render.clone();
        match side {
            Side::Point => render.kernel = Kernel::Point,
            Side::Block => render.kernel = Kernel::Block,
            Side::Surfel => render.kernel = Kernel::Surfel,
            Side::Gather => render.kernel = Kernel::Gather,
            Side::Cpu => render.backend = Backend::Cpu,
            Side::Gpu => render.backend = Backend::Gpu,
            Side::Everything => {
                settings.pruning.method = PruningMethod::Off;
                settings.spans.levels = SpanLevels::Off;
            }
            _ => {}
        }
        let as_shown = method_of(&settings) == method_of(&key.settings[0]);
        let left_out = match key.place {
            Place::HoldOut(camera) => Some(camera),
            _ => None,
        };
        let samples = if as_shown && left_out.is_none() {
            key.samples.clone()
        } else {
            self.samples(key, &settings, vantage.frame, left_out, job)?
        };
        self.renderer.forget_background();
        let (picture, _) = self.renderer.render(&samples, vantage, &render, job)?;
        if side == Side::Gpu
            && let Some(notice) = self.renderer.notice()
        {
            return Err(Error::invalid("comparison", notice));
        }
        Ok(difference::of_picture(&picture))
    }

    fn samples(
        &mut self,
        key: &CompareKey,
        settings: &Settings,
        frame: usize,
        left_out: Option<usize>,
        job: &Job,
    ) -> Result<Arc<SampleSet>> {
        let capture = capture_of(&key.scene)?;
        let made = Made {
            scene: key.scene.id,
            frame,
            method: method_of(settings),
            left_out,
            with_scan: key.scan.is_some(),
        };
        if let Some((_, samples)) = self.made.iter().find(|(known, _)| *known == made) {
            return Ok(samples.clone());
        }
        let samples = match left_out {
            // What is known about time counts all cameras; the frame alone serves as well here.
            Some(left_out) => {
                let others = capture.with_cameras(|index, _| index != left_out);
                preprocess::inspect_frame(&others, None, settings, frame, job)?.samples
            }
            None => preprocess::inspect_frame(capture, key.scan.as_deref(), settings, frame, job)?.samples,
        };
        if self.made.len() == KEPT {
            self.made.remove(0);
        }
        self.made.push((made, samples.clone()));
        Ok(samples)
    }
}

fn capture_of(scene: &Scene) -> Result<&Capture> {
    scene.capture().ok_or_else(|| {
        Error::invalid(
            "comparison",
            "A store holds no source frames to compare with: open the capture it was made from.",
        )
    })
}

/// The vantage, and what was recorded there.
fn place(key: &CompareKey) -> Result<(Vantage, Option<Arc<Frame>>)> {
    match key.place {
        Place::Live => Ok((key.vantage.clone(), None)),
        Place::HoldOut(camera) => {
            let capture = capture_of(&key.scene)?;
            let there = capture
                .cameras
                .get(camera)
                .ok_or_else(|| Error::invalid("comparison", "there is no such camera"))?;
            let vantage = Vantage { camera: there.clone(), frame: key.vantage.frame };
            Ok((vantage, Some(capture.frame(camera, key.vantage.frame)?)))
        }
        Place::Truth(index) => {
            let capture = capture_of(&key.scene)?;
            let Content::Capture { truth, .. } = &key.scene.content else {
                return Err(Error::invalid("comparison", "a store comes without truth vantages"));
            };
            let view = truth
                .iter()
                .filter(|view| view.truth.is_some())
                .nth(index)
                .ok_or_else(|| Error::invalid("comparison", "there is no such truth vantage"))?;
            let frame = capture.frame_index(view.frame_number).ok_or_else(|| {
                Error::invalid(&view.file_path, format!("there is no frame {}", view.frame_number))
            })?;
            let load = view.truth.as_ref().map(|load| load()).transpose()?;
            Ok((Vantage { camera: view.camera.clone(), frame }, load.map(Arc::new)))
        }
    }
}
