//! Whatever a manifest leaves open is read as it is meant, or one line says what to write.

use crate::captures::{Folder, PIXELS, SIZE, entry, flat, picture, plain};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, WritableImage,
};
use image::{ImageBuffer, Luma, Rgba};
use overlook_engine::capture::{Capture, transforms};
use overlook_engine::error::Result;
use serde_json::{Value, json};

/// Positions on a wall that faces the camera of [`entry`].
fn wall_at(depth: f32) -> [FlatSamples; 3] {
    let of = |pick: fn(f32, f32) -> f32| {
        let at = |i: usize| pick((i % SIZE.0) as f32 + 0.5, (i / SIZE.0) as f32 + 0.5);
        FlatSamples::F32((0..PIXELS).map(|i| depth * at(i)).collect())
    };
    [of(|x, _| (x - 3.0) / 3.0), of(|_, _| 1.0), of(|_, y| (2.0 - y) / 3.0)]
}

fn refusal(result: Result<Capture>) -> String {
    let refused = result.map(drop).unwrap_err().to_string();
    assert!(!refused.contains('\n'), "{refused}");
    refused
}

/// Without what says which frame it is.
fn timeless(file_path: &str, camera: &str) -> Value {
    let mut entry = entry(file_path, camera, 0);
    entry.as_object_mut().unwrap().remove("time");
    entry
}

/// A capture of one picture of this depth, with positions on a wall two units away.
fn beside_positions(depth: FlatSamples, keys: Value) -> (Vec<String>, f32) {
    let folder = Folder::new();
    let mut channels = vec![("R", flat(0.5)), ("G", flat(0.5)), ("B", flat(0.5)), ("Z", depth)];
    channels.extend(["P.X", "P.Y", "P.Z"].into_iter().zip(wall_at(2.0)));
    for file in ["0.exr", "1.exr"] {
        folder.put(file, &picture(&[("", channels.clone())]));
    }
    let capture = folder.open(keys, &[entry("0.exr", "a", 0), entry("1.exr", "a", 1)]).unwrap();
    (capture.warnings.clone(), capture.frame(0, 1).unwrap().inverse_depth[(0, 0)])
}

#[test]
fn positions_win_over_depth_that_contradicts_them_unless_the_manifest_says_what_depth_is() {
    for contradicting in [flat(200.0), flat(0.25), flat(2.2)] {
        let (warnings, inverse) = beside_positions(contradicting.clone(), json!({}));
        assert_eq!(inverse, 0.5);
        assert!(warnings.len() == 1 && warnings[0].contains("depth_kind"), "{warnings:?}");
        for keys in [json!({"depth_kind": "planar_z"}), json!({"depth_channel": "Z"})] {
            let (warnings, inverse) = beside_positions(contradicting.clone(), keys);
            assert!(warnings.is_empty() && inverse != 0.5, "{warnings:?}");
        }
    }
}

#[test]
fn depth_stays_where_positions_agree_or_are_not_understood() {
    let (warnings, inverse) = beside_positions(flat(2.001), json!({}));
    assert!(warnings.is_empty() && inverse == 1.0 / 2.001, "{warnings:?} {inverse}");
    let (warnings, inverse) = beside_positions(flat(200.0), json!({"depth_unit_scale_factor": 0.01}));
    assert!(warnings.is_empty() && inverse == 0.5, "positions in another unit: {warnings:?} {inverse}");
}

