//! What poses and depth mean is found by the agreement between views: under every convention of an analytic scene, with and
//! without noise.

use std::sync::Arc;

use crate::scene::{Scene, Sphere};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use overlook_engine::capture::conventions::{
    CameraAxes, ConventionVerdict, DepthMeasure, Finding, PoseConvention, PoseDirection, ReadingPart, check,
    pictures,
};
use overlook_engine::capture::transforms::{self, write_capture};
use overlook_engine::capture::{Camera, Capture, CaptureParts, Frame, FrameSource, Intrinsics, Source};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;
use rayon::prelude::*;
use serde_json::{Value, json};

const UNITS: [f64; 5] = [1.0, 1e-3, 1e-2, 1.0 / 5000.0, 1e-4];

/// How a file was written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Export {
    pub(crate) pose: PoseConvention,
    pub(crate) measure: DepthMeasure,
    pub(crate) unit: f64,
}

/// Frames of a capture whose files are of one convention, and are read as nerfstudio's in meters.
struct Misread {
    frames: Arc<Vec<Frame>>,
    cameras: Vec<Camera>,
    export: Export,
}

impl FrameSource for Misread {
    fn load(&self, camera: usize, _: usize) -> Result<Frame> {
        let mut read = self.frames[camera].clone();
        let intrinsics = self.cameras[camera].intrinsics;
        let width = intrinsics.size().0;
        for (index, inverse) in read.inverse_depth.as_mut_slice().iter_mut().enumerate() {
            let pixel = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let ray = intrinsics.ray_in_camera(pixel).length();
            let along_ray = self.export.measure == DepthMeasure::RayDistance;
            // The number in the file is z, or z times the ray's length, in its unit; it is taken for z in meters.
            let factor = if along_ray { ray } else { 1.0 } / self.export.unit;
            *inverse = (f64::from(*inverse) / factor) as f32;
        }
        Ok(read)
    }

    fn place(&self, camera: usize, _: usize) -> String {
        format!("camera {camera}")
    }
}

/// A room's corner with things in it, so that no direction looks like another.
pub(crate) fn corner(depth_noise: f32) -> Scene {
    let mut scene = Scene::still_life();
    scene.normals = false;
    scene.depth_noise = depth_noise;
    scene.spheres.push(Sphere::resting(DVec3::new(-1.3, 0.7, 0.9), 0.5, [0.2, 0.3, 0.7]));
    scene.spheres.push(Sphere::resting(DVec3::new(0.4, -1.2, 0.25), 0.25, [0.6, 0.6, 0.1]));
    scene.spheres.push(Sphere::resting(DVec3::new(1.0, 9.0, 3.0), 5.0, [0.4, 0.6, 0.1]));
    scene
}

/// Four cameras of different height and turn around it, with wide lenses.
fn cameras() -> Vec<Camera> {
    let intrinsics = Intrinsics::from_horizontal_angle(64, 48, 1.25);
    let eyes = [(-2.6, -2.9, 1.4), (-0.6, -3.5, 2.3), (1.2, -3.1, 1.1), (2.7, -1.9, 1.9)];
    let camera = |(index, eye): (usize, &(f64, f64, f64))| {
        let target = DVec3::new(0.15 * index as f64 - 0.2, 0.1, 0.4);
        Camera::look_at(format!("c{index}"), intrinsics, DVec3::from(*eye), target, DVec3::new(0.1, 0.0, 1.0))
    };
    eyes.iter().enumerate().map(camera).collect()
}

fn recorded(depth_noise: f32) -> (Vec<Camera>, Arc<Vec<Frame>>) {
    let (scene, cameras) = (corner(depth_noise), cameras());
    let frames = cameras.iter().enumerate().map(|(seed, camera)| scene.trace(camera, 0, seed)).collect();
    (cameras, Arc::new(frames))
}

pub(crate) fn read_as_nerfstudio(cameras: &[Camera], frames: &Arc<Vec<Frame>>, export: Export) -> Capture {
    let cameras: Vec<Camera> = cameras
        .iter()
        .map(|camera| {
            let matrix = export.pose.matrix(&camera.world_from_camera);
            let world_from_camera = PoseConvention::default().world_from_camera(&matrix);
            Camera { world_from_camera, ..camera.clone() }
        })
        .collect();
    let source = Misread { frames: Arc::clone(frames), cameras: cameras.clone(), export };
    let parts = CaptureParts {
        name: "misread".to_owned(),
        frame_numbers: vec![0],
        up_in_world: DVec3::Z,
        has_normals: false,
        antialiased_color: false,
        warnings: Vec::new(),
        source: Arc::new(source),
        cameras,
    };
    Capture::new(parts, 64 << 20)
}

