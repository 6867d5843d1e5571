//! Scalar values beside color: from the capture through pruning and the store, bit for bit.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use half::f16;
use overlook_engine::capture::exr::ExrFile;
use overlook_engine::capture::pictures::parse_npy;
use overlook_engine::capture::{
    Camera, Capture, CaptureParts, Frame, FrameSource, Intrinsics, MISSING_VALUE, ValueChannel, Values, open,
    transforms::write_capture,
};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::render::output::{PictureValues, write_exr_with_values, write_npy, write_png};
use overlook_engine::render::{CpuRenderer, NO_IMAGE, ValueColors, Vantage};
use overlook_engine::samples::{SampleImage, SampleSet};
use overlook_engine::settings::{CaptureSettings, Colormap, Settings, SpanLevels, ValueScale};
use overlook_engine::store::file::{Store, write};
use overlook_engine::store::read;

/// The values of a point at a frame, as a camera has them, one a channel.
type Field = fn(point_in_world: DVec3, frame: usize, camera: usize) -> Vec<f32>;

/// A capture with values of points.
struct Valued {
    original: Capture,
    channels: Vec<ValueChannel>,
    field: Field,
}

impl FrameSource for Valued {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let mut of_frame = Frame::clone(&*self.original.frame(camera, frame)?);
        let (width, _) = of_frame.size();
        let value = |(pixel, inverse_depth): (usize, &f32)| {
            if *inverse_depth <= 0.0 {
                return vec![MISSING_VALUE; self.channels.len()];
            }
            let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
            let depth = 1.0 / f64::from(*inverse_depth);
            (self.field)(self.original.cameras[camera].unproject(center, depth), frame, camera)
        };
        let values: Vec<Vec<f32>> = of_frame.inverse_depth.as_slice().iter().enumerate().map(value).collect();
        let plane = |channel: usize| values.iter().map(|values| values[channel]).collect();
        of_frame.values = Values::from_planes(&(0..self.channels.len()).map(plane).collect::<Vec<_>>());
        Ok(of_frame)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.original.place(camera, frame)
    }

    fn value_channels(&self) -> &[ValueChannel] {
        &self.channels
    }
}

fn channel(name: &str, range: [f32; 2]) -> ValueChannel {
    ValueChannel {
        name: name.into(),
        unit: "Pa".into(),
        range,
        tolerance: (range[1] - range[0]) / 256.0,
        is_exact: true,
    }
}

fn valued(original: Capture, channels: Vec<ValueChannel>, field: Field) -> Capture {
    let parts = CaptureParts::clone(&original);
    let source = Arc::new(Valued { original, channels, field });
    Capture::new(CaptureParts { source, ..parts }, 1 << 28)
}

/// Smooth, another one that changes with time, and a number of a part of space, missing in some.
fn fields(point: DVec3, frame: usize, _: usize) -> Vec<f32> {
    let smooth = (1.3 * point.x).sin() + 0.4 * point.y + 0.1 * point.z * point.z;
    let part = (point.x.floor() + 2.0 * point.y.floor()) as f32;
    vec![
        smooth as f32,
        (smooth + 0.001 * frame as f64) as f32,
        if part == 1.0 { MISSING_VALUE } else { part },
    ]
}

pub(crate) fn orrery(channels: usize) -> Capture {
    let spec = DemoSpec::new("orrery").cameras(4).frames(4).size((160, 120));
    let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
    let all = [channel("pressure", [-3.0, 3.0]), channel("drift", [-3.0, 3.0]), channel("part", [-8.0, 8.0])];
    match channels {
        0 => capture,
        1 => valued(capture, all[..1].to_vec(), |point, frame, camera| {
            fields(point, frame, camera)[..1].to_vec()
        }),
        _ => valued(capture, all.to_vec(), fields),
    }
}