#[test]
fn pixels_that_are_not_square_make_two_focal_lengths_of_one() {
    let write = |pixel_aspect: f32| {
        let names = ["R", "G", "B", "Z"];
        let list = names.into_iter().map(|name| AnyChannel::new(name, flat(0.5))).collect();
        let channels = AnyChannels::sort(list);
        let layer = Layer::new(SIZE, LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
        let mut attributes = ImageAttributes::new(IntegerBounds::from_dimensions(SIZE));
        attributes.pixel_aspect = pixel_aspect;
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = Image::empty(attributes).with_layer(layer);
        image.write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    };
    let folder = Folder::new();
    folder.put("a.exr", &write(2.0));
    let lens = |change: &dyn Fn(&mut Value)| {
        let mut entry = entry("a.exr", "a", 0);
        entry.as_object_mut().unwrap().remove("fl_x");
        change(&mut entry);
        let capture = folder
            .open(
                json!({}),
                &[entry.clone(), {
                    entry["time"] = 1.into();
                    entry
                }],
            )
            .unwrap();
        (capture.cameras[0].intrinsics.fx, capture.cameras[0].intrinsics.fy)
    };
    assert_eq!(lens(&|entry| entry["fl_x"] = 3.into()), (3.0, 6.0));
    assert_eq!(lens(&|entry| entry["fl_y"] = 3.into()), (1.5, 3.0));
    let (fx, fy) = lens(&|entry| entry["camera_angle_x"] = json!(std::f64::consts::FRAC_PI_2));
    assert!((fx - 3.0).abs() < 1e-12 && fy == 2.0 * fx, "{fx} {fy}");
    assert_eq!(lens(&|entry| (entry["fl_x"], entry["fl_y"]) = (3.into(), 4.into())), (3.0, 4.0));
}

#[test]
fn a_frame_beside_a_fractional_time_is_the_number_of_its_picture_and_of_its_view() {
    let folder = Folder::new();
    let mut entries = Vec::new();
    for frame in 1..=3 {
        folder.put(&format!("{frame}.exr"), &plain(flat(frame as f32)));
        let mut entry = entry(&format!("{frame}.exr"), "a", 0);
        (entry["time"], entry["frame"]) = (json!(f64::from(frame) / 2.0), frame.into());
        entries.push(entry);
    }
    let capture = folder.open(json!({}), &entries).unwrap();
    assert_eq!(capture.frame_numbers, [1, 2, 3]);
    assert!(capture.warnings.is_empty() && !capture.frames_are_ranked(), "{:?}", capture.warnings);
    let views = transforms::open_views_of(&folder.path("transforms.json"), true).unwrap();
    assert_eq!(views.iter().map(|view| view.frame_number).collect::<Vec<_>>(), [1, 2, 3]);
    entries[0].as_object_mut().unwrap().remove("frame");
    let refused = refusal(folder.open(json!({}), &entries));
    assert!(refused.contains("\"frame\" in all of them"), "{refused}");
}

#[test]
fn negative_depth_is_refused_whatever_stands_for_nothing_hit() {
    for background in [0.0, 1e10, f32::NAN, f32::INFINITY] {
        let folder = Folder::new();
        let mut depth = vec![-2.0; PIXELS];
        depth[..PIXELS / 2].fill(background);
        folder.put("a.exr", &plain(FlatSamples::F32(depth)));
        let refused = refusal(folder.open(json!({}), &[entry("a.exr", "a", 0)]));
        assert!(refused.contains("negative"), "{refused}");
    }
    let folder = Folder::new();
    let mut depth = vec![2.0; PIXELS];
    depth[..PIXELS / 2].fill(-1.0);
    folder.put("a.exr", &plain(FlatSamples::F32(depth)));
    let capture = folder.open(json!({}), &[entry("a.exr", "a", 0)]).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().invalid_pixels(), PIXELS / 2);
}

#[test]
fn depth_in_whole_numbers_may_be_in_any_unit() {
    let folder = Folder::new();
    let mut depth = vec![2_000_000_000; PIXELS];
    depth[0] = u32::MAX;
    folder.put("a.exr", &plain(FlatSamples::U32(depth)));
    let capture = folder.open(json!({"depth_unit_scale_factor": 1e-9}), &[entry("a.exr", "a", 0)]).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    assert_eq!((frame.inverse_depth[(0, 0)], frame.inverse_depth[(1, 0)]), (0.0, 0.5));
}

#[test]
fn instant_ngps_words_for_depth_are_known_and_its_other_lenses_are_refused() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(7.0)));
    let depth: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(6, 4, Luma([20_000]));
    depth.save(folder.path("d.png")).unwrap();
    let mut ingp = entry("a.exr", "a", 0);
    ingp["depth_path"] = "d.png".into();
    let capture = folder.open(json!({"integer_depth_scale": 1e-4}), &[ingp.clone()]).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.5);
    let places = transforms::picture_places(&folder.path("transforms.json")).unwrap();
    assert!(places.contains(&folder.path("d.png")));
    ingp["integer_depth_scale"] = 2e-4.into();
    let capture = folder.open(json!({"depth_unit_scale_factor": 1e-4}), &[ingp.clone()]).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.25);
    for (key, value) in
        [("latlong", json!(true)), ("equirectangular", json!(true)), ("ftheta_p1", json!(0.001))]
    {
        let mut keys = json!({});
        keys[key] = value;
        let refused = refusal(folder.open(keys.clone(), &[entry("a.exr", "a", 0)]));
        assert!(refused.contains("undistort the pictures first"), "{refused}");
        keys[key] = json!(0);
        assert!(folder.open(keys, &[entry("a.exr", "a", 0)]).is_ok(), "{key}");
    }
}

