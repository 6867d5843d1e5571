//! `overlook demo`: a built-in scene as a capture on disk.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde::Serialize;

use crate::cli::output::{self, CommandError};
use overlook_engine::capture::transforms::{MANIFEST_NAME, open_views, picture_name, write_capture};
use overlook_engine::capture::{Camera, TruthView};
use overlook_engine::demo::{Demo, DemoSpec, MAX_CAMERAS, SCENES};
use overlook_engine::error::{Error, Result};
use overlook_engine::plural::counted;
use overlook_engine::settings::CaptureSettings;

#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Which scene.
    #[arg(value_name = "NAME", value_parser = PossibleValuesParser::new(
        SCENES.iter().map(|(name, help)| PossibleValue::new(*name).help(*help))))]
    scene: String,
    /// Folder to write to.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Number of cameras [default: the scene's own].
    #[arg(long, value_name = "N")]
    cameras: Option<usize>,
    /// Number of frames [default: the scene's own].
    #[arg(long, value_name = "N")]
    frames: Option<usize>,
    /// Columns and rows of every camera [default: the scene's own].
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Relative standard deviation of renderer-like color noise [default: the scene's own].
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    noise: Option<f32>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct DemoOutput {
    scene: String,
    cameras: usize,
    frames: usize,
    truth_views: usize,
}

impl DemoArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let spec = DemoSpec {
            scene: self.scene.clone(),
            cameras: self.cameras,
            frames: self.frames,
            size: self.size,
            noise: self.noise,
        };
        let demo = Demo::new(&spec).map_err(|error| CommandError::Usage(error.to_string()))?;
        output::check_folder(&self.out)?;
        self.check_is_ours(&spec)?;
        let capture = demo.capture(&CaptureSettings::default());
        let views = demo.truth_views();
        output::watched(|job| write_capture(&self.out, &capture, &views, job))?;
        let written = DemoOutput {
            scene: self.scene,
            cameras: capture.cameras.len(),
            frames: capture.frame_count(),
            truth_views: views.len(),
        };
        if self.json {
            return output::print_json(&written);
        }
        let out = self.out.display();
        output::print(&format!(
            "Wrote {}: {}, {}, {}, to {out}\nNext: overlook preprocess {out} --out {}.ovl",
            written.scene,
            counted(written.cameras, "camera"),
            counted(written.frames, "frame"),
            counted(written.truth_views, "truth view"),
            written.scene
        ))
    }

    /// Refuses a folder that holds another capture. Its own scene may be recorded again with other counts and sizes: none of them
    /// moves a camera.
    fn check_is_ours(&self, spec: &DemoSpec) -> Result<()> {
        let all = Demo::new(&spec.clone().cameras(MAX_CAMERAS))?;
        let cameras = all.capture(&CaptureSettings::default()).cameras.clone();
        let novel: Vec<Camera> = all.truth_views().into_iter().map(|view| view.camera).collect();
        let manifests = [self.out.join(MANIFEST_NAME), self.out.join("novel").join(MANIFEST_NAME)];
        for (manifest, cameras) in manifests.into_iter().zip([cameras, novel]) {
            if !manifest.exists() {
                continue;
            }
            let views = open_views(&manifest).unwrap_or_default();
            if views.is_empty() || !views.iter().all(|view| is_of(&cameras, view)) {
                let scene = &self.scene;
                let what = format!(
                    "is not of the scene '{scene}', and would be written over; name another folder with --out"
                );
                return Err(Error::invalid(manifest.display(), what));
            }
        }
        Ok(())
    }
}

/// Whether a demo with these cameras writes this picture.
fn is_of(cameras: &[Camera], view: &TruthView) -> bool {
    let TruthView { file_path, camera, frame_number, .. } = view;
    *file_path == picture_name(camera, *frame_number)
        && cameras.iter().any(|known| {
            known.name == camera.name
                && known.world_from_camera.abs_diff_eq(camera.world_from_camera, SAME_POSE)
        })
}

/// Far below the distance of two cameras, far above the error of writing and reading a pose.
const SAME_POSE: f64 = 1e-6;

/// Columns and rows.
pub(super) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let (width, height) = text.split_once(['x', '×']).ok_or("write it as WxH, as in 640x480")?;
    let side = |text: &str| text.trim().parse().map_err(|_| format!("'{text}' is not a number of pixels"));
    Ok((side(width)?, side(height)?))
}

#[cfg(test)]
mod tests {
    use super::parse_size;

    #[test]
    fn sizes_are_read_or_refused() {
        assert_eq!(parse_size("640x480"), Ok((640, 480)));
        for text in ["640", "x", "-1x5", "640x480x3"] {
            assert!(parse_size(text).is_err());
        }
    }
}