fn every_export() -> Vec<Export> {
    let mut exports = Vec::new();
    for axes in CameraAxes::all() {
        for direction in [PoseDirection::CameraToWorld, PoseDirection::WorldToCamera] {
            for measure in [DepthMeasure::PlanarZ, DepthMeasure::RayDistance] {
                let pose = PoseConvention { direction, axes };
                exports.extend(UNITS.iter().map(|&unit| Export { pose, measure, unit }));
            }
        }
    }
    exports
}

/// Whether a finding names the export, part by part, or says of a part that it cannot tell.
fn wrong_parts(export: &Export, finding: &Finding) -> Vec<ReadingPart> {
    let (reading, undecided) = match &finding.verdict {
        ConventionVerdict::Stands { undecided } => (finding.claimed, undecided.clone()),
        ConventionVerdict::Other(other) => (other.reading, other.undecided.clone()),
        ConventionVerdict::Unknown { .. } => return Vec::new(),
    };
    let parts = [
        (ReadingPart::Pose, reading.pose == export.pose),
        (ReadingPart::Measure, reading.measure == export.measure),
        (ReadingPart::Unit, (reading.unit / export.unit - 1.0).abs() < 1e-6),
    ];
    let is_open = |part: ReadingPart| {
        undecided.iter().any(|undecided| undecided.part == part && !undecided.why.is_empty())
    };
    parts.into_iter().filter(|(part, right)| !right && !is_open(*part)).map(|(part, _)| part).collect()
}

fn is_decided(finding: &Finding) -> bool {
    match &finding.verdict {
        ConventionVerdict::Stands { undecided } => undecided.is_empty(),
        ConventionVerdict::Other(other) => other.undecided.is_empty(),
        ConventionVerdict::Unknown { .. } => false,
    }
}

fn under_every_convention(depth_noise: f32, least_decided: usize) {
    let (cameras, frames) = recorded(depth_noise);
    let findings: Vec<(Export, Finding)> = every_export()
        .into_par_iter()
        .map(|export| (export, check(&read_as_nerfstudio(&cameras, &frames, export)).unwrap()))
        .collect();
    assert_eq!(findings.len(), 48 * 2 * 2 * 5);
    for (export, finding) in &findings {
        let wrong = wrong_parts(export, finding);
        assert!(wrong.is_empty(), "{export:?}: {wrong:?}: {}: {finding:?}", finding.sentence());
        let is_as_read = export.pose == PoseConvention::default()
            && export.measure == DepthMeasure::PlanarZ
            && export.unit == 1.0;
        assert_eq!(finding.warning().is_none(), is_as_read, "{export:?}: {}", finding.sentence());
    }
    let decided = findings.iter().filter(|(_, finding)| is_decided(finding)).count();
    assert!(decided >= least_decided, "{decided} of {}", findings.len());
}

#[test]
fn every_convention_of_exact_depth_is_named() {
    under_every_convention(0.0, 960);
}

#[test]
fn every_convention_of_depth_with_one_percent_of_noise_is_named() {
    under_every_convention(0.01, 960);
}

#[test]
fn a_finding_names_the_keys_that_correct_it() {
    let (cameras, frames) = recorded(0.0);
    let pose = PoseConvention { direction: PoseDirection::WorldToCamera, axes: CameraAxes::OPENCV };
    let export = Export { pose, measure: DepthMeasure::RayDistance, unit: 1e-3 };
    let warning = check(&read_as_nerfstudio(&cameras, &frames, export)).unwrap().warning().unwrap();
    for part in [
        "\"transform_direction\": \"world_to_camera\"",
        "\"camera_axes\": [\"right\", \"down\", \"forward\"]",
        "\"depth_kind\": \"ray_distance\"",
        "\"depth_unit_scale_factor\": 0.001",
    ] {
        assert!(warning.contains(part), "{warning}");
    }
    assert!(!warning.contains('\n'), "{warning}");
}

/// Writes the scene as files, with the manifest changed.
fn written(change: impl Fn(&mut Value)) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let capture = corner(0.0).record(cameras(), 1);
    write_capture(folder.path(), &capture, &[], &Job::new()).unwrap();
    let path = folder.path().join("transforms.json");
    let mut manifest: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    change(&mut manifest);
    std::fs::write(&path, manifest.to_string()).unwrap();
    folder
}

