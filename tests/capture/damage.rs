//! Damaged and contradictory captures give one clear line, and nothing panics.

#![expect(clippy::unwrap_used, reason = "a fixture that cannot be made fails the test")]

use crate::captures as common;
use crate::captures::{Folder, PIXELS, entry, flat, picture, plain};
use exr::prelude::{AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, WritableImage};
use overlook_engine::capture::exr::ExrFile;
use overlook_engine::error::{Error, Result};
use overlook_engine::settings::CaptureSettings;
use proptest::prelude::*;
use serde_json::{Value, json};

/// The error of opening a capture of two cameras and two frames that `change` has spoiled, or of decoding it.
fn error_of(change: impl FnOnce(&Folder, &mut Value, &mut Vec<Value>)) -> String {
    let folder = Folder::new();
    let mut entries = Vec::new();
    for (camera, time) in [("left", 0), ("left", 1), ("right", 0), ("right", 1)] {
        let name = format!("{camera}/{time:04}.exr");
        folder.put(&name, &plain(flat(2.0)));
        entries.push(entry(&name, camera, time));
    }
    let mut keys = json!({});
    change(&folder, &mut keys, &mut entries);
    let all_frames = |folder: &Folder| -> Result<()> {
        let capture = folder.open(keys, &entries)?;
        for camera in 0..capture.cameras.len() {
            for frame in 0..capture.frame_count() {
                capture.frame(camera, frame)?;
            }
        }
        Ok(())
    };
    let error = all_frames(&folder).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    error
}

fn assert_names(error: &str, words: &[&str]) {
    for word in words {
        assert!(error.contains(word), "'{word}' is not in: {error}");
    }
}

const RIGHT_1: &[&str] = &["right/0001.exr", "camera 'right'", "frame 1"];

#[test]
fn a_missing_file_is_named_with_its_frame() {
    let error = error_of(|folder, _, _| {
        for camera in ["left", "right"] {
            std::fs::remove_dir_all(folder.path(camera)).unwrap();
        }
    });
    assert_names(&error, &["left/0000.exr", "camera 'left'", "frame 0", "missing"]);
}

#[test]
fn a_frame_that_a_camera_lacks_is_named() {
    let error = error_of(|_, _, entries| drop(entries.pop()));
    assert_names(&error, &["transforms.json", "camera 'right'", "frame 1"]);
}

#[test]
fn a_frame_recorded_twice_is_named() {
    let error = error_of(|_, _, entries| entries[3]["time"] = 0.into());
    assert_names(&error, &["right/0001.exr", "right/0000.exr", "frame 0"]);
}

#[test]
fn a_frame_of_another_size_is_named() {
    let large = |folder: &Folder, _: &mut Value, _: &mut Vec<Value>| {
        let pixels = 3 * PIXELS / 2;
        let image = Image::from_channels(
            (9, 4),
            AnyChannels::sort(
                ["R", "G", "B", "Z"]
                    .map(|name| AnyChannel::new(name, FlatSamples::F32(vec![1.0; pixels])))
                    .into_iter()
                    .collect(),
            ),
        );
        image.write().to_file(folder.path("right/0001.exr")).unwrap();
    };
    let error = error_of(large);
    assert_names(&error, RIGHT_1);
    assert_names(&error, &["9×4", "6×4"]);
}

#[test]
fn a_depth_plane_of_nan_is_named_with_its_channel() {
    let error = error_of(|folder, _, _| folder.put("right/0001.exr", &plain(flat(f32::NAN))));
    assert_names(&error, RIGHT_1);
    assert_names(&error, &["'Z'"]);
}

#[test]
fn a_picture_without_depth_or_color_is_named_with_the_channels_it_has() {
    let rgb = || vec![("R", flat(0.5)), ("G", flat(0.5)), ("B", flat(0.5))];
    let mut trap = rgb();
    trap.push(("Mist.Z", flat(1.0)));
    let error = error_of(|folder, _, _| folder.put("right/0001.exr", &picture(&[("", trap)])));
    assert_names(&error, RIGHT_1);
    assert_names(&error, &["no depth", "Mist.Z", "depth_channel"]);
    let error =
        error_of(|folder, _, _| folder.put("left/0000.exr", &picture(&[("", vec![("Z", flat(1.0))])])));
    assert_names(&error, &["left/0000.exr", "no color"]);
}

#[test]
fn moving_and_zooming_cameras_are_not_supported() {
    let error = error_of(|_, _, entries| entries[3]["transform_matrix"][0][3] = 0.5.into());
    assert_names(&error, RIGHT_1);
    assert_names(&error, &["moved"]);
    let error = error_of(|_, _, entries| entries[3]["fl_x"] = 4.into());
    assert_names(&error, &["right/0001.exr", "zooms"]);
}

