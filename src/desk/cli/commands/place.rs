//! `overlook place`: poses that together show most of what a coarse capture saw.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use serde::Serialize;

use super::demo::parse_size;
use crate::cli::input::{EditsArgs, SettingsArgs};
use crate::cli::output::{self, CommandError};
use crate::ways_out::points;
use overlook_engine::capture::Capture;
use overlook_engine::capture::transforms::write_cameras;
use overlook_engine::error::Result;
use overlook_engine::placement::{self, PlaceOptions, Placement, Stand, Surfel};
use overlook_engine::settings::{AlignSettings, Settings};

#[derive(Debug, Args)]
pub(crate) struct PlaceArgs {
    /// A first capture of few pixels.
    coarse: PathBuf,
    /// How many cameras are placed.
    #[arg(long, value_name = "N", default_value_t = 6)]
    cameras: usize,
    /// Manifest of their poses, as in placed.json.
    #[arg(long, value_name = "TRANSFORMS")]
    out: PathBuf,
    /// Columns and rows of their pictures [default: those of the capture].
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Pixels a unit that surfaces should be seen with [default: as finely as the finest picture of the capture].
    #[arg(long, value_name = "PIXELS")]
    rate: Option<f64>,
    /// Cameras may stand all around too, as far and as high as those of the capture [default: between those].
    #[arg(long, conflicts_with = "within")]
    ring: bool,
    /// Cameras may stand anywhere in this box, as in -2,-2,0,2,2,3.
    #[arg(long, value_name = "XMIN,YMIN,ZMIN,XMAX,YMAX,ZMAX", value_parser = parse_box, allow_hyphen_values = true)]
    within: Option<[DVec3; 2]>,
    /// PLY file of the surface that no placed camera sees.
    #[arg(long, value_name = "FILE")]
    unseen: Option<PathBuf>,
    #[command(flatten)]
    edits: EditsArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct PlaceOutput {
    cameras: Vec<PlacedOutput>,
    /// Shares of all surface that the capture saw, 0 to 1; a surface counts in proportion to the rate that is asked for.
    coarse_cameras_see: f64,
    unseen: f64,
    seconds: f64,
}

#[derive(Serialize)]
struct PlacedOutput {
    name: String,
    position_in_world: [f64; 3],
    forward_in_world: [f64; 3],
    adds: f64,
    seen: f64,
}

impl PlaceArgs {
    pub(crate) fn run(self) -> std::result::Result<(), CommandError> {
        // Poses of renderers are exact.
        let base = Settings { align: AlignSettings::OFF, ..Settings::default() };
        let settings = self.settings.over(base)?;
        for (out, example) in [(Some(&self.out), "placed.json"), (self.unseen.as_ref(), "unseen.ply")] {
            let Some(out) = out else { continue };
            output::check_file(out, example)?;
            output::refuse_store(out)?;
            self.settings.refuse_inputs(out)?;
            self.edits.refuse_inputs(out)?;
            output::refuse_capture_files(&self.coarse, None, out)?;
        }
        let capture = self.edits.open_capture(&self.coarse, &settings.capture)?;
        let stand = match self.within {
            Some(corners) => Stand::Within(corners),
            None if self.ring => Stand::Ring,
            None => Stand::Between,
        };
        let options = PlaceOptions { cameras: self.cameras, stand, size: self.size, rate: self.rate };
        let started = std::time::Instant::now();
        let placed = output::watched(|job| placement::place(&capture, &options, &settings, job))?;
        let seconds = started.elapsed().as_secs_f64();
        let cameras: Vec<_> = placed.cameras.iter().map(|placed| placed.camera.clone()).collect();
        write_cameras(&self.out, &cameras, placed.frame_number, placed.up_in_world)?;
        if let Some(unseen) = &self.unseen {
            write_unseen(unseen, &capture, &placed.unseen_surfels)?;
        }
        if self.json {
            return output::print_json(&document(&placed, seconds));
        }
        output::print(&self.said(&capture, &placed))
    }

    fn said(&self, capture: &Capture, placed: &Placement) -> String {
        let percent = |share: f64| 100.0 * share;
        let mut text = format!("{:>8} {:>8}  {:<10} position", "adds %", "seen %", "camera");
        for one in &placed.cameras {
            let [x, y, z] = one.camera.position_in_world().to_array();
            let (adds, seen, name) = (percent(one.adds), percent(one.seen), &one.camera.name);
            let _ = write!(text, "\n{adds:>8.2} {seen:>8.2}  {name:<10} {x:.3}, {y:.3}, {z:.3}");
        }
        let _ = write!(
            text,
            "\n\nThe {} of the capture see {:.2} % of the same surface; {:.2} % of it no placed camera sees at all.",
            overlook_engine::plural::counted(capture.cameras.len(), "camera"),
            percent(placed.coarse_cameras_see),
            percent(placed.unseen)
        );
        if placed.cameras.len() < self.cameras {
            text += "\nFewer cameras were placed than asked for: another would add nothing.";
        }
        let _ = write!(text, "\nWrote {}", self.out.display());
        if let Some(unseen) = &self.unseen {
            let points = output::count_of(placed.unseen_surfels.len() as u64, "point");
            let _ = write!(text, "\nWrote {points} to {}", unseen.display());
        }
        text
    }
}

fn document(placed: &Placement, seconds: f64) -> PlaceOutput {
    let cameras = placed.cameras.iter().map(|one| PlacedOutput {
        name: one.camera.name.clone(),
        position_in_world: one.camera.position_in_world().to_array(),
        forward_in_world: one.camera.forward_in_world().to_array(),
        adds: one.adds,
        seen: one.seen,
    });
    let Placement { coarse_cameras_see, unseen, .. } = *placed;
    PlaceOutput { cameras: cameras.collect(), coarse_cameras_see, unseen, seconds }
}

fn write_unseen(path: &Path, capture: &Capture, surfels: &[Surfel]) -> Result<u64> {
    let points = surfels.iter().map(|surfel| points::Disk {
        point_in_world: surfel.point_in_world,
        normal_in_world: surfel.normal_in_world,
        radius: 0.5 * surfel.width,
        color: surfel.color,
    });
    points::write_points(path, &capture.name, &capture.cameras, surfels.len() as u64, points)
}

fn parse_box(text: &str) -> std::result::Result<[DVec3; 2], String> {
    let numbers: std::result::Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z, far_x, far_y, far_z]) => Ok([DVec3::new(x, y, z), DVec3::new(far_x, far_y, far_z)]),
        _ => Err("write it as six numbers, as in -2,-2,0,2,2,3".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_read_or_refused() {
        assert_eq!(
            parse_box("-2, -1,0,2,1.5,3"),
            Ok([DVec3::new(-2.0, -1.0, 0.0), DVec3::new(2.0, 1.5, 3.0)])
        );
        assert!(["", "1,2,3", "1,2,3,4,5,six"].iter().all(|text| parse_box(text).is_err()));
    }
}
