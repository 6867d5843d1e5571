//! Whatever program wrote it, a capture reads as what was seen.

use crate::captures::{Folder, PIXELS, SIZE, entry, flat, picture, plain};
use exr::prelude::FlatSamples;
use glam::{DVec2, DVec3};
use half::f16;
use image::{ImageBuffer, Luma, Rgba};
use overlook_engine::capture::transforms;
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::settings::Settings;
use serde_json::json;

/// Blender's passes in full names, with those that only end as depth and normal do.
fn blender_channels() -> Vec<(&'static str, FlatSamples)> {
    let ramp = |scale: f32| FlatSamples::F32((0..PIXELS).map(|i| scale * (i + 1) as f32).collect());
    vec![
        ("ViewLayer.Combined.R", FlatSamples::F16((0..PIXELS).map(|i| f16::from_f32(i as f32)).collect())),
        ("ViewLayer.Combined.G", FlatSamples::F16(vec![f16::from_f32(0.25); PIXELS])),
        ("ViewLayer.Combined.B", FlatSamples::F16(vec![f16::from_f32(0.5); PIXELS])),
        ("ViewLayer.Combined.A", FlatSamples::F16(vec![f16::ONE; PIXELS])),
        ("ViewLayer.Depth.Z", ramp(0.5)),
        ("ViewLayer.Denoising Depth.Z", ramp(7.0)),
        ("ViewLayer.Mist.Z", flat(0.9)),
        ("ViewLayer.Normal.X", flat(0.0)),
        ("ViewLayer.Normal.Y", flat(-0.5)),
        ("ViewLayer.Normal.Z", flat(0.0)),
        ("ViewLayer.Position.X", wall_at(4.0)[0].clone()),
        ("ViewLayer.Position.Y", wall_at(4.0)[1].clone()),
        ("ViewLayer.Position.Z", wall_at(4.0)[2].clone()),
    ]
}

/// Positions on a wall that faces the camera of [`entry`].
fn wall_at(depth: f32) -> [FlatSamples; 3] {
    let of = |pick: fn(f32, f32) -> f32| {
        let at = |i: usize| pick((i % SIZE.0) as f32 + 0.5, (i / SIZE.0) as f32 + 0.5);
        FlatSamples::F32((0..PIXELS).map(|i| depth * at(i)).collect())
    };
    [of(|x, _| (x - 3.0) / 3.0), of(|_, _| 1.0), of(|_, y| (2.0 - y) / 3.0)]
}

const RGB: [&str; 3] = ["R", "G", "B"];

/// A gray picture with further channels.
fn gray_with<'a>(more: impl IntoIterator<Item = (&'a str, FlatSamples)>) -> Vec<(&'a str, FlatSamples)> {
    RGB.map(|name| (name, flat(0.5))).into_iter().chain(more).collect()
}

#[test]
fn blenders_one_part_and_its_part_for_every_pass_are_the_same_frame() {
    let folder = Folder::new();
    let channels = blender_channels();
    folder.put("one.exr", &picture(&[("", channels.clone())]));
    let pass = |name: &str| -> Vec<(&str, FlatSamples)> {
        let prefix = format!("{name}.");
        channels.iter().filter(|(channel, _)| channel.starts_with(&prefix)).cloned().collect()
    };
    let passes: Vec<_> = ["Normal", "Denoising Depth", "Mist", "Depth", "Position", "Combined"]
        .iter()
        .map(|name| format!("ViewLayer.{name}"))
        .collect();
    let parts: Vec<_> = passes.iter().map(|name| (name.as_str(), pass(name))).collect();
    folder.put("many.exr", &picture(&parts));
    // The same again with short names inside the parts, as other writers have them.
    let short: Vec<(&str, Vec<(&str, FlatSamples)>)> = parts
        .iter()
        .map(|(part, channels)| {
            let last = |name: &'static str| name.rsplit('.').next().unwrap();
            (*part, channels.iter().map(|(name, samples)| (last(name), samples.clone())).collect())
        })
        .collect();
    folder.put("short.exr", &picture(&short));
    let entries = [entry("one.exr", "a", 0), entry("many.exr", "b", 0), entry("short.exr", "c", 0)];
    let capture = folder.open(json!({"depth_kind": "planar_z"}), &entries).unwrap();
    assert!(capture.has_normals);
    let frame = capture.frame(0, 0).unwrap();
    assert_eq!(frame, capture.frame(1, 0).unwrap());
    assert_eq!(frame, capture.frame(2, 0).unwrap());
    assert_eq!(frame.inverse_depth[(1, 0)], 1.0);
    assert_eq!(frame.color[(2, 0)].map(f16::to_f32), [2.0, 0.25, 0.5]);
    assert_eq!(frame.normal_in_world.as_ref().unwrap()[(0, 0)], [0.0, -1.0, 0.0]);
    assert_eq!(frame.depth_step_relative, 0.0);
}

