//! Paints the picture of the left view, from one camera's frame and its verdicts.

use std::sync::Arc;

use egui::{Color32, ColorImage};

use crate::app::camera_cues;
use crate::app::colormap::{agreeing, dimmed, diverging, mix, recorded, sequential};
use crate::app::model::picture::{
    Legend, Overlay, RATIO_RANGE, SourceKey, SourcePicture, VIEW_DEPENDENCE_RANGE, ranked,
};
use crate::app::model::{Message, OpenScene, Same, State, percent};
use crate::app::theme::Tokens;
use crate::app::work::develop::{background_at, displayed, histogram_of};
use crate::app::work::worker::Wanted;
use overlook_engine::capture::Frame;
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;
use overlook_engine::preprocess::agreement::SampleAgreement;
use overlook_engine::preprocess::inspect::{CameraInspection, VISIBLE_STEPS};
use overlook_engine::preprocess::pruning::Verdict;
use overlook_engine::preprocess::temporal::PixelClass;
use overlook_engine::samples::TILE;

/// Largest side of a texture that every graphics card of the last ten years takes.
const LARGEST_TEXTURE: usize = 4096;

/// A picture of the source view.
#[derive(Clone, PartialEq)]
pub(crate) struct SourceRequest {
    pub scene: Arc<OpenScene>,
    pub key: SourceKey,
}

impl Wanted for SourceRequest {
    fn wanted(state: &State) -> Option<Self> {
        let scene = state.doc.scene.clone()?;
        let (overlay, has_capture) = (state.source.overlay, state.has_capture());
        // Verdicts of a frame just passed are better than a flash of another kind: in motion they may never catch up.
        let inspected = state.doc.inspected.as_ref().filter(|_| overlay.needs_verdicts() || !has_capture);
        let inspection = inspected.map(|inspected| Same(inspected.inspection.clone()));
        if inspection.is_none() && !has_capture {
            return None;
        }
        let key = SourceKey {
            scene: scene.id,
            camera: state.source.camera,
            frame: inspection.as_ref().map_or(state.timeline.frame, |inspection| inspection.frame),
            overlay,
            against: state.source.against,
            isolated: state.doc.isolated.filter(|_| overlay.names_cameras()),
            display: state.display,
            dark: state.dark,
            inspection,
        };
        Some(Self { scene, key })
    }
}

/// Paints the picture of `key`; without verdicts `decoder` reads the frame.
pub(crate) fn paint_source(request: SourceRequest, decoder: &rayon::ThreadPool) -> Result<Message> {
    let SourceRequest { scene, key } = request;
    let frame = if let Some(inspection) = &key.inspection {
        inspection.cameras[key.camera].frame.clone()
    } else {
        let capture = scene.source()?;
        decoder.install(|| capture.frame(key.camera, key.frame))?
    };
    let picture = source_picture(&key, &frame);
    Ok(Message::SourcePainted { key, picture: Arc::new(picture) })
}

/// The picture of a key, of what its camera recorded at its frame.
pub(crate) fn source_picture(key: &SourceKey, frame: &Frame) -> SourcePicture {
    let tokens = Tokens::of(key.dark);
    let linear = |c: &[half::f16; 3]| c.map(half::f16::to_f32);
    let neutral = key.display.is_neutral();
    let picture = if neutral { frame.color.map(|c| recorded(*c)) } else { shown_picture(key, frame) };
    let histogram = (key.overlay == Overlay::Color).then(|| histogram_of(&frame.color, &picture, linear));
    let verdicts = key.inspection.as_ref().map(|inspection| &inspection.cameras[key.camera]);
    let (pixels, legend) = match (key.overlay, verdicts) {
        (Overlay::Depth, _) => depth(frame, tokens),
        (Overlay::Normals, Some(camera)) => (normals(&camera.normal_in_world, tokens), Legend::Plain),
        (Overlay::SamplingRatio, Some(_)) => sampling_ratio(key, &picture),
        (Overlay::WhoWon, Some(camera)) => who_won(camera, &picture, tokens, key.isolated),
        (Overlay::Agreement, Some(_)) => agreement(key, &picture, tokens),
        (Overlay::ViewDependence, Some(_)) => view_dependence(key, &picture),
        (Overlay::Split, Some(camera)) => split(camera, &picture, tokens),
        (Overlay::Tiles, Some(camera)) => tiles(camera, &picture),
        _ => (picture, Legend::Plain),
    };
    let size = [pixels.width(), pixels.height()];
    let pixels = thinned(pixels);
    let image = ColorImage::new([pixels.width(), pixels.height()], pixels.into_vec());
    SourcePicture { image: Arc::new(image), size, legend, histogram }
}

