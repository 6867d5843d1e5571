//! A camera path: keys that are set by standing somewhere, played in the live view and exported as a sequence of pictures.
//!
//! Between keys positions follow a Catmull-Rom curve (Catmull and Rom 1974) through the keys, and directions turn evenly
//! (spherical linear interpolation, Shoemake 1985). Time runs evenly from one key's frame to the next one's.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};

use super::super::views::rig::Rig;
use crate::color::srgb8_from_linear;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::preprocess::SampleSet;
use crate::render::{Picture, Renderer, Vantage};
use crate::settings::RenderSettings;
use crate::store::Playback;

/// A place on the path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PathKey {
    /// Where the view stands.
    pub rig: Rig,
    /// The frame shown there.
    pub frame: usize,
}

/// A camera path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraPath {
    /// The keys, in order.
    pub keys: Vec<PathKey>,
    /// Pictures from one key to the next.
    pub pictures_per_leg: usize,
    /// The picture that is played; `None` while it does not play.
    pub playing: Option<f32>,
}

impl Default for CameraPath {
    fn default() -> Self {
        Self { keys: Vec::new(), pictures_per_leg: 48, playing: None }
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
    pub(crate) fn at(&self, picture: f32) -> Option<PathKey> {
        let last = self.keys.len().checked_sub(1)?;
        let place = (picture / self.pictures_per_leg as f32).clamp(0.0, last as f32);
        let leg = (place as usize).min(last.saturating_sub(1));
        let share = f64::from(place - leg as f32);
        let key = |index: i64| &self.keys[index.clamp(0, last as i64) as usize];
        let leg = leg as i64;
        let (from, to) = (key(leg), key(leg + 1));
        let position = |key: &PathKey| key.rig.world_from_camera.translation;
        let translation = catmull_rom(
            [position(key(leg - 1)), position(from), position(to), position(key(leg + 2))],
            share,
        );
        let turn = |key: &PathKey| DQuat::from_mat3(&key.rig.world_from_camera.matrix3);
        let rotation = turn(from).slerp(turn(to), share);
        let mut rig = from.rig.clone();
        rig.world_from_camera = DAffine3::from_rotation_translation(rotation.normalize(), translation);
        rig.pivot_distance += (to.rig.pivot_distance - from.rig.pivot_distance) * share;
        let frame = from.frame as f64 + (to.frame as f64 - from.frame as f64) * share;
        Some(PathKey { rig, frame: frame.round() as usize })
    }
}

fn catmull_rom([before, from, to, after]: [DVec3; 4], share: f64) -> DVec3 {
    let (s, s2, s3) = (share, share * share, share * share * share);
    0.5 * (2.0 * from
        + (to - before) * s
        + (2.0 * before - 5.0 * from + 4.0 * to - after) * s2
        + (3.0 * from - before - 3.0 * to + after) * s3)
}

/// What is exported.
pub(crate) struct ExportRequest {
    /// The path.
    pub path: CameraPath,
    /// What is painted; of a store played from disk, what there is to play.
    pub samples: Arc<SampleSet>,
    /// Where the samples come from, frame by frame, if not from memory.
    pub playback: Option<Arc<Playback>>,
    /// How.
    pub settings: RenderSettings,
    /// Columns and rows of the pictures.
    pub size: [u32; 2],
    /// The folder that receives `0001.png`, `0002.png`, …
    pub folder: PathBuf,
}

/// Paints and writes all pictures; gives their number.
///
/// # Errors
/// `Invalid` without a path, `Io` where the folder cannot be written, whatever rendering gives, and `Cancelled`.
pub(crate) fn export(request: &ExportRequest, job: &Job) -> Result<usize> {
    let pictures = request.path.pictures();
    if pictures == 0 {
        return Err(Error::invalid("camera path", "it needs two keys at least; add them in the Path view"));
    }
    std::fs::create_dir_all(&request.folder).map_err(|error| Error::io(&request.folder, error))?;
    job.start("Exporting pictures", pictures);
    let mut renderer = Renderer::new();
    for picture in 0..pictures {
        job.check()?;
        let Some(key) = request.path.at(picture as f32) else { break };
        let [width, height] = request.size;
        let frame = key.frame.min(request.samples.frame_count().saturating_sub(1));
        let vantage = Vantage { camera: key.rig.camera(width, height), frame };
        let samples = match &request.playback {
            Some(playback) => playback.seen_from(&vantage.camera, frame, job)?,
            None => request.samples.clone(),
        };
        let (painted, _) = renderer.render(&samples, &vantage, &request.settings, job)?;
        write_png(&painted, &request.folder.join(format!("{:04}.png", picture + 1)))?;
        job.advance(1);
    }
    Ok(pictures)
}

/// Writes a picture as 8-bit sRGB; holes are transparent.
///
/// # Errors
/// `Io` where the file cannot be written.
pub(crate) fn write_png(picture: &Picture, path: &Path) -> Result<()> {
    let (width, height) = picture.color.size();
    let pixels = picture.color.as_slice().iter().zip(picture.inverse_depth.as_slice());
    let bytes: Vec<u8> = pixels
        .flat_map(|(color, inverse_depth)| {
            let [r, g, b] = color.map(srgb8_from_linear);
            [r, g, b, if *inverse_depth < 0.0 { 0 } else { 255 }]
        })
        .collect();
    image::save_buffer(path, &bytes, width as u32, height as u32, image::ColorType::Rgba8)
        .map_err(|error| Error::io(path, std::io::Error::other(error)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::views::rig::Rig;

    fn path(positions: &[DVec3]) -> CameraPath {
        let keys = positions.iter().enumerate().map(|(index, position)| {
            let mut rig = Rig::for_tests();
            rig.world_from_camera.translation = *position;
            PathKey { rig, frame: index * 10 }
        });
        CameraPath { keys: keys.collect(), pictures_per_leg: 8, playing: None }
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
    fn a_path_needs_two_keys() {
        assert_eq!(path(&[]).at(0.0), None);
        assert_eq!(path(&[DVec3::X]).pictures(), 0);
        assert!(path(&[DVec3::X]).at(3.0).is_some());
    }
}
