//! What is transparent in a picture is no sample, whatever its depth says.

use crate::captures::{Folder, PIXELS, SIZE, entry, flat, picture};
use crate::said::succeed;
use exr::prelude::FlatSamples;
use half::f16;
use image::{ImageBuffer, Luma, Rgba};
use overlook_engine::capture::Capture;
use overlook_engine::color::linear_from_srgb;
use serde_json::{Value, json};

const COLUMNS: u32 = SIZE.0 as u32;
const ROWS: u32 = SIZE.1 as u32;

/// A picture in PNG that is opaque in its right half, and depth of two meters everywhere.
fn write_png(folder: &Folder, alpha: impl Fn(u32) -> u8) {
    let pixel = |x, y| Rgba([if alpha(x) > 0 { 188 } else { 0 }, 10 * y as u8, 7, alpha(x)]);
    ImageBuffer::from_fn(COLUMNS, ROWS, pixel).save(folder.path("a.png")).unwrap();
    let depth: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(COLUMNS, ROWS, Luma([2000]));
    depth.save(folder.path("depth.png")).unwrap();
}

fn png_entry() -> Value {
    let mut entry = entry("a.png", "a", 0);
    entry["depth_file_path"] = "depth.png".into();
    entry
}

fn half_opaque(x: u32) -> u8 {
    if x < COLUMNS / 2 { 0 } else { 255 }
}

fn with_depth(capture: &Capture) -> usize {
    PIXELS - capture.frame(0, 0).unwrap().invalid_pixels()
}

#[test]
fn a_background_that_was_cut_out_is_no_sample_though_its_depth_is_there() {
    let folder = Folder::new();
    write_png(&folder, half_opaque);
    let capture = folder.open(json!({}), &[png_entry()]).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    assert!(frame.inverse_depth[(0, 0)] < 0.0 && frame.inverse_depth[(5, 3)] == 0.5);
    assert_eq!(with_depth(&capture), PIXELS / 2);
    assert_eq!(capture.transparent_share().unwrap(), Some(0.5));
}

#[test]
fn colors_that_were_multiplied_with_alpha_are_found_and_divided_and_others_stay() {
    let folder = Folder::new();
    write_png(&folder, |_| 255);
    let is_half = |x: u32| x % 2 == 1;
    for (half, found) in [(100_u8, 199_u8), (150, 150)] {
        let gray = |x| if is_half(x) { half } else { 200 };
        let pixel = |x, _| Rgba([gray(x), gray(x), gray(x), if is_half(x) { 128 } else { 255 }]);
        ImageBuffer::from_fn(COLUMNS, ROWS, pixel).save(folder.path("a.png")).unwrap();
        let frame = folder.open(json!({}), &[png_entry()]).unwrap().frame(0, 0).unwrap();
        let expected = linear_from_srgb(f32::from(found) / 255.0);
        let color = frame.color[(1, 1)][0].to_f32();
        assert!((color - expected).abs() < 5e-3, "{half}: {color} in place of {expected}");
    }
}

#[test]
fn one_key_says_that_alpha_means_something_else() {
    let folder = Folder::new();
    write_png(&folder, half_opaque);
    let capture = folder.open(json!({"use_alpha": false}), &[png_entry()]).unwrap();
    assert_eq!((with_depth(&capture), capture.transparent_share().unwrap()), (PIXELS, None));
}

#[test]
fn info_says_that_transparent_pixels_are_left_out_and_how_to_take_them() {
    let folder = Folder::new();
    write_png(&folder, half_opaque);
    folder.open(json!({}), &[png_entry()]).unwrap();
    let said = succeed(&folder.path(""), &["info", "."]);
    assert!(
        said.contains("transparent") && said.contains("50 %") && said.contains("\"use_alpha\""),
        "{said}"
    );
    write_png(&folder, |_| 255);
    assert!(!succeed(&folder.path(""), &["info", "."]).contains("transparent"), "nothing is");
}

#[test]
fn alpha_that_is_0_over_a_whole_picture_says_nothing() {
    let folder = Folder::new();
    write_png(&folder, |_| 0);
    let capture = folder.open(json!({}), &[png_entry()]).unwrap();
    assert_eq!((with_depth(&capture), capture.transparent_share().unwrap()), (PIXELS, None));
}

#[test]
fn a_mixed_pixel_of_an_edge_has_the_color_of_its_surface() {
    let folder = Folder::new();
    let ramp = |values: [f32; SIZE.0]| FlatSamples::F32((0..PIXELS).map(|i| values[i % SIZE.0]).collect());
    let alpha = [0.0, 0.25, 0.5, 0.75, 1.0, 1.0];
    let color = alpha.map(|alpha| 0.5 * alpha);
    let channels = vec![
        ("R", ramp(color)),
        ("G", ramp(color)),
        ("B", ramp(color)),
        ("A", ramp(alpha)),
        ("Z", flat(2.0)),
    ];
    folder.put("a.exr", &picture(&[("", channels)]));
    let capture = folder.open(json!({}), &[entry("a.exr", "a", 0)]).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    let seen: Vec<bool> = (0..SIZE.0).map(|x| frame.inverse_depth[(x, 1)] > 0.0).collect();
    assert_eq!(seen, [false, false, true, true, true, true]);
    for x in 2..SIZE.0 {
        assert_eq!(frame.color[(x, 1)], [f16::from_f32(0.5); 3], "{x}");
    }
}
