//! Pictures of the window. With `OVERLOOK_UPDATE_SCREENSHOTS=1` they are written to `screenshots/` (by `cargo test --release`, as
//! they show how long things take); otherwise smaller ones are drawn and checked to hold something.

use super::driver::{
    Window, choose, click, demo, drag, look_at, measure, open, open_share, open_view, pick, save_store,
    settle, wait,
};
use egui_kittest::kittest::Queryable;
use image::{GrayImage, RgbImage, RgbaImage};
use std::collections::HashMap;

pub(super) fn updating() -> bool {
    std::env::var_os("OVERLOOK_UPDATE_SCREENSHOTS").is_some_and(|value| value == "1")
}

/// The recording in the pictures: the orrery at its own size while updating, a small one otherwise.
pub(super) fn orrery() -> overlook::app::Start {
    if updating() { demo(5, 16, (400, 300)) } else { demo(3, 3, (64, 48)) }
}

fn shoot(window: &mut Window, name: &str) {
    window.run_steps(4);
    let picture =
        window.render().expect("no adapter to draw with: install a Vulkan driver (mesa-vulkan-drivers)");
    check(&picture, name);
    if updating() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("screenshots");
        std::fs::create_dir_all(&folder).unwrap();
        save(picture, &folder.join(format!("{name}.png")));
    }
}

/// Bytes a picture of the window may have.
const LARGEST: usize = 250_000;

/// Small files: 256 colors, the window's own among them.
fn save(picture: RgbaImage, path: &std::path::Path) {
    let (indices, palette) = indexed(&image::DynamicImage::ImageRgba8(picture).to_rgb8());
    let bytes = with_palette(&indices, &palette);
    assert!(bytes.len() <= LARGEST, "{} would have {} bytes", path.display(), bytes.len());
    std::fs::write(path, bytes).unwrap();
}

/// The nearest of 256 colors, pixel by pixel: half of them those found most often, the others by median cut of what
/// is left (Heckbert, *Color image quantization for frame buffer display*, 1982).
pub(super) fn indexed(picture: &RgbImage) -> (GrayImage, Vec<[u8; 3]>) {
    let mut counts = HashMap::new();
    for pixel in picture.pixels() {
        *counts.entry(pixel.0).or_insert(0_usize) += 1;
    }
    let mut colors: Vec<[u8; 3]> = counts.keys().copied().collect();
    colors.sort_unstable_by_key(|color| (std::cmp::Reverse(counts[color]), *color));
    let rest = colors.split_off(colors.len().min(128));
    let mut palette = colors;
    let mut boxes = vec![rest];
    let widest = |colors: &[[u8; 3]]| {
        let range = |axis: usize| {
            let values = colors.iter().map(|color| color[axis]);
            values.clone().max().unwrap_or(0) - values.min().unwrap_or(0)
        };
        (0..3).map(|axis| (range(axis), axis)).max().unwrap()
    };
    while boxes.len() < 128 {
        let (at, (range, axis)) =
            boxes.iter().map(|colors| widest(colors)).enumerate().max_by_key(|(_, wide)| wide.0).unwrap();
        if range == 0 {
            break;
        }
        boxes[at].sort_unstable_by_key(|color| color[axis]);
        let half = boxes[at].len() / 2;
        let upper = boxes[at].split_off(half);
        boxes.push(upper);
    }
    palette.extend(boxes.iter().filter(|colors| !colors.is_empty()).map(|colors| {
        let weight: usize = colors.iter().map(|color| counts[color]).sum();
        [0, 1, 2].map(|axis| {
            let sum: usize = colors.iter().map(|color| usize::from(color[axis]) * counts[color]).sum();
            (sum / weight) as u8
        })
    }));
    let distance =
        |a: &[u8; 3], b: &[u8; 3]| (0..3).map(|i| u32::from(a[i].abs_diff(b[i])).pow(2)).sum::<u32>();
    let nearest: HashMap<[u8; 3], u8> = counts
        .keys()
        .map(|color| {
            (*color, (0..palette.len()).min_by_key(|i| distance(color, &palette[*i])).unwrap() as u8)
        })
        .collect();
    let indices = GrayImage::from_fn(picture.width(), picture.height(), |x, y| {
        image::Luma([nearest[&picture.get_pixel(x, y).0]])
    });
    (indices, palette)
}

/// A PNG of 8-bit indices into a palette.
fn with_palette(indices: &GrayImage, palette: &[[u8; 3]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, indices.width(), indices.height());
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette.as_flattened());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    encoder.write_header().unwrap().write_image_data(indices).unwrap();
    bytes
}

/// A picture holds something where it has many colors and no single one covers it all.
fn check(picture: &RgbaImage, name: &str) {
    let mut counts = HashMap::new();
    for pixel in picture.pixels() {
        *counts.entry(pixel.0).or_insert(0_usize) += 1;
    }
    let most = counts.values().copied().max().unwrap_or(0);
    let pixels = (picture.width() * picture.height()) as usize;
    assert!(counts.len() > 100, "{name}: only {} colors", counts.len());
    assert!(most < pixels * 9 / 10, "{name}: almost blank");
}

