//! From one camera's frame and its verdicts to the pixels of the left view. Runs on a lane, not on the UI thread.

use std::sync::Arc;

use egui::{Color32, ColorImage};

use super::colormap::{camera as camera_color, dimmed, diverging, mix, sequential};
use crate::app::theme::Tokens;
use crate::capture::Frame;
use crate::color::steps_from_linear;
use crate::grid::Grid;
use crate::preprocess::inspect::{CameraInspection, FrameInspection};
use crate::preprocess::pruning::Verdict;
use crate::preprocess::temporal::PixelClass;
use crate::samples::TILE;

/// What the left view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub(crate) enum Overlay {
    /// The picture as recorded.
    #[default]
    Color,
    /// Depth.
    Depth,
    /// Surface normals.
    Normals,
    /// The sampling rate against another camera.
    SamplingRatio,
    /// Which camera's sample stands for each pruned one.
    WhoWon,
    /// Where the two rate models name different cameras.
    RateDisputes,
    /// For how long samples are stored.
    Split,
    /// What is kept in each tile of the store.
    Tiles,
}

impl Overlay {
    /// Whether it shows what became of the pixels.
    pub(crate) fn needs_verdicts(self) -> bool {
        !matches!(self, Self::Color | Self::Depth)
    }

    /// Every overlay, in the order of the menu.
    pub(crate) const ALL: [Self; 8] = [
        Self::Color,
        Self::WhoWon,
        Self::SamplingRatio,
        Self::RateDisputes,
        Self::Split,
        Self::Tiles,
        Self::Depth,
        Self::Normals,
    ];

    /// Its name in the menu.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Color => "Picture",
            Self::Depth => "Depth",
            Self::Normals => "Normals",
            Self::SamplingRatio => "Sampling",
            Self::RateDisputes => "Rates",
            Self::WhoWon => "Who won",
            Self::Split => "Motion",
            Self::Tiles => "Tiles",
        }
    }

    /// What it shows, in a sentence.
    pub(crate) fn help(self) -> &'static str {
        match self {
            Self::Color => "The picture as the camera recorded it.",
            Self::Depth => "How far away each pixel is: light is near.",
            Self::Normals => "Which way each surface faces, given or estimated.",
            Self::SamplingRatio => {
                "How densely this camera samples each point against another: purple where this one is denser, orange \
                 where the other is."
            }
            Self::RateDisputes => {
                "Where the paper's rate and the footprint name different cameras as the best: in the color of the one that \
                 the rate not in use names."
            }
            Self::WhoWon => {
                "Pruned pixels in the color of the camera whose sample stands for them; kept pixels show their own picture."
            }
            Self::Split => MOTION,
            Self::Tiles => {
                "The share of samples kept in each 16 × 16 tile of the store; empty tiles cost nothing."
            }
        }
    }
}

/// What either view's *Motion* shows.
pub(crate) const MOTION: &str = "For how long samples are stored: once for all frames, once for several frames where they hold that long, or for this \
     frame alone.";

/// What a left picture was made from; a picture with an equal key is the same picture.
#[derive(Clone)]
pub(crate) struct SourceKey {
    /// The scene.
    pub scene: u64,
    /// The camera.
    pub camera: usize,
    /// The frame.
    pub frame: usize,
    /// What is shown.
    pub overlay: Overlay,
    /// For the sampling ratio: against which camera, or the best other.
    pub against: Option<usize>,
    /// Dark or light, as overlays use colors of the theme.
    pub dark: bool,
    /// The verdicts; `None` for the bare picture.
    pub inspection: Option<Arc<FrameInspection>>,
}

impl PartialEq for SourceKey {
    fn eq(&self, other: &Self) -> bool {
        let same_inspection = match (&self.inspection, &other.inspection) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        same_inspection
            && (self.scene, self.camera, self.frame, self.overlay, self.against, self.dark)
                == (other.scene, other.camera, other.frame, other.overlay, other.against, other.dark)
    }
}

/// What the colors of a picture mean.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Legend {
    /// Colors are colors.
    Plain,
    /// Depth from `near` to `far`, in the capture's unit.
    Depth {
        /// Nearest depth on the scale.
        near: f32,
        /// Farthest depth on the scale.
        far: f32,
    },
    /// log₂ r from −[`RATIO_RANGE`] to [`RATIO_RANGE`].
    Ratio,
    /// Pixels that each camera won, and those that were kept.
    Winners {
        /// Kept pixels.
        kept: u64,
        /// Pixels lost to each camera.
        lost_to: Vec<u64>,
        /// Pixels dropped without a witness.
        dropped: u64,
    },
    /// Pixels on whose best-sampled camera both rate models agree, and those that each camera would win by the other model.
    RateDisputes {
        /// Pixels on which both agree.
        agreed: u64,
        /// Pixels that each camera would win.
        won_by: Vec<u64>,
    },
    /// Pixels per class.
    Split {
        /// The same over all frames.
        background: u64,
        /// The same over several frames.
        lasting: u64,
        /// Of this frame alone.
        foreground: u64,
        /// Without depth.
        invalid: u64,
    },
    /// Kept share of each tile, 0 to 1.
    Tiles(Grid<f32>),
}

/// log₂ r at either end of the scale: eight times denser or coarser.
pub(crate) const RATIO_RANGE: f32 = 3.0;

/// Largest side of a texture that every graphics card of the last ten years takes.
const LARGEST_TEXTURE: usize = 4096;

/// The left picture.
pub(crate) struct SourcePicture {
    /// Its pixels; of a very large picture every second, third, …
    pub image: Arc<ColorImage>,
    /// Columns and rows of the picture itself.
    pub size: [usize; 2],
    /// What they mean.
    pub legend: Legend,
}

