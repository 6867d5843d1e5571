//! What somebody sees who has never seen the program.

use egui::{Rect, accesskit::Role};
use egui_kittest::kittest::Queryable;

use super::driver::{SIZE, Window, click, demo, look_at, open_fresh, settle, shows};

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
