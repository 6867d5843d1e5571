//! Many cameras in lists: each has a sign of its own, and is chosen by its picture.

use std::collections::HashSet;

use egui::{Rect, accesskit::Role, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use image::RgbaImage;

use super::driver::{SIZE, Window, click, demo, open, open_view, settle};

fn part(picture: &RgbaImage, area: Rect) -> RgbaImage {
    let [x, y, width, height] =
        [area.min.x, area.min.y, area.width(), area.height()].map(|side| side.round() as u32);
    image::imageops::crop_imm(picture, x, y, width, height).to_image()
}

/// The signs left of the names in the list of cameras that a filter leaves, as far as they are in view, as they are drawn.
fn signs(window: &mut Window, filter: &str) -> Vec<RgbaImage> {
    window.get_by_label("Filter the cameras").focus();
    window.run_steps(2);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text(filter.to_owned()));
    window.run_steps(4);
    let names: Vec<Rect> = (window.query_all_by_label_contains("Camera extra"))
        .filter(|node| node.accesskit_node().role() == Role::Button)
        .map(|node| node.rect())
        .collect();
    assert!(names.len() > 5, "{filter}: {} cameras", names.len());
    let picture = window.render().unwrap();
    let signs = names.into_iter().map(|name| {
        let sign = Rect::from_center_size(pos2(name.left() - 13.0, name.center().y), vec2(18.0, 14.0));
        part(&picture, sign)
    });
    signs.collect()
}

#[test]
fn of_thirty_two_cameras_no_two_have_one_sign_and_none_vanishes_in_either_theme() {
    let mut window = open(demo(32, 1, (32, 24)), [SIZE[0], 1700.0]);
    settle(&mut window);
    click(&mut window, "Workspace: Explore");
    open_view(&mut window, "View");
    settle(&mut window);
    for theme in ["Light theme", "Dark theme"] {
        click(&mut window, theme);
        settle(&mut window);
        // The first ones, and those whose colors were there before.
        let signs = [signs(&mut window, "extra1"), signs(&mut window, "extra2")].concat();
        let different: HashSet<Vec<u8>> = signs.iter().map(|sign| sign.as_raw().clone()).collect();
        assert_eq!(different.len(), signs.len(), "after {theme}");
        for (nth, sign) in signs.iter().enumerate() {
            let brightness =
                |pixel: &image::Rgba<u8>| pixel.0[..3].iter().map(|c| i32::from(*c)).sum::<i32>();
            let ground = brightness(sign.get_pixel(0, 0));
            let seen = sign.pixels().filter(|pixel| (brightness(pixel) - ground).abs() > 90).count();
            assert!(seen > 25, "after {theme}, camera {nth}: {seen} pixels stand out");
        }
    }
}

#[test]
fn the_list_to_go_to_shows_the_picture_of_each_camera() {
    let mut window = open(demo(5, 1, (96, 72)), SIZE);
    settle(&mut window);
    // The pictures of the list are those of the thumbnails.
    open_view(&mut window, "Cameras");
    settle(&mut window);
    click(&mut window, "Go to camera");
    for name in ["front", "left", "right"] {
        let row = window.get_by_role_and_label(Role::Button, name).rect();
        let picture = window.render().unwrap();
        let colors: HashSet<[u8; 4]> =
            part(&picture, Rect::from_min_size(row.min + vec2(4.0, 4.0), vec2(48.0, 34.0)))
                .pixels()
                .map(|pixel| pixel.0)
                .collect();
        assert!(colors.len() > 60, "{name}: {} colors", colors.len());
    }
}
