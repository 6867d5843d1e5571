//! What helps to find one's way in the live view: frames of pictures, axes, and the speed and direction of moving.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Rect, vec2};
use egui_kittest::kittest::Queryable;
use image::RgbImage;
use image::imageops::FilterType;

use super::driver::{
    SIZE, Window, choose, click, fold, open, open_view, settle, share_path, shows, small_demo,
    wait_for_shared,
};

/// A window in the workspace that has the View panel beside the live view.
fn explore() -> Window {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Workspace: Explore");
    click(&mut window, "Hide cameras");
    fold(&mut window, "Pose");
    fold(&mut window, "Guides");
    window
}

/// Mean brightness of columns of the live picture, from its left edge to its right one, of 255.
fn columns(window: &mut Window) -> Vec<f64> {
    let area = window.get_by_label("Live picture").rect();
    let whole = image::DynamicImage::ImageRgba8(window.render().unwrap());
    // The axes lie in the lower left.
    let area = Rect::from_min_max(area.min, area.max - vec2(0.0, 110.0)).shrink(8.0);
    let [x, y, width, height] = [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
    let part = whole.crop_imm(x, y, width, height).to_luma8();
    let column = |x: u32| (0..height).map(|y| f64::from(part.get_pixel(x, y).0[0])).sum::<f64>();
    (0..width).map(|x| column(x) / f64::from(height)).collect()
}

/// The share of columns that a frame guide darkened.
fn darkened(before: &[f64], now: &[f64]) -> f64 {
    let pairs = before.iter().zip(now);
    pairs.filter(|(before, now)| **now < 0.75 * **before).count() as f64 / before.len() as f64
}

#[test]
fn what_lies_outside_of_the_camera_s_picture_is_darkened() {
    let mut window = explore();
    let free = columns(&mut window);
    choose(&mut window, "Frame guide", "Camera");
    settle(&mut window);
    let of_camera = darkened(&free, &columns(&mut window));
    assert!(of_camera > 0.02 && of_camera < 0.8, "{of_camera} of the columns are outside");
    choose(&mut window, "Frame guide", "Off");
    settle(&mut window);
    assert_eq!(darkened(&free, &columns(&mut window)), 0.0);
}

#[test]
fn axes_and_ground_are_shown_and_hidden_and_the_unit_is_told() {
    let mut window = explore();
    assert!(window.query_by_label("View from X").is_some(), "the axes are there at first");
    let before = window.render().unwrap();
    click(&mut window, "Ground grid");
    settle(&mut window);
    let grid = window.render().unwrap();
    let changed = before.pixels().zip(grid.pixels()).filter(|(a, b)| a != b).count();
    assert!(changed > 500, "{changed} pixels show the ground");
    for unit in ["cm", "mm", "units", "m"] {
        choose(&mut window, "Unit", unit);
        window.run_steps(3);
        assert!(window.query_by_label(&format!("Unit: {unit}")).is_some());
    }
    click(&mut window, "Axes");
    settle(&mut window);
    assert!(window.query_by_label("View from X").is_none());
    assert!(shows(&window, "Fly speed") && shows(&window, "Up axis"));
}

/// Types a number into a field of the window.
fn type_number(window: &mut Window, name: &str, number: u32) {
    window.get_by_role_and_label(Role::SpinButton, name).focus();
    window.run_steps(2);
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text(number.to_string()));
    window.key_press(Key::Enter);
    window.run_steps(3);
}

/// Exports pictures of the camera path into a folder, and reads the first.
fn exported(window: &mut Window, folder: &std::path::Path) -> RgbImage {
    share_path(window, &[("Pictures of", "Camera path")], folder);
    wait_for_shared(window);
    while !window.state().observed().notices.is_empty() {
        window.key_press(Key::Escape);
        window.run_steps(2);
    }
    settle(window);
    image::open(folder.join("0001.png")).unwrap().to_rgb8()
}

/// The frame that is drawn in a picture of the live view: first and last column, first and last row of its bright outline.
fn outline(live: &RgbImage) -> [u32; 4] {
    const BRIGHT: [u8; 3] = [0xf2, 0xf5, 0xf8];
    let is_bright =
        |x: u32, y: u32| live.get_pixel(x, y).0.iter().zip(BRIGHT).all(|(a, b)| a.abs_diff(b) < 4);
    let count = |lines: u32, along: u32, bright: &dyn Fn(u32, u32) -> bool| {
        let counts: Vec<usize> =
            (0..lines).map(|line| (0..along).filter(|&at| bright(line, at)).count()).collect();
        let most = *counts.iter().max().unwrap();
        let first = counts.iter().position(|count| *count > most / 2).unwrap() as u32;
        let last = counts.iter().rposition(|count| *count > most / 2).unwrap() as u32;
        [first, last]
    };
    let (width, height) = live.dimensions();
    let [left, right] = count(width, height, &is_bright);
    let [top, bottom] = count(height, width, &|y, x| is_bright(x, y));
    [left, right, top, bottom]
}