/// Paints the picture that `key` asks for; `frame` is the recorded one.
pub(crate) fn paint(key: &SourceKey, frame: &Frame) -> SourcePicture {
    let tokens = Tokens::of(key.dark);
    let picture = frame.color.map(|c| display_color(*c));
    let verdicts = key.inspection.as_ref().map(|inspection| &inspection.cameras[key.camera]);
    let (pixels, legend) = match (key.overlay, verdicts) {
        (Overlay::Depth, _) => depth(frame, tokens),
        (Overlay::Normals, Some(camera)) => (normals(&camera.normal_in_world, tokens), Legend::Plain),
        (Overlay::SamplingRatio, Some(_)) => (sampling_ratio(key, &picture), Legend::Ratio),
        (Overlay::WhoWon, Some(camera)) => who_won(camera, &picture, tokens),
        (Overlay::RateDisputes, Some(camera)) => rate_disputes(camera, &picture),
        (Overlay::Split, Some(camera)) => split(camera, &picture, tokens),
        (Overlay::Tiles, Some(camera)) => tiles(camera, &picture),
        _ => (picture, Legend::Plain),
    };
    let size = [pixels.width(), pixels.height()];
    let pixels = thinned(pixels);
    let image = ColorImage::new([pixels.width(), pixels.height()], pixels.into_vec());
    SourcePicture { image: Arc::new(image), size, legend }
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

fn display_color(linear: [half::f16; 3]) -> Color32 {
    let [r, g, b] = linear.map(|c| steps_from_linear(c).clamp(0.0, 255.0).round() as u8);
    Color32::from_rgb(r, g, b)
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
    (pixels, Legend::Depth { near: 1.0 / near, far: 1.0 / far })
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

fn sampling_ratio(key: &SourceKey, picture: &Grid<Color32>) -> Grid<Color32> {
    let Some(inspection) = &key.inspection else { return picture.clone() };
    let ratio = inspection.log2_sampling_ratio(key.camera, key.against);
    Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let value = ratio[(x, y)];
        if value.is_nan() { dimmed(picture[(x, y)], 0.35) } else { diverging(value / RATIO_RANGE) }
    })
}

fn who_won(camera: &CameraInspection, picture: &Grid<Color32>, tokens: &Tokens) -> (Grid<Color32>, Legend) {
    let (mut kept, mut dropped) = (0, 0);
    let mut lost_to = Vec::new();
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let verdict = camera.verdict[(x, y)];
        let own = picture[(x, y)];
        if camera.class[(x, y)] == PixelClass::Invalid {
            return tokens.invalid;
        }
        if verdict.is_kept() {
            kept += 1;
            return own;
        }
        let winner = verdict.witness_camera as usize;
        if verdict.witness_camera == Verdict::NO_CAMERA {
            dropped += 1;
            return tokens.hole;
        }
        if lost_to.len() <= winner {
            lost_to.resize(winner + 1, 0);
        }
        lost_to[winner] += 1;
        mix(dimmed(own, 0.8), camera_color(winner), 0.72)
    });
    (pixels, Legend::Winners { kept, lost_to, dropped })
}

fn rate_disputes(camera: &CameraInspection, picture: &Grid<Color32>) -> (Grid<Color32>, Legend) {
    let mut agreed = 0;
    let mut won_by = Vec::new();
    let pixels = Grid::from_fn(picture.width(), picture.height(), |x, y| {
        let Some(winner) = camera.other_winner(y * picture.width() + x) else {
            agreed += 1;
            return dimmed(picture[(x, y)], 0.35);
        };
        if won_by.len() <= winner {
            won_by.resize(winner + 1, 0);
        }
        won_by[winner] += 1;
        mix(picture[(x, y)], camera_color(winner), 0.72)
    });
    (pixels, Legend::RateDisputes { agreed, won_by })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preprocess::pruning::{Dispute, Rule};

    fn camera() -> (CameraInspection, Grid<Color32>) {
        let (width, height) = (32, 16);
        let frame = Frame {
            color: Grid::filled(width, height, [half::f16::ONE; 3]),
            inverse_depth: Grid::filled(width, height, 0.5),
            normal_in_world: None,
            depth_step_relative: 0.0,
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
            disputes: (0..(width * height) as u32)
                .filter(|pixel| pixel % 32 < 8)
                .map(|pixel| Dispute { pixel, camera: 0, other_camera: 1 })
                .collect(),
            normal_in_world: Arc::new(Grid::filled(width, height, [0.0, 0.0, 1.0])),
        };
        (camera, Grid::filled(width, height, Color32::WHITE))
    }

    #[test]
    fn pruned_pixels_are_counted_for_their_winner() {
        let (camera, picture) = camera();
        let (pixels, legend) = who_won(&camera, &picture, Tokens::of(true));
        assert_eq!(legend, Legend::Winners { kept: 256, lost_to: vec![0, 0, 256], dropped: 0 });
        assert_eq!(pixels[(0, 0)], Color32::WHITE);
        assert_ne!(pixels[(20, 0)], Color32::WHITE);
    }

    #[test]
    fn pixels_on_which_the_rates_disagree_are_counted_for_the_other_winner() {
        let (camera, picture) = camera();
        let (pixels, legend) = rate_disputes(&camera, &picture);
        assert_eq!(legend, Legend::RateDisputes { agreed: 384, won_by: vec![0, 128] });
        assert_ne!(pixels[(0, 0)], pixels[(20, 0)]);
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
