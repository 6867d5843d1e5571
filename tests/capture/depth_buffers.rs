//! Depth as graphics libraries keep it: read between its planes, and recognized where a manifest does not say so.

use crate::analytic_scene::{camera, check, colors, depths, rows};
use crate::folder::Folder;
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
use image::{ImageBuffer, Luma, Rgb};
use overlook_engine::capture::conventions::{self, Finding};
use overlook_engine::capture::{Capture, Intrinsics, Source};
use overlook_engine::error::Result;
use overlook_engine::settings::CaptureSettings;
use serde_json::{Value, json};

const VIEWS: usize = 6;
const SIZE: (u32, u32) = (64, 48);
const NEAR: f64 = 0.1;
const FAR: f64 = 100.0;

fn lens() -> Intrinsics {
    Intrinsics::from_horizontal_angle(SIZE.0, SIZE.1, 1.2)
}

/// What a depth buffer keeps of planar z.
fn buffer(z: f64) -> f64 {
    FAR / (FAR - NEAR) * (1.0 - NEAR / z)
}

fn write_exr(folder: &Folder, name: &str, values: Vec<f32>) {
    let channels = AnyChannels::sort([AnyChannel::new("Z", FlatSamples::F32(values))].into_iter().collect());
    let size = (SIZE.0 as usize, SIZE.1 as usize);
    Image::from_channels(size, channels).write().to_file(folder.path(name)).unwrap();
}

/// Views of the analytic scene whose depth is `value` of planar z: floats in `OpenEXR`, or 16 bits in PNG.
fn write(folder: &Folder, ending: &str, value: impl Fn(f64) -> f64, keys: Value) {
    let mut manifest = keys;
    let lens = lens();
    let entry = |step: usize| {
        let camera = camera(step, lens);
        let picture = ImageBuffer::<Rgb<u8>, _>::from_raw(SIZE.0, SIZE.1, colors(&camera)).unwrap();
        picture.save(folder.path(&format!("{step}.png"))).unwrap();
        let name = format!("depth{step}.{ending}");
        let values: Vec<f64> = depths(&camera).into_iter().map(&value).collect();
        if ending == "exr" {
            write_exr(folder, &name, values.iter().map(|value| *value as f32).collect());
        } else {
            let levels = values.iter().map(|value| (value * 65535.0).round() as u16).collect();
            let picture = ImageBuffer::<Luma<u16>, Vec<u16>>::from_raw(SIZE.0, SIZE.1, levels).unwrap();
            picture.save(folder.path(&name)).unwrap();
        }
        let matrix: Vec<Vec<f64>> = rows(&camera.world_from_camera).chunks(4).map(<[f64]>::to_vec).collect();
        json!({"file_path": format!("{step}.png"), "depth_file_path": name, "transform_matrix": matrix})
    };
    manifest["frames"] = (0..VIEWS).map(entry).collect();
    manifest["camera_axes"] = json!(["right", "down", "forward"]);
    (manifest["fl_x"], manifest["fl_y"]) = (lens.fx.into(), lens.fy.into());
    folder.put("transforms.json", manifest.to_string().as_bytes());
}

fn open(folder: &Folder) -> Result<Capture> {
    Source::find(&folder.path(""))?.open(&CaptureSettings::default())
}

fn finding(folder: &Folder) -> Finding {
    conventions::check(&open(folder).unwrap()).unwrap()
}

#[test]
fn buffers_of_both_orders_in_floats_and_in_whole_numbers_are_planar_depth() {
    // Whole numbers of 16 bits are coarse far from so near a plane.
    for (ending, near, tolerance) in [("exr", NEAR, 1.0), ("png", 0.5, 1.0)] {
        let value = move |z: f64| FAR / (FAR - near) * (1.0 - near / z);
        let reversed = move |z: f64| 1.0 - value(z);
        let folder = Folder::new();
        write(&folder, ending, value, json!({"depth_kind": "z_buffer", "depth_range": [near, FAR]}));
        check(&open(&folder).unwrap(), VIEWS, tolerance);
        write(
            &folder,
            ending,
            reversed,
            json!({"depth_kind": "reversed_z_buffer", "depth_range": [near, FAR]}),
        );
        check(&open(&folder).unwrap(), VIEWS, tolerance);
        let finding = finding(&folder);
        assert!(finding.alternative().is_none() && finding.claimed_score > 0.3, "{}", finding.sentence());
    }
}

