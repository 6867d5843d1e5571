//! `overlook export video`: films that other programs play, on machines without any other program.

use std::io::Cursor;
use std::path::Path;
use std::process::Output;

use image::codecs::gif::GifDecoder;
use image::{AnimationDecoder, Frame, Rgba};
use rusty_h264_decoder::Decoder;
use serde_json::json;

use crate::command::{overlook, scene, succeed};

/// A folder with the store of a small scene, and a camera path from its truth view of this size.
fn stored(frames: &str, [width, height]: [usize; 2]) -> tempfile::TempDir {
    let folder = scene(frames, "64x48");
    succeed(overlook(folder.path(), &["preprocess", "scene", "--out", "scene.ovl"]));
    let views = std::fs::read(folder.path().join("scene/novel/transforms.json")).unwrap();
    let views: serde_json::Value = serde_json::from_slice(&views).unwrap();
    let view = |frame: usize| {
        let mut pose = views["frames"][0]["transform_matrix"].clone();
        pose[0][3] = json!(pose[0][3].as_f64().unwrap() + 0.02 * frame as f64);
        json!({"file_path": format!("{frame}.png"), "path_time": 0.5 * frame as f64, "transform_matrix": pose})
    };
    let path = json!({"w": width, "h": height, "fl_x": width, "frame": 1, "frames": [view(0), view(1)]});
    std::fs::write(folder.path().join("path.json"), path.to_string()).unwrap();
    folder
}

fn film(folder: &Path, more: &[&str]) -> Output {
    let arguments = ["export", "video", "scene.ovl", "--path", "path.json", "--backend", "cpu"];
    overlook(folder, &[&arguments[..], more].concat()).env("PATH", folder).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The content of the box at the end of a path of names, where `skip` bytes stand before the boxes within it.
fn content<'a>(mut boxes: &'a [u8], path: &[(&str, usize)]) -> &'a [u8] {
    for (name, skip) in path {
        let found = loop {
            assert!(boxes.len() >= 8, "there is no {name}");
            let size = u32::from_be_bytes(boxes[..4].try_into().unwrap()) as usize;
            if &boxes[4..8] == name.as_bytes() {
                break &boxes[8 + skip..size];
            }
            boxes = &boxes[size..];
        };
        boxes = found;
    }
    boxes
}

const TABLE: [(&str, usize); 5] = [("moov", 0), ("trak", 0), ("mdia", 0), ("minf", 0), ("stbl", 0)];
/// The fields of a video before its own boxes.
const ENTRY: [(&str, usize); 2] = [("stsd", 8), ("avc1", 78)];

fn table<'a>(film: &'a [u8], path: &[(&str, usize)]) -> &'a [u8] {
    content(film, &[&TABLE[..], path].concat())
}

fn numbers(bytes: &[u8]) -> Vec<usize> {
    bytes.chunks_exact(4).map(|four| u32::from_be_bytes(four.try_into().unwrap()) as usize).collect()
}

/// The pictures of a film as a decoder shows them, sRGB.
fn decoded(film: &[u8]) -> Vec<image::RgbImage> {
    let decoder = table(film, &[&ENTRY[..], &[("avcC", 0)]].concat());
    let mut stream = Vec::new();
    let mut at = 6;
    for _ in 0..2 {
        let size = usize::from(u16::from_be_bytes([decoder[at], decoder[at + 1]]));
        stream.extend([0, 0, 0, 1]);
        stream.extend(&decoder[at + 2..at + 2 + size]);
        at += 3 + size;
    }
    let mut start = numbers(table(film, &[("stco", 0)]))[2];
    for size in &numbers(table(film, &[("stsz", 0)]))[3..] {
        let unit = &film[start..start + size];
        assert_eq!(numbers(&unit[..4]), [size - 4], "one unit is one picture");
        stream.extend([0, 0, 0, 1]);
        stream.extend(&unit[4..]);
        start += size;
    }
    assert_eq!(start, film.len(), "the pictures end where the film does");
    let frames = Decoder::new().decode_stream(&stream).unwrap();
    let shown = |frame: &rusty_h264_common::YuvFrame| {
        image::RgbImage::from_fn(frame.width as u32, frame.height as u32, |x, y| {
            let color = y as usize / 2 * frame.width / 2 + x as usize / 2;
            let luma = (f32::from(frame.y[y as usize * frame.width + x as usize]) - 16.0) * 255.0 / 219.0;
            let [blue, red] =
                [&frame.u, &frame.v].map(|plane| (f32::from(plane[color]) - 128.0) * 255.0 / 224.0);
            // Rec. 709.
            let rgb = [luma + 1.5748 * red, luma - 0.187_324 * blue - 0.468_124 * red, luma + 1.8556 * blue];
            image::Rgb(rgb.map(|channel| (channel + 0.5).clamp(0.0, 255.0) as u8))
        })
    };
    frames.iter().map(shown).collect()
}

