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
            isolated: state.doc.isolated.filter(|_| overlay == Overlay::WhoWon),
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
    let found = key.inspection.as_ref().map(|found| (found, &found.cameras[key.camera]));
    let (pixels, legend) = match (key.overlay, found) {
        (Overlay::Depth, _) => depth(frame, tokens),
        (Overlay::Normals, Some((_, camera))) => (normals(&camera.normal_in_world, tokens), Legend::Plain),
        (Overlay::SamplingRatio, Some((inspection, _))) => {
            sampling_ratio(&inspection.log2_sampling_ratio(key.camera, key.against), &picture)
        }
        (Overlay::WhoWon, Some((_, camera))) => who_won(camera, &picture, tokens, key.isolated),
        (Overlay::Agreement, Some((inspection, _))) => {
            agreement(&inspection.agreement(key.camera), &picture, tokens)
        }
        (Overlay::ViewDependence, Some((inspection, _))) => {
            view_dependence(&inspection.view_dependence(key.camera), &picture)
        }
        (Overlay::Split, Some((_, camera))) => split(&camera.class, &picture, tokens),
        (Overlay::Tiles, Some((_, camera))) => tiles(camera, &picture),
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

/// Brightness of pixels that are not those of the isolated camera.
const ASIDE: f32 = 0.3;

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
            let winner = verdict.witness_camera as usize;
            lost_to.resize(lost_to.len().max(winner + 1), 0);
            lost_to[winner] += 1;
        }
    }
    let (ranked, named) = ranked(&lost_to);
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
        if verdict.witness_camera == Verdict::NO_CAMERA {
            dropped += 1;
            return tokens.hole;
        }
        let (winner, under) = (verdict.witness_camera as usize, dimmed(own, 0.8));
        match isolated {
            Some(isolated) if isolated != winner => dimmed(under, ASIDE),
            None if !ranked[..named].contains(&winner) => mix(under, tokens.text_weak, 0.72),
            _ => mix(under, camera_cues::color_at(winner, x, y), 0.72),
        }
    });
    (pixels, Legend::Winners { kept, lost_to, dropped, invalid })
}

/// Pixels by their class of three and its color, which `class_of` gives; none for those without depth.
fn classified(
    picture: &Grid<Color32>,
    tokens: &Tokens,
    class_of: impl Fn(usize, usize) -> Option<(usize, Color32)>,
) -> (Grid<Color32>, Legend) {
    let (mut counts, mut invalid) = ([0; 3], 0);
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let Some((class, color)) = class_of(x, y) else {
            invalid += 1;
            return tokens.invalid;
        };
        counts[class] += 1;
        color
    });
    (pixels, Legend::Classes { counts, invalid })
}

fn agreement(
    agreement: &Grid<Option<SampleAgreement>>,
    picture: &Grid<Color32>,
    tokens: &Tokens,
) -> (Grid<Color32>, Legend) {
    classified(picture, tokens, |x, y| {
        let found = agreement[(x, y)]?;
        let class = match found {
            SampleAgreement::Confirmed => 0,
            SampleAgreement::Contradicted => 1,
            SampleAgreement::Alone => 2,
        };
        Some((class, agreeing(picture[(x, y)], found, tokens)))
    })
}

fn split(classes: &Grid<PixelClass>, picture: &Grid<Color32>, tokens: &Tokens) -> (Grid<Color32>, Legend) {
    classified(picture, tokens, |x, y| {
        let (class, color, opacity) = match classes[(x, y)] {
            PixelClass::Background => (0, tokens.static_over_time, 0.55),
            PixelClass::Lasting => (1, tokens.lasting, 0.7),
            PixelClass::Foreground => (2, tokens.moving, 0.7),
            PixelClass::Invalid => return None,
        };
        Some((class, mix(dimmed(picture[(x, y)], 0.9), color, opacity)))
    })
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

/// A quantity in colors; dimmed where no other camera shows the point, so that it is not known.
fn colored(found: &Grid<f32>, picture: &Grid<Color32>, color: impl Fn(f32) -> Color32) -> Grid<Color32> {
    Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let value = found[(x, y)];
        if value.is_nan() { dimmed(picture[(x, y)], UNKNOWN) } else { color(value) }
    })
}

fn count(found: &Grid<f32>, wanted: fn(f32) -> bool) -> u64 {
    found.as_slice().iter().filter(|value| wanted(**value)).count() as u64
}

/// The sampling ratio against another camera, or the best of them.
fn sampling_ratio(log2_ratio: &Grid<f32>, picture: &Grid<Color32>) -> (Grid<Color32>, Legend) {
    let pixels = colored(log2_ratio, picture, |ratio| diverging(ratio / RATIO_RANGE));
    let unknown = count(log2_ratio, f32::is_nan) as f32 / log2_ratio.len().max(1) as f32;
    (pixels, Legend::Ratio { unknown })
}

/// By how much colors differ from those of other cameras.
fn view_dependence(steps: &Grid<f32>, picture: &Grid<Color32>) -> (Grid<Color32>, Legend) {
    let legend = Legend::ViewDependence {
        visible: count(steps, |steps| steps >= VISIBLE_STEPS),
        alike: count(steps, |steps| steps < VISIBLE_STEPS),
        unknown: count(steps, f32::is_nan),
    };
    (colored(steps, picture, |steps| sequential(steps / VIEW_DEPENDENCE_RANGE)), legend)
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
    fn classes_of_motion_and_of_agreement_are_told_apart_and_counted() {
        let found = [
            Some(SampleAgreement::Confirmed),
            Some(SampleAgreement::Contradicted),
            Some(SampleAgreement::Alone),
            None,
        ];
        let agreements = Grid::from_fn(32, 16, |x, _| found[x / 8]);
        let (camera, picture) = camera();
        for tokens in [true, false].map(Tokens::of) {
            for ((pixels, legend), counts, invalid) in [
                (agreement(&agreements, &picture, tokens), [128; 3], 128),
                (split(&camera.class, &picture, tokens), [256, 128, 128], 0),
            ] {
                assert_eq!(legend, Legend::Classes { counts, invalid });
                let colors: std::collections::HashSet<_> = pixels.as_slice().iter().collect();
                assert_eq!(colors.len(), if invalid > 0 { 4 } else { 3 });
            }
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
}
