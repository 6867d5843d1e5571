//! The normals of samples: those of the store, or else estimated from the depths around.
//!
//! Around a sample lie those of its camera that hold at least as long: they are there whenever it is.

use glam::Vec3;

use crate::capture::Camera;
use crate::preprocess::normals::{DepthView, MIN_CONFIDENCE, estimate_at};
use crate::samples::{SampleImage, TILE, TILE_SAMPLES};
use crate::settings::NormalSettings;

/// For each sample of an image its normal in world space, unit length, toward `camera`, which saw it; zero where none can be told.
/// `around` are images of the same camera and resolution, whatever holds at least as long as this one.
pub(super) fn normals(
    image: &SampleImage,
    around: &[&SampleImage],
    camera: &Camera,
    settings: &NormalSettings,
) -> Vec<Vec3> {
    let mut normals: Vec<Vec3> = match &image.normal {
        Some(stored) => stored.iter().map(|normal| normal.decode()).collect(),
        None => vec![Vec3::ZERO; image.len()],
    };
    let (width, height) = camera.intrinsics.size();
    let unknown = |index: usize| normals[index] == Vec3::ZERO;
    let (indices, pixels): (Vec<usize>, Vec<u32>) = image
        .samples()
        .filter(|sample| unknown(sample.index) && sample.x < width && sample.y < height)
        .map(|sample| (sample.index, (sample.y * width + sample.x) as u32))
        .unzip();
    if pixels.is_empty() {
        return normals;
    }
    let mut depths = vec![0.0; width * height];
    let near = NearTiles::of(image, width.div_ceil(TILE), height.div_ceil(TILE));
    for image in around.iter().copied().chain([image]) {
        lay_out(image, &near, &mut depths, width);
    }
    let view = DepthView::new(&depths, camera, settings);
    let rotation = camera.world_from_camera.matrix3.as_mat3();
    for (index, estimate) in indices.into_iter().zip(estimate_at(&view, settings.estimator, &pixels)) {
        if estimate.confidence >= MIN_CONFIDENCE {
            normals[index] = rotation * estimate.normal_in_camera;
        }
    }
    normals
}

/// The tiles of an image and those beside them.
struct NearTiles {
    columns: usize,
    is_near: Vec<bool>,
}

impl NearTiles {
    fn of(image: &SampleImage, columns: usize, rows: usize) -> Self {
        let mut is_near = vec![false; columns * rows];
        for tile in &image.tiles {
            let (x, y) = (usize::from(tile.tile_x), usize::from(tile.tile_y));
            for row in y.saturating_sub(1)..(y + 2).min(rows) {
                for column in x.saturating_sub(1)..(x + 2).min(columns) {
                    is_near[row * columns + column] = true;
                }
            }
        }
        Self { columns, is_near }
    }

    fn has(&self, tile_x: u16, tile_y: u16) -> bool {
        let at = usize::from(tile_y) * self.columns + usize::from(tile_x);
        usize::from(tile_x) < self.columns && self.is_near.get(at).copied().unwrap_or(false)
    }
}

/// Puts the inverse depths of an image's tiles into the pixels of a picture, row-major.
fn lay_out(image: &SampleImage, near: &NearTiles, depths: &mut [f32], width: usize) {
    let mut unpacked = [0.0; TILE_SAMPLES];
    for (index, tile) in image.tiles.iter().enumerate().filter(|(_, tile)| near.has(tile.tile_x, tile.tile_y))
    {
        image.depth.tile(index, tile.first, tile.count()).unpack(&mut unpacked);
        let (left, top) = (usize::from(tile.tile_x) * TILE, usize::from(tile.tile_y) * TILE);
        let mut nth = 0;
        for (row, columns) in tile.rows.iter().enumerate() {
            for column in (0..TILE).filter(|column| columns >> column & 1 == 1) {
                let (x, y) = (left + column, top + row);
                if x < width
                    && let Some(depth) = depths.get_mut(y * width + x)
                {
                    *depth = unpacked[nth];
                }
                nth += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::job::Job;
    use crate::preprocess::preprocess;
    use crate::settings::Settings;

    #[test]
    fn estimated_normals_are_those_that_a_store_would_have_kept() {
        let demo = Demo::new(&DemoSpec::new("orrery").size((160, 120)).cameras(2).frames(2)).unwrap();
        let mut settings = Settings::default();
        settings.store.normals = true;
        let set = preprocess(&demo.capture(&settings.capture), &settings, &Job::new()).unwrap().samples;
        let image = set.images_at(0).max_by_key(|image| image.len()).unwrap();
        let camera = &set.cameras[image.camera as usize];
        let around: Vec<&SampleImage> = Vec::new();
        let given = normals(image, &around, camera, &settings.normals);
        let mut bare = (**image).clone();
        bare.normal = None;
        let estimated = normals(&bare, &around, camera, &settings.normals);
        let depths = image.inverse_depths();
        let (mut close, mut known) = (0, 0);
        for index in (0..image.len()).filter(|index| depths[*index] > 0.0) {
            let (given, estimated) = (given[index], estimated[index]);
            known += usize::from(estimated != Vec3::ZERO);
            close += usize::from(given.dot(estimated) > 0.97);
        }
        assert!(known * 10 > image.len() * 4 && close * 100 > known * 90, "{close} of {known}");
    }
}
