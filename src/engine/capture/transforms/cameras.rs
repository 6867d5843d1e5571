//! Who recorded which frame: entries of the manifest grouped by camera and time.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use glam::DAffine3;

use super::files::{PictureFiles, named_path};
use super::header_probe::{HeaderFacts, probe};
use super::left_out::{self, LeftOut, Posed, UNREADABLE};
use super::manifest::{Keys, Manifest, PictureEntry};
use super::manifest_file::ManifestOrigin;
use super::placed_entry::PlacedEntry;
use super::same_camera::{SimilarNames, is_absolute, refuse_motion};
use super::{frame_numbers, pose, value_places};
use crate::capture::camera::Camera;
use crate::capture::parts::Skipped;
use crate::capture::pictures::RayCache;
use crate::capture::pose_convention::upright;
use crate::error::{Error, Result};

/// A camera that moves by more than this, relative to the distance from the origin, is warned of.
const WARNED_MOTION: f64 = 1e-9;

/// All entries in the manifest's order, each with camera and frame.
pub(super) fn entries(manifest: &Manifest, origin: &ManifestOrigin) -> Result<Vec<PlacedEntry>> {
    let ManifestOrigin { path, folder } = origin;
    let keys: Vec<Keys> = manifest.frames.iter().map(|entry| entry.keys.clone().or(&manifest.keys)).collect();
    let poses: Vec<DAffine3> = manifest
        .frames
        .iter()
        .enumerate()
        .map(|(index, entry)| {
            let place = pose::place_of(origin, index, &entry.file_path);
            pose::world_from_camera(&entry.transform_matrix, keys[index].pose_convention(), &place)
        })
        .collect::<Result<_>>()?;
    let mirrored = poses.iter().filter(|pose| pose.matrix3.determinant() < 0.0).count();
    if mirrored != 0 && mirrored != poses.len() {
        let what = "some poses mirror and some do not; export all of them alike";
        return Err(Error::invalid(path.display(), what));
    }
    let poses: Vec<DAffine3> = poses.into_iter().map(upright).collect();
    let names = camera_names(&keys, &poses, path)?;
    let numbers = frame_numbers::frame_numbers(&keys, &manifest.frames, &names, path)?;
    let rays = RayCache::default();
    let similar = SimilarNames::default();
    let mut placed = Vec::with_capacity(keys.len());
    for (index, (keys, entry)) in keys.into_iter().zip(&manifest.frames).enumerate() {
        let (camera_name, number) = (names[index].clone(), numbers[index]);
        let mut files = picture_files(folder, entry, &keys, path, &similar)?;
        files.rays = rays.clone();
        placed.push(PlacedEntry {
            file_path: entry.file_path.clone(),
            place: format!("{} (camera '{camera_name}', frame {number})", files.color.display()),
            camera_name,
            number,
            files,
            keys,
            is_left_out: false,
            world_from_camera: poses[index],
        });
    }
    Ok(placed)
}

fn picture_files(
    folder: &Path,
    entry: &PictureEntry,
    keys: &Keys,
    manifest: &Path,
    similar: &SimilarNames,
) -> Result<PictureFiles> {
    let resolve =
        |file_path: &Option<String>| file_path.as_ref().map(|name| named_path(folder, name, &[], similar));
    let [depth, normal] = [resolve(&entry.depth_file_path), resolve(&entry.normal_file_path)];
    let others: Vec<&Path> = [&depth, &normal].into_iter().flatten().map(PathBuf::as_path).collect();
    let color = named_path(folder, &entry.file_path, &others, similar);
    let apart = |path: Option<PathBuf>| path.filter(|path| *path != color);
    let place = format!("{} ({})", manifest.display(), entry.file_path);
    let [confidence, mask] = [resolve(&entry.confidence_file_path), resolve(&entry.mask_path)];
    let mut files = PictureFiles::new(color.clone(), apart(depth), apart(normal), keys, &place)?;
    (files.confidence, files.mask) = (confidence, mask);
    files.values = value_places::files(entry, keys, &place, |name| named_path(folder, name, &[], similar))?;
    Ok(files)
}

