//! What a picture says of its colors, its rows and its projection counts, unless the manifest says otherwise.

use crate::captures::{Folder, PIXELS, SIZE, entry, flat};
use exr::meta::attribute::{Chromaticities, EnvironmentMap};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes, Vec2,
    WritableImage,
};
use half::f16;
use image::{ImageBuffer, ImageFormat, Luma, Rgb, RgbImage};
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
use serde_json::{Value, json};

/// An uncompressed TIFF picture of `SIZE`: samples of so many bits, of TIFF's sample format 1 (whole), 2 (signed) or 3 (floats).
fn tiff(channels: u16, bits: u16, format: u16, samples: &[u8]) -> Vec<u8> {
    let (width, height) = (SIZE.0 as u32, SIZE.1 as u32);
    let tags: [(u16, u16, u32, u32); 11] = [
        (256, 4, 1, width),
        (257, 4, 1, height),
        (258, 3, u32::from(channels), if channels == 1 { u32::from(bits) } else { 146 }),
        (259, 3, 1, 1),
        (262, 3, 1, if channels == 1 { 1 } else { 2 }),
        (273, 4, 1, 160),
        (277, 3, 1, u32::from(channels)),
        (278, 4, 1, height),
        (279, 4, 1, samples.len() as u32),
        (284, 3, 1, 1),
        (339, 3, u32::from(channels), if channels == 1 { u32::from(format) } else { 152 }),
    ];
    let mut file = b"II*\0\x08\0\0\0".to_vec();
    file.extend((tags.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in tags {
        file.extend(tag.to_le_bytes().into_iter().chain(kind.to_le_bytes()));
        file.extend(count.to_le_bytes().into_iter().chain(value.to_le_bytes()));
    }
    file.extend([0; 4]);
    for value in [bits, format] {
        let three = [value; 3];
        file.extend(three.into_iter().flat_map(u16::to_le_bytes));
    }
    file.resize(160, 0);
    file.extend(samples);
    file
}

/// A capture of one picture of color with depth of two meters beside it.
fn with_depth(folder: &Folder, color: &str, keys: Value) -> Result<Capture> {
    let depth: ImageBuffer<Luma<u16>, Vec<u16>> =
        ImageBuffer::from_pixel(SIZE.0 as u32, SIZE.1 as u32, Luma([2000]));
    depth.save(folder.path("depth.png")).unwrap();
    let mut one = entry(color, "a", 0);
    one["depth_file_path"] = "depth.png".into();
    folder.open(keys, &[one])
}

fn first_color(capture: &Capture) -> [f32; 3] {
    capture.frame(0, 0).unwrap().color[(0, 0)].map(f16::to_f32)
}

fn assert_near(found: [f32; 3], expected: [f32; 3]) {
    let is_near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 4e-3);
    assert!(is_near, "{found:?} {expected:?}");
}

#[test]
fn color_in_tiff_is_srgb_in_whole_numbers_and_linear_in_floats() {
    let folder = Folder::new();
    let bytes: Vec<u8> = [188, 0, 255].repeat(PIXELS);
    folder.put("u8.tif", &tiff(3, 8, 1, &bytes));
    let wide: Vec<u8> = bytes.iter().flat_map(|value| (u16::from(*value) * 257).to_le_bytes()).collect();
    folder.put("u16.tif", &tiff(3, 16, 1, &wide));
    let floats: Vec<u8> = [0.5_f32, 0.0, 1.5].repeat(PIXELS).into_iter().flat_map(f32::to_le_bytes).collect();
    folder.put("f32.tif", &tiff(3, 32, 3, &floats));
    let halves: Vec<u8> =
        [0.5, 0.0, 1.5].map(f16::from_f32).repeat(PIXELS).into_iter().flat_map(f16::to_le_bytes).collect();
    folder.put("f16.tif", &tiff(3, 16, 3, &halves));
    folder.put("gray.tif", &tiff(1, 8, 1, &[188; PIXELS]));
    for (name, expected) in [
        ("u8.tif", [0.503, 0.0, 1.0]),
        ("u16.tif", [0.503, 0.0, 1.0]),
        ("f32.tif", [0.5, 0.0, 1.5]),
        ("f16.tif", [0.5, 0.0, 1.5]),
        ("gray.tif", [0.503; 3]),
    ] {
        assert_near(first_color(&with_depth(&folder, name, json!({})).unwrap()), expected);
    }
    let linear = with_depth(&folder, "u8.tif", json!({"color_space": "linear"})).unwrap();
    assert_near(first_color(&linear), [188.0 / 255.0, 0.0, 1.0]);
}

#[test]
fn depth_may_be_half_floats_signed_or_gray_in_three_channels_and_where_it_cannot_be_the_line_says_why() {
    let folder = Folder::new();
    RgbImage::from_pixel(SIZE.0 as u32, SIZE.1 as u32, Rgb([9; 3])).save(folder.path("a.png")).unwrap();
    let open = |name: &str, keys: Value| {
        let mut one = entry("a.png", "a", 0);
        one["depth_file_path"] = name.into();
        folder.open(keys, &[one])
    };
    let halves: Vec<u8> = [f16::from_f32(2.5); PIXELS].into_iter().flat_map(f16::to_le_bytes).collect();
    folder.put("f16.tif", &tiff(1, 16, 3, &halves));
    let capture = open("f16.tif", json!({"depth_unit_scale_factor": 1})).unwrap();
    let frame = capture.frame(0, 0).unwrap();
    assert_eq!((frame.inverse_depth[(0, 0)], frame.depth_step_relative), (0.4, 1.0 / 2048.0));
    let mut signed = vec![2500_i16; PIXELS];
    signed[1] = -1;
    let signed: Vec<u8> = signed.into_iter().flat_map(i16::to_le_bytes).collect();
    folder.put("i16.tif", &tiff(1, 16, 2, &signed));
    let frame = open("i16.tif", json!({})).unwrap().frame(0, 0).unwrap();
    assert_eq!((frame.inverse_depth[(0, 0)], frame.inverse_depth[(1, 0)]), (0.4, -1.0));
    let gray = ImageBuffer::<Rgb<u16>, _>::from_pixel(SIZE.0 as u32, SIZE.1 as u32, Rgb([2500; 3]));
    gray.save(folder.path("rgb.png")).unwrap();
    assert_eq!(open("rgb.png", json!({})).unwrap().frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.4);
    let mut pfm = format!("Pf\n{} {}\n-1.0\n", SIZE.0, SIZE.1).into_bytes();
    pfm.extend([2.5_f32; PIXELS].into_iter().flat_map(f32::to_le_bytes));
    folder.put("d.pfm", &pfm);
    assert_eq!(open("d.pfm", json!({})).unwrap().frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.4);
    RgbImage::new(6, 4).save_with_format(folder.path("d.jpg"), ImageFormat::Jpeg).unwrap();
    folder.put("d.npz", b"PK");
    folder.put("u8.tif", &tiff(1, 8, 1, &[7; PIXELS]));
    for (name, why) in [("d.jpg", "JPEG holds no depth"), ("d.npz", ".npy"), ("u8.tif", "16 or 32 bits")] {
        let refused = open(name, json!({})).map(drop).unwrap_err().to_string();
        assert!(refused.contains(why) && refused.contains("EXR") && !refused.contains('\n'), "{refused}");
    }
}

/// An EXR picture of one color and depth 2, with these attributes.
fn exr(color: [f32; 3], change: impl Fn(&mut ImageAttributes, &mut LayerAttributes)) -> Vec<u8> {
    let planes = [("R", color[0]), ("G", color[1]), ("B", color[2]), ("Z", 2.0)];
    let list = planes.map(|(name, value)| AnyChannel::new(name, flat(value))).into_iter().collect();
    let (mut image, mut layer) =
        (ImageAttributes::new(IntegerBounds::from_dimensions(SIZE)), LayerAttributes::default());
    change(&mut image, &mut layer);
    let layer = Layer::new(SIZE, layer, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list));
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::empty(image).with_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn chromaticities_are_converted_unless_the_manifest_names_rec_709() {
    let folder = Folder::new();
    let p3 = Chromaticities {
        red: Vec2(0.68, 0.32),
        green: Vec2(0.265, 0.69),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    };
    folder.put("a.exr", &exr([1.0, 0.0, 0.0], |image, _| image.chromaticities = Some(p3)));
    let color = |keys: Value| {
        let capture = folder.open(keys, &[entry("a.exr", "a", 0)]).unwrap();
        assert!(capture.warnings.is_empty(), "{:?}", capture.warnings);
        first_color(&capture)
    };
    assert_near(color(json!({})), [1.2249, -0.0420, -0.0196]);
    assert_near(color(json!({"color_space": "Linear Rec.709"})), [1.0, 0.0, 0.0]);
}

#[test]
fn a_panorama_is_refused_by_its_header() {
    let folder = Folder::new();
    let panorama = exr([0.5; 3], |_, layer| layer.environment_map = Some(EnvironmentMap::LatitudeLongitude));
    folder.put("a.exr", &panorama);
    let refused = folder.open(json!({}), &[entry("a.exr", "a", 0)]).map(drop).unwrap_err().to_string();
    assert!(
        refused.contains("panorama") && refused.contains("a.exr") && !refused.contains('\n'),
        "{refused}"
    );
}

#[test]
fn luminance_alone_is_gray() {
    let folder = Folder::new();
    let channels = vec![("Y", flat(0.25)), ("Z", flat(2.0))];
    folder.put("a.exr", &crate::captures::picture(&[("", channels)]));
    let capture = folder.open(json!({}), &[entry("a.exr", "a", 0)]).unwrap();
    assert_eq!(first_color(&capture), [0.25; 3]);
    assert_eq!(capture.frame(0, 0).unwrap().inverse_depth[(0, 0)], 0.5);
    folder.put("b.exr", &crate::captures::picture(&[("", vec![("Y", flat(0.25))])]));
    let refused = folder.open(json!({}), &[entry("b.exr", "a", 0)]).map(drop).unwrap_err().to_string();
    assert!(refused.contains("no depth"), "a picture is not its own depth: {refused}");
}

/// A PNG with a further chunk.
fn png_with(picture: &RgbImage, name: [u8; 4], data: &[u8]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let bytes = bytes.into_inner();
    let named: Vec<u8> = name.iter().chain(data).copied().collect();
    let mut chunk = (data.len() as u32).to_be_bytes().to_vec();
    chunk.extend(&named);
    chunk.extend(crc32fast::hash(&named).to_be_bytes());
    // Behind the header.
    [&bytes[..33], &chunk, &bytes[33..]].concat()
}

#[test]
fn a_png_that_names_other_colors_than_srgb_is_converted() {
    let folder = Folder::new();
    let red = RgbImage::from_pixel(SIZE.0 as u32, SIZE.1 as u32, Rgb([255, 0, 0]));
    // Display P3 with the sRGB curve, by H.273's numbers; and linear light by its gamma.
    folder.put("p3.png", &png_with(&red, *b"cICP", &[12, 13, 0, 1]));
    assert_near(first_color(&with_depth(&folder, "p3.png", json!({})).unwrap()), [1.2249, -0.0420, -0.0196]);
    let said = with_depth(&folder, "p3.png", json!({"color_space": "srgb"})).unwrap();
    assert_near(first_color(&said), [1.0, 0.0, 0.0]);
    let gray = RgbImage::from_pixel(SIZE.0 as u32, SIZE.1 as u32, Rgb([51; 3]));
    folder.put("linear.png", &png_with(&gray, *b"gAMA", &100_000_u32.to_be_bytes()));
    assert_near(first_color(&with_depth(&folder, "linear.png", json!({})).unwrap()), [0.2; 3]);
    folder.put("usual.png", &png_with(&gray, *b"gAMA", &45_455_u32.to_be_bytes()));
    let usual = first_color(&with_depth(&folder, "usual.png", json!({})).unwrap());
    gray.save(folder.path("plain.png")).unwrap();
    assert_eq!(usual, first_color(&with_depth(&folder, "plain.png", json!({})).unwrap()));
}

/// Exif data with an orientation alone.
fn exif(orientation: u8) -> Vec<u8> {
    let mut data = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    data.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
    data
}

/// Columns and rows of pictures of a wall, and the focal length of the cameras before it.
const WALL: (u32, u32, f64) = (48, 32, 40.0);

/// What a camera at `x`, two units before a wall, sees of its pattern.
fn wall(x: f64) -> RgbImage {
    let (width, height, focal) = WALL;
    RgbImage::from_fn(width, height, |column, row| {
        let at = |pixel: u32, side: u32| 2.0 * (f64::from(pixel) + 0.5 - f64::from(side) / 2.0) / focal;
        let (u, v) = (x + at(column, width), at(row, height));
        let wave = |phase: f64| (127.0 + 100.0 * phase.sin()) as u8;
        Rgb([wave(3.0 * u + v), wave(2.0 * v - u), wave(u + 4.0 * v)])
    })
}

/// A capture of the wall by cameras at these places, whose files are turned by `stored` and have an orientation tag.
fn walls(
    folder: &Folder,
    places: &[f64],
    tag: u8,
    keys: Value,
    stored: fn(&RgbImage) -> RgbImage,
) -> Result<Capture> {
    let (width, height, focal) = WALL;
    let depth: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_pixel(width, height, Luma([2000]));
    depth.save(folder.path("depth.png")).unwrap();
    let entries: Vec<Value> = places
        .iter()
        .enumerate()
        .map(|(index, x)| {
            folder.put(&format!("{index}.png"), &png_with(&stored(&wall(*x)), *b"eXIf", &exif(tag)));
            json!({
                "file_path": format!("{index}.png"), "depth_file_path": "depth.png", "fl_x": focal,
                "transform_matrix": [[1, 0, 0, x], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]],
            })
        })
        .collect();
    folder.open(keys, &entries)
}

