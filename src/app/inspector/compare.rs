//! Two pictures of one place, side by side: before and after pruning, two settings, the truth, kernels, painters.
//!
//! Works on a lane of its own with a renderer of its own, so that neither view waits.

use std::sync::Arc;

use super::super::scene::{Content, Scene};
use super::super::state::method_of;
use super::super::theme::Tokens;
use super::super::views::colormap::sequential;
use super::compare_look::{Place, Side};
use crate::capture::{Capture, Frame};
use crate::color::{srgb8_from_linear, steps_from_linear};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::{self, SampleSet, TemporalScan};
use crate::render::{NO_IMAGE, Picture, Renderer, Vantage};
use crate::settings::{Backend, Kernel, PruningMethod, Settings, SpanLevels};
use egui::ColorImage;

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
    /// The difference that the map's upper end stands for, 8-bit steps; `None` to fit it.
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

/// Two pictures and what tells them apart.
pub(crate) struct Comparison {
    /// The two sides, of one size.
    pub images: [Arc<ColorImage>; 2],
    /// Where and how much they differ.
    pub difference: Arc<ColorImage>,
    /// The difference that the map's upper end stands for, 8-bit steps.
    pub range: f32,
    /// Peak signal-to-noise ratio of one side against the other where both have something; infinite where equal.
    pub psnr_db: f64,
    /// Mean difference of a channel there, 8-bit steps.
    pub mean_steps: f64,
    /// Share of pixels that only one side has something for.
    pub one_sided: f64,
}

/// One side as displayed colors (0 to 255 a channel); `None` where there is nothing.
struct Painted {
    size: [usize; 2],
    pixels: Vec<Option<[u8; 3]>>,
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
        Ok(compared(&left, &right, key))
    }

    fn side(
        &mut self,
        key: &CompareKey,
        side: Side,
        vantage: &Vantage,
        truth: Option<&Frame>,
        job: &Job,
    ) -> Result<Painted> {
        if side == Side::Truth {
            let frame = truth.ok_or_else(|| {
                Error::invalid(
                    "comparison",
                    "The truth is known at truth vantages and hold-out cameras only: choose one in the last list above.",
                )
            })?;
            return Ok(of_frame(frame));
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
        Ok(of_picture(&picture))
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

fn of_frame(frame: &Frame) -> Painted {
    let pixels = frame
        .color
        .as_slice()
        .iter()
        .map(|color| Some(color.map(|c| steps_from_linear(c).clamp(0.0, 255.0).round() as u8)));
    let (width, height) = frame.color.size();
    Painted { size: [width, height], pixels: pixels.collect() }
}

fn of_picture(picture: &Picture) -> Painted {
    let (width, height) = picture.color.size();
    let pixels = picture.color.as_slice().iter().zip(picture.image.as_slice());
    let pixels = pixels.zip(picture.inverse_depth.as_slice()).map(|((color, image), inverse_depth)| {
        let something = *image != NO_IMAGE || *inverse_depth >= 0.0;
        something.then(|| color.map(srgb8_from_linear))
    });
    Painted { size: [width, height], pixels: pixels.collect() }
}

/// Share of pixels that may differ by more than a fitted range.
const BEYOND: f32 = 0.01;

fn compared(left: &Painted, right: &Painted, key: &CompareKey) -> Comparison {
    let tokens = Tokens::of(key.dark);
    let image = |side: &Painted| {
        let pixels = side
            .pixels
            .iter()
            .map(|pixel| pixel.map_or(tokens.hole, |[r, g, b]| egui::Color32::from_rgb(r, g, b)));
        Arc::new(ColorImage::new(side.size, pixels.collect()))
    };
    let apart: Vec<Option<f32>> = left
        .pixels
        .iter()
        .zip(&right.pixels)
        .map(|(a, b)| match (a, b) {
            (Some(a), Some(b)) => Some((0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0).into()),
            _ => None,
        })
        .collect();
    let mut sorted: Vec<f32> = apart.iter().flatten().copied().collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let fitted = sorted.get((sorted.len() as f32 * (1.0 - BEYOND)) as usize).copied().unwrap_or(1.0).max(1.0);
    let range = key.range.unwrap_or(fitted);
    let map = apart.iter().map(|apart| apart.map_or(tokens.hole, |apart| sequential(apart / range)));
    let (mut squares, mut sum, mut count, mut lonely) = (0.0, 0.0, 0_u64, 0_u64);
    for (a, b) in left.pixels.iter().zip(&right.pixels) {
        match (a, b) {
            (Some(a), Some(b)) => {
                for c in 0..3 {
                    let difference = f64::from(a[c].abs_diff(b[c]));
                    squares += difference * difference;
                    sum += difference;
                    count += 1;
                }
            }
            (None, None) => {}
            _ => lonely += 1,
        }
    }
    let count = count.max(1) as f64;
    Comparison {
        images: [image(left), image(right)],
        difference: Arc::new(ColorImage::new(left.size, map.collect())),
        range,
        psnr_db: 10.0 * (255.0 * 255.0 * count / squares).log10(),
        mean_steps: sum / count,
        one_sided: lonely as f64 / left.pixels.len().max(1) as f64,
    }
}