#[test]
fn a_position_pass_gives_planar_depth_whatever_the_depth_channel_says() {
    let folder = Folder::new();
    folder.put("a.exr", &picture(&[("", blender_channels())]));
    let capture = folder.open(json!({"depth_kind": "position"}), &[entry("a.exr", "a", 0)]).unwrap();
    // The camera looks along +y.
    assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.25);
}

#[test]
fn mitsubas_distance_along_the_ray_becomes_planar() {
    let folder = Folder::new();
    let near = 0.5;
    let intrinsics = overlook_engine::capture::Intrinsics::centered(6, 4, 3.0);
    let mut distance: Vec<f32> = (0..PIXELS)
        .map(|i| DVec2::new((i % SIZE.0) as f64 + 0.5, (i / SIZE.0) as f64 + 0.5))
        .map(|pixel| ((2.0 - near) * intrinsics.ray_in_camera(pixel).length()) as f32)
        .collect();
    distance[0] = 0.0;
    let mut channels = vec![("R", flat(0.1)), ("G", flat(0.2)), ("B", flat(0.3))];
    channels.push(("dd.T", FlatSamples::F32(distance)));
    channels.extend([("nn.X", flat(0.0)), ("nn.Y", flat(1.0)), ("nn.Z", flat(0.0))]);
    folder.put("a.exr", &picture(&[("", channels)]));
    let unknown = folder.open(json!({}), &[entry("a.exr", "a", 0)]).unwrap();
    assert!(unknown.warnings[0].contains("near_clip"));
    let capture = folder.open(json!({"near_clip": near}), &[entry("a.exr", "a", 0)]).unwrap();
    assert!(capture.warnings.is_empty());
    let frame = capture.frame(0, 0).unwrap();
    assert_eq!(frame.inverse_depth[(0, 0)], 0.0);
    assert!(frame.inverse_depth.as_slice()[1..].iter().all(|inverse| (inverse - 0.5).abs() < 1e-6));
    // A normal that leans away from the viewer is that of the surface's other side.
    assert_eq!(frame.normal_in_world.as_ref().unwrap()[(3, 1)], [0.0, -1.0, 0.0]);
}

#[test]
fn a_plain_nerfstudio_file_has_a_camera_for_every_pose() {
    let folder = Folder::new();
    let gray: ImageBuffer<Rgba<u8>, Vec<u8>> = ImageBuffer::from_pixel(6, 4, Rgba([188, 0, 255, 255]));
    let mut depth: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(6, 4, Luma([2000]));
    depth.put_pixel(1, 0, Luma([0]));
    for index in 0..2 {
        gray.save(folder.path(&format!("{index}.png"))).unwrap();
        depth.save(folder.path(&format!("depth{index}.png"))).unwrap();
    }
    let entries = [0, 1].map(|index| {
        json!({
            "file_path": format!("./{index}.png"), "depth_file_path": format!("depth{index}.png"),
            "transform_matrix": [[1, 0, 0, index], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
        })
    });
    let keys = json!({
        "camera_angle_x": std::f64::consts::FRAC_PI_2, "aabb_scale": 16, "k1": 0, "camera_model": "OPENCV",
        "applied_transform": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]], "ply_file_path": "sparse.ply",
    });
    let capture = folder.open(keys, &entries).unwrap();
    assert_eq!((capture.cameras.len(), capture.frame_count()), (2, 1));
    assert_eq!((capture.up_in_world, capture.has_normals), (DVec3::Z, false));
    let camera = &capture.cameras[1];
    assert!((camera.intrinsics.fx - 3.0).abs() < 1e-12);
    assert_eq!((camera.intrinsics.size(), camera.forward_in_world()), (SIZE, DVec3::NEG_Z));
    let frame = capture.frame(1, 0).unwrap();
    assert_eq!((frame.inverse_depth[(0, 0)], frame.invalid_pixels()), (0.5, 1));
    assert!((frame.color[(0, 0)][0].to_f32() - 0.5029).abs() < 1e-3, "sRGB is decoded");
    assert_eq!(frame.color[(0, 0)][2].to_f32(), 1.0);
    assert!((frame.depth_step_relative - 0.00025).abs() < 1e-8, "half a millimeter at two meters");
}