/// The picture by the person's choice of exposure, curve, channel and background.
fn shown_picture(key: &SourceKey, frame: &Frame) -> Grid<Color32> {
    Grid::from_fn(frame.color.width(), frame.color.height(), |x, y| {
        let at_infinity = frame.inverse_depth[(x, y)] == 0.0;
        let background = background_at(key.display.background, x, y).filter(|_| at_infinity);
        background.unwrap_or_else(|| displayed(&key.display, frame.color[(x, y)].map(half::f16::to_f32)))
    })
}

/// Every n-th pixel of a picture that graphics cards may refuse as a texture.
fn thinned(pixels: Grid<Color32>) -> Grid<Color32> {
    let step = pixels.width().max(pixels.height()).div_ceil(LARGEST_TEXTURE).max(1);
    if step == 1 {
        return pixels;
    }
    Grid::from_fn(pixels.width().div_ceil(step), pixels.height().div_ceil(step), |x, y| {
        pixels[(x * step, y * step)]
    })
}

fn depth(frame: &Frame, tokens: &Tokens) -> (Grid<Color32>, Legend) {
    let mut finite: Vec<f32> = frame.inverse_depth.as_slice().iter().copied().filter(|w| *w > 0.0).collect();
    finite.sort_unstable_by(f32::total_cmp);
    // The outermost hundredth on either side would stretch the scale for a handful of pixels.
    let at = |share: f32| finite.get((finite.len().saturating_sub(1) as f32 * share) as usize).copied();
    let (far, near) = (at(0.01).unwrap_or(0.0), at(0.99).unwrap_or(1.0));
    let range = (near - far).max(f32::MIN_POSITIVE);
    let pixels = frame.inverse_depth.map(|&w| match w {
        w if w < 0.0 => tokens.invalid,
        w => sequential((w - far) / range),
    });
    let depths = frame.inverse_depth.as_slice();
    let without = depths.iter().filter(|w| **w < 0.0).count() as f32 / depths.len().max(1) as f32;
    (pixels, Legend::Depth { near: 1.0 / near, far: 1.0 / far, without })
}

fn normals(normal_in_world: &Grid<[f32; 3]>, tokens: &Tokens) -> Grid<Color32> {
    normal_in_world.map(|n| {
        if *n == [0.0; 3] {
            return tokens.invalid;
        }
        let [r, g, b] = n.map(|c| ((c * 0.5 + 0.5) * 255.0).clamp(0.0, 255.0) as u8);
        Color32::from_rgb(r, g, b)
    })
}

fn who_won(
    camera: &CameraInspection,
    picture: &Grid<Color32>,
    tokens: &Tokens,
    isolated: Option<usize>,
) -> (Grid<Color32>, Legend) {
    let (mut kept, mut dropped, mut invalid) = (0, 0, 0);
    let mut lost_to = Vec::new();
    for verdict in camera.verdict.as_slice() {
        if !verdict.is_kept() && verdict.witness_camera != Verdict::NO_CAMERA {
            count(&mut lost_to, verdict.witness_camera as usize);
        }
    }
    let colors = CameraColors::new(&lost_to, isolated, tokens);
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let verdict = camera.verdict[(x, y)];
        let own = picture[(x, y)];
        if camera.class[(x, y)] == PixelClass::Invalid {
            invalid += 1;
            return tokens.invalid;
        }
        if verdict.is_kept() {
            kept += 1;
            return if isolated.is_some() { dimmed(own, ASIDE) } else { own };
        }
        let winner = verdict.witness_camera as usize;
        if verdict.witness_camera == Verdict::NO_CAMERA {
            dropped += 1;
            return tokens.hole;
        }
        colors.at(winner, x, y, dimmed(own, 0.8))
    });
    (pixels, Legend::Winners { kept, lost_to, dropped, invalid })
}

fn agreement(key: &SourceKey, picture: &Grid<Color32>, tokens: &Tokens) -> (Grid<Color32>, Legend) {
    match &key.inspection {
        Some(inspection) => agreement_picture(&inspection.agreement(key.camera), picture, tokens),
        None => (picture.clone(), Legend::Plain),
    }
}

fn agreement_picture(
    agreement: &Grid<Option<SampleAgreement>>,
    picture: &Grid<Color32>,
    tokens: &Tokens,
) -> (Grid<Color32>, Legend) {
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| match agreement[(x, y)] {
        None => tokens.invalid,
        Some(found) => agreeing(picture[(x, y)], found, tokens),
    });
    let count = |wanted| agreement.as_slice().iter().filter(|found| **found == wanted).count() as u64;
    let legend = Legend::Agreement {
        confirmed: count(Some(SampleAgreement::Confirmed)),
        contradicted: count(Some(SampleAgreement::Contradicted)),
        alone: count(Some(SampleAgreement::Alone)),
        invalid: count(None),
    };
    (pixels, legend)
}