fn open(folder: &tempfile::TempDir) -> Result<Capture> {
    transforms::open(folder.path(), &CaptureSettings::default())
}

fn change_matrices(manifest: &mut Value, export: PoseConvention) {
    for entry in manifest["frames"].as_array_mut().unwrap() {
        let rows: Vec<Vec<f64>> = serde_json::from_value(entry["transform_matrix"].clone()).unwrap();
        let column = |column: usize| DVec3::new(rows[0][column], rows[1][column], rows[2][column]);
        let matrix = DMat3::from_cols(column(0), column(1), column(2));
        let pose = DAffine3::from_mat3_translation(matrix, column(3));
        let changed = export.matrix(&PoseConvention::default().world_from_camera(&pose));
        let row = |row: usize| {
            let matrix = changed.matrix3.row(row);
            json!([matrix.x, matrix.y, matrix.z, changed.translation[row]])
        };
        entry["transform_matrix"] = json!([row(0), row(1), row(2), [0, 0, 0, 1]]);
    }
}

/// Where the other cameras stand as the first one sees them, which no change of the world changes.
fn seen_from_the_first(capture: &Capture) -> Vec<DAffine3> {
    let first = capture.cameras[0].camera_from_world();
    capture.cameras.iter().map(|camera| first * camera.world_from_camera).collect()
}

/// Writes the keys that a sentence names into the manifest.
fn write_named_keys(manifest: &mut Value, sentence: &str) {
    for key in ["transform_direction", "camera_axes", "depth_kind", "depth_unit_scale_factor"] {
        let Some((_, value)) = sentence.split_once(&format!("\"{key}\": ")) else { continue };
        manifest[key] =
            serde_json::Deserializer::from_str(value).into_iter::<Value>().next().unwrap().unwrap();
    }
}

/// The key that tells of a mistake, and the mistake.
type Plant = (&'static str, Box<dyn Fn(&mut Value)>);

#[test]
fn a_wrong_key_is_named_and_what_is_named_corrects_the_capture() {
    let right = written(|_| {});
    let truth = open(&right).unwrap();
    assert_eq!(check(&truth).unwrap().warning(), None);
    let inverse = PoseConvention { direction: PoseDirection::WorldToCamera, ..PoseConvention::default() };
    let opencv = PoseConvention { axes: CameraAxes::OPENCV, ..PoseConvention::default() };
    let unity: CameraAxes = serde_json::from_value(json!(["right", "up", "forward"])).unwrap();
    let unity = PoseConvention { axes: unity, ..PoseConvention::default() };
    let plants: [Plant; 6] = [
        ("depth_kind", Box::new(|manifest| manifest["depth_kind"] = json!("ray_distance"))),
        ("depth_unit_scale_factor", Box::new(|manifest| manifest["depth_unit_scale_factor"] = json!(0.01))),
        ("transform_direction", Box::new(move |manifest| change_matrices(manifest, inverse))),
        ("camera_axes", Box::new(move |manifest| change_matrices(manifest, opencv))),
        ("camera_axes", Box::new(|manifest| manifest["camera_axes"] = json!(["right", "forward", "up"]))),
        ("camera_axes", Box::new(move |manifest| change_matrices(manifest, unity))),
    ];
    for (key, plant) in plants {
        let folder = written(|manifest| plant(manifest));
        // Poses that mirror do not open, but are told of by the same words.
        let told = match open(&folder) {
            Ok(capture) => check(&capture).unwrap().warning().unwrap(),
            Err(error) => error.to_string(),
        };
        assert!(told.contains(&format!("\"{key}\": ")) && !told.contains('\n'), "{key}: {told}");
        let correct = written(|manifest| {
            plant(manifest);
            write_named_keys(manifest, &told);
        });
        let corrected = open(&correct).unwrap();
        assert_eq!(check(&corrected).unwrap().warning(), None, "{told}");
        let same = seen_from_the_first(&truth).into_iter().zip(seen_from_the_first(&corrected));
        assert!(same.into_iter().all(|(a, b)| a.abs_diff_eq(b, 1e-9)), "{told}");
        assert!(corrected.cameras.iter().all(|c| c.world_from_camera.matrix3.determinant() > 0.0));
    }
}

/// How far the colors of other views lie from what the camera recorded, in the middle of the pixels that they show, and the share of
/// those pixels.
fn distance_from_recorded(
    recorded: &overlook_engine::grid::Grid<[f32; 3]>,
    shown: &overlook_engine::grid::Grid<Option<[f32; 3]>>,
) -> (f32, f64) {
    let both = recorded.as_slice().iter().zip(shown.as_slice());
    let mut apart: Vec<f32> = both
        .filter_map(|(recorded, shown)| {
            let shown = shown.as_ref()?;
            Some(recorded.iter().zip(shown).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max))
        })
        .collect();
    apart.sort_unstable_by(f32::total_cmp);
    (apart.get(apart.len() / 2).copied().unwrap_or(f32::MAX), apart.len() as f64 / recorded.len() as f64)
}