/// How far a part of the live view, in shares of the frame beyond its edges, is from a picture: mean difference of a channel, of 255.
/// Only what lies near the border counts, without the corner where the size is written.
fn apart(live: &RgbImage, [left, right, top, bottom]: [u32; 4], beyond: [f32; 4], picture: &RgbImage) -> f32 {
    let (width, height) = ((right - left + 1) as f32, (bottom - top + 1) as f32);
    let (columns, rows) = picture.dimensions();
    let edge = |at: u32, share: f32, size: f32| at as f32 + share * size;
    let area = [
        edge(left, beyond[0], width),
        edge(right + 1, beyond[1], width),
        edge(top, beyond[2], height),
        edge(bottom + 1, beyond[3], height),
    ];
    // Where the part goes beyond the view, its edge is repeated.
    let (x_scale, y_scale) = ((area[1] - area[0]) / 400.0, (area[3] - area[2]) / 400.0);
    let seen = RgbImage::from_fn(400, 400, |x, y| {
        let place = |from: f32, at: u32, scale: f32, most: u32| {
            ((from + (at as f32 + 0.5) * scale).max(0.0) as u32).min(most - 1)
        };
        *live.get_pixel(place(area[0], x, x_scale, live.width()), place(area[2], y, y_scale, live.height()))
    });
    let seen = image::imageops::resize(&seen, columns, rows, FilterType::Triangle);
    let is_near = |x: u32, y: u32| {
        let share = [x as f32 / columns as f32, y as f32 / rows as f32];
        let inside = share.iter().all(|share| (0.2..0.8).contains(share));
        let beside_the_size = share[0] > 0.4 || share[1] > 0.25;
        !inside && beside_the_size
    };
    let mut sum = (0.0, 0.0);
    for (x, y, pixel) in picture.enumerate_pixels().filter(|(x, y, _)| is_near(*x, *y)) {
        let other = seen.get_pixel(x, y);
        let difference: f32 = pixel.0.iter().zip(other.0).map(|(a, b)| f32::from(a.abs_diff(b))).sum();
        sum = (sum.0 + difference / 3.0, sum.1 + 1.0);
    }
    sum.0 / sum.1
}

#[test]
fn what_lies_inside_the_frame_of_exports_is_what_exported_pictures_hold() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = explore();
    click(&mut window, "Axes");
    choose(&mut window, "Frame guide", "Export");
    for _ in 0..2 {
        window.key_press(Key::K);
        window.run_steps(2);
    }
    open_view(&mut window, "Camera path");
    type_number(&mut window, "Frames per segment", 1);
    // Of the camera's shape; wider than the view; and higher, so that both would be cut off by it.
    for [width, height] in [[96, 72], [240, 60], [80, 80]] {
        type_number(&mut window, "Picture width", width);
        type_number(&mut window, "Picture height", height);
        let picture = exported(&mut window, &folder.path().join(format!("{width}")));
        assert_eq!(picture.dimensions(), (width, height));
        let area = window.get_by_label("Live picture").rect();
        let [x, y, columns, rows] =
            [area.left(), area.top(), area.width(), area.height()].map(|at| at as u32);
        let live = image::DynamicImage::ImageRgba8(window.render().unwrap()).crop_imm(x, y, columns, rows);
        let live = live.to_rgb8();
        let frame = outline(&live);
        let shape = |long: u32, short: u32| f64::from(long) / f64::from(short);
        let seen = shape(frame[1] - frame[0] + 1, frame[3] - frame[2] + 1);
        assert!((seen / shape(width, height) - 1.0).abs() < 0.02, "{frame:?} for {width}×{height}");
        let within = apart(&live, frame, [0.0; 4], &picture);
        for side in 0..4 {
            for share in [-0.04, 0.04] {
                let mut beyond = [0.0; 4];
                beyond[side] = share;
                let moved = apart(&live, frame, beyond, &picture);
                assert!(moved > within, "{width}×{height}: {within}, side {side} by {share}: {moved}");
            }
        }
    }
}