#[test]
fn the_window_shows_a_capture_in_both_themes_and_with_overlays() {
    let mut window = open(orrery(), [1280.0, 800.0]);
    settle(&mut window);
    shoot(&mut window, "main_dark");
    choose(&mut window, "Source shows", "Kept by");
    choose(&mut window, "Live view shows", "Camera");
    click(&mut window, "Report");
    look_at(&mut window, "Source picture", egui::vec2(0.62, 0.55));
    settle(&mut window);
    shoot(&mut window, "who_won");
    open_view(&mut window, "Cameras");
    settle(&mut window);
    shoot(&mut window, "cameras");
    choose(&mut window, "Source shows", "Sampling");
    choose(&mut window, "Live view shows", "Sampling");
    click(&mut window, "Settings");
    settle(&mut window);
    shoot(&mut window, "sampling_ratio");
    choose(&mut window, "Live view shows", "Picture");
    open_view(&mut window, "Compare");
    open_view(&mut window, "Time");
    shoot(&mut window, "compare_wipe");
    choose(&mut window, "Compare by", "Difference");
    pick(&mut window, "Left side", "Truth");
    pick(&mut window, "From", "Camera left, held out");
    open_view(&mut window, "Memory");
    settle(&mut window);
    shoot(&mut window, "compare_truth");
    open_view(&mut window, "Live view");
    choose(&mut window, "Source shows", "Motion");
    window.set_size(egui::vec2(1920.0, 1080.0));
    choose(&mut window, "Live view shows", "Picture");
    click(&mut window, "Light theme");
    settle(&mut window);
    shoot(&mut window, "main_light");
    choose(&mut window, "Source shows", "Tiles");
    click(&mut window, "Report");
    settle(&mut window);
    shoot(&mut window, "tiles_light");
}

#[test]
fn the_window_shows_what_the_inspector_measures_and_how_it_explains_itself() {
    let mut window = open(orrery(), [1024.0, 640.0]);
    settle(&mut window);
    click(&mut window, "Light theme");
    look_at(&mut window, "Live picture", egui::vec2(0.4, 0.6));
    settle(&mut window);
    shoot(&mut window, "small_light");
    click(&mut window, "Dark theme");
    window.set_size(egui::vec2(1280.0, 800.0));
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::P);
    window.run_steps(3);
    window.get_by_label("Command").type_text("set render");
    window.run_steps(3);
    shoot(&mut window, "palette");
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    open_view(&mut window, "Camera path");
    window.key_press(egui::Key::K);
    drag(&mut window, "Live picture", egui::vec2(0.5, 0.5), egui::vec2(90.0, 20.0));
    window.key_press(egui::Key::K);
    choose(&mut window, "Live view shows", "Motion");
    settle(&mut window);
    shoot(&mut window, "camera_path");
    open_share(&mut window, "Interactive page");
    shoot(&mut window, "share");
    click(&mut window, "Close sharing");
    open_view(&mut window, "Log");
    open_view(&mut window, "Sweep");
    measure(&mut window, "Run a sweep…");
    let points = if updating() { "12 settings; click one" } else { "1 setting; click it" };
    wait(&mut window, "the points", |window| window.query_all_by_label_contains(points).next().is_some());
    shoot(&mut window, "sweep");
    window.key_press(egui::Key::Escape);
}

#[test]
fn the_window_shows_a_store_without_source_frames() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(orrery(), [1280.0, 800.0]);
    settle(&mut window);
    let path = save_store(&mut window, folder.path());
    let mut window = open(overlook::app::Start::Path(path), [1280.0, 800.0]);
    wait(&mut window, "the store", |window| window.state().observed().scene_name.is_some());
    settle(&mut window);
    shoot(&mut window, "store");
}

#[test]
fn the_window_shows_that_it_is_loading_and_what_went_wrong() {
    let mut window = open(orrery(), [1280.0, 800.0]);
    shoot(&mut window, "opening");
    wait(&mut window, "the first picture", |window| window.state().observed().live_coverage.is_some());
    shoot(&mut window, "loading");
    let missing = overlook::app::Start::Path("/no/such/folder/capture.ovl".into());
    let mut window = open(missing, [1280.0, 800.0]);
    wait(&mut window, "the error", |window| !window.state().observed().notices.is_empty());
    // It is drawn with the next picture of the window.
    window.run_steps(2);
    assert!(window.query_by_label("Dismiss").is_some());
    shoot(&mut window, "error");
}

#[test]
fn a_picture_of_few_colors_comes_back_from_its_palette_as_it_was() {
    let picture = RgbImage::from_fn(40, 30, |x, y| image::Rgb([x as u8 * 6, 7 * (y as u8 % 4), 200]));
    let (indices, palette) = indexed(&picture);
    let read = image::load_from_memory(&with_palette(&indices, &palette)).unwrap().to_rgb8();
    assert_eq!(read, picture);
}
