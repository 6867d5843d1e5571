//! A second reader, written from FORMAT.md alone: nothing of the library's store is used to read, so that the page must be right.

mod reader;
mod values;

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use half::f16;
use overlook_engine::capture::{Camera, Intrinsics, MISSING_VALUE, ValueChannel, Values};
use overlook_engine::job::Job;
use overlook_engine::samples::{
    DepthPlane, OctNormal, SampleImage, SampleSet, SampleTile, Span, TILE, TileMask,
};
use overlook_engine::settings::{Precision, Settings};

use reader::Store;

/// Two cameras, twelve frames: planes that move, holes, sky, noise, and normals in the second camera.
fn set() -> SampleSet {
    let cameras: Vec<Camera> = [("wide", 150, 70), ("tall", 40, 131)]
        .map(|(name, width, height)| Camera {
            name: name.to_owned(),
            intrinsics: Intrinsics::from_horizontal_angle(width, height, 0.9),
            world_from_camera: DAffine3::from_translation(DVec3::new(0.5, 1.0, -2.0)),
        })
        .into();
    let mut images = Vec::new();
    for (start, end) in [(0, 12), (0, 2), (2, 4)].into_iter().chain((0..12).map(|frame| (frame, frame + 1))) {
        for (index, camera) in cameras.iter().enumerate() {
            images.push(Arc::new(image(index, camera, Span { start, end })));
        }
    }
    let mut settings = Settings::default();
    settings.store.precision = Precision::Lossless;
    SampleSet {
        name: "second".to_owned(),
        cameras,
        frame_numbers: (0..12).collect(),
        up_in_world: DVec3::Z,
        settings,
        images,
        values: Vec::new(),
    }
}