/// A picture as films show it, where holes are black.
fn over_black(picture: &image::RgbaImage) -> image::RgbImage {
    image::RgbImage::from_fn(picture.width(), picture.height(), |x, y| {
        let [red, green, blue, alpha] = picture.get_pixel(x, y).0;
        image::Rgb(if alpha > 0 { [red, green, blue] } else { [0; 3] })
    })
}

/// The mean color of every four pixels, which share one in a film.
fn means_of_four(picture: &image::RgbImage) -> Vec<f32> {
    let blocks =
        (0..picture.height() / 2).flat_map(|y| (0..picture.width() / 2).map(move |x| (2 * x, 2 * y)));
    let mean = |(x, y): (u32, u32), channel: usize| {
        let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        four.map(|(x, y)| f32::from(picture.get_pixel(x, y).0[channel])).iter().sum::<f32>() / 4.0
    };
    blocks.flat_map(|at| (0..3).map(move |channel| mean(at, channel))).collect()
}

#[test]
fn a_film_shows_the_pictures_of_its_path_without_another_program() {
    let folder = stored("3", [70, 50]);
    let folder = folder.path();
    let output = film(folder, &["--fps", "12", "--out", "film.mp4"]);
    assert!(output.status.success(), "{}", said(&output));
    let bytes = std::fs::read(folder.join("film.mp4")).unwrap();
    let shown = decoded(&bytes);
    let pictures =
        ["export", "pictures", "scene.ovl", "--path", "path.json", "--backend", "cpu", "--pictures", "7"];
    succeed(overlook(folder, &[&pictures[..], &["--out", "pictures"]].concat()));
    assert_eq!(shown.len(), 7, "half a second at 12 pictures a second, both ends included");
    for (index, shown) in shown.iter().enumerate() {
        let picture =
            image::open(folder.join(format!("pictures/{:04}.png", index + 1))).unwrap().into_rgba8();
        assert_eq!(shown.dimensions(), picture.dimensions());
        let apart = means_of_four(shown)
            .into_iter()
            .zip(means_of_four(&over_black(&picture)))
            .map(|(shown, picture)| (shown - picture).abs());
        let mean = apart.sum::<f32>() / (3 * 35 * 25) as f32;
        assert!(mean < 3.0, "picture {index}: {mean}");
    }
}

#[test]
fn a_film_says_its_size_its_pace_and_its_colors_before_its_pictures() {
    let folder = stored("3", [71, 49]);
    let folder = folder.path();
    let output = film(folder, &["--fps", "29.97", "--pictures", "5", "--out", "film.mp4"]);
    assert!(output.status.success(), "{}", said(&output));
    let bytes = std::fs::read(folder.join("film.mp4")).unwrap();
    assert_eq!(&bytes[4..12], b"ftypisom");
    let place = |name: &[u8]| bytes.windows(4).position(|four| four == name).unwrap();
    assert!(place(b"moov") < place(b"mdat"), "it plays while it loads");
    let media = numbers(content(&bytes, &[("moov", 0), ("trak", 0), ("mdia", 0), ("mdhd", 0)]));
    assert_eq!(media[3..5], [29_970, 5_000], "ticks a second, and ticks");
    assert_eq!(numbers(table(&bytes, &[("stts", 0)])), [0, 1, 5, 1000]);
    assert_eq!(numbers(table(&bytes, &[("stss", 0)]))[2], 1, "the first picture needs no other");
    let color = table(&bytes, &[&ENTRY[..], &[("colr", 0)]].concat());
    assert_eq!(color, b"nclx\0\x01\0\x0d\0\x01\0", "Rec. 709, the curve of sRGB, television range");
    // A side with an odd number of pixels has its last one twice.
    assert!(decoded(&bytes).iter().all(|picture| picture.dimensions() == (72, 50)));
}