#[test]
fn depth_and_normals_may_lie_in_files_of_their_own() {
    let folder = Folder::new();
    folder.put("color.exr", &picture(&[("", vec![("R", flat(0.5)), ("G", flat(0.5)), ("B", flat(0.5))])]));
    folder
        .put("depth.exr", &picture(&[("", vec![("V", FlatSamples::F16(vec![f16::from_f32(4.0); PIXELS]))])]));
    let normal = vec![("X", flat(0.0)), ("Y", flat(0.0)), ("Z", flat(1.0))];
    folder.put("normal.exr", &picture(&[("Normal", normal), ("Other", vec![("Y", flat(0.0))])]));
    let mut with_files = entry("color.exr", "a", 0);
    with_files["depth_file_path"] = "depth.exr".into();
    with_files["normal_file_path"] = "normal.exr".into();
    let capture = folder.open(json!({"normal_space": "camera"}), &[with_files]).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    assert_eq!(frame.inverse_depth[(0, 0)], 0.25);
    assert_eq!(frame.depth_step_relative, 1.0 / 2048.0);
    assert_eq!(frame.normal_in_world.as_ref().unwrap()[(2, 2)], [0.0, -1.0, 0.0]);
}

#[test]
fn given_keys_decide_what_names_leave_open() {
    let folder = Folder::new();
    folder.put("a.exr", &picture(&[("", blender_channels())]));
    let keys = json!({
        "depth_channel": "ViewLayer.Mist.Z", "depth_unit_scale_factor": 10.0, "normal_space": null,
        "up": [0, 2, 0], "antialiased_color": false, "color_space": "ACEScg",
    });
    let capture = folder.open(keys, &[entry("a.exr", "a", 0)]).unwrap();
    assert!((capture.frame(0, 0).unwrap().inverse_depth[(0, 0)] - 1.0 / 9.0).abs() < 1e-7);
    assert_eq!((capture.has_normals, capture.antialiased_color), (false, false));
    assert_eq!(capture.up_in_world, DVec3::Y);
    assert!(capture.warnings[0].contains("ACEScg"));
    let mut alone = entry("a.exr", "a", 0);
    alone["color_space"] = "ACEScg".into();
    alone["antialiased_color"] = false.into();
    alone["up"] = json!([0, 1, 0]);
    let capture =
        folder.open(json!({"color_space": "linear", "depth_kind": "planar_z"}), &[alone.clone()]).unwrap();
    assert_eq!((capture.up_in_world, capture.antialiased_color), (DVec3::Y, false));
    assert!(capture.warnings[0].contains("ACEScg"));
    let refused = folder.open(json!({}), &[alone, entry("a.exr", "b", 0)]).unwrap_err().to_string();
    assert!(refused.contains("\"up\" differs"), "{refused}");
}