/// The name of every entry's camera: the manifest's, or one for each distinct pose in order of appearance.
fn camera_names(keys: &[Keys], poses: &[DAffine3], path: &Path) -> Result<Vec<String>> {
    let named = keys.iter().filter(|keys| keys.camera.is_some()).count();
    let mut names = keys.iter().filter_map(|keys| keys.camera.as_ref());
    if let Some(name) = names.find(|name| name.contains(char::is_control)) {
        let problem = format!("camera {name:?} has control characters in its name; leave them out");
        return Err(Error::invalid(path.display(), problem));
    }
    if named == keys.len() {
        return Ok(keys.iter().filter_map(|keys| keys.camera.clone()).collect());
    }
    if named > 0 {
        return Err(Error::invalid(
            path.display(),
            "some entries name a \"camera\" and some do not; name it in all of them",
        ));
    }
    // Exact equality: a camera that does not move is written with the same digits every time, and two close
    // viewpoints of a hand-held camera are two cameras.
    let mut index_of_pose: BTreeMap<[u64; 12], usize> = BTreeMap::new();
    let names = poses.iter().map(|pose| {
        let count = index_of_pose.len();
        let bits = pose.to_cols_array().map(f64::to_bits);
        format!("cam{}", *index_of_pose.entry(bits).or_insert(count))
    });
    Ok(names.collect())
}

/// All pictures of all cameras, every camera with the same frames.
pub(super) struct CameraFiles {
    /// In order of appearance.
    pub cameras: Vec<Camera>,
    /// Ascending.
    pub frame_numbers: Vec<i64>,
    /// Whether these are the order of times that are fractions.
    pub is_ranked: bool,
    /// By camera, then by frame.
    pub entries: Vec<Vec<PlacedEntry>>,
    /// Recoverable trouble.
    pub warnings: Vec<String>,
}

impl CameraFiles {
    /// Groups the entries of a manifest. Every file is looked for; pictures that cannot be used are left out with a warning.
    ///
    /// # Errors
    /// `Invalid` for a camera without one of the frames, or with one twice, and where no picture is left; `Unsupported` for a camera
    /// that moves.
    pub(super) fn group(manifest: &Manifest, origin: &ManifestOrigin) -> Result<Self> {
        let path = &origin.path;
        let mut warnings = Vec::new();
        let is_ranked = frame_numbers::are_ranked(manifest);
        if is_ranked {
            warnings.push(format!(
                "{}: times are fractions; frames are numbered by their order instead, and views name these numbers as \"frame\"",
                path.display()
            ));
        }
        warnings.extend(names_of_another_machine(manifest, origin));
        let Posed { manifest, faults, skipped } = left_out::with_possible_poses(manifest, origin)?;
        let mut left_out = LeftOut::new(skipped);
        let mut entries = entries(&manifest, origin)?;
        left_out.by_pose(&mut entries, faults);
        if entries.iter().all(|entry| entry.keys.frame.or(entry.keys.time).is_none()) {
            let names: Vec<String> = entries.iter().map(|entry| entry.camera_name.clone()).collect();
            warnings.extend(frame_numbers::pairing(&manifest.frames, &names, path)?);
        }
        let times =
            entries.iter().filter(|_| is_ranked).filter_map(|entry| Some((entry.number, entry.keys.time?)));
        let times = times.collect();
        let are_unnamed = entries.iter().all(|entry| entry.keys.camera.is_none());
        let (order, mut by_camera) = by_camera(entries)?;
        let numbers: BTreeSet<i64> = by_camera.values().flat_map(BTreeMap::keys).copied().collect();
        if !are_unnamed && !is_ranked {
            left_out.fill_gaps(&mut by_camera, &numbers);
        }
        for name in &order {
            let lacks = |number: &&i64| !by_camera[name].contains_key(number);
            if let Some(missing) = numbers.iter().find(lacks) {
                let poses = are_unnamed.then_some(order.len());
                return Err(no_such_frame(name, *missing, &times, poses, path));
            }
        }
        let frame_numbers = left_out.by_files(&order, &mut by_camera)?;
        warnings.extend(left_out.lines());
        let (cameras, entries) = (Vec::new(), Vec::new());
        let mut recording = Self { cameras, frame_numbers, is_ranked, entries, warnings };
        let mut unreadable = Vec::new();
        for name in &order {
            let frames = by_camera.remove(name).unwrap_or_default();
            match recording.add_camera(name, frames) {
                Err(error) if recording.is_of_one_frame() => unreadable.push(error),
                added => added?,
            }
        }
        recording.leave_out_unreadable(unreadable)?;
        Ok(recording)
    }

    /// Whether every camera has one picture, so that one that cannot be read leaves the others as they are.
    fn is_of_one_frame(&self) -> bool {
        self.frame_numbers.len() == 1
    }

