//! Paints the samples that one pruning of a frame has and another lacks, as the live view sees them.

use std::collections::HashMap;
use std::sync::Arc;

use egui::{Color32, ColorImage};
use glam::{DVec2, DVec3};

use crate::app::camera_cues;
use crate::app::model::window::DockView;
use crate::app::model::{Message, Same, State};
use crate::app::rooms::change::state::ChangeRequest;
use crate::app::work::worker::Wanted;
use overlook_engine::capture::sighting::tolerances::MARKED_SURFACE;
use overlook_engine::capture::sighting::{Sighting, look};
use overlook_engine::samples::{SampleSet, TILE};

/// Most columns of the picture: it is drawn over the live view for less than a second.
const COLUMNS: u32 = 640;

/// Widest sample, pixels.
const WIDEST: f64 = 12.0;

impl Wanted for ChangeRequest {
    const IS_SHOWN: bool = false;

    fn wanted(state: &State) -> Option<Self> {
        let pair = state.doc.change.unpainted.clone().filter(|_| state.shows(DockView::Live))?;
        let [width, height] = state.live.size;
        let columns = width.clamp(1, COLUMNS);
        let rows = (u64::from(height) * u64::from(columns) / u64::from(width.max(1))).max(1) as u32;
        let shown = state.doc.live_shown.as_ref();
        let seen = shown.map(|shown| (Same(shown.picture.clone()), shown.key.vantage.camera.clone()));
        let camera = state.live_camera([columns, rows])?;
        Some(Self { scene: state.doc.scene.as_ref()?.id, pair, camera, seen })
    }
}

/// What went and what came; `None` where nothing did that is in view.
pub(crate) fn paint(request: ChangeRequest) -> Message {
    let [before, after] = request.pair.each_ref().map(|inspection| &inspection.samples);
    let pictures = [(before, after), (after, before)]
        .map(|(of, other)| Splats::of(&request).with_all(of, other).picture().map(Arc::new));
    Message::ChangePainted { request: Box::new(request), pictures }
}

/// Samples as squares of their width, in the colors of their cameras.
struct Splats<'a> {
    request: &'a ChangeRequest,
    size: [usize; 2],
    pixels: Vec<Color32>,
}

impl<'a> Splats<'a> {
    fn of(request: &'a ChangeRequest) -> Self {
        let lens = &request.camera.intrinsics;
        let size = [lens.width as usize, lens.height as usize];
        let pixels = vec![Color32::TRANSPARENT; size[0] * size[1]];
        Self { request, size, pixels }
    }

    /// Adds every sample that `other` has not, save those at infinity.
    fn with_all(mut self, of: &SampleSet, other: &SampleSet) -> Self {
        let mut known: HashMap<_, [u16; TILE]> = HashMap::new();
        for image in &other.images {
            for tile in &image.tiles {
                let rows = known.entry((image.camera, tile.tile_x, tile.tile_y)).or_default();
                rows.iter_mut().zip(tile.rows).for_each(|(all, row)| *all |= row);
            }
        }
        for image in &of.images {
            let camera = &of.cameras[image.camera as usize];
            for (index, tile) in image.tiles.iter().enumerate() {
                let known = known.get(&(image.camera, tile.tile_x, tile.tile_y)).copied().unwrap_or_default();
                if tile.rows.iter().zip(known).all(|(row, known)| row & !known == 0) {
                    continue;
                }
                let depths = image.depth.tile(index, tile.first, tile.count());
                for sample in tile.samples() {
                    let inverse_depth = depths.get(sample.index - tile.first as usize);
                    if known[sample.y % TILE] >> (sample.x % TILE) & 1 == 0 && inverse_depth > 0.0 {
                        let center = DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
                        let depth = f64::from(inverse_depth).recip();
                        let width = camera.intrinsics.spread_at(depth) / camera.intrinsics.fx;
                        self.add(camera.unproject(center, depth), width, image.camera as usize);
                    }
                }
            }
        }
        self
    }

    /// Adds a sample of a camera by its place and its width, world units.
    fn add(&mut self, point_in_world: DVec3, width: f64, camera: usize) {
        let to = &self.request.camera;
        let Some((at, depth)) = to.project(point_in_world) else { return };
        let width = width * to.intrinsics.fx / to.intrinsics.spread_at(depth);
        let half = width.clamp(1.0, WIDEST) / 2.0;
        let range = |middle: f64, side: usize| {
            let [first, end] = [middle - half, middle + half].map(|edge| edge.round().max(0.0) as usize);
            first.min(side)..end.min(side)
        };
        let (columns, rows) = (range(at.x, self.size[0]), range(at.y, self.size[1]));
        if columns.is_empty() || rows.is_empty() || self.is_hidden(point_in_world) {
            return;
        }
        let color = camera_cues::color(camera);
        for y in rows {
            self.pixels[y * self.size[0]..][columns.clone()].fill(color);
        }
    }

    /// Whether the live picture shows something before a point.
    fn is_hidden(&self, point_in_world: DVec3) -> bool {
        let seen = self.request.seen.as_ref();
        let seen = seen.and_then(|(picture, camera)| picture.rendered().map(|rendered| (rendered, camera)));
        seen.is_some_and(|(rendered, camera)| {
            look(camera, &rendered.inverse_depth, point_in_world, MARKED_SURFACE) == Sighting::Nearer
        })
    }

    fn picture(self) -> Option<ColorImage> {
        let is_empty = self.pixels.iter().all(|pixel| *pixel == Color32::TRANSPARENT);
        (!is_empty).then(|| ColorImage::new(self.size, self.pixels))
    }
}
