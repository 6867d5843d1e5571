//! The files that a command reads: whether they are still what they were.

use std::fmt::Write;
use std::path::Path;
use std::time::UNIX_EPOCH;

use crate::capture::Capture;
use crate::capture::transforms::{manifest_path, picture_places};
use crate::error::{Error, Result};

/// What a capture, opened from `path`, and the manifest of its truth held when they were looked at: it changes with any camera, any
/// word of a manifest, and any picture that is written anew.
pub(super) fn state(path: &Path, capture: &Capture, views: Option<&Path>) -> Result<String> {
    let mut pictures = capture.files();
    let mut manifests = vec![manifest_path(path)];
    if let Some(views) = views {
        pictures.extend(picture_places(views)?);
        manifests.push(manifest_path(views));
    }
    // Manifests are small enough to be read again, pictures are not; where these lie is said by the manifests.
    let mut state = String::new();
    for manifest in manifests {
        let bytes = std::fs::read(&manifest).map_err(|error| Error::io(&manifest, error))?;
        let _ = write!(state, "{:08x} ", crc32fast::hash(&bytes));
    }
    let (mut sum, mut files) = (crc32fast::Hasher::new(), 0);
    for facts in pictures.iter().filter_map(|path| path.metadata().ok()) {
        let modified = facts.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        sum.update(&facts.len().to_le_bytes());
        sum.update(&modified.unwrap_or_default().as_nanos().to_le_bytes());
        files += 1;
    }
    let _ = write!(state, "{:08x} of {files} files; {:?}", sum.finalize(), capture.cameras);
    Ok(state)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::demo::{Demo, DemoSpec};
    use crate::capture::transforms::{MANIFEST_NAME, open, write_capture};
    use crate::job::Job;
    use crate::settings::CaptureSettings;

    fn record(folder: &Path, noise: Option<f32>) {
        let spec = DemoSpec {
            scene: "orrery".to_owned(),
            cameras: Some(2),
            frames: Some(1),
            size: Some((16, 12)),
            noise,
        };
        let demo = Demo::new(&spec).unwrap();
        let capture = demo.capture(&CaptureSettings::default());
        write_capture(folder, &capture, &demo.truth_views(), &Job::new()).unwrap();
    }

    #[test]
    fn a_capture_is_the_same_until_a_picture_a_pose_or_the_truth_changes() {
        let folder = tempfile::tempdir().unwrap();
        let (scene, views) = (folder.path(), folder.path().join("novel").join(MANIFEST_NAME));
        let seen = || {
            let capture = open(scene, &CaptureSettings::default()).unwrap();
            state(scene, &capture, Some(&views)).unwrap()
        };
        record(scene, None);
        let mut known = vec![seen()];
        assert_eq!(known[0], seen());
        let mut is_new = |what: &str| {
            let now = seen();
            assert!(!known.contains(&now), "{what}: {now}");
            known.push(now);
        };
        record(scene, Some(0.1));
        is_new("other pictures");

        let manifest = scene.join(MANIFEST_NAME);
        let mut moved: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&manifest).unwrap()).unwrap();
        moved["frames"][0]["transform_matrix"][0][3] = 7.5.into();
        std::fs::write(&manifest, moved.to_string()).unwrap();
        is_new("another pose");

        let picture = picture_places(&views).unwrap().remove(0);
        let bytes = std::fs::read(&picture).unwrap();
        std::fs::write(&picture, [bytes, vec![0]].concat()).unwrap();
        is_new("another true picture");
    }
}
