//! Identity of the files that a command reads.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use overlook_engine::capture::transforms::{manifest_path, picture_places};
use overlook_engine::capture::{Capture, Source};
use overlook_engine::error::{Error, Result};

/// A text that changes with any camera of a capture, any byte of its manifest or of its truth's, and any rewritten picture.
pub(crate) fn state(path: &Path, capture: &Capture, views: Option<&Path>) -> Result<String> {
    let mut pictures = capture.files();
    let mut manifests = Source::find(path)?.inputs().to_vec();
    if let Some(views) = views {
        pictures.extend(picture_places(views)?);
        manifests.push(manifest_path(views));
    }
    Ok(format!("{}; {:?}", files_state(&manifests, &pictures)?, capture.cameras))
}

fn files_state(manifests: &[PathBuf], pictures: &[PathBuf]) -> Result<String> {
    // Manifests are small enough to be read again. Pictures are not: their lengths and times have to do.
    let mut state = String::new();
    for manifest in manifests {
        let bytes = std::fs::read(manifest).map_err(|error| Error::io(manifest, error))?;
        let _ = write!(state, "{:08x} ", crc32fast::hash(&bytes));
    }
    let (mut sum, mut files) = (crc32fast::Hasher::new(), 0);
    for facts in pictures.iter().filter_map(|path| path.metadata().ok()) {
        let modified = facts.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        sum.update(&facts.len().to_le_bytes());
        sum.update(&modified.unwrap_or_default().as_nanos().to_le_bytes());
        files += 1;
    }
    let _ = write!(state, "{:08x} of {files} files", sum.finalize());
    Ok(state)
}

/// A text that changes with any byte of a capture's manifest, and with any camera or frame number.
pub(crate) fn capture_state(path: &Path, capture: &Capture) -> Result<String> {
    let manifests = files_state(Source::find(path)?.inputs(), &[])?;
    Ok(format!("{} {manifests}; {:?} {:?}", capture.name, capture.frame_numbers, capture.cameras))
}

/// A text that changes with the length and the time of any of these pictures.
pub(crate) fn pictures_state(pictures: &[PathBuf]) -> Result<String> {
    files_state(&[], pictures)
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::capture::transforms::{MANIFEST_NAME, open, write_capture};
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_engine::job::Job;
    use overlook_engine::settings::CaptureSettings;

    fn record(folder: &Path, noise: Option<f32>) {
        let spec = DemoSpec { noise, ..DemoSpec::new("orrery").cameras(2).frames(1).size((16, 12)) };
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
