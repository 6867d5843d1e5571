//! A camera path: keys that are set by standing somewhere, played in the live view and exported as pictures or as a film.
//!
//! Between keys the camera moves as [`crate::render::film::pose_at`] says; every leg takes as many pictures, and time and lens change evenly
//! from one key's to the next one's.

use std::path::{Path, PathBuf};

use super::orbit_camera::OrbitCamera;
use crate::capture::Intrinsics;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::film::{self, FilmEncoder, FilmSource};
use crate::render::output::write_png;
use crate::render::{Picture, Renderer, Vantage};
use crate::settings::RenderSettings;

/// Why a path of fewer than two keys cannot be exported.
pub(crate) const NO_KEYS: &str =
    "A camera path needs two keys at least; add them in the Camera path view (K).";

/// A place on the path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SavedPathKey {
    /// Where the view stands.
    pub rig: OrbitCamera,
    /// The frame shown there.
    pub frame: usize,
}

/// A camera path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraPath {
    /// The keys, in order.
    pub keys: Vec<SavedPathKey>,
    /// Pictures from one key to the next.
    pub pictures_per_leg: usize,
    /// Columns and rows of exported pictures, where they were chosen.
    pub size: Option<[u32; 2]>,
    /// The picture that is played; `None` while it does not play.
    pub playing: Option<f32>,
}

impl Default for CameraPath {
    fn default() -> Self {
        Self { keys: Vec::new(), pictures_per_leg: 48, size: None, playing: None }
    }
}

impl CameraPath {
    /// Pictures of the whole path; 0 with fewer than two keys.
    pub(crate) fn pictures(&self) -> usize {
        match self.keys.len() {
            0 | 1 => 0,
            keys => (keys - 1) * self.pictures_per_leg + 1,
        }
    }

    /// Where the view stands at a picture, and which frame it shows; `None` without keys.
    pub(crate) fn at(&self, picture: f32) -> Option<SavedPathKey> {
        let last = self.keys.len().checked_sub(1)?;
        let time = f64::from(picture / self.pictures_per_leg as f32).clamp(0.0, last as f64);
        let timed = self.keys.iter().enumerate().map(|(index, key)| film::PathKey {
            time: index as f64,
            world_from_camera: key.rig.world_from_camera,
        });
        let world_from_camera = film::pose_at(&timed.collect::<Vec<_>>(), time)?;
        let leg = (time as usize).min(last.saturating_sub(1));
        let share = time - leg as f64;
        let (from, to) = (&self.keys[leg], &self.keys[(leg + 1).min(last)]);
        let between = |from: f64, to: f64| from + (to - from) * share;
        let mut rig = from.rig.clone();
        rig.world_from_camera = world_from_camera;
        rig.lens = lens_between([from.rig.lens, to.rig.lens], share);
        rig.pivot_distance = between(from.rig.pivot_distance, to.rig.pivot_distance);
        Some(SavedPathKey { rig, frame: between(from.frame as f64, to.frame as f64).round() as usize })
    }

    /// Every picture's vantage, for pictures of `width` by `height` pixels of a scene of `frames` frames.
    fn vantages(&self, [width, height]: [u32; 2], frames: usize) -> Vec<Vantage> {
        let keys = (0..self.pictures()).filter_map(|picture| self.at(picture as f32));
        let last = frames.saturating_sub(1);
        keys.map(|key| Vantage { camera: key.rig.camera(width, height), frame: key.frame.min(last) })
            .collect()
    }
}

/// The lens on the way from one to another: what it sees of the world changes evenly, whatever the sizes of the two pictures.
fn lens_between([from, to]: [Intrinsics; 2], share: f64) -> Intrinsics {
    if from == to {
        return from;
    }
    let between = |of: &dyn Fn(&Intrinsics) -> f64| of(&from) + (of(&to) - of(&from)) * share;
    let width = between(&|lens| f64::from(lens.width)).round();
    let height = between(&|lens| f64::from(lens.height)).round();
    Intrinsics {
        width: width as u32,
        height: height as u32,
        // Both by the width, so that square pixels stay square when a side is rounded.
        fx: width * between(&|lens| lens.fx / f64::from(lens.width)),
        fy: width * between(&|lens| lens.fy / f64::from(lens.width)),
        cx: width * between(&|lens| lens.cx / f64::from(lens.width)),
        cy: height * between(&|lens| lens.cy / f64::from(lens.height)),
    }
}

/// What a camera path is exported as.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ExportTarget {
    /// A folder that receives `0001.png`, `0002.png`, …
    Pictures(PathBuf),
    /// A film, and how many pictures it shows a second.
    Film(PathBuf, f64),
}

impl ExportTarget {
    /// The folder or file.
    pub(crate) fn path(&self) -> &Path {
        match self {
            Self::Pictures(path) | Self::Film(path, _) => path,
        }
    }