    /// Notes pictures that cannot be read, which are cameras no more.
    ///
    /// # Errors
    /// The first one's, if no other picture is left.
    fn leave_out_unreadable(&mut self, errors: Vec<Error>) -> Result<()> {
        let mut skipped = Vec::new();
        for error in &errors {
            Skipped::note(&mut skipped, UNREADABLE, error.to_string());
        }
        self.warnings.extend(skipped.iter().map(Skipped::line));
        errors.into_iter().next().filter(|_| self.cameras.is_empty()).map_or(Ok(()), Err)
    }

    /// What the headers of each camera's first picture tell. A camera whose only picture cannot be read is left out.
    ///
    /// # Errors
    /// Whatever makes a picture unreadable: no color, no depth, another size.
    pub(super) fn probe(&mut self) -> Result<Vec<HeaderFacts>> {
        let probes = self.cameras.iter().zip(self.first_read());
        let probes: Vec<Result<HeaderFacts>> =
            probes.map(|(camera, first)| probe(&first.files, camera, &first.place)).collect();
        if !self.is_of_one_frame() {
            return probes.into_iter().collect();
        }
        let mut is_readable = probes.iter().map(Result::is_ok).collect::<Vec<_>>().into_iter();
        let mut is_kept = is_readable.clone();
        self.cameras.retain(|_| is_readable.next().unwrap_or(false));
        self.entries.retain(|_| is_kept.next().unwrap_or(false));
        let (found, errors): (Vec<_>, Vec<_>) = probes.into_iter().partition(Result::is_ok);
        self.leave_out_unreadable(errors.into_iter().filter_map(Result::err).collect())?;
        found.into_iter().collect()
    }

    fn add_camera(&mut self, name: &str, frames: BTreeMap<i64, PlacedEntry>) -> Result<()> {
        let frames: Vec<PlacedEntry> = frames.into_values().collect();
        let mut read = frames.iter().filter(|entry| !entry.is_left_out);
        let Some(first) = read.next() else { return Ok(()) };
        let camera = first.camera()?;
        let size = camera.intrinsics.size();
        let mut moved: f64 = 0.0;
        for entry in read {
            let other = entry.camera_of_size(|| Ok(size), || camera.intrinsics.fy / camera.intrinsics.fx)?;
            refuse_motion(&camera, &other, first.number, &entry.place)?;
            moved = moved.max(camera.position_in_world().distance(other.position_in_world()));
        }
        if moved > WARNED_MOTION * camera.position_in_world().length().max(1.0) {
            self.warnings.push(format!(
                "camera '{name}' moves by up to {moved:.1e} units; that is taken for rounding, and frame {} says where it stands",
                first.number
            ));
        }
        self.cameras.push(camera);
        self.entries.push(frames);
        Ok(())
    }

    /// The first picture of each camera that is read.
    pub(super) fn first_read(&self) -> impl Iterator<Item = &PlacedEntry> {
        self.entries.iter().filter_map(|frames| frames.iter().find(|entry| !entry.is_left_out))
    }
}

/// A warning where pictures are named from the root of another machine, and files below the manifest are read in their place.
fn names_of_another_machine(manifest: &Manifest, origin: &ManifestOrigin) -> Option<String> {
    let mut names = manifest.frames.iter().map(|entry| &entry.file_path).filter(|name| is_absolute(name));
    let first = names.find(|name| !origin.folder.join(name.as_str()).is_file())?;
    Some(format!(
        "{}: pictures are named from the root of another machine, as '{first}'; files below {} whose names end alike are read",
        origin.path.display(),
        origin.folder.join(".").display()
    ))
}

/// The names of the cameras in order of appearance, and their entries by number.
type ByCamera = (Vec<String>, BTreeMap<String, BTreeMap<i64, PlacedEntry>>);

/// The entries of each camera.
fn by_camera(entries: Vec<PlacedEntry>) -> Result<ByCamera> {
    let mut order: Vec<String> = Vec::new();
    let mut by_camera: BTreeMap<String, BTreeMap<i64, PlacedEntry>> = BTreeMap::new();
    for entry in entries {
        if !by_camera.contains_key(&entry.camera_name) {
            order.push(entry.camera_name.clone());
        }
        let frames = by_camera.entry(entry.camera_name.clone()).or_default();
        if let Some(first) = frames.get(&entry.number) {
            let what = format!("this camera has that frame already, in {}; take one out", first.file_path);
            return Err(Error::invalid(&entry.place, what));
        }
        frames.insert(entry.number, entry);
    }
    Ok((order, by_camera))
}

