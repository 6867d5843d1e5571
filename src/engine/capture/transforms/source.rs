//! The files of a capture as a source of frames.

use super::cameras::CameraFiles;
use super::header_probe::HeaderFacts;
use super::load::{self, NeededPlanes};
use super::placed_entry::PlacedEntry;
use crate::capture::depth_claim::DepthClaim;
use crate::capture::frame::Frame;
use crate::capture::parts::FrameSource;
use crate::capture::pose_convention::PoseConvention;
use crate::capture::values::ValueChannel;
use crate::error::Result;

/// Decodes frames from their files on demand.
pub(super) struct FileSource {
    /// What is where.
    pub recording: CameraFiles,
    /// Whether normals are read.
    pub has_normals: bool,
    /// The channels of values.
    pub values: Vec<ValueChannel>,
    /// Whether the manifest says that there is no noise, or that there is some.
    pub noise_free: Option<bool>,
}

impl FileSource {
    /// The first picture that is read.
    pub(super) fn first_entry(&self) -> Option<&PlacedEntry> {
        self.recording.first_read().next()
    }
}

impl FrameSource for FileSource {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let entry = &self.recording.entries[camera][frame];
        if entry.is_left_out {
            return Ok(load::without_samples(
                &self.recording.cameras[camera],
                self.has_normals,
                self.values.len(),
            ));
        }
        let need = NeededPlanes::Geometry { normals: self.has_normals };
        load::frame(&entry.files, &self.recording.cameras[camera], &entry.place, need)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        self.recording.entries[camera][frame].place.clone()
    }

    fn transparent_pixels(&self, camera: usize, frame: usize) -> Result<Option<usize>> {
        let entry = &self.recording.entries[camera][frame];
        if entry.is_left_out {
            return Ok(None);
        }
        load::transparent_pixels(&entry.files, &self.recording.cameras[camera], &entry.place)
    }

    fn frames_are_ranked(&self) -> bool {
        self.recording.is_ranked
    }

    fn depth_claim(&self) -> DepthClaim {
        self.first_entry().map(|entry| entry.files.depth_claim()).unwrap_or_default()
    }

    fn is_noise_free(&self) -> bool {
        self.noise_free == Some(true)
    }

    fn is_rendered(&self) -> Option<bool> {
        self.noise_free
    }

    fn value_channels(&self) -> &[ValueChannel] {
        &self.values
    }

    fn pose_convention(&self) -> PoseConvention {
        self.first_entry().map(|entry| entry.keys.pose_convention()).unwrap_or_default()
    }

    fn files(&self, camera: usize, frame: usize) -> Vec<std::path::PathBuf> {
        let entry = &self.recording.entries[camera][frame];
        if entry.is_left_out {
            return Vec::new();
        }
        let files = &entry.files;
        let more = [&files.depth, &files.normal, &files.confidence, &files.mask];
        let values = files.values.iter().filter_map(|value| value.path.as_ref());
        std::iter::once(&files.color).chain(more.into_iter().flatten()).chain(values).cloned().collect()
    }
}

/// Whether all cameras have normals, by the headers of their first frames, with warnings about what these say.
pub(super) fn normals_in_all_cameras(
    recording: &CameraFiles,
    probes: &[HeaderFacts],
    warnings: &mut Vec<String>,
) -> bool {
    let names = recording.cameras.iter().map(|camera| camera.name.as_str());
    let probes: Vec<(&str, &HeaderFacts)> = names.zip(probes).collect();
    let cameras = |is_so: fn(&HeaderFacts) -> bool| -> Vec<&str> {
        probes.iter().filter(|(_, probe)| is_so(probe)).map(|(name, _)| *name).collect()
    };
    let of_absurd_primaries = cameras(|probe| probe.has_absurd_primaries);
    if !of_absurd_primaries.is_empty() {
        warnings.push(format!(
            "the pictures of {} state chromaticities that no colors have; colors are taken as linear Rec.709",
            of_absurd_primaries.join(", ")
        ));
    }
    let without_near_clip = cameras(|probe| probe.lacks_near_clip);
    if !without_near_clip.is_empty() {
        warnings.push(format!(
            "depth of {} starts at the near plane, which is taken as 0; give near_clip in the manifest",
            without_near_clip.join(", ")
        ));
    }
    let without = cameras(|probe| !probe.has_normals);
    if !without.is_empty() && without.len() < recording.cameras.len() {
        warnings.push(format!(
            "only some cameras give normals ({} do not); normals are estimated for all of them",
            without.join(", ")
        ));
    }
    without.is_empty()
}