#[test]
fn nothing_was_drawn_at_the_far_plane_of_a_buffer() {
    let folder = Folder::new();
    let cleared = |z: f64| if z > 2.9 { 1.0 } else { buffer(z) };
    write(&folder, "exr", cleared, json!({"depth_kind": "z_buffer", "depth_range": [NEAR, FAR]}));
    let frame = open(&folder).unwrap().frame(0, 0).unwrap();
    let sky = frame.inverse_depth.as_slice().iter().filter(|inverse| **inverse == 0.0).count();
    let far = depths(&camera(0, lens())).iter().filter(|z| **z > 2.9).count();
    assert!(far > 100 && sky == far, "{sky} of {far}");
}

#[test]
fn a_buffer_without_its_planes_is_refused_by_the_key_that_gives_them() {
    let folder = Folder::new();
    write(&folder, "exr", buffer, json!({"depth_kind": "z_buffer"}));
    let refused = open(&folder).map(drop).unwrap_err().to_string();
    assert!(refused.contains("\"depth_range\": [near, far]") && !refused.contains('\n'), "{refused}");
}

#[test]
fn a_buffer_that_is_taken_for_the_other_order_is_found_by_agreement() {
    let folder = Folder::new();
    // Levels between planes run from the far one where nothing else is said.
    write(&folder, "png", |z| FAR / (FAR - 1.0) * (1.0 - 1.0 / z), json!({"depth_range": [1.0, FAR]}));
    let said = finding(&folder).warning().unwrap_or_default();
    assert!(said.contains("write \"depth_kind\": \"z_buffer\"") && !said.contains("camera_axes"), "{said}");
}

#[test]
fn a_buffer_that_is_taken_for_distances_is_found_with_its_planes() {
    for is_reversed in [false, true] {
        let folder = Folder::new();
        let value = |z: f64| if is_reversed { 1.0 - buffer(z) } else { buffer(z) };
        write(&folder, "exr", value, json!({}));
        let finding = finding(&folder);
        let said = finding.sentence();
        let kind = if is_reversed { "\"reversed_z_buffer\"" } else { "\"z_buffer\"" };
        assert!(said.contains(&format!("write \"depth_kind\": {kind}, \"depth_range\": [")), "{said}");
        let keys = finding.alternative().unwrap().keys.clone();
        let source = Source::find(&folder.path("")).unwrap().read_as(&keys).unwrap();
        let read = conventions::check(&source.open(&CaptureSettings::default()).unwrap()).unwrap();
        assert!(read.alternative().is_none() && read.claimed_score > 0.3, "{}", read.sentence());
    }
}

#[test]
fn depth_divided_by_the_farthest_and_reciprocals_of_depth_are_no_buffers_with_planes_of_chance() {
    let said = |value: fn(f64) -> f64| {
        let folder = Folder::new();
        write(&folder, "exr", value, json!({}));
        finding(&folder).sentence()
    };
    let divided = said(|z| z / 12.0);
    assert!(
        divided.contains("write \"depth_unit_scale_factor\": 12.0 in") && divided.contains("sure"),
        "{divided}"
    );
    let turned = said(|z| 1.0 - z / 10.0);
    assert!(turned.contains("(at 10.0 and 0") && turned.contains("convert it"), "{turned}");
    let reciprocal = said(|z| 0.25 / z);
    assert!(reciprocal.contains("\"reversed_z_buffer\", \"depth_range\": [0.25, null]"), "{reciprocal}");
}