#[test]
fn nonsense_in_the_manifest_is_named() {
    let spoil: &[(&str, Value, &str)] = &[
        ("depth_kind", json!("depth"), "planar_z"),
        ("normal_space", json!("tangent"), "camera"),
        ("depth_channel", json!("Q"), "'Q'"),
        ("near_clip", json!(-1.0), "near_clip"),
        ("far_clip", json!(0.0), "far_clip"),
        ("up", json!([0, 0, 0]), "up"),
        ("camera_angle_x", json!("wide"), "\"camera_angle_x\": invalid type"),
        ("distortion_params", json!([0, 0, 0, 0.3]), "undistort"),
        ("k5", json!(0.1), "undistort"),
        ("p3", json!(0.1), "undistort"),
        ("camera_type", json!("PANO"), "undistort"),
        ("camera_model", json!("THIN_PRISM_FISHEYE"), "undistort"),
        ("pixel_center_offset", json!(-40), "pixel_center_offset is -40"),
    ];
    for (key, value, word) in spoil {
        let error = error_of(|_, keys, _| keys[*key] = value.clone());
        assert_names(&error, &[word]);
    }
    assert_names(&error_of(|_, _, entries| entries.clear()), &["transforms.json", "empty"]);
    assert_names(&error_of(|_, _, entries| entries[3]["h"] = json!("64")), &["frames[3]", "\"h\""]);
    let half = |_: &Folder, _: &mut Value, entries: &mut Vec<Value>| {
        entries[0].as_object_mut().unwrap().remove("h");
        entries[0]["w"] = json!(640);
    };
    assert_names(&error_of(half), &["left/0000.exr", "w is 640 but the picture is 6×4"]);
    assert_names(&error_of(|_, _, entries| entries[2]["w"] = json!(1e9)), &["right/0000.exr", "w is"]);
    assert_names(
        &error_of(|_, _, entries| {
            for entry in entries.iter_mut() {
                entry["transform_matrix"][2][2] = 3.into();
            }
        }),
        &["frames[0]", "left/0000.exr", "rotation"],
    );
    assert_names(&error_of(|_, _, entries| drop(entries[1]["camera"].take())), &["camera", "all of them"]);
}

#[test]
fn an_entry_that_says_it_is_not_bent_is_believed() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(2.0)));
    let mut straight = entry("a.exr", "a", 0);
    straight["k1"] = 0.into();
    let keys = json!({"k1": 0.1, "distortion_params": [0, 0.0], "is_fisheye": false, "camera_type": "PERSP"});
    let capture = folder.open(keys, &[straight]).unwrap();
    let lens = capture.cameras[0].intrinsics;
    assert_eq!((lens.size(), lens.fx, lens.fy, lens.cx, lens.cy), (common::SIZE, 3.0, 3.0, 3.0, 2.0));
    let frame = capture.frame(0, 0).unwrap();
    assert_eq!(frame.inverse_depth.as_slice(), [0.5; PIXELS]);
    assert_eq!(frame.color.as_slice(), [[half::f16::from_f32(0.5); 3]; PIXELS]);
    assert_eq!(capture.warnings, Vec::<String>::new());
}

#[test]
fn junk_in_files_of_depth_and_normals_is_found_before_anything_is_decoded() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(2.0)));
    for (key, name) in [
        ("depth_file_path", "junk.exr"),
        ("depth_file_path", "junk.png"),
        ("normal_file_path", "junk.exr"),
        ("normal_file_path", "junk.png"),
    ] {
        folder.put(name, b"junk");
        let mut entry = entry("a.exr", "a", 0);
        entry[key] = name.into();
        assert_names(&folder.open(json!({}), &[entry]).unwrap_err().to_string(), &["frame 0", name]);
    }
    let gray = image::GrayImage::new(6, 4);
    gray.save(folder.path("8bit.png")).unwrap();
    let mut coarse = entry("a.exr", "a", 0);
    coarse["depth_file_path"] = "8bit.png".into();
    assert_names(&folder.open(json!({}), &[coarse.clone()]).unwrap_err().to_string(), &["16-bit"]);
    image::ImageBuffer::from_pixel(6, 4, image::Luma([9_u16])).save(folder.path("8bit.png")).unwrap();
    let error = folder.open(json!({"depth_kind": "position"}), &[coarse]).unwrap_err().to_string();
    assert_names(&error, &["8bit.png", "three channels"]);
}

#[test]
fn a_png_wider_than_any_picture_is_too_large_and_not_damaged() {
    let error = error_of(|folder, _, entries| {
        image::GrayImage::new(32_769, 1).save(folder.path("left/wide.png")).unwrap();
        entries[0]["file_path"] = "left/wide.png".into();
        entries[0]["depth_file_path"] = "left/0001.exr".into();
    });
    assert_names(&error, &["left/wide.png", "too large", "32768"]);
}