/// The error of a camera without one of the frames. `times` are those that frames were ranked by, and `poses` how many cameras
/// were made of poses because entries name none.
fn no_such_frame(
    name: &str,
    number: i64,
    times: &BTreeMap<i64, f64>,
    poses: Option<usize>,
    path: &Path,
) -> Error {
    let what = match (times.get(&number), poses) {
        (Some(time), _) => format!(
            "camera '{name}' has no frame of time {time}; every camera needs the same times to the last digit, or a \"frame\" in every entry"
        ),
        (None, Some(poses)) => format!(
            "camera '{name}' has no frame {number}; every camera needs the same frames, and as no entry names its \"camera\", each of {poses} poses became one: name them (a camera that moves is not supported)"
        ),
        (None, None) => {
            format!("camera '{name}' has no frame {number}; every camera needs the same frames")
        }
    };
    Error::invalid(path.display(), what)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn group(entries: &[Value]) -> Result<CameraFiles> {
        let frames: Vec<Value> = entries
            .iter()
            .enumerate()
            .map(|(index, keys)| {
                let mut entry = json!({
                    "file_path": format!("{index}.exr"), "w": 4, "h": 3, "fl_x": 5,
                    "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, keys["z"].as_f64().unwrap_or(0.0)]],
                });
                for (key, value) in keys.as_object().unwrap() {
                    entry[key] = value.clone();
                }
                entry
            })
            .collect();
        let manifest = json!({ "frames": frames }).to_string();
        let folder = tempfile::tempdir().unwrap();
        for index in 0..entries.len() {
            std::fs::write(folder.path().join(format!("{index}.exr")), "").unwrap();
        }
        let origin = ManifestOrigin::of_file(&folder.path().join("transforms.json"));
        CameraFiles::group(&Manifest::from_json(manifest.as_bytes(), "transforms.json")?, &origin)
    }

    fn names(recording: &CameraFiles) -> Vec<&str> {
        recording.cameras.iter().map(|camera| camera.name.as_str()).collect()
    }

    #[test]
    fn cameras_keep_their_order_and_frames_are_sorted() {
        let recording = group(&[
            json!({"camera": "b", "time": 7}),
            json!({"camera": 3, "frame": 7}),
            json!({"camera": "b", "frame": 2}),
            json!({"camera": 3, "time": 2, "frame": 2}),
        ])
        .unwrap();
        assert_eq!(names(&recording), ["b", "3"]);
        assert_eq!(recording.frame_numbers, [2, 7]);
        assert_eq!(recording.entries[1][0].file_path, "3.exr");
    }

    #[test]
    fn without_names_and_times_poses_are_cameras_and_repetitions_are_frames() {
        let recording = group(&[json!({}), json!({"z": 1}), json!({}), json!({"z": 1})]).unwrap();
        assert_eq!(names(&recording), ["cam0", "cam1"]);
        assert_eq!(recording.frame_numbers, [0, 1]);
        assert_eq!(recording.entries[0][1].file_path, "2.exr");
    }

    #[test]
    fn fractional_times_are_ranked_with_a_warning() {
        let recording = group(&[json!({"time": 0.5}), json!({"time": 0.0}), json!({"time": 1.0})]).unwrap();
        assert_eq!(recording.frame_numbers, [0, 1, 2]);
        assert_eq!(recording.entries[0][1].file_path, "0.exr");
        assert_eq!(recording.warnings.len(), 1);
    }

    #[test]
    fn a_camera_that_pans_is_refused_however_far_from_the_origin_it_stands() {
        let at = |time: u32, angle: f64, east: f64| {
            let (sine, cosine) = angle.sin_cos();
            let place = [east, 4.6e6, 12.0];
            json!({"camera": "a", "time": time, "transform_matrix": [
                [cosine, 0.0, sine, place[0]], [0.0, 1.0, 0.0, place[1]], [-sine, 0.0, cosine, place[2]],
            ]})
        };
        let refused = group(&[at(0, 0.0, 5e5), at(1, 0.001, 5e5)]).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains("the camera moved since frame 0"), "{refused}");
        let rounded = group(&[at(0, 0.3, 5e5), at(1, 0.3 + 1e-7, 5e5 + 0.1)]).unwrap();
        assert!(
            rounded.warnings[0].contains("camera 'a' moves by up to 1.0e-1 units"),
            "{:?}",
            rounded.warnings
        );
        assert!(group(&[at(0, 0.3, 5e5), at(1, 0.3, 5e5)]).unwrap().warnings.is_empty());
        assert!(group(&[at(0, 0.3, 5e5), at(1, 0.3, 5e5 + 3.0)]).is_err());
    }

    #[test]
    fn half_named_manifests_are_refused() {
        assert!(group(&[json!({"camera": "a"}), json!({"z": 1})]).is_err());
        assert!(group(&[json!({"time": 1}), json!({"z": 1})]).is_err());
    }
}