#[test]
fn pictures_of_two_readings_show_which_is_right_and_reading_otherwise_leaves_the_files_alone() {
    let opencv = PoseConvention { axes: CameraAxes::OPENCV, ..PoseConvention::default() };
    let folder = written(|manifest| change_matrices(manifest, opencv));
    let before = std::fs::read(folder.path().join("transforms.json")).unwrap();
    let misread = open(&folder).unwrap();
    let finding = check(&misread).unwrap();
    let other = finding.alternative().unwrap();
    assert!(other.can_be_written(&finding.claimed));
    let pictures = pictures(&misread, [finding.claimed, other.reading], 40).unwrap();
    assert_eq!(pictures.recorded.size(), (40, 30));
    let [as_read, otherwise] = &pictures.readings;
    let (apart, shown) = distance_from_recorded(&pictures.recorded, &otherwise.color);
    assert!(apart < 0.03 && shown > 0.5, "{apart} {shown}");
    let (apart_as_read, shown_as_read) = distance_from_recorded(&pictures.recorded, &as_read.color);
    assert!(apart_as_read > 3.0 * apart || shown_as_read < 0.5 * shown, "{apart_as_read} {shown_as_read}");
    assert!(otherwise.agree > 0.5 && otherwise.contradict < 0.02 && as_read.agree < 0.2, "{otherwise:?}");
    let source = Source::find(folder.path()).unwrap();
    assert_eq!(source.manifest(), Some(folder.path().join("transforms.json").as_path()));
    let reread = source.read_as(&other.keys).unwrap().open(&CaptureSettings::default()).unwrap();
    assert_eq!(check(&reread).unwrap().warning(), None);
    assert_eq!(std::fs::read(folder.path().join("transforms.json")).unwrap(), before);
}

#[test]
fn what_views_cannot_tell_is_said_and_why() {
    let (cameras, frames) = recorded(0.0);
    let as_read = Export { pose: PoseConvention::default(), measure: DepthMeasure::PlanarZ, unit: 1.0 };
    let one = read_as_nerfstudio(&cameras[..1], &frames, as_read);
    assert!(check(&one).unwrap().sentence().contains("one view only"));
    // A camera that only turns says nothing about units, and is not accused of a wrong one.
    let mut turning = cameras.clone();
    for (index, camera) in turning.iter_mut().enumerate() {
        let turn = DMat3::from_euler(glam::EulerRot::YXZ, 0.2 * index as f64, 0.1 * index as f64, 0.05);
        camera.world_from_camera = cameras[0].world_from_camera * DAffine3::from_mat3(turn);
    }
    let frames: Vec<Frame> = turning.iter().map(|camera| corner(0.0).trace(camera, 0, 0)).collect();
    let finding =
        check(&read_as_nerfstudio(&turning, &Arc::new(frames), Export { unit: 1e-3, ..as_read })).unwrap();
    assert_eq!(finding.warning(), None);
    let ConventionVerdict::Stands { undecided } = &finding.verdict else { panic!("{finding:?}") };
    assert!(
        undecided.iter().any(|open| open.part == ReadingPart::Unit && open.why.contains("close together")),
        "{finding:?}"
    );
}

#[test]
fn views_that_share_nothing_give_no_verdict() {
    let (mut cameras, frames) = recorded(0.0);
    for (index, camera) in cameras.iter_mut().enumerate() {
        camera.world_from_camera.translation += DVec3::new(0.0, 0.0, 1e4 * index as f64);
    }
    let as_read = Export { pose: PoseConvention::default(), measure: DepthMeasure::PlanarZ, unit: 1.0 };
    let finding = check(&read_as_nerfstudio(&cameras, &frames, as_read)).unwrap();
    assert_eq!(finding.warning(), None, "{}", finding.sentence());
    assert!(finding.sentence().contains("cannot be checked"), "{}", finding.sentence());
}