/// How many samples there are, and how many values of them are missing. All have the bits of the first frame of their span.
fn compared_with_source(samples: &SampleSet, capture: &Capture) -> (usize, usize) {
    let (mut count, mut missing) = (0, 0);
    for image in &samples.images {
        let frame = capture.frame(image.camera as usize, image.span.start as usize).unwrap();
        let (width, _) = frame.size();
        assert_eq!(image.values.channels(), capture.value_channels().len());
        for sample in image.samples() {
            let source = frame.values.of(sample.y * width + sample.x).iter().map(|value| value.to_bits());
            let kept = image.values.of(sample.index).iter().map(|value| value.to_bits());
            assert!(source.eq(kept), "camera {}, {sample:?}", image.camera);
            count += 1;
            missing += image.values.of(sample.index).iter().filter(|value| value.is_nan()).count();
        }
    }
    (count, missing)
}

#[test]
fn every_kept_sample_has_its_source_s_values_bit_for_bit_in_the_set_and_in_the_store() {
    let folder = tempfile::tempdir().unwrap();
    let capture = orrery(3);
    for levels in [SpanLevels::Tree, SpanLevels::Paper] {
        let mut settings = Settings::default();
        settings.spans.levels = levels;
        let kept = preprocess(&capture, &settings, &Job::new()).unwrap().samples;
        let (count, missing) = compared_with_source(&kept, &capture);
        assert!(count > 10_000 && missing > 100, "{count} {missing}");
        let path = folder.path().join("scene.ovl");
        write(&path, &kept, "{}", &Job::new()).unwrap();
        let (stored, _) = read(&path, &Job::new()).unwrap();
        assert!(stored.values == capture.value_channels());
        let same = |(stored, kept): (&Arc<SampleImage>, &Arc<SampleImage>)| stored.values == kept.values;
        assert!(stored.images.iter().zip(&kept.images).all(same));
        assert_eq!(compared_with_source(&stored, &capture), (count, missing));
        let info = Store::open(&path).unwrap().info().clone();
        assert!(info.values.iter().all(|stored| stored.error == 0.0 && stored.bytes > 0));
    }
}

#[test]
fn a_capture_without_values_keeps_the_samples_and_the_bytes_that_it_has_without_any_channel() {
    let folder = tempfile::tempdir().unwrap();
    let [plain, valued] = [orrery(0), orrery(1)].map(|capture| {
        let kept = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples;
        let path = folder.path().join("scene.ovl");
        let bytes = write(&path, &kept, "{}", &Job::new()).unwrap();
        (kept, bytes)
    });
    assert!(plain.0.values.is_empty() && plain.0.images.iter().all(|image| image.values.is_empty()));
    assert!(valued.0.sample_count() >= plain.0.sample_count() && valued.1 > plain.1);
}

/// Bytes of the store of a capture with one value and without it, and how much its stored values differ at most.
fn bytes_with_and_without(capture: &Capture) -> (u64, u64, f32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ovl");
    let kept = preprocess(capture, &Settings::default(), &Job::new()).unwrap().samples;
    let with = write(&path, &kept, "{}", &Job::new()).unwrap();
    let (stored, _) = read(&path, &Job::new()).unwrap();
    let mut most: f32 = 0.0;
    for (stored, kept) in stored.images.iter().zip(&kept.images) {
        for (stored, kept) in stored.values.channel(0).zip(kept.values.channel(0)) {
            assert_eq!(stored.is_nan(), kept.is_nan());
            most = if kept.is_nan() { most } else { most.max((stored - kept).abs()) };
        }
    }
    let bare = |image: &Arc<SampleImage>| {
        Arc::new(SampleImage { values: Values::default(), ..SampleImage::clone(image) })
    };
    let images = kept.images.iter().map(bare).collect();
    let without = SampleSet { values: Vec::new(), images, ..SampleSet::clone(&kept) };
    (with, write(&path, &without, "{}", &Job::new()).unwrap(), most)
}

/// The crystal of spheres or the planets, with one value.
fn with_value(name: &str, is_exact: bool, field: Field) -> Capture {
    let spec = DemoSpec::new(name).cameras(4).frames(4).size((160, 120));
    let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
    valued(capture, vec![ValueChannel { is_exact, ..channel("pressure", [-3.0, 3.0]) }], field)
}