#[test]
fn a_frame_that_alone_says_it_has_no_normals_gets_estimated_ones() {
    let folder = Folder::new();
    folder.put("a.exr", &picture(&[("", blender_channels())]));
    let mut without = entry("a.exr", "a", 2);
    without["normal_space"] = serde_json::Value::Null;
    let entries = [entry("a.exr", "a", 0), entry("a.exr", "a", 1), without];
    let capture = folder.open(json!({}), &entries).unwrap();
    let normals = |frame: usize| capture.frame(0, frame).unwrap().normal_in_world.clone().unwrap();
    assert!(normals(0).as_slice().iter().any(|normal| *normal != [0.0; 3]));
    assert!(normals(2).as_slice().iter().all(|normal| *normal == [0.0; 3]));
    let done = preprocess(&capture, &Settings::default(), &Job::new()).unwrap();
    assert!(done.samples.images.iter().any(|image| !image.is_empty()));
}

#[test]
fn a_camera_into_whose_view_nothing_has_come_yet_has_a_frame_without_samples() {
    let folder = Folder::new();
    let channel = |name| (name, flat(0.0));
    let layer =
        |depth: f32| vec![("A", flat(0.0)), channel("B"), channel("G"), channel("R"), ("Z", flat(depth))];
    folder.put("empty.exr", &picture(&[("", layer(1e10))]));
    folder.put("later.exr", &plain(flat(2.0)));
    let entries = [entry("empty.exr", "a", 0), entry("later.exr", "a", 1)];
    let capture = folder.open(json!({}), &entries).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().invalid_pixels(), PIXELS);
    let done = preprocess(&capture, &Settings::default(), &Job::new()).unwrap();
    let mut images = done.samples.images.iter();
    assert!(images.clone().any(|image| image.span.contains(1) && !image.is_empty()));
    assert!(images.all(|image| image.is_empty() || !image.span.contains(0)));
}

#[test]
fn cameras_of_different_sizes_share_a_capture_and_cropped_renders_keep_their_place() {
    let folder = Folder::new();
    let mut depth = vec![2.0; PIXELS];
    depth[0] = f32::NAN;
    depth[1] = f32::INFINITY;
    folder.put("a.exr", &plain(FlatSamples::F32(depth)));
    // A render cropped to 6×4 at (2, 1) of a picture of 10×8.
    let mut cropped = exr::prelude::read_all_flat_layers_from_file(folder.path("a.exr")).unwrap();
    cropped.attributes.display_window = exr::prelude::IntegerBounds::from_dimensions((10, 8));
    cropped.layer_data[0].attributes.layer_position = exr::math::Vec2(2, 1);
    exr::prelude::WritableImage::write(&cropped).to_file(folder.path("b.exr")).unwrap();
    let mut large = entry("b.exr", "b", 0);
    large["w"] = 10.into();
    large["h"] = 8.into();
    let capture = folder.open(json!({}), &[entry("a.exr", "a", 0), large]).unwrap();
    let (small, large) = (capture.frame(0, 0).unwrap(), capture.frame(1, 0).unwrap());
    assert_eq!((small.size(), small.invalid_pixels()), (SIZE, 1));
    assert_eq!((small.inverse_depth[(0, 0)], small.inverse_depth[(1, 0)]), (-1.0, 0.0));
    assert_eq!((large.size(), large.invalid_pixels()), ((10, 8), 80 - PIXELS + 1));
    assert_eq!((large.inverse_depth[(3, 1)], large.inverse_depth[(7, 4)]), (0.0, 0.5));
    assert_eq!(large.inverse_depth[(8, 4)], -1.0);
}

#[test]
fn vantages_have_truth_where_their_picture_exists_and_may_move() {
    let folder = Folder::new();
    folder.put("novel/a.exr", &plain(flat(2.0)));
    folder.put("novel/b.exr", &picture(&[("", vec![("R", flat(0.5)), ("G", flat(0.5)), ("B", flat(0.5))])]));
    let mut moved = entry("c.exr", "v", 2);
    moved["transform_matrix"][0][3] = 5.0.into();
    let manifest = json!({"frames": [entry("a.exr", "v", 0), entry("b.exr", "v", 1), moved]});
    folder.put("novel/transforms.json", manifest.to_string().as_bytes());
    let views = transforms::open_views(&folder.path("novel")).unwrap();
    let numbers: Vec<i64> = views.iter().map(|view| view.frame_number).collect();
    assert_eq!(numbers, [0, 1, 2]);
    assert_eq!(views[2].camera.position_in_world(), DVec3::new(5.0, 0.0, 0.0));
    assert!(views[2].truth.is_none());
    let truth = |index: usize| views[index].truth.as_ref().unwrap()().unwrap();
    assert_eq!(truth(0).inverse_depth[(0, 0)], 0.5);
    assert_eq!((truth(1).inverse_depth[(0, 0)], truth(1).invalid_pixels()), (0.0, 0));
}