#[test]
fn depth_behind_the_camera_is_told_from_depth_that_is_not_there() {
    let error = error_of(|folder, _, _| folder.put("right/0001.exr", &plain(flat(-2.0))));
    assert_names(&error, RIGHT_1);
    assert_names(&error, &["'Z'", "negative"]);
}

#[test]
fn positions_off_the_rays_of_their_pixels_are_refused() {
    // The camera looks along +y: a wall in front of it, in its own space, and shifted by a meter.
    let wall = |shift: f32, in_world: bool| {
        let at = |i: usize| ((i % 6) as f32 + 0.5, (i / 6) as f32 + 0.5);
        let of = |pick: &dyn Fn(f32, f32) -> f32| {
            FlatSamples::F32((0..PIXELS).map(|i| pick(at(i).0, at(i).1)).collect())
        };
        let x = of(&|x, _| 4.0 * (x - 3.0) / 3.0 + shift);
        let up = of(&|_, y| 4.0 * (2.0 - y) / 3.0);
        let [y, z] = if in_world { [flat(4.0), up] } else { [up, flat(-4.0)] };
        let channels =
            [("R", flat(0.5)), ("G", flat(0.5)), ("B", flat(0.5)), ("P.X", x), ("P.Y", y), ("P.Z", z)];
        picture(&[("", channels.to_vec())])
    };
    let folder = Folder::new();
    let read = |bytes: &[u8]| {
        folder.put("a.exr", bytes);
        folder.open(json!({}), &[entry("a.exr", "a", 0)])?.frame(0, 0)
    };
    // A shift along the wall leaves each pixel's depth what it is.
    for shift in [0.0, 1.0] {
        let frame = read(&wall(shift, true)).unwrap();
        assert!(frame.inverse_depth.as_slice().iter().all(|w| (w - 0.25).abs() < 1e-6), "shift {shift}");
    }
    assert_names(
        &read(&wall(4.0, true)).unwrap_err().to_string(),
        &["a.exr", "rays of camera 'a'", "median 3 px"],
    );
    assert_names(
        &read(&wall(0.0, false)).unwrap_err().to_string(),
        &["a.exr", "rays of camera 'a'", "behind"],
    );
}

#[test]
fn a_large_picture_of_one_color_is_read_however_small_its_dwa_file() {
    let encoding = Encoding { compression: Compression::DWAA(None), ..Encoding::UNCOMPRESSED };
    // Of few rows, as each block of them takes some bytes.
    let (width, height) = (16_384, 256);
    let zeros = || FlatSamples::F16(vec![half::f16::ZERO; width * height]);
    let channels = ["R", "G", "B"].map(|name| AnyChannel::new(name, zeros()));
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = Image::from_encoded_channels((width, height), encoding, channels);
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    let bytes = bytes.into_inner();
    // More pixels a byte than any other compression makes of them.
    assert!(bytes.len() * 1100 < width * height, "{} bytes", bytes.len());
    let file = ExrFile::from_bytes(bytes, PLACE).unwrap();
    let window = file.window(None).unwrap();
    assert_eq!((window.width, window.height), (width, height));
    let planes = file.decode(&[0, 1, 2], window).unwrap();
    assert_eq!(planes.len(), 3);
    for plane in planes {
        let values = plane.into_single();
        assert!(values.len() == width * height && values.iter().all(|value| *value == 0.0));
    }
}

#[test]
fn a_folder_without_a_manifest_says_what_a_capture_is() {
    let folder = Folder::new();
    let error = overlook_engine::capture::transforms::open(&folder.path(""), &CaptureSettings::default());
    assert_names(&error.err().unwrap().to_string(), &["transforms.json", "a capture is"]);
}

#[test]
fn a_picture_of_another_type_is_refused_with_what_to_do() {
    let error = error_of(|folder, _, entries| {
        folder.put("right/0001.webp", b"");
        entries[3]["file_path"] = "right/0001.webp".into();
    });
    assert_names(&error, &["right/0001.webp", "EXR, PNG, TIFF or JPEG"]);
}

const PLACE: &str = "cam0/0003.exr (camera 'cam0', frame 3)";

/// Decodes every channel of a file, as far as it lets us.
fn decode(bytes: &[u8]) -> Result<()> {
    let file = ExrFile::from_bytes(bytes.to_vec(), PLACE)?;
    let window = file.window(Some(common::SIZE))?;
    let all: Vec<usize> = (0..file.channels().len()).collect();
    file.decode(&all, window).map(drop)
}

fn assert_clear(error: &Error) {
    let text = error.to_string();
    assert_names(&text, &["cam0/0003.exr", "frame 3"]);
    assert!(!text.contains('\n') && text.len() < 400, "{text}");
}

