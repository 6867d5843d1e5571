//! Zoomed in four times on what one camera stood close to: its detail is there, and with first camera wins it is not.
//!
//! With `OVERLOOK_UPDATE_SCREENSHOTS=1` the pictures are made larger and written to `screenshots/zoom.png`.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use overlook_engine::capture::{Camera, Capture, Frame, Intrinsics};
use overlook_engine::color::srgb8_from_linear;
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::render::{CpuRenderer, NO_IMAGE, Picture, Vantage};
use overlook_engine::settings::{CaptureSettings, PruningMethod, RenderSettings, Settings};

fn updating() -> bool {
    std::env::var_os("OVERLOOK_UPDATE_SCREENSHOTS").is_some_and(|value| value == "1")
}

/// What the first camera would see of the close-up's object, with a lens four times as long.
fn zoomed(capture: &Capture) -> Camera {
    let close = capture.cameras.last().unwrap();
    let (width, height) = close.intrinsics.size();
    let frame = capture.frame(capture.cameras.len() - 1, 0).unwrap();
    let w = frame.inverse_depth[(width / 2, height / 2)];
    let middle = DVec2::new(width as f64 / 2.0, height as f64 / 2.0);
    let object = close.unproject(middle, 1.0 / f64::from(w));
    let k = capture.cameras[0].intrinsics;
    let intrinsics = Intrinsics { fx: 4.0 * k.fx, fy: 4.0 * k.fy, ..k };
    Camera::look_at("zoomed", intrinsics, capture.cameras[0].position_in_world(), object, DVec3::Z)
}

fn mean_squared_error(picture: &Picture, truth: &Frame) -> f64 {
    let pixels = picture.color.as_slice().iter().zip(truth.color.as_slice()).zip(picture.image.as_slice());
    let shown: Vec<f64> = pixels
        .filter(|(_, image)| **image != NO_IMAGE)
        .map(|((found, truth), _)| {
            (0..3).map(|channel| f64::from(found[channel] - truth[channel].to_f32()).powi(2)).sum::<f64>()
        })
        .collect();
    assert!(shown.len() * 10 > picture.image.len() * 9, "nearly everything there was sampled");
    shown.iter().sum::<f64>() / shown.len() as f64
}

#[test]
fn the_close_up_s_detail_is_there_and_with_first_camera_wins_it_is_not() {
    let size = if updating() { (480, 360) } else { (160, 120) };
    let spec = DemoSpec::new("nine-cameras").frames(1).size(size);
    let demo = Demo::new(&spec).unwrap();
    let capture = demo.capture(&CaptureSettings::default());
    let vantage = Vantage { camera: zoomed(&capture), frame: 0 };
    let truth = demo.render(&vantage.camera, 0);
    let paint = |method| -> Arc<Picture> {
        let mut settings = Settings::default();
        settings.pruning.method = method;
        let samples = preprocess(&capture, &settings, &Job::new()).unwrap().samples;
        CpuRenderer::new().render(&samples, &vantage, &RenderSettings::default(), &Job::new()).unwrap().0
    };
    let (by_rate, first) = (paint(PruningMethod::HighestRate), paint(PruningMethod::FirstCamera));
    let (ours, theirs) = (mean_squared_error(&by_rate, &truth), mean_squared_error(&first, &truth));
    println!("mean squared error: by rate {ours:.5}, first camera wins {theirs:.5}");
    assert!(ours * 1.5 < theirs, "by rate {ours}, first camera wins {theirs}");
    if updating() {
        save(&first, &by_rate);
    }
}

/// Both pictures side by side.
fn save(left: &Picture, right: &Picture) {
    let (width, height) = left.color.size();
    let gap = 8;
    let both = image::RgbImage::from_fn((2 * width + gap) as u32, height as u32, |x, y| {
        let (x, y) = (x as usize, y as usize);
        let color = match x {
            x if x < width => left.color[(x, y)].map(srgb8_from_linear),
            x if x >= width + gap => right.color[(x - width - gap, y)].map(srgb8_from_linear),
            _ => [255; 3],
        };
        image::Rgb(color)
    });
    both.save(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../screenshots/zoom.png")).unwrap();
}