fn image(index: usize, camera: &Camera, span: Span) -> SampleImage {
    let (width, height) = camera.intrinsics.size();
    // A number that looks random and is the same in every run.
    let noise = |x: usize, y: usize| {
        let mixed = (x * 73_856_093) ^ (y * 19_349_663) ^ (span.start as usize * 83_492_791);
        (mixed.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as u32
    };
    let held = |x: usize, y: usize| (x + y + span.start as usize) % 9 > 1 && (x / 20 + y / 30) % 4 != 3;
    let (mut tiles, mut color, mut depths, mut normals) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for tile_y in 0..height.div_ceil(TILE) {
        for tile_x in 0..width.div_ceil(TILE) {
            let mut tile = SampleTile {
                tile_x: tile_x as u16,
                tile_y: tile_y as u16,
                first: color.len() as u32,
                rows: [0; TILE],
            };
            for (row, mask) in tile.rows.iter_mut().enumerate() {
                for column in 0..TILE {
                    let (x, y) = (tile_x * TILE + column, tile_y * TILE + row);
                    if x >= width || y >= height || !held(x, y) {
                        continue;
                    }
                    *mask |= 1 << column;
                    let plane = 0.3 + x as f32 * 0.002 - y as f32 * 0.001 + if x > 60 { 1.5 } else { 0.0 };
                    let moved = if y > 40 { span.start as f32 * 0.01 } else { 0.0 };
                    depths.push(if x + y < 20 { 0.0 } else { (plane + moved).max(0.01) });
                    let shade = 0.2 + (noise(x, y) % 64) as f32 / 4000.0 - if x == 7 { 0.5 } else { 0.0 };
                    color.push(
                        [shade, shade * 0.8, if y > 50 { 40.0 } else { shade * 0.5 }].map(f16::from_f32),
                    );
                    normals.push(OctNormal([(noise(y, x) % 7) as i8 - 3, -120]));
                }
            }
            if tile.count() > 0 {
                tiles.push(tile);
            }
        }
    }
    let depth = DepthPlane::pack(&tiles, &depths);
    let normal = (index == 1).then_some(normals);
    let doubtful = if index == 0 { Vec::new() } else { every_other_row(&tiles) };
    SampleImage {
        camera: index as u32,
        span,
        tiles,
        color,
        depth,
        normal,
        doubtful,
        values: Values::default(),
    }
}

/// The samples in every other row as doubtful ones.
fn every_other_row(tiles: &[SampleTile]) -> Vec<TileMask> {
    let masks = tiles.iter().enumerate().map(|(tile, SampleTile { rows, .. })| {
        let rows = std::array::from_fn(|row| if row % 2 == 0 { rows[row] } else { 0 });
        TileMask { tile: tile as u32, rows }
    });
    masks.filter(|mask| mask.rows != [0; TILE]).collect()
}

/// The same samples with values: a curved one, another over depth, numbers of parts with gaps, and what floats end with.
fn valued() -> SampleSet {
    let channel = |(name, is_exact): (&str, bool)| ValueChannel {
        name: name.to_owned(),
        unit: String::new(),
        range: [-1.0, 30.0],
        tolerance: 0.02,
        is_exact,
    };
    let value_of = |image: &SampleImage, x: usize, y: usize, inverse_depth: f32| {
        let moved = if x > 90 { 0.1 * image.span.start as f32 } else { 0.0 };
        let curved = 0.002 * (x * x) as f32 - 0.01 * (x * y) as f32 + moved;
        let part = if (x / 9 + y / 7).is_multiple_of(5) { MISSING_VALUE } else { (x / 9) as f32 };
        let ends = [f32::INFINITY, -0.0, f32::NEG_INFINITY, 1e-42, 3e38, 0.0];
        [curved, 3.0 * inverse_depth + curved, part, ends[(x * y / 3 + y) % ends.len()]]
    };
    let with_values = |image: &Arc<SampleImage>| {
        let depths = image.inverse_depths();
        let mut planes = vec![vec![0.0; image.len()]; 4];
        for sample in image.samples() {
            let values = value_of(image, sample.x, sample.y, depths[sample.index]);
            planes.iter_mut().zip(values).for_each(|(plane, value)| plane[sample.index] = value);
        }
        Arc::new(SampleImage { values: Values::from_planes(&planes), ..SampleImage::clone(image) })
    };
    let plain = set();
    let names = [("curved", true), ("within", false), ("part", true), ("ends", true)];
    SampleSet {
        images: plain.images.iter().map(with_values).collect(),
        values: names.map(channel).into(),
        ..plain
    }
}

fn written(settings: &[&str]) -> (SampleSet, Vec<u8>) {
    written_of(set(), settings)
}

fn written_of(mut set: SampleSet, settings: &[&str]) -> (SampleSet, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("second.ovl");
    for setting in settings {
        set.settings.set_text(setting).unwrap();
    }
    overlook_engine::store::file::write(&path, &set, "{}", &Job::new()).unwrap();
    (set, std::fs::read(&path).unwrap())
}

fn assert_reads_as(store: &Store, images: &[Arc<SampleImage>]) {
    assert_eq!(store.images.len(), images.len());
    for (read, image) in store.images.iter().zip(images) {
        assert_eq!((read.camera, read.span), (image.camera, (image.span.start, image.span.end)));
        let depths = image.inverse_depths();
        let expected: Vec<_> = image
            .samples()
            .map(|sample| {
                let color = image.color[sample.index].map(f16::to_bits);
                let normal = image.normal.as_ref().map(|normals| normals[sample.index].0);
                let is_doubtful = image.is_doubtful(sample.x, sample.y);
                ((sample.x, sample.y), color, depths[sample.index].to_bits(), normal, is_doubtful)
            })
            .collect();
        let mut read: Vec<_> = read
            .samples
            .iter()
            .map(|s| ((s.x, s.y), s.color, s.inverse_depth, s.normal, s.is_doubtful))
            .collect();
        let tile_order = |(x, y): (usize, usize)| (y / TILE, x / TILE, y, x);
        read.sort_by_key(|sample| tile_order(sample.0));
        assert_eq!(read, expected);
    }
}

#[test]
fn a_reader_written_from_the_description_reads_every_sample() {
    let (set, bytes) = written(&[]);
    let store = Store::read(&bytes);
    assert_eq!(store.cameras, [("wide".to_owned(), 150, 70), ("tall".to_owned(), 40, 131)]);
    assert!(store.images.iter().filter(|image| image.is_predicted).count() > 15);
    assert_reads_as(&store, &set.images);
    let of_camera = |camera| {
        let images = set.images.iter().filter(move |image| image.camera == camera);
        images.map(|image| image.doubtful_count()).collect::<Vec<_>>()
    };
    assert!(of_camera(0).iter().all(|count| *count == 0) && of_camera(1).iter().all(|count| *count > 0));
}

#[test]
fn it_reads_plain_stores_too() {
    let (set, bytes) = written(&["store.coding=plain"]);
    assert_reads_as(&Store::read(&bytes), &set.images);
}

#[test]
fn it_reads_reduced_stores_as_overlook_does() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reduced.ovl");
    let (_, bytes) = written(&["store.precision=bits10", "store.depth_precision=0.25"]);
    std::fs::write(&path, &bytes).unwrap();
    let (read, _) = overlook_engine::store::read(&path, &Job::new()).unwrap();
    assert_reads_as(&Store::read(&bytes), &read.images);
}

#[test]
fn it_reads_the_scalar_values_that_overlook_reads_in_coded_and_plain_stores() {
    for coding in ["store.coding=modeled", "store.coding=plain"] {
        let (set, bytes) = written_of(valued(), &[coding]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("valued.ovl");
        std::fs::write(&path, &bytes).unwrap();
        let (expected, _) = overlook_engine::store::read(&path, &Job::new()).unwrap();
        let store = Store::read(&bytes);
        assert_reads_as(&store, &set.images);
        for ((read, image), given) in store.images.iter().zip(&expected.images).zip(&set.images) {
            let of_pixel = read.samples.iter().map(|sample| ((sample.x, sample.y), &sample.values));
            let of_pixel: std::collections::HashMap<_, _> = of_pixel.collect();
            for sample in image.samples() {
                let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
                let found = bits(of_pixel[&(sample.x, sample.y)]);
                assert_eq!(found, bits(image.values.of(sample.index)), "{sample:?}");
                let source = bits(given.values.of(sample.index));
                assert_eq!([found[0], found[2], found[3]], [source[0], source[2], source[3]]);
            }
        }
    }
}