#[test]
fn a_layer_of_positions_of_any_name_can_be_chosen_and_goes_before_known_ones() {
    let folder = Folder::new();
    let names = ["P.X", "P.Y", "P.Z", "WorldPosition.X", "WorldPosition.Y", "WorldPosition.Z"];
    let planes = wall_at(2.0).into_iter().chain(wall_at(4.0));
    folder.put("a.exr", &picture(&[("", gray_with(names.into_iter().zip(planes)))]));
    for wish in ["WorldPosition", "WorldPosition.X"] {
        let keys = json!({"depth_kind": "position", "depth_channel": wish});
        let capture = folder.open(keys, &[entry("a.exr", "a", 0)]).unwrap();
        assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.25, "{wish}");
    }
}

#[test]
fn channels_of_one_name_in_several_parts_are_told_apart_by_their_parts() {
    let folder = Folder::new();
    let depth = |value| vec![("depth.Z", flat(value))];
    folder.put(
        "a.exr",
        &picture(&[("rgba", gray_with([])), ("depth.left", depth(1.0)), ("depth.right", depth(2.0))]),
    );
    let refused = folder.open(json!({}), &[entry("a.exr", "a", 0)]).unwrap_err().to_string();
    assert!(refused.contains("depth.right.depth.Z") && refused.contains("depth_channel"), "{refused}");
    let keys = json!({"depth_channel": "depth.right.depth.Z"});
    let capture = folder.open(keys, &[entry("a.exr", "a", 0)]).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.5);
}

#[test]
fn the_near_plane_is_missed_in_depth_files_too() {
    let folder = Folder::new();
    folder.put("color.exr", &picture(&[("", gray_with([]))]));
    folder.put("depth.exr", &picture(&[("", vec![("dd.T", flat(2.0))])]));
    let depth: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(6, 4, Luma([2000]));
    depth.save(folder.path("depth.png")).unwrap();
    for (depth, kind) in [("depth.exr", None), ("depth.png", Some("ray_distance_from_near_clip"))] {
        let mut apart = entry("color.exr", "a", 0);
        apart["depth_file_path"] = depth.into();
        let capture = folder.open(json!({"depth_kind": kind}), &[apart]).unwrap();
        assert!(capture.warnings.iter().any(|warning| warning.contains("near_clip")), "{depth}");
    }
}

#[test]
fn what_is_not_converted_is_warned_of() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(2.0)));
    let mut wide = exr::prelude::read_all_flat_layers_from_file(folder.path("a.exr")).unwrap();
    let at = exr::math::Vec2::<f32>;
    let (white, blue) = (at(0.3127, 0.329), at(0.15, 0.06));
    let mut warnings = |red, green| {
        wide.attributes.chromaticities =
            Some(exr::meta::attribute::Chromaticities { red, green, blue, white });
        exr::prelude::WritableImage::write(&wide).to_file(folder.path("a.exr")).unwrap();
        folder.open(json!({}), &[entry("a.exr", "a", 0)]).unwrap().warnings.clone()
    };
    assert!(warnings(at(0.64, 0.33), at(0.3, 0.6)).is_empty());
    assert!(warnings(at(0.713, 0.293), at(0.165, 0.83)).is_empty(), "these are converted");
    assert!(warnings(at(0.15, 0.06), at(0.15, 0.06))[0].contains("chromaticities"));
    folder.put("a.exr", &plain(flat(2.0)));
    let scaled = |more: serde_json::Value| {
        let mut keys = json!({"applied_scale": 0.1});
        keys.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        folder.open(keys, &[entry("a.exr", "a", 0)]).unwrap().warnings.clone()
    };
    assert!(scaled(json!({}))[0].contains("applied_scale 0.1"));
    assert!(scaled(json!({"depth_unit_scale_factor": 1})).is_empty());
    assert!(scaled(json!({"applied_scale": 1})).is_empty());
}