fn corner(capture: &Capture) -> [f32; 3] {
    first_color(capture)
}

#[test]
fn a_turned_picture_is_read_as_sizes_and_the_other_views_say() {
    let straight = {
        let folder = Folder::new();
        let as_it_is = |picture: &RgbImage| picture.clone();
        corner(&walls(&folder, &[0.0, 0.2], 1, json!({}), as_it_is).unwrap())
    };
    let half = |picture: &RgbImage| image::imageops::rotate180(picture);
    let back = |picture: &RgbImage| image::imageops::rotate270(picture);
    let none = |picture: &RgbImage| picture.clone();
    let read = |tag, stored: fn(&RgbImage) -> RgbImage| {
        let folder = Folder::new();
        corner(&walls(&folder, &[0.0, 0.2], tag, json!({}), stored).unwrap())
    };
    assert_eq!(read(3, half), straight, "turned by half, poses of the picture as shown");
    assert_eq!(read(3, none), straight, "turned by half, poses of the rows as stored");
    assert_eq!(read(6, back), straight, "turned by a quarter, depth as large as the picture as shown");
    assert_eq!(read(6, none), straight, "turned by a quarter, depth as large as the rows as stored");
}

#[test]
fn a_turned_picture_that_nothing_explains_is_refused_with_the_key_that_does() {
    let half = |picture: &RgbImage| image::imageops::rotate180(picture);
    let folder = Folder::new();
    let one = |keys: Value| walls(&folder, &[0.0], 3, keys, half);
    let refused = one(json!({})).map(drop).unwrap_err().to_string();
    assert!(refused.contains("orientation tag") && refused.contains("picture_orientation"), "{refused}");
    let shown = corner(&one(json!({"picture_orientation": "as_shown"})).unwrap());
    let stored = corner(&one(json!({"picture_orientation": "as_stored"})).unwrap());
    assert!(shown != stored);
    assert_near(
        shown,
        wall(0.0)[(0, 0)].0.map(|value| {
            let encoded = f32::from(value) / 255.0;
            ((encoded + 0.055) / 1.055).powf(2.4)
        }),
    );
}