#[test]
fn pictures_without_times_belong_together_by_the_numbers_in_their_names() {
    let folder = Folder::new();
    for (camera, depth) in [("a", 1.0), ("b", 10.0)] {
        for number in 8..=10 {
            folder.put(&format!("{camera}/{number}.exr"), &plain(flat(depth * number as f32)));
        }
    }
    let open = |a: &[&str], b: &[&str]| {
        let of = |camera: &str, names: &[&str]| -> Vec<Value> {
            names.iter().map(|name| timeless(&format!("{camera}/{name}.exr"), camera)).collect()
        };
        folder.open(json!({}), &[of("a", a), of("b", b)].concat())
    };
    let capture = open(&["10", "8", "9"], &["8", "9", "10"]).unwrap();
    assert_eq!(capture.frame_numbers, [0, 1, 2]);
    for frame in 0..3 {
        let inverse = |camera| capture.frame(camera, frame).unwrap().inverse_depth[(0, 0)];
        assert_eq!(inverse(0), 1.0 / (8 + frame) as f32);
        assert_eq!(inverse(1), 1.0 / (80 + 10 * frame) as f32);
    }
    let refused = refusal(open(&["8", "10"], &["8", "9"]));
    assert!(refused.contains("'a'") && refused.contains('9') && refused.contains("\"frame\""), "{refused}");
    let apart = open(&["8", "9"], &["10"]).map(drop).unwrap_err().to_string();
    assert!(apart.contains("camera 'b' has no frame 1"), "{apart}");
    assert_eq!(open(&["8"], &["10"]).unwrap().frame_count(), 1);
}

#[test]
fn a_camera_without_a_frame_is_told_why_it_lacks_it() {
    let folder = Folder::new();
    let mut moving: Vec<Value> = (0..3).map(|at| timeless(&format!("{at}x.exr"), "a")).collect();
    for (at, entry) in moving.iter_mut().enumerate() {
        entry.as_object_mut().unwrap().remove("camera");
        entry["transform_matrix"][0][3] = json!(at.min(1));
    }
    let refused = refusal(folder.open(json!({}), &moving));
    assert!(refused.contains("each of 2 poses became one") && refused.contains("\"camera\""), "{refused}");
    let mut jittered = Vec::new();
    for (camera, late) in [("a", 0.0), ("b", 1e-9)] {
        for time in [0.0, 0.5] {
            let mut entry = entry("a.exr", camera, 0);
            entry["time"] = json!(time + late);
            jittered.push(entry);
        }
    }
    let refused = refusal(folder.open(json!({}), &jittered));
    assert!(refused.contains("no frame of time 0.000000001") && refused.contains("\"frame\""), "{refused}");
}

#[test]
fn a_view_without_a_size_or_a_picture_is_told_to_give_one() {
    let folder = Folder::new();
    let mut view = entry("a.exr", "a", 0);
    view.as_object_mut().unwrap().remove("w");
    view.as_object_mut().unwrap().remove("h");
    folder.put("views.json", json!({"frames": [view]}).to_string().as_bytes());
    let refused = transforms::open_views(&folder.path("views.json")).map(drop).unwrap_err().to_string();
    assert!(refused.contains("give w and h"), "{refused}");
}

#[test]
fn a_picture_in_place_of_a_manifest_is_told_to_be_one() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(2.0)));
    let settings = overlook_engine::settings::CaptureSettings::default();
    let refused = refusal(transforms::open(&folder.path("a.exr"), &settings));
    assert!(refused.contains("is a picture") && refused.contains("transforms.json"), "{refused}");
}

#[test]
fn a_name_without_extension_means_the_picture_and_not_its_depth() {
    let folder = Folder::new();
    let gray: ImageBuffer<Rgba<u8>, Vec<u8>> = ImageBuffer::from_pixel(6, 4, Rgba([188, 188, 188, 255]));
    gray.save(folder.path("a.png")).unwrap();
    folder.put("a.exr", &picture(&[("", vec![("V", flat(2.0))])]));
    let mut apart = entry("a", "a", 0);
    apart["depth_file_path"] = "a.exr".into();
    assert_eq!(folder.open(json!({}), &[apart]).unwrap().frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.5);
    folder.put("b.EXR", &plain(flat(4.0)));
    let mut both = entry("b", "a", 0);
    let capture = folder.open(json!({}), &[both.clone()]).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.25);
    both["depth_file_path"] = "b.EXR".into();
    assert!(folder.open(json!({}), &[both]).is_ok(), "where there is no other file it is this one");
}
