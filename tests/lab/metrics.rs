//! Every metric equals that of other programs: `assets/metrics/make.py` made the pictures and ran these programs.

use std::path::Path;

use overlook_engine::color::linear_from_srgb;
use overlook_engine::grid::Grid;
use overlook_lab::metrics;

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/metrics")
}

/// sRGB-encoded values of a picture, 0 to 1.
fn encoded(name: &str) -> Grid<[f32; 3]> {
    let picture = image::open(folder().join(name)).unwrap().to_rgb8();
    let values = picture.pixels().map(|pixel| pixel.0.map(|value| f32::from(value) / 255.0)).collect();
    Grid::from_vec(picture.width() as usize, picture.height() as usize, values)
}

#[test]
fn every_metric_agrees_with_another_program() {
    let values: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder().join("values.json")).unwrap()).unwrap();
    let expect = |name: &str, value: f64, tolerance: f64| {
        let expected = values[name].as_f64().unwrap();
        assert!((value - expected).abs() < tolerance, "{name} is {value}, elsewhere {expected}");
    };
    let (picture, truth) = (encoded("picture.png"), encoded("truth.png"));
    let (a, b) = (picture.as_slice(), truth.as_slice());
    expect("psnr_db", metrics::psnr_db(a, b, 0..a.len()).unwrap(), 1e-4);

    let (a, b) = (picture.map(metrics::luma), truth.map(metrics::luma));
    expect("ssim", metrics::ssim(&a, &b, |_, _| true), 1e-6);
    expect("ms_ssim", metrics::ms_ssim(&a, &b, &a.map(|_| true)), 2e-5);

    let linear = |picture: &Grid<[f32; 3]>| picture.map(|color| color.map(linear_from_srgb));
    let map = metrics::flip(&linear(&picture), &linear(&truth), metrics::DEFAULT_PIXELS_PER_DEGREE);
    expect(
        "flip",
        map.as_slice().iter().map(|value| f64::from(*value)).sum::<f64>() / map.len() as f64,
        1e-4,
    );
    for (place, expected) in values["flip_pixels"].as_object().unwrap() {
        let (x, y) = place.split_once(',').unwrap();
        let value = f64::from(map[(x.parse().unwrap(), y.parse().unwrap())]);
        assert!(
            (value - expected.as_f64().unwrap()).abs() < 1e-3,
            "FLIP at {place}: {value}, not {expected}"
        );
    }
}
