//! Whichever layers a file has, its picture, normals and depth are told apart, or one clear line says what to name.

mod common;

use common::{Folder, PIXELS, SIZE, entry, flat, picture};
use exr::prelude::FlatSamples;
use overlook::capture::{Capture, transforms};
use overlook::error::Result;
use serde_json::{Value, json};

/// Three channels of a constant.
fn constant(names: [&str; 3], values: [f32; 3]) -> Vec<(&str, FlatSamples)> {
    names.into_iter().zip(values.map(flat)).collect()
}

const GRAY: [f32; 3] = [0.5; 3];
/// Toward the camera of [`entry`].
const FACING: [f32; 3] = [0.0, -1.0, 0.0];

/// Positions on a wall that faces the camera of [`entry`].
fn wall_at(depth: f32) -> [FlatSamples; 3] {
    let of = |pick: fn(f32, f32) -> f32| {
        let at = |i: usize| pick((i % SIZE.0) as f32 + 0.5, (i / SIZE.0) as f32 + 0.5);
        FlatSamples::F32((0..PIXELS).map(|i| depth * at(i)).collect())
    };
    [of(|x, _| (x - 3.0) / 3.0), of(|_, _| 1.0), of(|_, y| (2.0 - y) / 3.0)]
}

fn open(parts: &[(&str, Vec<(&str, FlatSamples)>)], keys: Value) -> (Folder, Result<Capture>) {
    let folder = Folder::new();
    folder.put("a.exr", &picture(parts));
    let capture = folder.open(keys, &[entry("a.exr", "a", 0)]);
    (folder, capture)
}

/// Red, the inverse depth and the normal of the first pixel.
fn seen(capture: Result<Capture>) -> (f32, f32, Option<[f32; 3]>) {
    let capture = capture.unwrap();
    let frame = capture.frame(0, 0).unwrap();
    let normal = frame.normal_in_world.as_ref().map(|normals| normals[(0, 0)]);
    (frame.color[(0, 0)][0].to_f32(), frame.inverse_depth[(0, 0)], normal)
}

#[test]
fn normals_are_never_taken_for_a_picture_that_is_not_there() {
    let mut channels = constant(["Normal.R", "Normal.G", "Normal.B"], FACING);
    channels.push(("Z", flat(2.0)));
    let (_folder, refused) = open(&[("", channels)], json!({}));
    let refused = refused.map(drop).unwrap_err().to_string();
    assert!(refused.contains("no color among the channels") && refused.contains("\"layer\""), "{refused}");
}

#[test]
fn normals_in_red_green_and_blue_are_read_beside_the_only_picture() {
    let rgb = ["R", "G", "B"];
    let parts = [
        ("diffuse", constant(rgb, GRAY)),
        ("normals", constant(rgb, FACING)),
        ("Depth", vec![("Z", flat(2.0))]),
    ];
    let (_folder, capture) = open(&parts, json!({}));
    assert_eq!(seen(capture), (0.5, 0.5, Some(FACING)));
    let mut channels = constant(rgb, GRAY);
    channels.extend(constant(["Normal.R", "Normal.G", "Normal.B"], FACING));
    channels.push(("Z", flat(2.0)));
    let (_folder, capture) = open(&[("", channels)], json!({}));
    assert_eq!(seen(capture), (0.5, 0.5, Some(FACING)));
}

#[test]
fn a_file_of_normals_may_hold_them_as_its_picture_or_in_a_layer_of_their_name() {
    let plain = constant(["R", "G", "B"], FACING);
    let named = constant(["Normal.R", "Normal.G", "Normal.B"], FACING);
    let beside = [constant(["R", "G", "B"], GRAY), named.clone()].concat();
    for channels in [plain, named, beside] {
        let folder = Folder::new();
        folder.put("a.exr", &common::plain(flat(2.0)));
        folder.put("n.exr", &picture(&[("", channels)]));
        let mut apart = entry("a.exr", "a", 0);
        apart["normal_file_path"] = "n.exr".into();
        assert_eq!(seen(folder.open(json!({}), &[apart])), (0.5, 0.5, Some(FACING)));
    }
}

#[test]
fn naming_the_layer_that_an_error_lists_gives_its_depth_and_normals() {
    let layer = |names: [&'static str; 7], depth: f32| {
        let [r, g, b, x, y, z, d] = names;
        let mut channels = constant([r, g, b], GRAY);
        channels.extend(constant([x, y, z], FACING));
        channels.push((d, flat(depth)));
        channels
    };
    let front = [
        "Front.Combined.R",
        "Front.Combined.G",
        "Front.Combined.B",
        "Front.Normal.X",
        "Front.Normal.Y",
        "Front.Normal.Z",
        "Front.Depth.Z",
    ];
    let back = [
        "Back.Combined.R",
        "Back.Combined.G",
        "Back.Combined.B",
        "Back.Normal.X",
        "Back.Normal.Y",
        "Back.Normal.Z",
        "Back.Depth.Z",
    ];
    let channels = [layer(front, 2.0), layer(back, 4.0)].concat();
    let (_folder, refused) = open(&[("", channels.clone())], json!({}));
    let refused = refused.map(drop).unwrap_err().to_string();
    assert!(refused.contains("(Back.Combined, Front.Combined)"), "{refused}");
    for (name, inverse_depth) in [("Front.Combined", 0.5), ("Back.Combined", 0.25), ("Back", 0.25)] {
        let (_folder, capture) = open(&[("", channels.clone())], json!({"layer": name}));
        assert_eq!(seen(capture), (0.5, inverse_depth, Some(FACING)), "{name}");
    }
}

#[test]
fn positions_go_before_distances_of_unknown_beginning_and_coordinates_of_textures_are_neither() {
    let positions = || ["P.X", "P.Y", "P.Z"].into_iter().zip(wall_at(4.0));
    let with = |more: Vec<(&'static str, FlatSamples)>, keys: Value| {
        let mut channels = constant(["R", "G", "B"], GRAY);
        channels.extend(positions());
        channels.extend(more);
        open(&[("", channels)], keys)
    };
    let (_folder, capture) = with(vec![("st.S", flat(0.5)), ("st.T", flat(0.5))], json!({}));
    assert_eq!(capture.as_ref().map(|capture| capture.warnings.len()).unwrap(), 0);
    assert_eq!(seen(capture).1, 0.25);
    let (_folder, capture) = with(vec![("dd.T", flat(0.5))], json!({}));
    assert_eq!(seen(capture).1, 0.25);
    let keys = json!({"depth_channel": "dd.T", "near_clip": 1});
    let (_folder, capture) = with(vec![("dd.T", flat(0.5))], keys);
    assert!(seen(capture).1 > 0.5, "what is named is read");
}

#[test]
fn a_name_that_ends_in_a_number_may_lack_its_extension() {
    let folder = Folder::new();
    folder.put("front/frame.0001.exr", &common::plain(flat(2.0)));
    let capture = folder.open(json!({}), &[entry("front/frame.0001", "a", 0)]);
    assert_eq!(seen(capture).1, 0.5);
    let places = transforms::picture_places(&folder.path("")).unwrap();
    assert!(places.contains(&folder.path("front/frame.0001.exr")), "{places:?}");
    let missing = folder.open(json!({}), &[entry("front/frame.0002", "a", 0)]).map(drop).unwrap_err();
    assert!(missing.to_string().contains("frame.0002 is missing"), "{missing}");
}
