//! A capture of which no pixel has depth is refused with the likeliest cause, whatever its format.

use crate::captures::{Folder, PIXELS, SIZE, entry, flat, plain};
use image::{ImageBuffer, Luma, Rgb};
use overlook_engine::capture::Capture;
use overlook_engine::error::Result;
use serde_json::{Value, json};

/// An array of `NumPy` with the shape of a picture.
fn npy(values: &[f32]) -> Vec<u8> {
    let (columns, rows) = SIZE;
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Two cameras with depth in files of these names.
fn open(folder: &Folder, depths: [&str; 2]) -> Result<Capture> {
    ImageBuffer::from_pixel(SIZE.0 as u32, SIZE.1 as u32, Rgb([9_u8, 8, 7]))
        .save(folder.path("a.png"))
        .unwrap();
    let entries: Vec<Value> = depths
        .iter()
        .zip(["left", "right"])
        .map(|(depth, camera)| {
            let mut entry = entry("a.png", camera, 0);
            entry["depth_file_path"] = (*depth).into();
            entry
        })
        .collect();
    folder.open(json!({}), &entries)
}

fn refusal(result: Result<Capture>) -> String {
    let refused = result.map(drop).unwrap_err().to_string();
    assert!(!refused.contains('\n'), "{refused}");
    refused
}

#[test]
fn arrays_of_negative_zero_and_unknown_depth_are_refused_by_their_cause() {
    for (value, cause) in [(-2000.0, "negative"), (0.0, "every value is 0"), (f32::NAN, "NaN")] {
        let folder = Folder::new();
        folder.put("depth.npy", &npy(&[value; PIXELS]));
        let refused = refusal(open(&folder, ["depth.npy"; 2]));
        assert!(refused.contains(cause) && refused.contains("not one pixel"), "{refused}");
    }
}

#[test]
fn a_png_of_zeros_is_refused() {
    let folder = Folder::new();
    let zeros: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::new(SIZE.0 as u32, SIZE.1 as u32);
    zeros.save(folder.path("depth.png")).unwrap();
    let refused = refusal(open(&folder, ["depth.png"; 2]));
    assert!(refused.contains("every value is 0"), "{refused}");
}

#[test]
fn the_same_in_openexr_is_refused() {
    for (value, cause) in [(-2.0, "negative"), (0.0, "every value is 0"), (1e10, "nothing was hit")] {
        let folder = Folder::new();
        folder.put("a.exr", &plain(flat(value)));
        let refused = refusal(folder.open(json!({}), &[entry("a.exr", "a", 0)]));
        assert!(refused.contains(cause), "{value}: {refused}");
    }
}

#[test]
fn depth_in_any_picture_is_enough() {
    let folder = Folder::new();
    folder.put("none.npy", &npy(&[0.0; PIXELS]));
    let mut one = [0.0; PIXELS];
    one[7] = 2000.0;
    folder.put("some.npy", &npy(&one));
    let capture = open(&folder, ["none.npy", "some.npy"]).unwrap();
    assert_eq!(capture.frame(1, 0).unwrap().invalid_pixels(), PIXELS - 1);
}
