//! Sample sets made up for the store's contract.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use half::f16;
use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::preprocess::diagnostics::{CameraReport, Report};
use overlook_engine::samples::{
    DepthPlane, OctNormal, SampleImage, SampleSet, SampleTile, Span, TILE, TileMask,
};
use overlook_engine::settings::{Precision, Settings};
use proptest::prelude::*;

fn camera(name: &str, width: u32, height: u32) -> Camera {
    Camera {
        name: name.to_owned(),
        intrinsics: Intrinsics::from_horizontal_angle(width, height, 0.9),
        world_from_camera: DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(0.3),
            DVec3::new(0.1, -2.0, 1.0 / 3.0),
        ),
    }
}

/// An image whose tiles have the given masks, cut to the picture; `values` seeds its planes.
fn image(
    camera_index: u32,
    camera: &Camera,
    span: Span,
    masks: &[u16],
    values: &[u32],
    normals: bool,
) -> SampleImage {
    let (width, height) = camera.intrinsics.size();
    let mut tiles = Vec::new();
    let mut first = 0;
    let mut masks = masks.iter().copied().cycle();
    for tile_y in 0..height.div_ceil(TILE) {
        for tile_x in 0..width.div_ceil(TILE) {
            let columns = (width - tile_x * TILE).min(TILE);
            let inside = if columns == TILE { u16::MAX } else { (1 << columns) - 1 };
            let mut mask = || masks.next().unwrap_or(0) & inside;
            let rows = std::array::from_fn(|row| if tile_y * TILE + row < height { mask() } else { 0 });
            let tile = SampleTile { tile_x: tile_x as u16, tile_y: tile_y as u16, first, rows };
            if tile.count() > 0 {
                first += tile.count() as u32;
                tiles.push(tile);
            }
        }
    }
    let count = first as usize;
    let value = |i: usize| values[i % values.len()].wrapping_add(i as u32 / 7);
    let half = |bits: u32| f16::from_bits((bits & 0x3FFF) as u16 | (bits >> 1 & 0x8000) as u16);
    // Zero is a sample at infinity.
    let inverse_depth: Vec<f32> = (0..count)
        .map(|i| if value(i).is_multiple_of(5) { 0.0 } else { f32::from_bits(value(i) & 0x7F00_FFFF) })
        .collect();
    let depth = DepthPlane::pack(&tiles, &inverse_depth);
    SampleImage {
        camera: camera_index,
        span,
        color: (0..count).map(|i| [value(i), value(i + 1), value(i + 2) >> 3].map(half)).collect(),
        depth,
        normal: normals
            .then(|| (0..count).map(|i| OctNormal([value(i) as i8, (value(i) >> 8) as i8])).collect()),
        doubtful: doubtful(&tiles, values),
        tiles,
        values: overlook_engine::capture::Values::default(),
    }
}

/// What promises every bit.
fn lossless() -> Settings {
    let mut settings = Settings::default();
    settings.store.precision = Precision::Lossless;
    settings
}

fn set_of(cameras: Vec<Camera>, frames: usize, images: Vec<SampleImage>) -> SampleSet {
    SampleSet {
        name: "Kristallisation ❄".to_owned(),
        cameras,
        frame_numbers: (0..frames as i64).map(|frame| 3 * frame - 4).collect(),
        up_in_world: DVec3::new(0.0, 0.6, 0.8),
        settings: lossless(),
        images: images.into_iter().filter(|image| !image.is_empty()).map(Arc::new).collect(),
        values: Vec::new(),
    }
}

pub(crate) fn small_set() -> SampleSet {
    let cameras = vec![camera("left", 20, 18), camera("right", 17, 5)];
    let images = vec![
        image(0, &cameras[0], Span { start: 0, end: 2 }, &[0xFFFF, 0x00F0, 0], &[7, 0x3C00_1234], true),
        image(1, &cameras[1], Span { start: 1, end: 2 }, &[0x1001], &[0x1_0000, 5, 99], false),
    ];
    set_of(cameras, 2, images)
}

/// Ten frames of one camera, 90×70 pixels, in which a plane stays and its colors drift.
pub(crate) fn moving_set() -> SampleSet {
    let cameras = vec![camera("one", 90, 70)];
    let images = (0..10).map(|frame| {
        let span = Span { start: frame, end: frame + 1 };
        let mut image = image(0, &cameras[0], span, &[0xFFFF, 0x7FFE, 0x0FF0], &[7], false);
        let depths: Vec<f32> =
            image.samples().map(|sample| 0.25 + sample.x as f32 * 0.001 - sample.y as f32 * 0.0005).collect();
        image.depth = DepthPlane::pack(&image.tiles, &depths);
        image.color = image
            .samples()
            .map(|sample| {
                let shade = (sample.x * 37 % 23 + sample.y * 11 % 17) as f32 / 80.0;
                [shade, shade * 0.5 + 0.001 * frame as f32, 0.25].map(f16::from_f32)
            })
            .collect();
        image
    });
    let images = images.collect();
    set_of(cameras, 10, images)
}

/// A report as a store keeps it.
pub(crate) fn small_report() -> String {
    let mut report = Report { samples_in: 890, ..Report::default() };
    report.cameras.push(CameraReport { color_noise_steps: 0.1, ..CameraReport::default() });
    report.pruned.insert("static".to_owned(), 17);
    report.to_json().unwrap()
}

pub(crate) fn any_set() -> impl Strategy<Value = SampleSet> {
    let mask = prop_oneof![Just(0_u16), Just(u16::MAX), any::<u16>()];
    let parts = (
        (1..40_u32, 1..40_u32, 1..4_usize),
        prop::collection::vec(prop::collection::vec(mask, 1..40), 0..5),
        prop::collection::vec(any::<u32>(), 1..20),
        any::<bool>(),
    );
    parts.prop_map(|((width, height, frames), masks, values, normals)| {
        let cameras = vec![camera("a", width, height), camera("b", height, width)];
        let mut images: Vec<SampleImage> = Vec::new();
        for (i, masks) in masks.iter().enumerate() {
            let index = (i % 2) as u32;
            let start = (i % frames) as u32;
            let span = Span { start, end: start + 1 + (i as u32 % (frames as u32 - start)) };
            // A camera has at most one image of a span.
            if images.iter().all(|image| (image.camera, image.span) != (index, span)) {
                images.push(image(index, &cameras[index as usize], span, masks, &values, normals));
            }
        }
        set_of(cameras, frames, images)
    })
}

/// In some sets some of the samples of every third tile or so.
fn doubtful(tiles: &[SampleTile], values: &[u32]) -> Vec<TileMask> {
    let value = |i: usize| values[i % values.len()].wrapping_mul(0x9E37_79B9).rotate_left(i as u32 % 32);
    let tiles = tiles.iter().enumerate().filter(|_| values[0].is_multiple_of(2));
    let masks =
        tiles.filter(|(tile, _)| value(*tile).is_multiple_of(3)).map(|(tile, SampleTile { rows, .. })| {
            let rows = std::array::from_fn(|row| rows[row] & (value(tile + row) >> 9) as u16);
            TileMask { tile: tile as u32, rows }
        });
    masks.filter(|mask| mask.rows != [0; TILE]).collect()
}