#[test]
fn a_smooth_value_within_half_its_tolerance_adds_at_most_fifteen_percent_of_bytes() {
    let smooth: Field = |point, frame, camera| fields(point, frame, camera)[..1].to_vec();
    let (with, without, most) = bytes_with_and_without(&with_value("orrery", false, smooth));
    println!("smooth, bounded: {with} bytes, {without} without, {most} off at most");
    assert!((with as f64) < 1.15 * without as f64, "{with} {without}");
    assert!(most > 0.0 && most <= 6.0 / 256.0 / 2.0 * 1.000_001, "{most}");
}

#[test]
fn labels_are_kept_bit_for_bit_for_at_most_fifteen_percent_of_bytes() {
    let label: Field = |point, _, _| vec![(point.x.floor() + 2.0 * point.y.floor()) as f32];
    let smooth: Field = |point, frame, camera| fields(point, frame, camera)[..1].to_vec();
    let linear: Field = |point, _, _| vec![(0.25 * point.x + 0.125 * point.y) as f32];
    for (name, field) in [("linear", linear), ("smooth", smooth)] {
        let (with, without, most) = bytes_with_and_without(&with_value("orrery", true, field));
        println!("{name}, exact: {with} bytes, {without} without, {most} off at most");
    }
    let (with, without, most) = bytes_with_and_without(&with_value("orrery", true, label));
    println!("label, exact: {with} bytes, {without} without");
    assert!((with as f64) < 1.15 * without as f64 && most == 0.0, "{with} {without} {most}");
}

/// Two cameras before a wall of one color, whose values differ from camera to camera.
struct Wall {
    apart: f32,
}

impl Wall {
    fn capture(apart: f32) -> Capture {
        let camera = |name: &str, x: f64| {
            let lens = Intrinsics::from_horizontal_angle(64, 48, 0.8);
            Camera::look_at(name, lens, DVec3::new(x, -4.0, 0.0), DVec3::new(x, 0.0, 0.0), DVec3::Z)
        };
        let parts = CaptureParts {
            name: "wall".to_owned(),
            cameras: vec![camera("left", 0.0), camera("right", 0.0)],
            frame_numbers: vec![0],
            up_in_world: DVec3::Z,
            has_normals: true,
            antialiased_color: false,
            warnings: Vec::new(),
            source: Arc::new(Self { apart }),
        };
        Capture::new(parts, 1 << 24)
    }
}

impl FrameSource for Wall {
    fn load(&self, camera: usize, _: usize) -> Result<Frame> {
        let value = if camera == 0 { 1.0 } else { 1.0 + self.apart };
        Ok(Frame {
            color: Grid::filled(64, 48, [f16::from_f32(0.5); 3]),
            inverse_depth: Grid::filled(64, 48, 0.25),
            normal_in_world: Some(Grid::filled(64, 48, [0.0, -1.0, 0.0])),
            depth_step_relative: 0.0,
            values: Values::from_planes(&[vec![value; 64 * 48]]),
        })
    }

    fn place(&self, camera: usize, _: usize) -> String {
        format!("wall, camera {camera}")
    }

    fn value_channels(&self) -> &[ValueChannel] {
        static CHANNELS: std::sync::LazyLock<[ValueChannel; 1]> =
            std::sync::LazyLock::new(|| [channel("pressure", [0.0, 256.0])]);
        &*CHANNELS
    }
}

#[test]
fn two_surfaces_that_agree_in_color_and_depth_but_not_in_value_are_both_kept() {
    let kept = |apart: f32| {
        preprocess(&Wall::capture(apart), &Settings::default(), &Job::new()).unwrap().samples.sample_count()
    };
    let pixels = 64 * 48;
    // The tolerance is 1.
    assert!(kept(0.0) < pixels * 5 / 4 && kept(0.9) == kept(0.0), "{} {}", kept(0.0), kept(0.9));
    assert_eq!([kept(1.5), kept(MISSING_VALUE)], [2 * pixels; 2]);
}