/// Brightness of pixels that are not those of the isolated camera.
const ASIDE: f32 = 0.3;

/// In which colors the pixels of a picture show the cameras that won them.
struct CameraColors {
    /// Whether a camera has a color of its own in this picture, by its index.
    is_named: Vec<bool>,
    isolated: Option<usize>,
    others: Color32,
}

impl CameraColors {
    fn new(won_by: &[u64], isolated: Option<usize>, tokens: &Tokens) -> Self {
        let (ranked, named) = ranked(won_by);
        let mut is_named = vec![false; won_by.len()];
        for camera in &ranked[..named] {
            is_named[*camera] = true;
        }
        Self { is_named, isolated, others: tokens.text_weak }
    }

    /// The color of a pixel that `camera` won, over what it shows.
    fn at(&self, camera: usize, x: usize, y: usize, under: Color32) -> Color32 {
        match self.isolated {
            Some(isolated) if isolated != camera => dimmed(under, ASIDE),
            None if !self.is_named.get(camera).is_some_and(|named| *named) => mix(under, self.others, 0.72),
            _ => mix(under, camera_cues::color_at(camera, x, y), 0.72),
        }
    }
}

/// Counts one more pixel for a camera.
fn count(pixels: &mut Vec<u64>, camera: usize) {
    if pixels.len() <= camera {
        pixels.resize(camera + 1, 0);
    }
    pixels[camera] += 1;
}

fn split(camera: &CameraInspection, picture: &Grid<Color32>, tokens: &Tokens) -> (Grid<Color32>, Legend) {
    let (mut background, mut lasting, mut foreground, mut invalid) = (0, 0, 0, 0);
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let own = dimmed(picture[(x, y)], 0.9);
        match camera.class[(x, y)] {
            PixelClass::Background => {
                background += 1;
                mix(own, tokens.static_over_time, 0.55)
            }
            PixelClass::Lasting => {
                lasting += 1;
                mix(own, tokens.lasting, 0.7)
            }
            PixelClass::Foreground => {
                foreground += 1;
                mix(own, tokens.moving, 0.7)
            }
            PixelClass::Invalid => {
                invalid += 1;
                tokens.invalid
            }
        }
    });
    (pixels, Legend::Split { background, lasting, foreground, invalid })
}

fn tiles(camera: &CameraInspection, picture: &Grid<Color32>) -> (Grid<Color32>, Legend) {
    let (width, height) = picture.size();
    let shares = Grid::from_fn(width.div_ceil(TILE), height.div_ceil(TILE), |tile_x, tile_y| {
        let columns = tile_x * TILE..((tile_x + 1) * TILE).min(width);
        let rows = tile_y * TILE..((tile_y + 1) * TILE).min(height);
        let pixels = columns.len() * rows.len();
        let kept = rows
            .flat_map(|y| columns.clone().map(move |x| (x, y)))
            .filter(|&at| camera.verdict[at].is_kept())
            .count();
        kept as f32 / pixels.max(1) as f32
    });
    let pixels = Grid::from_fn(width, height, |x, y| {
        let share = shares[(x / TILE, y / TILE)];
        let own = picture[(x, y)];
        let on_edge = x % TILE == 0 || y % TILE == 0;
        if share == 0.0 {
            dimmed(own, if on_edge { 0.15 } else { 0.3 })
        } else {
            mix(dimmed(own, 0.9), sequential(share), if on_edge { 0.9 } else { 0.6 })
        }
    });
    (pixels, Legend::Tiles(shares))
}

/// What is said of the tiles that show the dark picture.
pub(crate) fn empty_tiles(shares: &Grid<f32>) -> String {
    let empty = shares.as_slice().iter().filter(|share| **share == 0.0).count();
    format!("empty {}", percent(empty as u64, shares.len() as u64))
}

/// Brightness of pixels that no other camera shows.
pub(crate) const UNKNOWN: f32 = 0.35;

/// The sampling ratio against another camera, or the best of them; dimmed if no other camera shows the point.
pub(crate) fn sampling_ratio(key: &SourceKey, picture: &Grid<Color32>) -> (Grid<Color32>, Legend) {
    let Some(inspection) = &key.inspection else { return (picture.clone(), Legend::Plain) };
    let ratio = inspection.log2_sampling_ratio(key.camera, key.against);
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let value = ratio[(x, y)];
        if value.is_nan() { dimmed(picture[(x, y)], UNKNOWN) } else { diverging(value / RATIO_RANGE) }
    });
    let unknown = ratio.as_slice().iter().filter(|value| value.is_nan()).count();
    (pixels, Legend::Ratio { unknown: unknown as f32 / ratio.len().max(1) as f32 })
}

