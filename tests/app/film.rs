//! The film that the README opens with: the window itself at work. With `OVERLOOK_UPDATE_SCREENSHOTS=1` it is written to
//! `screenshots/film.png`; otherwise a short one is made and checked.

use egui::{Key, vec2};
use image::{GenericImage, GrayImage, RgbImage};

use super::driver::{Window, choose, drag, look_at, open, settle};
use super::screenshots::{indexed, orrery, updating};

const SIZE: [f32; 2] = [1024.0, 640.0];

/// Bytes that the film may have.
const LARGEST: usize = 3_000_000;

/// Pictures of the window, each with the milliseconds for which it stays.
#[derive(Default)]
struct Film {
    pictures: Vec<(RgbImage, u16)>,
}

impl Film {
    fn shoot(&mut self, window: &mut Window, milliseconds: u16) {
        window.run_steps(2);
        let picture = window.render().expect("an adapter to draw with");
        self.pictures.push((image::DynamicImage::ImageRgba8(picture).to_rgb8(), milliseconds));
    }

    /// An animated PNG: one palette for all pictures, and of each after the first only what changed.
    fn png(&self) -> Vec<u8> {
        let (width, height) = self.pictures[0].0.dimensions();
        let mut all = RgbImage::new(width, height * self.pictures.len() as u32);
        for (nth, (picture, _)) in self.pictures.iter().enumerate() {
            all.copy_from(picture, 0, height * nth as u32).unwrap();
        }
        let (indices, palette) = indexed(&all);
        let of = |nth: usize| {
            image::imageops::crop_imm(&indices, 0, height * nth as u32, width, height).to_image()
        };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_palette(palette.as_flattened());
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::NoFilter);
        encoder.set_animated(self.pictures.len() as u32, 0).unwrap();
        let mut writer = encoder.write_header().unwrap();
        let mut before: Option<GrayImage> = None;
        for (nth, (_, milliseconds)) in self.pictures.iter().enumerate() {
            let now = of(nth);
            let [x, y, columns, rows] =
                before.as_ref().map_or([0, 0, width, height], |before| changed(before, &now));
            let part = image::imageops::crop_imm(&now, x, y, columns, rows).to_image();
            if nth > 0 {
                // The area of the picture before would not hold the new one.
                writer.reset_frame_position().unwrap();
                writer.set_frame_dimension(columns, rows).unwrap();
                writer.set_frame_position(x, y).unwrap();
            }
            writer.set_frame_delay(*milliseconds, 1000).unwrap();
            writer.write_image_data(&part).unwrap();
            before = Some(now);
        }
        writer.finish().unwrap();
        bytes
    }
}

/// The smallest area outside of which two pictures are equal, at least a pixel: column, row, columns, rows.
fn changed(before: &GrayImage, now: &GrayImage) -> [u32; 4] {
    let mut area: Option<[u32; 4]> = None;
    for (x, y, pixel) in now.enumerate_pixels() {
        if before.get_pixel(x, y) != pixel {
            let [left, top, right, bottom] = area.unwrap_or([x, y, x, y]);
            area = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
        }
    }
    let [left, top, right, bottom] = area.unwrap_or_default();
    [left, top, right - left + 1, bottom - top + 1]
}

#[test]
fn the_film_of_the_readme_shows_the_window_orbited_explained_and_played() {
    let steps = if updating() { 12 } else { 2 };
    let mut window = open(orrery(), SIZE);
    settle(&mut window);
    let mut film = Film::default();
    film.shoot(&mut window, 900);
    for _ in 0..steps {
        drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(9.0, -2.0));
        settle(&mut window);
        film.shoot(&mut window, 90);
    }
    choose(&mut window, "Source shows", "Kept by");
    choose(&mut window, "Live view shows", "Camera");
    settle(&mut window);
    film.shoot(&mut window, 1200);
    look_at(&mut window, "Source picture", vec2(0.62, 0.55));
    settle(&mut window);
    film.shoot(&mut window, 1800);
    for _ in 0..steps {
        drag(&mut window, "Live picture", vec2(0.5, 0.5), vec2(-9.0, 2.0));
        settle(&mut window);
        film.shoot(&mut window, 90);
    }
    choose(&mut window, "Live view shows", "Picture");
    for _ in 0..steps {
        window.key_press(Key::Period);
        settle(&mut window);
        film.shoot(&mut window, 90);
    }
    let bytes = film.png();
    assert!(bytes.len() <= LARGEST, "the film would have {} bytes", bytes.len());
    let read = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let animation = read.info().animation_control().expect("it is animated");
    assert_eq!(animation.num_frames as usize, film.pictures.len());
    assert!(
        film.pictures.windows(2).filter(|pair| pair[0].0 != pair[1].0).count() > steps,
        "the window moves"
    );
    if updating() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("screenshots");
        std::fs::write(folder.join("film.png"), bytes).unwrap();
    }
}
