//! What somebody sees who has never seen the program.

use std::path::Path;
use std::time::Duration;

use egui::{Rect, accesskit::Role};
use egui_kittest::kittest::Queryable;
use image::RgbaImage;

use super::command::{overlook, succeed};
use super::display::{
    can_drive_a_window, clipboard_text, drag, picture_of, quit, start_display, start_program, wait_for,
    wait_for_pictures, xdotool,
};
use super::driver::{SIZE, Window, click, demo, look_at, open_fresh, settle, shows, wait};
use overlook::app::Start;

fn rect_of(window: &Window, name: &str) -> Rect {
    window.get_by_label(name).rect()
}

fn tab_of(window: &Window, name: &str) -> Rect {
    window.get_by_role_and_label(Role::Button, name).rect()
}

#[test]
fn the_introduction_covers_nothing_that_it_explains_and_goes_with_the_views_it_speaks_of() {
    let mut window = open_fresh(demo(3, 4, (96, 72)), SIZE);
    settle(&mut window);
    let introduction = ["Click a pixel", "Orbit the live view", "Change a threshold"]
        .map(|title| rect_of(&window, title))
        .into_iter()
        .fold(Rect::NOTHING, Rect::union);
    let pictures = ["Live picture", "Source picture"].map(|name| rect_of(&window, name));
    let tabs = ["Live view", "Settings", "Pixel"].map(|name| tab_of(&window, name));
    for explained in pictures.into_iter().chain(tabs) {
        assert!(!introduction.intersects(explained), "the introduction covers {explained:?}");
    }
    assert!(window.query_by_label("Play").is_some(), "nothing plays while a pixel is to be clicked");
    look_at(&mut window, "Source picture", egui::vec2(0.5, 0.5));
    settle(&mut window);
    assert!(shows(&window, "Kept") || shows(&window, "Dropped"), "the pixel is explained");
    click(&mut window, "Maximize Live view");
    assert!(window.query_by_label("Got it").is_none(), "nothing speaks of views that are not there");
}

#[test]
fn a_start_without_anything_to_open_shows_a_room_that_moves_says_what_it_is_and_leads_to_why_in_one_click() {
    for size in [[1280.0, 800.0], [1024.0, 640.0]] {
        let mut window = open_fresh(Start::Welcome, size);
        wait(&mut window, "time to pass", |window| window.state().observed().frame > 0);
        wait(&mut window, "the first picture", |window| shows(window, "samples drawn"));
        assert!(shows(&window, "9 cameras filmed this room for 60 frames"));
        for nothing in ["–", "…"] {
            assert!(window.query_all_by_label(nothing).next().is_none(), "a figure is {nothing}");
        }
        assert!(shows(&window, "What became of all pixels: Kept 2"), "the bars are in sight");
        assert!(!shows(&window, "Aligning") && !shows(&window, "Reading frames"));
        click(&mut window, "See why");
        assert!(shows(&window, "What was dropped, and why"));
        click(&mut window, "Got it");
        assert!(!shows(&window, "filmed this room"));
    }
}

/// A window of the program on a display of its own, and where its parts lie.
struct RealWindow<'a> {
    display: &'a str,
    folder: &'a Path,
    /// The live picture as long as it is docked.
    live: Rect,
}

impl RealWindow<'_> {
    /// A part of what is on the display.
    fn part(&self, area: Rect) -> RgbaImage {
        let [x, y, width, height] =
            [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
        picture_of(self.display, self.folder).crop_imm(x, y, width, height).to_rgba8()
    }

    /// A part of the display once it has been the same for a while.
    fn at_rest(&self, area: Rect) -> RgbaImage {
        wait_for("the picture to come to rest", || {
            let before = self.part(area);
            std::thread::sleep(Duration::from_millis(1500));
            (self.part(area) == before).then_some(before)
        })
    }

    fn press(&self, key: &str) {
        xdotool(self.display, &["key", key]).unwrap();
    }

    fn point_at(&self, at: egui::Pos2) {
        let [x, y] = [at.x, at.y].map(|place| format!("{place:.0}"));
        xdotool(self.display, &["mousemove", &x, &y]).unwrap();
        std::thread::sleep(Duration::from_millis(300));
    }

    /// Double-clicks until a part of the display shows something else; on a busy machine two clicks may come too far apart.
    fn double_click_until_changed(&self, at: egui::Pos2, area: Rect) {
        let before = self.part(area);
        wait_for("the double-click to be answered", || {
            self.point_at(at);
            xdotool(self.display, &["click", "--repeat", "2", "--delay", "10", "1"]).unwrap();
            std::thread::sleep(Duration::from_secs(3));
            (changed(&before, &self.part(area)) > 0.5).then_some(())
        });
    }
}

/// Pixels that differ between two pictures of one size, as a share of all.
fn changed(before: &RgbaImage, after: &RgbaImage) -> f64 {
    let changed = before.pixels().zip(after.pixels()).filter(|(before, after)| before != after).count();
    changed as f64 / f64::from(before.width() * before.height())
}

