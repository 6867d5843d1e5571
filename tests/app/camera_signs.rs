//! Many cameras in lists: each is chosen by its picture.

use std::collections::HashSet;

use egui::{Rect, accesskit::Role, vec2};
use egui_kittest::kittest::Queryable;
use image::RgbaImage;

use super::driver::{SIZE, click, demo, open, open_view, settle};

fn part(picture: &RgbaImage, area: Rect) -> RgbaImage {
    let [x, y, width, height] =
        [area.min.x, area.min.y, area.width(), area.height()].map(|side| side.round() as u32);
    image::imageops::crop_imm(picture, x, y, width, height).to_image()
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