#[test]
fn two_stores_are_compared_by_a_line_that_crosses_once_or_in_turn() {
    let folder = stored("3", [64, 48]);
    let folder = folder.path();
    let settings = ["--set", "pruning.depth_tolerance=8", "--set", "render.kernel=point"];
    let other = [&["preprocess", "scene", "--out", "b.ovl"], &settings[..]].concat();
    succeed(overlook(folder, &other));
    let pictures = |store: &str, more: &[&str], out: &str| {
        let arguments = ["export", "pictures", store, "--path", "path.json", "--set", "render.backend=cpu"];
        succeed(overlook(folder, &[&arguments[..], more, &["--pictures", "13", "--out", out]].concat()));
        let picture =
            |number| image::open(folder.join(format!("{out}/{number:04}.png"))).unwrap().into_rgba8();
        (1..=13).map(picture).collect::<Vec<_>>()
    };
    let [a, b] = [("scene.ovl", "a"), ("b.ovl", "b")].map(|(store, out)| pictures(store, &[], out));
    assert_ne!(a[6], b[6]);
    let compared = |more: &[&str], out: &str| {
        let pictures = pictures("scene.ovl", &[&["--compare", "b.ovl"], more].concat(), out);
        let height = a[0].height();
        assert!(pictures.iter().all(|picture| picture.height() > height), "names stand below");
        let part = |picture: &image::RgbaImage, top: u32, rows: u32| {
            image::imageops::crop_imm(picture, 0, top, 64, rows).to_image()
        };
        let above = pictures.iter().map(|picture| part(picture, 0, height)).collect::<Vec<_>>();
        let below = pictures.iter().map(|picture| part(picture, height, picture.height() - height));
        (above, below.collect::<Vec<_>>())
    };
    let (wiped, names) = compared(&[], "wiped");
    assert!(wiped[0] == a[0] && wiped[12] == b[12], "from one side to the other");
    assert!(
        names[0] != names[6] && names[6] != names[12] && names[0] != names[12],
        "what is shown stands out"
    );
    let (split, row) = (32, 24);
    assert_eq!(wiped[6].get_pixel(split, row).0, [255; 4]);
    assert!((0..split - 2).all(|x| wiped[6].get_pixel(x, row) == a[6].get_pixel(x, row)));
    assert!((split + 2..64).all(|x| wiped[6].get_pixel(x, row) == b[6].get_pixel(x, row)));
    let (flipped, _) = compared(&["--mode", "flip"], "flipped");
    assert!((0..12).all(|nth| flipped[nth] == a[nth]), "half a second at 24 pictures a second");
    assert_eq!(flipped[12], b[12], "then the other side");
    let film = film(folder, &["--compare", "b.ovl", "--mode", "wipe", "--fps", "12", "--out", "film.mp4"]);
    assert!(film.status.success(), "{}", said(&film));
    assert_eq!(decoded(&std::fs::read(folder.join("film.mp4")).unwrap()).len(), 7);

    let short = scene("1", "64x48");
    succeed(overlook(short.path(), &["preprocess", "scene", "--out", "short.ovl"]));
    let short = short.path().join("short.ovl").display().to_string();
    let refused = self::film(folder, &["--frame", "2", "--compare", &short, "--out", "none.mp4"]);
    let words = said(&refused);
    assert!(words.contains("short.ovl: has no frame 2, which scene.ovl shows"), "{words}");
    assert!(words.trim().lines().count() == 1 && !folder.join("none.mp4").exists(), "{words}");
}

#[test]
fn a_gif_shows_the_pictures_of_the_film_for_as_long_and_without_end() {
    let folder = stored("3", [64, 48]);
    let folder = folder.path();
    let written = film(folder, &["--out", "film.gif"]);
    assert!(written.status.success(), "{}", said(&written));
    let bytes = std::fs::read(folder.join("film.gif")).unwrap();
    assert!(bytes.windows(11).any(|window| window == b"NETSCAPE2.0"), "it repeats");
    let frames = GifDecoder::new(Cursor::new(bytes)).unwrap().into_frames().collect_frames().unwrap();
    let pictures = ["export", "pictures", "scene.ovl", "--path", "path.json", "--backend", "cpu"];
    succeed(overlook(folder, &[&pictures[..], &["--out", "pictures"]].concat()));
    let mut shown: Vec<_> =
        std::fs::read_dir(folder.join("pictures")).unwrap().map(|entry| entry.unwrap().path()).collect();
    shown.retain(|path| path.extension().is_some_and(|extension| extension == "png"));
    shown.sort();
    assert_eq!(frames.len(), shown.len());
    let milliseconds = |frame: &Frame| f64::from(frame.delay().numer_denom_ms().0);
    let lasts: f64 = frames.iter().map(milliseconds).sum();
    assert!((lasts - frames.len() as f64 * 1000.0 / 24.0).abs() <= 10.0, "{lasts} ms");
    for (frame, path) in frames.iter().zip(&shown) {
        let (own, expected) = (frame.buffer(), image::open(path).unwrap().to_rgba8());
        assert_eq!(own.dimensions(), expected.dimensions());
        let apart = |(a, b): (&Rgba<u8>, &Rgba<u8>)| {
            (0..3).map(|c| f64::from(a.0[c].abs_diff(b.0[c]))).sum::<f64>() / 3.0
        };
        let mean = own.pixels().zip(expected.pixels()).map(apart).sum::<f64>() / (64.0 * 48.0);
        assert!(mean < 4.0, "{mean} of 255");
    }
    let refused = film(folder, &["--fps", "60", "--out", "quick.gif"]);
    assert!(said(&refused).contains("at most 50 pictures a second") && !folder.join("quick.gif").exists());
}

