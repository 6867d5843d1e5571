//! Pictures of the window, and what each has to show: texts, a theme, and pictures within it. With `OVERLOOK_UPDATE_SCREENSHOTS=1` they
//! are written to `screenshots/` (by `cargo test --release`, as they show how long things take); otherwise smaller ones are drawn.

use super::driver::{
    Window, choose, click, demo, drag, look_at, measure, open, open_share, open_view, pick, save_store,
    settle, shows, wait,
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

/// How a picture within the window looks.
#[derive(Clone, Copy, Debug)]
enum Look {
    /// As a camera records the scene: many colors, few of them strong, none of them in most places.
    Recorded,
    /// In the colors of two of the first three cameras; the rest may show its own picture.
    ByCamera,
    /// In the light colors of a diverging map.
    Diverging,
    /// In dark violet, but where two pictures differ.
    Difference,
    /// In this many colors at least.
    Colors(usize),
}

/// The share of all pixels that the condition holds for.
fn share(picture: &RgbaImage, holds: impl Fn([u8; 3]) -> bool) -> f64 {
    let all = f64::from(picture.width() * picture.height());
    picture.pixels().filter(|pixel| holds([pixel.0[0], pixel.0[1], pixel.0[2]])).count() as f64 / all
}

/// How many pixels have each color.
fn counts(picture: &RgbaImage) -> HashMap<[u8; 4], usize> {
    let mut counts = HashMap::new();
    for pixel in picture.pixels() {
        *counts.entry(pixel.0).or_insert(0) += 1;
    }
    counts
}

/// The difference of the largest and the smallest channel.
fn chroma(color: [u8; 3]) -> u8 {
    color.iter().max().unwrap() - color.iter().min().unwrap()
}

/// Whether a strong color has its hue in this range of degrees.
fn has_hue([r, g, b]: [u8; 3], degrees: std::ops::Range<f64>) -> bool {
    let [red, green, blue] = [r, g, b].map(f64::from);
    let hue = (3_f64.sqrt() * (green - blue)).atan2(2.0 * red - green - blue).to_degrees();
    chroma([r, g, b]) > 50 && degrees.contains(&hue.rem_euclid(360.0))
}

fn brightness(color: [u8; 3]) -> u32 {
    color.iter().map(|channel| u32::from(*channel)).sum::<u32>() / 3
}

impl Look {
    /// The look of a part of the window in numbers, for a picture that has another one.
    fn check(self, part: &RgbaImage, place: &str) {
        let counts = counts(part);
        let is_strong = share(part, |color| chroma(color) > 90);
        let commonest = *counts.values().max().unwrap() as f64 / f64::from(part.width() * part.height());
        let hue = |degrees: std::ops::Range<f64>| share(part, |color| has_hue(color, degrees.clone()));
        let bright = share(part, |color| brightness(color) > 180);
        let found = format!(
            "{place} {self:?}: {} colors, {commonest:.3} of one, {is_strong:.3} strong, {bright:.3} bright, hues {:.3} {:.3} {:.3} {:.3}",
            counts.len(),
            hue(190.0..215.0),
            hue(25.0..50.0),
            hue(150.0..175.0),
            hue(270.0..310.0)
        );
        let holds = match self {
            Self::Recorded => counts.len() > 500 && commonest < 0.6 && is_strong < 0.4,
            Self::ByCamera => {
                let cameras = [190.0..215.0, 25.0..50.0, 150.0..175.0];
                cameras.into_iter().filter(|camera| hue(camera.clone()) > 0.03).count() >= 2
            }
            Self::Diverging => bright > 0.3,
            Self::Difference => hue(270.0..310.0) > 0.2,
            Self::Colors(least) => counts.len() >= least,
        };
        assert!(holds, "{found}");
    }
}

/// A part of a picture of the window, by its accessible name.
fn part_of(window: &Window, picture: &RgbaImage, name: &str) -> RgbaImage {
    let [x, y, width, height] = {
        let area = window.get_by_label(name).rect();
        [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32)
    };
    image::imageops::crop_imm(picture, x, y, width, height).to_image()
}

/// Takes a picture of the window, which has to say the texts and to have each look in the part of an accessible name. The theme is
/// light where the name says so.
fn shoot(window: &mut Window, name: &str, texts: &[&str], pictures: &[(&str, Look)]) {
    window.run_steps(4);
    let picture =
        window.render().expect("no adapter to draw with: install a Vulkan driver (mesa-vulkan-drivers)");
    for text in texts {
        assert!(shows(window, text), "{name} does not say {text:?}");
    }
    let counts = counts(&picture);
    let most = counts.values().copied().max().unwrap_or(0);
    let pixels = (picture.width() * picture.height()) as usize;
    assert!(counts.len() > 100, "{name}: only {} colors", counts.len());
    assert!(most < pixels * 9 / 10, "{name}: almost blank");
    let dark = share(&picture, |color| brightness(color) < 60);
    assert!(if name.ends_with("_light") { dark < 0.2 } else { dark > 0.5 }, "{name}: {dark} of it is dark");
    for (place, look) in pictures {
        look.check(&part_of(window, &picture, place), &format!("{name}, {place}"));
    }
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

#[test]
fn the_window_shows_a_capture_in_both_themes_and_with_overlays() {
    let mut window = open(orrery(), [1280.0, 800.0]);
    settle(&mut window);
    shoot(
        &mut window,
        "main_dark",
        &["orrery", "Samples kept", "Frame 1 of", "Ready"],
        &[("Source picture", Look::Recorded), ("Live picture", Look::Recorded)],
    );
    choose(&mut window, "Source shows", "Kept by");
    choose(&mut window, "Live view shows", "Camera");
    click(&mut window, "Report");
    look_at(&mut window, "Source picture", egui::vec2(0.62, 0.55));
    settle(&mut window);
    shoot(
        &mut window,
        "who_won",
        &["What was dropped, and why", "Which camera replaces which", "this pixel"],
        &[("Source picture", Look::ByCamera), ("Live picture", Look::ByCamera)],
    );
    open_view(&mut window, "Cameras");
    settle(&mut window);
    shoot(&mut window, "cameras", &["Which camera replaces which"], &[("Live picture", Look::ByCamera)]);
    choose(&mut window, "Source shows", "Sampling");
    choose(&mut window, "Live view shows", "Sampling");
    click(&mut window, "Settings");
    settle(&mut window);
    shoot(
        &mut window,
        "sampling_ratio",
        &["this camera denser", "denser than pixels", "Depth tolerance"],
        &[("Source picture", Look::Diverging), ("Live picture", Look::Diverging)],
    );
    choose(&mut window, "Live view shows", "Picture");
    open_view(&mut window, "Compare");
    open_view(&mut window, "Time");
    shoot(
        &mut window,
        "compare_wipe",
        &["Left side"],
        &[("Comparison", Look::Recorded), ("Source picture", Look::Diverging)],
    );
    choose(&mut window, "Compare by", "Difference");
    pick(&mut window, "Left side", "Truth");
    pick(&mut window, "From", "Camera left, held out");
    open_view(&mut window, "Cameras");
    settle(&mut window);
    shoot(&mut window, "compare_truth", &["PSNR"], &[("Comparison", Look::Difference)]);
    open_view(&mut window, "Live view");
    open_view(&mut window, "Time");
    choose(&mut window, "Source shows", "Motion");
    window.set_size(egui::vec2(1920.0, 1080.0));
    choose(&mut window, "Live view shows", "Picture");
    click(&mut window, "Light theme");
    settle(&mut window);
    shoot(&mut window, "main_light", &["Samples kept"], &[("Live picture", Look::Recorded)]);
    choose(&mut window, "Source shows", "Tiles");
    click(&mut window, "Report");
    settle(&mut window);
    shoot(&mut window, "tiles_light", &["What was dropped, and why"], &[("Live picture", Look::Recorded)]);
}

#[test]
fn the_window_shows_what_the_inspector_measures_and_how_it_explains_itself() {
    let mut window = open(orrery(), [1024.0, 640.0]);
    settle(&mut window);
    click(&mut window, "Light theme");
    look_at(&mut window, "Live picture", egui::vec2(0.4, 0.6));
    settle(&mut window);
    shoot(
        &mut window,
        "small_light",
        &["this pixel"],
        &[("Source picture", Look::Recorded), ("Live picture", Look::Recorded)],
    );
    click(&mut window, "Dark theme");
    window.set_size(egui::vec2(1280.0, 800.0));
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::P);
    window.run_steps(3);
    window.get_by_label("Command").type_text("set render");
    window.run_steps(3);
    shoot(&mut window, "palette", &["Kernel"], &[]);
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    open_view(&mut window, "Camera path");
    window.key_press(egui::Key::K);
    drag(&mut window, "Live picture", egui::vec2(0.5, 0.5), egui::vec2(90.0, 20.0));
    window.key_press(egui::Key::K);
    choose(&mut window, "Live view shows", "Motion");
    settle(&mut window);
    shoot(&mut window, "camera_path", &["Key 1", "Key 2"], &[]);
    open_share(&mut window, "Interactive page");
    shoot(&mut window, "share", &["Interactive page: about", "Title of the page"], &[]);
    click(&mut window, "Close sharing");
    open_view(&mut window, "Sweep");
    measure(&mut window, "Run a sweep…");
    let points = if updating() { "12 settings; click one" } else { "1 setting; click it" };
    wait(&mut window, "the points", |window| window.query_all_by_label_contains(points).next().is_some());
    shoot(&mut window, "sweep", &["Pareto front"], &[("Sweep chart", Look::Colors(20))]);
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
    shoot(&mut window, "store", &["orrery"], &[("Live picture", Look::Recorded)]);
}

#[test]
fn the_window_shows_that_it_is_loading_and_what_went_wrong() {
    let mut window = open(orrery(), [1280.0, 800.0]);
    shoot(&mut window, "opening", &[], &[]);
    wait(&mut window, "the first picture", |window| window.state().observed().live_coverage.is_some());
    shoot(&mut window, "loading", &["orrery"], &[("Live picture", Look::Recorded)]);
    let missing = overlook::app::Start::Path("/no/such/folder/capture.ovl".into());
    let mut window = open(missing, [1280.0, 800.0]);
    wait(&mut window, "the error", |window| !window.state().observed().notices.is_empty());
    // It is drawn with the next picture of the window.
    window.run_steps(2);
    assert!(window.query_by_label("Dismiss").is_some());
    shoot(&mut window, "error", &["/no/such/folder/capture.ovl", "Dismiss"], &[]);
}

#[test]
fn a_picture_of_few_colors_comes_back_from_its_palette_as_it_was() {
    let picture = RgbImage::from_fn(40, 30, |x, y| image::Rgb([x as u8 * 6, 7 * (y as u8 % 4), 200]));
    let (indices, palette) = indexed(&picture);
    let read = image::load_from_memory(&with_palette(&indices, &palette)).unwrap().to_rgb8();
    assert_eq!(read, picture);
}