#[test]
fn depth_in_whole_numbers_is_rounded_to_its_unit_in_exr_files_too() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(FlatSamples::U32(vec![2000; PIXELS])));
    let capture = folder.open(json!({"depth_unit_scale_factor": 0.001}), &[entry("a.exr", "a", 0)]).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    assert_eq!(frame.inverse_depth[(0, 0)], 0.5);
    assert!((frame.depth_step_relative - 0.00025).abs() < 1e-8, "half a millimeter at two meters");
}

#[test]
fn a_frame_of_which_a_sensor_measured_nothing_has_no_samples() {
    let folder = Folder::new();
    folder.put("color.exr", &picture(&[("", gray_with([]))]));
    let depth: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(6, 4, Luma([0]));
    depth.save(folder.path("depth.png")).unwrap();
    let mut apart = entry("color.exr", "a", 0);
    apart["depth_file_path"] = "depth.png".into();
    folder.put("later.exr", &plain(flat(2.0)));
    let capture = folder.open(json!({}), &[apart, entry("later.exr", "a", 1)]).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().invalid_pixels(), PIXELS);
    assert_eq!(capture.frame(0, 1).unwrap().invalid_pixels(), 0);
}

#[test]
fn manifests_from_windows_are_read() {
    let folder = Folder::new();
    folder.put("front/0000.exr", &plain(flat(2.0)));
    let manifest = json!({"frames": [entry("front\\0000.exr", "a", 0)]});
    let marked = [b"\xEF\xBB\xBF".as_slice(), manifest.to_string().as_bytes()].concat();
    folder.put("transforms.json", &marked);
    let settings = overlook_engine::settings::CaptureSettings::default();
    let capture = transforms::open(&folder.path(""), &settings).unwrap();
    assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.5);
    let places = transforms::picture_places(&folder.path("")).unwrap();
    assert!(places.contains(&folder.path("front/0000.exr")), "{places:?}");
}

#[test]
fn views_at_times_that_are_fractions_name_the_number_of_their_frame() {
    let folder = Folder::new();
    folder.put("a.exr", &plain(flat(2.0)));
    let at = |key: &str, time: f64| {
        let mut entry = entry("a.exr", "a", 0);
        entry.as_object_mut().unwrap().remove("time");
        entry[key] = time.into();
        entry
    };
    let ranked = folder.open(json!({}), &[0.0, 0.25, 0.5, 0.75, 1.0].map(|time| at("time", time))).unwrap();
    let whole = folder.open(json!({}), &[0.0, 1.0].map(|time| at("time", time))).unwrap();
    let views = folder.path("views.json");
    let put = |key: &str, time: f64| {
        folder.put("views.json", json!({"frames": [at(key, time)]}).to_string().as_bytes());
    };
    for (key, time) in [("time", 0.5), ("frame", 0.5)] {
        put(key, time);
        for refused in
            [transforms::open_views(&views), transforms::open_views_of(&views, whole.frames_are_ranked())]
        {
            let refused = refused.map(drop).unwrap_err().to_string();
            assert!(refused.contains("frames[0]") && refused.contains("\"frame\""), "{refused}");
        }
    }
    // Frame 1, or the last one?
    put("time", 1.0);
    assert!(transforms::open_views_of(&views, ranked.frames_are_ranked()).is_err());
    assert_eq!(transforms::open_views_of(&views, whole.frames_are_ranked()).unwrap()[0].frame_number, 1);
    assert_eq!(transforms::open_views(&views).unwrap()[0].frame_number, 1);
    put("frame", 2.0);
    assert_eq!(transforms::open_views_of(&views, ranked.frames_are_ranked()).unwrap()[0].frame_number, 2);
}