    /// What is left of an export that was stopped, in words.
    pub(crate) fn stopped(&self) -> String {
        match self {
            Self::Pictures(folder) => {
                format!("Only the pictures painted until then were written to {}.", folder.display())
            }
            Self::Film(path, _) => format!("Nothing was written to {}.", path.display()),
        }
    }
}

/// What is exported.
pub(crate) struct ExportRequest {
    /// The path.
    pub path: CameraPath,
    /// What is painted.
    pub reel: FilmSource,
    /// How.
    pub settings: RenderSettings,
    /// Columns and rows of the pictures.
    pub size: [u32; 2],
    /// As what.
    pub target: ExportTarget,
}

/// What came of an export.
pub(crate) struct Exported {
    /// Pictures painted and written.
    pub pictures: usize,
    /// Why something else painted than was asked for.
    pub notice: Option<String>,
    /// What could not be read of a store so far, one line each.
    pub damage: Vec<String>,
}

/// Paints and writes all pictures.
///
/// # Errors
/// `Invalid` without a path, `Io` where nothing can be written there, whatever rendering and ffmpeg give, and `Cancelled`.
pub(crate) fn export(request: &ExportRequest, job: &Job) -> Result<Exported> {
    let vantages = request.path.vantages(request.size, request.reel.frame_count());
    if vantages.is_empty() {
        return Err(Error::invalid("camera path", NO_KEYS));
    }
    let mut renderer = Renderer::new();
    let mut paint = |take: &mut dyn FnMut(usize, &Picture) -> Result<()>| {
        film::paint(&request.reel, &vantages, &mut renderer, &request.settings, job, take)
    };
    match &request.target {
        ExportTarget::Pictures(folder) => {
            std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, error))?;
            paint(&mut |nth, picture| write_png(&folder.join(format!("{:04}.png", nth + 1)), picture))?;
        }
        ExportTarget::Film(path, frames_per_second) => {
            let size = request.size.map(|side| side as usize);
            let mut encoder = FilmEncoder::start(path, size, *frames_per_second)?;
            paint(&mut |_, picture| encoder.add(picture))?;
            encoder.finish(job)?;
        }
    }
    let damage = match &request.reel {
        FilmSource::Memory(_) => Vec::new(),
        FilmSource::Disk(playback) => playback.store().damage(),
    };
    Ok(Exported { pictures: vantages.len(), notice: renderer.notice().map(str::to_owned), damage })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn path(positions: &[DVec3]) -> CameraPath {
        let keys = positions.iter().enumerate().map(|(index, position)| {
            let mut rig = OrbitCamera::for_tests();
            rig.world_from_camera.translation = *position;
            SavedPathKey { rig, frame: index * 10 }
        });
        CameraPath { keys: keys.collect(), pictures_per_leg: 8, size: None, playing: None }
    }

    #[test]
    fn the_path_goes_through_its_keys() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::new(2.0, 1.0, 0.0)];
        let path = path(&positions);
        assert_eq!(path.pictures(), 17);
        for (index, position) in positions.into_iter().enumerate() {
            let key = path.at(index as f32 * 8.0).unwrap();
            assert!((key.rig.world_from_camera.translation - position).length() < 1e-9);
            assert_eq!(key.frame, index * 10);
        }
        assert_eq!(path.at(4.0).unwrap().frame, 5);
        assert_eq!(path.at(1e9), path.at(16.0), "beyond the end it stays");
    }

    #[test]
    fn the_lens_zooms_from_each_key_to_the_next_and_the_last_one_is_reached() {
        let mut path = path(&[DVec3::ZERO, DVec3::X]);
        let wide = path.keys[0].rig.lens;
        let zoomed =
            Intrinsics { fx: 6.0 * wide.fx, fy: 6.0 * wide.fy, cx: 96.0, cy: 72.0, width: 192, height: 144 };
        path.keys[1].rig.lens = zoomed;
        let focal = |picture: f32| {
            let camera = path.at(picture).unwrap().rig.camera(640, 480);
            assert_eq!([camera.intrinsics.cx, camera.intrinsics.cy], [320.0, 240.0]);
            assert!((camera.intrinsics.fx - camera.intrinsics.fy).abs() < 1e-9);
            camera.intrinsics.fx / (10.0 * wide.fx)
        };
        for (picture, expected) in [(0.0, 1.0), (4.0, 1.5), (8.0, 2.0), (99.0, 2.0)] {
            assert!((focal(picture) - expected).abs() < 1e-9, "{picture}: {}", focal(picture));
        }
        assert_eq!(path.at(8.0).unwrap().rig.lens.width, 192);
    }

    #[test]
    fn a_path_needs_two_keys() {
        assert_eq!(path(&[]).at(0.0), None);
        assert_eq!(path(&[DVec3::X]).pictures(), 0);
        assert!(path(&[DVec3::X]).at(3.0).is_some());
    }
}
