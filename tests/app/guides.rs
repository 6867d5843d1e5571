//! What helps to find one's way in the live view: frames of pictures, axes, and the speed and direction of moving.

use egui::{Rect, vec2};
use egui_kittest::kittest::Queryable;

use super::driver::{SIZE, Window, choose, click, open, settle, shows, small_demo};

/// A window in the workspace that has the View panel beside the live view.
fn explore() -> Window {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    click(&mut window, "Workspace: Explore");
    click(&mut window, "Hide cameras");
    settle(&mut window);
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
