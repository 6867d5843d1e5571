//! What can be chosen of how colors are shown is seen in both views.

use egui::Key;
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use image::RgbaImage;

use super::driver::{SIZE, Window, choose, click, fold, open, open_view, settle, small_demo};

/// A window with the Color panel beside both pictures, and no axes over them.
fn with_colors() -> Window {
    let mut window = open(small_demo(), [SIZE[0], 1000.0]);
    settle(&mut window);
    click(&mut window, "Hide cameras");
    open_view(&mut window, "View");
    fold(&mut window, "Guides");
    window.get_by_label("Axes").scroll_to_me();
    window.run_steps(3);
    click(&mut window, "Axes");
    open_view(&mut window, "Color");
    settle(&mut window);
    window
}

const PICTURES: [&str; 2] = ["Source picture", "Live picture"];

/// A picture without its edges.
fn picture(window: &mut Window, name: &str) -> RgbaImage {
    let area = window.get_by_label(name).rect().shrink(24.0);
    let [x, y, width, height] = [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
    image::imageops::crop_imm(&window.render().unwrap(), x, y, width, height).to_image()
}

/// The share of all pixels that the condition holds for.
fn share(picture: &RgbaImage, holds: impl Fn([u8; 3]) -> bool) -> f64 {
    let all = f64::from(picture.width() * picture.height());
    picture.pixels().filter(|pixel| holds([pixel.0[0], pixel.0[1], pixel.0[2]])).count() as f64 / all
}

fn is_gray([r, g, b]: [u8; 3]) -> bool {
    r.max(g).max(b) - r.min(g).min(b) < 3
}

#[test]
fn one_channel_is_shown_in_gray_in_both_views() {
    let mut window = with_colors();
    for name in PICTURES {
        let gray = share(&picture(&mut window, name), is_gray);
        assert!(gray < 0.9, "{name} has colors: {gray} is gray");
    }
    let mut before = Vec::new();
    fold(&mut window, "Tone curve and channel");
    for channel in ["R", "G", "B", "Luminance"] {
        choose(&mut window, "Channel", channel);
        settle(&mut window);
        for name in PICTURES {
            let gray = share(&picture(&mut window, name), is_gray);
            // The mark of a hole keeps its color in the source view.
            assert!(gray > 0.9, "{channel} in {name}: {gray} is gray");
        }
        let live = picture(&mut window, "Live picture");
        assert!(!before.contains(&live), "{channel} is as another channel");
        before.push(live);
    }
}

#[test]
fn every_tone_curve_shows_another_picture() {
    let mut window = with_colors();
    let mut before: Vec<RgbaImage> = Vec::new();
    fold(&mut window, "Tone curve and channel");
    for curve in ["sRGB", "Gamma", "Filmic", "Reinhard", "False color"] {
        choose(&mut window, "Tone curve", curve);
        settle(&mut window);
        assert_eq!(window.query_by_role_and_label(Role::Slider, "Gamma").is_some(), curve == "Gamma");
        let live = picture(&mut window, "Live picture");
        assert!(!before.contains(&live), "{curve} is as another curve");
        before.push(live);
    }
}

#[test]
fn what_is_brighter_than_white_is_marked_where_that_is_asked_for() {
    let mut window = with_colors();
    let is_red = |[r, g, b]: [u8; 3]| r > 200 && g < 90 && b < 90;
    window.get_by_role_and_label(Role::Slider, "Exposure").focus();
    window.run_steps(2);
    for _ in 0..40 {
        window.key_press(Key::ArrowRight);
        window.run_steps(1);
    }
    settle(&mut window);
    for (marks, expected) in [(false, false), (true, true)] {
        if marks {
            click(&mut window, "Mark clipped");
            settle(&mut window);
        }
        for name in PICTURES {
            let red = share(&picture(&mut window, name), is_red);
            assert_eq!(red > 0.2, expected, "{name}, marked {marks}: {red} is red");
        }
    }
}