fn ramp() -> Vec<u8> {
    plain(FlatSamples::F32((0..PIXELS).map(|i| 1.0 + (i as f32).sin()).collect()))
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    let bytes = ramp();
    decode(&bytes).unwrap();
    for length in 0..bytes.len() {
        assert_clear(&decode(&bytes[..length]).unwrap_err());
    }
}

#[test]
fn an_absurd_header_is_refused_before_anything_is_allocated_for_it() {
    let bytes = ramp();
    let find = |name: &[u8]| bytes.windows(name.len()).position(|window| window == name).unwrap();
    let claim = |attribute: &str, side: i32| {
        let mut absurd = bytes.clone();
        let x_max = find(attribute.as_bytes()) + attribute.len() + 4 + 8;
        absurd[x_max..x_max + 4].copy_from_slice(&side.to_le_bytes());
        absurd[x_max + 4..x_max + 8].copy_from_slice(&side.to_le_bytes());
        absurd
    };
    for side in [100_000, 1 << 30, i32::MAX] {
        assert_clear(&decode(&claim("dataWindow\0box2i\0", side)).unwrap_err());
        let display = claim("displayWindow\0box2i\0", side);
        let size = ExrFile::from_bytes(display, PLACE).and_then(|file| file.window(None));
        assert_clear(&size.unwrap_err());
    }
}

#[test]
fn compressions_that_cannot_be_read_say_so() {
    let bytes = ramp();
    let key = b"compression\0compression\0";
    let at = bytes.windows(key.len()).position(|window| window == key).unwrap() + key.len() + 4;
    for compression in 10..14 {
        let mut newer = bytes.clone();
        newer[at] = compression;
        let error = decode(&newer).unwrap_err();
        assert_clear(&error);
        assert_names(&error.to_string(), &["ZIP"]);
    }
}

/// A smooth picture that every compression makes smaller, so that none of it is stored raw.
fn smooth(compression: Compression) -> Vec<u8> {
    let ramp = |scale: f32| (0..64 * 48).map(|i| scale * (1.0 + (i / 64) as f32)).collect::<Vec<_>>();
    let half = |scale: f32| FlatSamples::F16(ramp(scale).into_iter().map(half::f16::from_f32).collect());
    let channels = [("R", half(0.1)), ("G", half(0.2)), ("B", half(0.3)), ("Z", FlatSamples::F32(ramp(1.0)))]
        .map(|(name, samples)| AnyChannel::new(name, samples));
    let encoding = Encoding { compression, ..Encoding::UNCOMPRESSED };
    let image =
        Image::from_encoded_channels((64, 48), encoding, AnyChannels::sort(channels.into_iter().collect()));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

const COMPRESSIONS: [Compression; 8] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::DWAA(None),
];

fn decode_smooth(bytes: &[u8]) -> Result<()> {
    let file = ExrFile::from_bytes(bytes.to_vec(), PLACE)?;
    let window = file.window(Some((64, 48)))?;
    let all: Vec<usize> = (0..file.channels().len()).collect();
    file.decode(&all, window).map(drop)
}

#[test]
fn a_block_that_claims_absurd_sizes_is_refused_before_they_are_allocated() {
    let bytes = smooth(Compression::DWAA(None));
    decode_smooth(&bytes).unwrap();
    // Two blocks of 32 rows: the offset table of two entries points right behind itself, at the first block's
    // position and length (4 bytes each), which its sizes follow (8 bytes each, after a version).
    let table = (0..bytes.len() - 8).find(|&at| bytes[at..at + 8] == (at as u64 + 16).to_le_bytes()).unwrap();
    let at = table + 16 + 8;
    for size in 1..10 {
        let mut absurd = bytes.clone();
        absurd[at + 8 * size..][..8].copy_from_slice(&(1_u64 << 60).to_le_bytes());
        let error = decode_smooth(&absurd).unwrap_err();
        assert_clear(&error);
        assert_names(&error.to_string(), &["DWA block"]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bits_are_an_error_or_another_picture(flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u8), 1..6)) {
        let mut bytes = ramp();
        for (index, bit) in flips {
            let at = index.index(bytes.len());
            bytes[at] ^= 1 << bit;
        }
        if let Err(error) = decode(&bytes) {
            assert_clear(&error);
        }
    }

    #[test]
    fn no_compression_panics_or_aborts_on_flipped_bits(
        compression in prop::sample::select(&COMPRESSIONS[..]),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0..8_u8), 1..4),
    ) {
        let mut bytes = smooth(compression);
        for (index, bit) in flips {
            let at = index.index(bytes.len());
            bytes[at] ^= 1 << bit;
        }
        if let Err(error) = decode_smooth(&bytes) {
            assert_clear(&error);
        }
    }
}