/// How often brightness differs from the pixel below, of the pixels that two pictures show differently: stripes have many such edges,
/// filled holes few. In each of the two, as shares of those pixels.
fn edges_where_they_differ(before: &RgbaImage, after: &RgbaImage) -> [f64; 2] {
    let brightness = |picture: &RgbaImage, x, y| {
        picture.get_pixel(x, y).0[..3].iter().map(|value| i32::from(*value)).sum::<i32>()
    };
    let (width, height) = before.dimensions();
    let pairs = (0..height - 1).flat_map(|y| (0..width).map(move |x| (x, y)));
    let differing: Vec<_> = pairs.filter(|&(x, y)| before.get_pixel(x, y) != after.get_pixel(x, y)).collect();
    [before, after].map(|picture| {
        let is_edge = |&&(x, y): &&(u32, u32)| {
            (brightness(picture, x, y) - brightness(picture, x, y + 1)).abs() > STRIPE_STEP
        };
        differing.iter().filter(is_edge).count() as f64 / differing.len().max(1) as f64
    })
}

/// Least step from a stripe to what lies between stripes, sum of three channels of 255.
const STRIPE_STEP: i32 = 30;

#[test]
fn in_the_first_minute_a_real_window_is_maximized_orbited_asked_about_a_pixel_and_put_back() {
    if !can_drive_a_window() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let size = ["--cameras", "3", "--frames", "4", "--size", "240x180", "--out", "orrery"];
    succeed(overlook(folder.path(), &[&["demo", "orrery"], size.as_slice()].concat()));
    let capture = folder.path().join("orrery");
    let mut plan = open_fresh(Start::Path(capture.clone()), SIZE);
    settle(&mut plan);
    let live = rect_of(&plan, "Live picture").shrink(12.0);
    let [tab, settings] = ["Live view", "Settings"].map(|name| tab_of(&plan, name));
    let pixel_panel = Rect::from_min_max(settings.left_bottom(), egui::pos2(SIZE[0], live.bottom()));
    let source = rect_of(&plan, "Source picture").shrink(12.0);
    let (_server, display) = start_display();
    let program = start_program(&display, folder.path(), &[&capture]);
    let window = RealWindow { display: &display, folder: folder.path(), live };
    wait_for_pictures(&display, folder.path());

    // The introduction asks to click a pixel: what is to be clicked stands still.
    window.point_at(egui::pos2(SIZE[0] / 2.0, 4.0));
    let start = window.at_rest(window.live);
    let recorded = window.at_rest(source);

    // The picture has no stripes; the key that hatches holes makes some.
    window.press("h");
    let hatched = wait_for("hatched holes", || {
        let now = window.part(window.live);
        (changed(&start, &now) > 0.01).then(|| window.at_rest(window.live))
    });
    let [filled, striped] = edges_where_they_differ(&start, &hatched);
    assert!(striped > 2.0 * filled, "edges are {filled} of what was filled and {striped} of what is striped");
    window.press("h");
    wait_for("filled holes", || (window.part(window.live) == start).then_some(()));

    // Where the source picture was, the live view shows something else.
    window.double_click_until_changed(tab.center(), source);
    window.point_at(egui::pos2(SIZE[0] / 2.0, 4.0));
    let large = Rect::from_min_max(egui::pos2(40.0, live.top()), egui::pos2(SIZE[0] - 40.0, live.bottom()));
    let maximized = window.at_rest(large);
    assert!(changed(&recorded, &window.part(source)) > 0.5, "the live view fills the window");
    assert!(colors(&window.part(pixel_panel)) > 1000, "also where settings were");

    drag(&display, ["640", "480"], "40");
    window.point_at(egui::pos2(SIZE[0] / 2.0, 4.0));
    let orbited = window.at_rest(large);
    assert!(changed(&maximized, &orbited) > 0.2, "the scene is seen from elsewhere");

    // The top of the table, which is no hole from here.
    window.point_at(large.lerp_inside(egui::vec2(0.6, 0.85)));
    xdotool(&display, &["click", "1"]).unwrap();
    let explanation = wait_for("an explanation of the pixel", || {
        window.press("ctrl+shift+c");
        std::thread::sleep(Duration::from_millis(500));
        clipboard_text(&display)
    });
    assert!(
        explanation.starts_with("orrery: camera ") && explanation.contains("\nFrame 1\n"),
        "{explanation}"
    );
    assert!(explanation.contains("footprint density"), "each camera is a row: {explanation}");

    // What is told of the clipboard is closed; the pixel stays pinned, with its mark in the picture.
    for key in ["shift+space", "Escape", "Home"] {
        window.press(key);
        std::thread::sleep(Duration::from_millis(300));
    }
    window.point_at(egui::pos2(SIZE[0] / 2.0, 4.0));
    // The mark and its outline cover up to 28×28 of some 150,000 pixels: 0.52 percent.
    wait_for("the first picture", || (changed(&start, &window.part(window.live)) < 0.006).then_some(()));
    quit(&display, program);
}

fn colors(picture: &RgbaImage) -> usize {
    picture.pixels().map(|pixel| pixel.0).collect::<std::collections::HashSet<_>>().len()
}
