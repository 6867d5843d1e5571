//! Whichever layers a file has, its picture, normals and depth are told apart, or one clear line says what to name.

use crate::captures as common;
use crate::captures::{Folder, PIXELS, SIZE, entry, flat, picture};
use exr::prelude::FlatSamples;
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
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
    let places = overlook_engine::capture::transforms::picture_places(&folder.path("")).unwrap();
    assert!(places.contains(&folder.path("front/frame.0001.exr")), "{places:?}");
    let missing = folder.open(json!({}), &[entry("front/frame.0002", "a", 0)]).map(drop).unwrap_err();
    assert!(missing.to_string().contains("frame.0002 is missing"), "{missing}");
}

/// What opening a picture with a file of depth or normals beside it gives.
fn open_apart(
    key: &str,
    color: &[(&str, FlatSamples)],
    apart: Vec<(&str, FlatSamples)>,
    keys: Value,
) -> (Folder, Result<Capture>) {
    let folder = Folder::new();
    folder.put("a.exr", &picture(&[("", color.to_vec())]));
    folder.put("aov.exr", &picture(&[("", apart)]));
    let mut entry = entry("a.exr", "a", 0);
    entry[key] = "aov.exr".into();
    let capture = folder.open(keys, &[entry]);
    (folder, capture)
}

/// Pictures that a file of passes holds beside what is looked for.
fn other_pictures() -> Vec<(&'static str, FlatSamples)> {
    let names = ["albedo.R", "albedo.G", "albedo.B", "emission.R", "emission.G", "emission.B"];
    names.map(|name| (name, flat(0.25))).to_vec()
}

#[test]
fn depth_and_normals_in_a_file_of_several_pictures_need_no_choice_among_these() {
    let color = constant(["R", "G", "B"], GRAY);
    let depth = || [other_pictures(), vec![("Z", flat(2.0))]].concat();
    for keys in [json!({}), json!({"depth_channel": "Z"}), json!({"depth_channel": "Z", "layer": "albedo"})] {
        let mut color = color.clone();
        color.extend(constant(["albedo.R", "albedo.G", "albedo.B"], GRAY));
        let (_folder, capture) = open_apart("depth_file_path", &color, depth(), keys);
        assert_eq!(seen(capture), (0.5, 0.5, None));
    }
    let with_depth = [color, vec![("Z", flat(2.0))]].concat();
    let normals = [other_pictures(), constant(["N.X", "N.Y", "N.Z"], FACING)].concat();
    for keys in [json!({}), json!({"normal_channel": "N"})] {
        let (_folder, capture) = open_apart("normal_file_path", &with_depth, normals.clone(), keys);
        assert_eq!(seen(capture), (0.5, 0.5, Some(FACING)));
    }
}

#[test]
fn a_depth_file_of_several_layers_is_read_in_the_layer_that_is_named() {
    let color = constant(["Front.Combined.R", "Front.Combined.G", "Front.Combined.B"], GRAY);
    let depth = vec![("Back.Depth.Z", flat(4.0)), ("Front.Depth.Z", flat(2.0))];
    let (_folder, capture) = open_apart("depth_file_path", &color, depth.clone(), json!({"layer": "Front"}));
    assert_eq!(seen(capture), (0.5, 0.5, None));
    let (_folder, refused) = open_apart("depth_file_path", &color, depth, json!({}));
    let refused = refused.map(drop).unwrap_err().to_string();
    assert!(refused.contains("\"depth_channel\""), "{refused}");
}

#[test]
fn a_file_of_its_own_may_hold_positions_or_normals_without_any_name() {
    let color = constant(["R", "G", "B"], GRAY);
    for names in [["X", "Y", "Z"], ["R", "G", "B"]] {
        for wish in [None, Some(names[0])] {
            let positions = names.into_iter().zip(wall_at(2.0)).collect();
            let keys = json!({"depth_kind": "position", "depth_channel": wish});
            let (_folder, capture) = open_apart("depth_file_path", &color, positions, keys);
            assert_eq!(seen(capture), (0.5, 0.5, None), "{names:?} {wish:?}");
        }
    }
    let with_depth = [color, vec![("Z", flat(2.0))]].concat();
    for keys in [json!({}), json!({"normal_channel": "X"})] {
        let normals = constant(["X", "Y", "Z"], FACING);
        let (_folder, capture) = open_apart("normal_file_path", &with_depth, normals, keys);
        assert_eq!(seen(capture), (0.5, 0.5, Some(FACING)));
    }
}

#[test]
fn layers_and_parts_can_be_named_in_any_script() {
    // The `exr` crate writes a byte for a letter.
    let utf8 = |name: &str| name.bytes().map(char::from).collect::<String>();
    let channels = |layer: &str, depth: f32| -> Vec<(String, FlatSamples)> {
        let color = ["R", "G", "B"].map(|name| (format!("{layer}.Combined.{name}"), flat(0.5)));
        color.into_iter().chain([(format!("{layer}.Depth.Z"), flat(depth))]).collect()
    };
    let named: Vec<(String, FlatSamples)> =
        [channels(&utf8("ビュー"), 2.0), channels(&utf8("Außen"), 4.0), channels("\u{fc}", 8.0)].concat();
    let named: Vec<(&str, FlatSamples)> =
        named.iter().map(|(name, samples)| (name.as_str(), samples.clone())).collect();
    for (layer, inverse) in [("ビュー", 0.5), ("Außen", 0.25), ("ü", 0.125)] {
        for keys in
            [json!({"layer": layer}), json!({"layer": layer, "depth_channel": format!("{layer}.Depth.Z")})]
        {
            let (_folder, capture) = open(&[("", named.clone())], keys);
            assert_eq!(seen(capture), (0.5, inverse, None), "{layer}");
        }
    }
    let plain = |depth: f32| [constant(["R", "G", "B"], GRAY), vec![("Z", flat(depth))]].concat();
    let parts = [utf8("Außen"), utf8("Innen")];
    let parts = [(parts[0].as_str(), plain(2.0)), (parts[1].as_str(), plain(4.0))];
    let (_folder, capture) = open(&parts, json!({"layer": "Außen"}));
    assert_eq!(seen(capture), (0.5, 0.5, None));
}

#[test]
fn a_picture_that_is_not_found_is_told_with_what_to_do() {
    let refused = |channels: Vec<(&str, FlatSamples)>, keys: Value| {
        let (_folder, refused) = open(&[("", channels)], keys);
        refused.map(drop).unwrap_err().to_string()
    };
    let words = constant(["rgba.red", "rgba.green", "rgba.blue"], GRAY);
    let words = refused([words, vec![("Z", flat(2.0))]].concat(), json!({}));
    assert!(words.contains("R, G and B"), "{words}");
    let plain = [constant(["R", "G", "B"], GRAY), vec![("Z", flat(2.0))]].concat();
    let elsewhere = refused(plain, json!({"layer": "beauty"}));
    assert!(elsewhere.contains("there is no layer 'beauty'"), "{elsewhere}");
}