#[test]
fn a_caption_stands_below_every_picture_and_leaves_it_as_it_is() {
    let folder = stored("3", [160, 48]);
    let folder = folder.path();
    for (out, more) in [("plain.mp4", &[][..]), ("told.mp4", &["--caption", "The orrery"])] {
        let written = film(folder, &[&["--out", out], more].concat());
        assert!(written.status.success(), "{}", said(&written));
    }
    let [plain, told] =
        ["plain.mp4", "told.mp4"].map(|out| decoded(&std::fs::read(folder.join(out)).unwrap()));
    assert!(plain.len() == told.len() && plain.len() > 1);
    for (plain, told) in plain.iter().zip(&told) {
        assert!(told.width() == 160 && told.height() > plain.height() + 8, "{:?}", told.dimensions());
        let above = image::imageops::crop_imm(told, 0, 0, 160, 48).to_image();
        let apart = above.as_raw().iter().zip(plain.as_raw()).map(|(a, b)| f64::from(a.abs_diff(*b)));
        let mean = apart.sum::<f64>() / above.as_raw().len() as f64;
        assert!(mean < 4.0, "{mean} of 255");
        let below = image::imageops::crop_imm(told, 0, 48, 160, told.height() - 48).to_image();
        let [ink, paper] = [below.iter().min(), below.iter().max()].map(|end| *end.unwrap());
        assert!(ink < 96 && paper > 224, "{ink} on {paper}");
    }
    let letter = film(folder, &["--out", "letter.mp4", "--caption", "日"]);
    assert!(said(&letter).contains("'日'") && !folder.join("letter.mp4").exists());
    let around = film(folder, &["--out", "all.mp4", "--caption", "x", "--projection", "equirectangular"]);
    assert!(said(&around).contains("sphere") && !folder.join("all.mp4").exists());
}

#[test]
fn what_cannot_be_a_film_gives_one_line_and_leaves_nothing() {
    let folder = stored("3", [20_000, 2]);
    let folder = folder.path();
    for (out, why) in
        [("film.mp4", "20000×2 pixels"), ("film.webm", "written as MP4"), ("film", "written as MP4")]
    {
        let output = film(folder, &["--out", out]);
        assert_eq!(output.status.code(), Some(1));
        assert!(
            said(&output).contains(why) && said(&output).trim().lines().count() == 1,
            "{}",
            said(&output)
        );
        assert!(!folder.join(out).exists());
    }
}

#[test]
#[cfg(unix)]
fn a_film_that_is_stopped_leaves_nothing_and_an_earlier_one_stays() {
    use rustix::process::{Pid, Signal, kill_process};
    use std::time::{Duration, Instant};

    let folder = stored("3", [64, 48]);
    let folder = folder.path();
    std::fs::write(folder.join("film.mp4"), "earlier").unwrap();
    let films = || {
        let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        names.filter(|name| name.to_string_lossy().ends_with(".mp4")).count()
    };
    let arguments = ["export", "video", "scene.ovl", "--path", "path.json", "--backend", "cpu"];
    let mut command =
        overlook(folder, &[&arguments[..], &["--pictures", "99999", "--out", "film.mp4"]].concat());
    let child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
    let asked = Instant::now();
    while films() < 2 {
        assert!(asked.elapsed() < Duration::from_mins(1), "nothing happens");
        std::thread::sleep(Duration::from_millis(1));
    }
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), said(&output).as_str()), (Some(130), "overlook: cancelled\n"));
    assert_eq!(films(), 1);
    assert_eq!(std::fs::read(folder.join("film.mp4")).unwrap(), b"earlier");
}

#[test]
fn a_film_of_all_directions_tells_players_so() {
    let folder = stored("3", [64, 48]);
    let folder = folder.path();
    let all_around = ["--projection", "equirectangular", "--width", "128", "--pictures", "2"];
    let output = film(folder, &[&all_around[..], &["--out", "film.mp4"]].concat());
    assert!(output.status.success(), "{}", said(&output));
    let bytes = std::fs::read(folder.join("film.mp4")).unwrap();
    assert!(decoded(&bytes).iter().all(|picture| picture.dimensions() == (128, 64)));
    let whole_sphere = table(&bytes, &[&ENTRY[..], &[("sv3d", 0), ("proj", 0), ("equi", 0)]].concat());
    assert_eq!(numbers(whole_sphere), [0; 5]);
    let output = film(folder, &["--width", "128", "--out", "plain.mp4"]);
    assert!(said(&output).contains("only equirectangular pictures") && !folder.join("plain.mp4").exists());
}