#[test]
fn a_capture_that_is_written_and_opened_again_has_the_same_values() {
    let folder = tempfile::tempdir().unwrap();
    let capture = orrery(3);
    write_capture(folder.path(), &capture, &[], &Job::new()).unwrap();
    let again = open(folder.path(), &CaptureSettings::default()).unwrap();
    assert_eq!(again.value_channels(), capture.value_channels());
    for (camera, frame) in [(0, 0), (3, 2)] {
        let [a, b] = [&capture, &again].map(|capture| capture.frame(camera, frame).unwrap());
        assert_eq!(a.values, b.values);
    }
}

#[test]
fn a_rendered_pixel_shows_the_values_of_one_sample_in_layers_arrays_and_colors() {
    let capture = orrery(3);
    let kept = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples;
    let mut camera = capture.cameras[0].clone();
    camera.world_from_camera.translation += DVec3::new(0.2, 0.1, 0.1);
    let vantage = Vantage { camera, frame: 1 };
    let settings = Settings::default().render;
    let (picture, _) = CpuRenderer::new().render(&kept, &vantage, &settings, &Job::new()).unwrap();
    let values = PictureValues::of(&kept, &vantage, &picture);
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<u32>>();
    let of_image = |image: &Arc<SampleImage>| {
        (0..image.len()).map(|index| bits(image.values.of(index))).collect::<Vec<_>>()
    };
    let sampled: HashSet<Vec<u32>> = kept.images_at(1).flat_map(of_image).collect();
    let missing = bits(&[MISSING_VALUE; 3]);
    let mut shown = 0;
    for (pixel, image) in picture.image.as_slice().iter().enumerate() {
        let found = bits(values.values.of(pixel));
        assert!(found == missing || (*image != NO_IMAGE && sampled.contains(&found)), "pixel {pixel}");
        shown += usize::from(found != missing);
    }
    assert!(shown > 160 * 120 / 2, "{shown}");

    let folder = tempfile::tempdir().unwrap();
    let [array, layers, colored] = ["a.npy", "a.exr", "a.png"].map(|name| folder.path().join(name));
    write_npy(&array, &picture, &values, 0).unwrap();
    let read = parse_npy(&std::fs::read(&array).unwrap(), "array").unwrap();
    assert!(
        read.size == (160, 120)
            && Values::from_planes(&[read.values])
                .channel(0)
                .map(f32::to_bits)
                .eq(values.values.channel(0).map(f32::to_bits))
    );
    write_exr_with_values(&layers, &picture, &values).unwrap();
    let file = ExrFile::open(&layers, "layers").unwrap();
    let layer = file.channels().iter().position(|channel| channel.name == "value.part").unwrap();
    let plane = file.decode(&[layer], file.window(None).unwrap()).unwrap().remove(0).into_single();
    assert!(plane.iter().map(|value| value.to_bits()).eq(values.values.channel(2).map(f32::to_bits)));
    let colors = ValueColors::new(Colormap::Viridis, ValueScale::Linear, [-3.0, 3.0]).unwrap();
    write_png(&colored, &values.colored(&picture, 0, &colors)).unwrap();
    let png = image::open(&colored).unwrap().to_rgba8();
    let of_value = values.values.channel(0).map(|value| colors.color(value));
    assert!(png.pixels().zip(of_value).all(|(pixel, color)| pixel[3] < 255 || pixel.0[..3] == color));
    let error = ValueChannel::named(&values.channels, "speed", "scene.ovl").unwrap_err().to_string();
    assert!(error.contains("pressure, drift, part") && !error.contains('\n'), "{error}");
}

/// An array of `NumPy`.
fn npy(path: &Path, descr: &str, (width, height): (usize, usize), values: &[u8]) {
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({height}, {width}), }}");
    while (10 + header.len()) % 64 != 63 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values);
    std::fs::write(path, bytes).unwrap();
}