/// By how much colors differ from those of other cameras; dimmed where none shows the point.
pub(crate) fn view_dependence(key: &SourceKey, picture: &Grid<Color32>) -> (Grid<Color32>, Legend) {
    let Some(inspection) = &key.inspection else { return (picture.clone(), Legend::Plain) };
    let found = inspection.view_dependence(key.camera);
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let steps = found[(x, y)];
        let of_camera = dimmed(picture[(x, y)], UNKNOWN);
        if steps.is_nan() { of_camera } else { sequential(steps / VIEW_DEPENDENCE_RANGE) }
    });
    let count =
        |wanted: fn(f32) -> bool| found.as_slice().iter().filter(|steps| wanted(**steps)).count() as u64;
    let legend = Legend::ViewDependence {
        visible: count(|steps| steps >= VISIBLE_STEPS),
        alike: count(|steps| steps < VISIBLE_STEPS),
        unknown: count(f32::is_nan),
    };
    (pixels, legend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::preprocess::pruning::Rule;

    fn camera() -> (CameraInspection, Grid<Color32>) {
        let (width, height) = (32, 16);
        let frame = Frame {
            color: Grid::filled(width, height, [half::f16::ONE; 3]),
            inverse_depth: Grid::filled(width, height, 0.5),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: overlook_engine::capture::Values::default(),
        };
        let lost = Verdict { rule: Rule::LowerRate, witness_level: 0, witness_camera: 2, witness_pixel: 0 };
        let camera = CameraInspection {
            frame: Arc::new(frame),
            class: Arc::new(Grid::from_fn(width, height, |x, _| match x {
                0..16 => PixelClass::Background,
                16..24 => PixelClass::Lasting,
                _ => PixelClass::Foreground,
            })),
            level: Arc::new(Grid::from_fn(width, height, |x, _| u8::from(x >= 16))),
            verdict: Grid::from_fn(width, height, |x, _| {
                if x < 16 { Verdict::without_witness(Rule::BestRate) } else { lost }
            }),
            normal_in_world: Arc::new(Grid::filled(width, height, [0.0, 0.0, 1.0])),
        };
        (camera, Grid::filled(width, height, Color32::WHITE))
    }

    #[test]
    fn pruned_pixels_are_counted_for_their_winner() {
        let (camera, picture) = camera();
        let (pixels, legend) = who_won(&camera, &picture, Tokens::of(true), None);
        assert_eq!(legend, Legend::Winners { kept: 256, lost_to: vec![0, 0, 256], dropped: 0, invalid: 0 });
        assert_eq!(pixels[(0, 0)], Color32::WHITE);
        assert_ne!(pixels[(20, 0)], Color32::WHITE);
    }

    #[test]
    fn what_others_confirm_what_they_contradict_and_what_is_alone_is_told_apart_and_counted() {
        let found = [
            Some(SampleAgreement::Confirmed),
            Some(SampleAgreement::Contradicted),
            Some(SampleAgreement::Alone),
            None,
        ];
        let agreement = Grid::from_fn(32, 16, |x, _| found[x / 8]);
        let (_, picture) = camera();
        for dark in [true, false] {
            let (pixels, legend) = agreement_picture(&agreement, &picture, Tokens::of(dark));
            let counts = Legend::Agreement { confirmed: 128, contradicted: 128, alone: 128, invalid: 128 };
            assert_eq!(legend, counts);
            let colors: std::collections::HashSet<_> = pixels.as_slice().iter().collect();
            assert_eq!(colors.len(), 4);
        }
    }

    #[test]
    fn a_very_large_picture_still_fits_a_texture() {
        let thin = thinned(Grid::filled(LARGEST_TEXTURE * 2 + 1, 2, Color32::WHITE));
        assert_eq!(thin.size(), (2731, 1));
        assert_eq!(thinned(Grid::filled(5, 4, Color32::WHITE)).size(), (5, 4));
    }

    #[test]
    fn a_tile_shows_its_kept_share() {
        let (camera, picture) = camera();
        let (_, legend) = tiles(&camera, &picture);
        assert_eq!(legend, Legend::Tiles(Grid::from_vec(2, 1, vec![1.0, 0.0])));
    }

    #[test]
    fn what_holds_for_all_frames_for_several_and_for_one_is_told_apart_and_counted() {
        let (camera, picture) = camera();
        let (pixels, legend) = split(&camera, &picture, Tokens::of(false));
        assert_eq!(legend, Legend::Split { background: 256, lasting: 128, foreground: 128, invalid: 0 });
        let [all, several, one] = [0, 20, 28].map(|x| pixels[(x, 0)]);
        assert!(all != several && several != one && one != all);
    }
}
