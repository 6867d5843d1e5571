//! The first minute of somebody who has never seen the program: in a real window, on a fresh profile.

use std::time::Duration;

use egui::{Rect, accesskit::Role};
use egui_kittest::kittest::Queryable;
use image::{DynamicImage, RgbImage};

use super::display::{
    can_drive_a_window, drag, picture_of, quit, start_display, start_program, wait_for, wait_for_pictures,
    xdotool,
};
use super::driver::{SIZE, Window, click, demo, look_at, open_fresh, settle, shows};

/// Colors of the hatching over holes in the dark theme.
const HATCHING: [[u8; 3]; 2] = [[0x33, 0x20, 0x40], [0x3f, 0x2a, 0x4e]];

/// Where things lie in the window, found by their names in the same layout off screen.
struct Places {
    introduction: Rect,
    got_it: Rect,
    live_picture: Rect,
    live_tab: Rect,
    live_name_maximized: Rect,
    live_picture_maximized: Rect,
    source_picture: Rect,
    pixel_view: Rect,
    settings_view: Rect,
}

fn rect_of(window: &Window, name: &str) -> Rect {
    window.get_by_label(name).rect()
}

fn tab_of(window: &Window, name: &str) -> Rect {
    window.get_by_role_and_label(Role::Button, name).rect()
}

fn places() -> Places {
    let mut window = open_fresh(demo(3, 4, (96, 72)), SIZE);
    settle(&mut window);
    let introduction = ["Click a pixel", "Orbit the live view", "Change a threshold"]
        .map(|title| rect_of(&window, title))
        .into_iter()
        .fold(Rect::NOTHING, Rect::union);
    let settings_tab = tab_of(&window, "Settings");
    let pixel_tab = tab_of(&window, "Pixel");
    let found = Places {
        introduction,
        got_it: rect_of(&window, "Got it"),
        live_picture: rect_of(&window, "Live picture"),
        live_tab: tab_of(&window, "Live view"),
        live_name_maximized: Rect::NOTHING,
        live_picture_maximized: Rect::NOTHING,
        source_picture: rect_of(&window, "Source picture"),
        pixel_view: Rect::from_min_max(
            egui::pos2(20.0, pixel_tab.bottom() + 12.0),
            egui::pos2(settings_tab.left() - 40.0, rect_of(&window, "Timeline").top() - 40.0),
        ),
        settings_view: Rect::from_min_max(
            egui::pos2(settings_tab.left(), settings_tab.bottom() + 40.0),
            egui::pos2(SIZE[0] - 20.0, pixel_tab.top()),
        ),
    };
    for covered in [found.live_picture, found.source_picture, found.live_tab, settings_tab, pixel_tab] {
        assert!(!introduction.intersects(covered), "the introduction covers {covered:?} of what it explains");
    }
    assert!(window.query_by_label("Play").is_some(), "nothing plays while a pixel is to be clicked");
    look_at(&mut window, "Source picture", egui::vec2(0.5, 0.5));
    settle(&mut window);
    assert!(
        shows(&window, "Kept") || shows(&window, "Dropped"),
        "the Pixel view says what it is said to say"
    );
    click(&mut window, "Maximize Live view");
    assert!(window.query_by_label("Got it").is_none(), "no callout speaks of views that are not there");
    Places {
        live_name_maximized: tab_of(&window, "Live view"),
        live_picture_maximized: rect_of(&window, "Live picture"),
        ..found
    }
}

/// A part of the display.
fn part(picture: &DynamicImage, area: Rect) -> RgbImage {
    let [x, y, width, height] =
        [area.left(), area.top(), area.width(), area.height()].map(|side| side as u32);
    picture.crop_imm(x, y, width, height).to_rgb8()
}

/// Pixels of the hatching over holes in a part of the display.
fn hatched(picture: &DynamicImage, area: Rect) -> usize {
    let is_close = |pixel: [u8; 3], to: [u8; 3]| pixel.into_iter().zip(to).all(|(a, b)| a.abs_diff(b) <= 2);
    let part = part(picture, area);
    part.pixels().filter(|pixel| HATCHING.iter().any(|color| is_close(pixel.0, *color))).count()
}