/// Opens a capture of one picture of 8×6 pixels whose manifest has these values and this file of them.
fn opened(folder: &Path, values: &str, file: &str) -> std::result::Result<Capture, String> {
    let path = folder.join("transforms.json");
    let mut manifest: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("original.json")).unwrap()).unwrap();
    manifest["values"] = serde_json::from_str(values).unwrap();
    for entry in manifest["frames"].as_array_mut().unwrap() {
        entry["value_file_paths"] = serde_json::from_str(file).unwrap();
    }
    std::fs::write(&path, manifest.to_string()).unwrap();
    open(&path, &CaptureSettings::default()).map_err(|error| error.to_string())
}

#[test]
fn arrays_of_numpy_are_read_to_the_last_bit_and_what_is_wrong_with_them_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let spec = DemoSpec::new("orrery").cameras(1).frames(1).size((8, 6));
    let demo = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
    write_capture(folder.path(), &demo, &[], &Job::new()).unwrap();
    std::fs::rename(folder.path().join("transforms.json"), folder.path().join("original.json")).unwrap();
    let values: Vec<f32> = (0..48).map(|i| if i == 5 { f32::NAN } else { 0.1 * i as f32 }).collect();
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    npy(&folder.path().join("p.npy"), "<f4", (8, 6), &bytes);
    npy(&folder.path().join("small.npy"), "<f4", (6, 4), &bytes);
    npy(&folder.path().join("double.npy"), "<f8", (8, 6), &[0; 8 * 48]);
    npy(&folder.path().join("large.npy"), "<i4", (8, 6), &20_000_000_i32.to_le_bytes().repeat(48));
    npy(&folder.path().join("empty.npy"), "<f4", (8, 6), &f32::NAN.to_le_bytes().repeat(48));
    let good = opened(folder.path(), r#"[{"name": "p", "unit": "Pa"}]"#, r#"{"p": "p.npy"}"#).unwrap();
    assert!(good.frame(0, 0).unwrap().values == Values::from_planes(&[values]));
    let expected = ValueChannel {
        name: "p".into(),
        unit: "Pa".into(),
        range: [0.0, 0.1 * 47.0_f32],
        tolerance: (f64::from(0.1 * 47.0_f32) / 256.0) as f32,
        is_exact: true,
    };
    assert_eq!(good.value_channels(), [expected]);
    assert!(opened(folder.path(), r#"[{"name": "p"}]"#, r#"{"p": "double.npy"}"#).is_ok(), "it is rounded");
    for (values, file, named) in [
        (r#"[{"name": "p"}]"#, r#"{"p": "small.npy"}"#, "6×4"),
        (r#"[{"name": "p"}]"#, r#"{"p": "large.npy"}"#, "float32"),
        (r#"[{"name": "p"}]"#, r#"{"p": "none.npy"}"#, "none.npy is missing"),
        (r#"[{"name": "p"}]"#, r#"{"p": "empty.npy"}"#, "give its \"range\""),
        (r#"[{"name": "p"}]"#, r#"{"q": "p.npy"}"#, "'q'"),
        (r#"[{"name": "p"}]"#, "{}", "no channel 'p'"),
        (r#"[{"name": "p", "range": [2, 2]}]"#, r#"{"p": "p.npy"}"#, "[2, 2]"),
        (r#"[{"name": "p", "tolerance": -1}]"#, r#"{"p": "p.npy"}"#, "tolerance"),
        (r#"[{"name": "p"}, {"name": "p"}]"#, r#"{"p": "p.npy"}"#, "two values"),
        (r#"[{"name": ""}]"#, r#"{"": "p.npy"}"#, "no name"),
        (r#"[{"name": "a"}, {"name": "b"}, {"name": "c"}, {"name": "d"}, {"name": "e"}]"#, "{}", "at most 4"),
        (r#"[{"unit": "Pa"}]"#, "{}", "name"),
    ] {
        let error = opened(folder.path(), values, file).unwrap_err();
        assert!(error.contains(named) && !error.contains('\n'), "{values} {file}: {error}");
    }
}