/// The share of pixels that differ between two pictures of the display, in a part of it.
fn changed(before: &DynamicImage, after: &DynamicImage, area: Rect) -> f64 {
    let (before, after) = (part(before, area), part(after, area));
    let differing = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b).count();
    differing as f64 / before.pixels().len() as f64
}

fn click_at(display: &str, area: Rect, clicks: &str) {
    let [x, y] = [area.center().x, area.center().y].map(|place| format!("{place:.0}"));
    xdotool(display, &["mousemove", &x, &y]).unwrap();
    std::thread::sleep(Duration::from_millis(200));
    xdotool(display, &["click", "--repeat", clicks, "--delay", "70", "1"]).unwrap();
    std::thread::sleep(Duration::from_millis(800));
}

#[test]
fn the_first_minute_leads_from_the_start_to_a_pixels_explanation_and_back() {
    if !can_drive_a_window() {
        return;
    }
    let places = places();
    let folder = tempfile::tempdir().unwrap();
    let (_server, display) = start_display();
    let program = start_program(&display, folder.path(), &[]);
    let look = || picture_of(&display, folder.path());
    wait_for_pictures(&display, folder.path());

    // What is explained is there, stands still, and is neither covered nor hatched.
    let band = [places.got_it.left() as u32 - 8, places.introduction.top() as u32];
    let accent = wait_for("the introduction", || {
        let color = look().to_rgb8().get_pixel(band[0], band[1]).0;
        (color == [0x24, 0x50, 0x79]).then_some(color)
    });
    let at_rest = wait_for("the picture at rest", || {
        let before = look();
        std::thread::sleep(Duration::from_secs(2));
        let now = look();
        (changed(&before, &now, places.live_picture) < 0.001).then_some(now)
    });
    assert_eq!(hatched(&at_rest, places.live_picture), 0, "the first picture is hatched");

    // A double-click on its tab lets the live view fill the window. A slow machine may take the two clicks for single ones.
    let large = wait_for("the live view to fill the window", || {
        click_at(&display, places.live_tab, "2");
        let now = look();
        (changed(&at_rest, &now, places.settings_view) > 0.5).then_some(now)
    });
    assert_ne!(
        large.to_rgb8().get_pixel(band[0], band[1]).0,
        accent,
        "the introduction stays where it is true"
    );

    let [x, y] = [places.live_picture_maximized.center().x, places.live_picture_maximized.center().y]
        .map(|place| format!("{place:.0}"));
    drag(&display, [&x, &y], "40");
    let orbited = wait_for("the orbited picture", || {
        let now = look();
        (changed(&large, &now, places.live_picture_maximized) > 0.3).then_some(now)
    });
    assert_eq!(hatched(&orbited, places.live_picture_maximized), 0, "an orbited picture is hatched");
    xdotool(&display, &["key", "h"]).unwrap();
    wait_for("holes where they are asked for", || {
        (hatched(&look(), places.live_picture_maximized) > 500).then_some(())
    });
    xdotool(&display, &["key", "h"]).unwrap();
    wait_for("holes to be filled again", || {
        (hatched(&look(), places.live_picture_maximized) == 0).then_some(())
    });

    wait_for("the views side by side again", || {
        click_at(&display, places.live_name_maximized, "2");
        (changed(&at_rest, &look(), places.settings_view) < 0.2).then_some(())
    });
    let before = look();
    click_at(&display, places.source_picture, "1");
    wait_for("the explanation of the pixel", || {
        (changed(&before, &look(), places.pixel_view) > 0.02).then_some(())
    });

    // Back to the start: no pixel is selected, the view is where it was, and the introduction can be dismissed.
    xdotool(&display, &["key", "Escape"]).unwrap();
    xdotool(&display, &["key", "Home"]).unwrap();
    wait_for("the first picture again", || {
        (changed(&at_rest, &look(), places.live_picture) < 0.05).then_some(())
    });
    click_at(&display, places.got_it, "1");
    wait_for("the introduction to go", || {
        (look().to_rgb8().get_pixel(band[0], band[1]).0 != accent).then_some(())
    });
    quit(&display, program);
}
