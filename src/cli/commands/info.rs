//! `overlook info`: what a capture or a store holds.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::capture::{Camera, transforms};
use crate::cli::output::{self, CommandError, Sizes};
use crate::preprocess::diagnostics::Report;
use crate::settings::{CaptureSettings, Settings};
use crate::store::file::{Provenance, Store};

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// A capture (a folder or its transforms.json) or a store.
    path: PathBuf,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct CameraInfo {
    name: String,
    width: u32,
    height: u32,
}

#[derive(Serialize)]
struct Info {
    kind: &'static str,
    name: String,
    cameras: Vec<CameraInfo>,
    frames: usize,
    #[serde(flatten)]
    contents: Contents,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Contents {
    Capture {
        pixels: u64,
        normals: bool,
        warnings: Vec<String>,
    },
    Store {
        samples: u64,
        bytes: u64,
        sizes: Box<Sizes>,
        spans: usize,
        version: String,
        settings: Box<Settings>,
        report: Box<Report>,
        provenance: Box<Provenance>,
        warnings: Vec<String>,
    },
}

impl InfoArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let info = if Store::is_store(&self.path)? { of_store(&self.path)? } else { of_capture(&self.path)? };
        if self.json { output::print_json(&info) } else { output::print(&info.text(&self.path)) }
    }
}

fn camera_infos(cameras: &[Camera]) -> Vec<CameraInfo> {
    let info = |camera: &Camera| {
        let (name, intrinsics) = (camera.name.clone(), camera.intrinsics);
        CameraInfo { name, width: intrinsics.width, height: intrinsics.height }
    };
    cameras.iter().map(info).collect()
}

fn of_store(path: &Path) -> Result<Info, CommandError> {
    let store = Store::open(path)?;
    let info = store.info();
    let report = Report::from_json(&info.report, &path.display().to_string())?;
    Ok(Info {
        kind: "store",
        name: info.name.clone(),
        cameras: camera_infos(&info.cameras),
        frames: info.frame_numbers.len(),
        contents: Contents::Store {
            samples: info.sample_count(),
            bytes: info.bytes,
            sizes: Box::new(Sizes::of(info, &report)),
            spans: info.span_count(),
            version: format!("{}.{}", info.version.0, info.version.1),
            settings: Box::new(info.settings.clone()),
            report: Box::new(report),
            provenance: Box::new(info.provenance.clone()),
            warnings: info.warnings.clone(),
        },
    })
}

fn of_capture(path: &Path) -> Result<Info, CommandError> {
    let capture = transforms::open(path, &CaptureSettings::default())?;
    Ok(Info {
        kind: "capture",
        name: capture.name.clone(),
        cameras: camera_infos(&capture.cameras),
        frames: capture.frame_count(),
        contents: Contents::Capture {
            pixels: capture.pixel_count(),
            normals: capture.has_normals,
            warnings: capture.warnings.clone(),
        },
    })
}

impl Info {
    fn text(&self, path: &Path) -> String {
        let mut text = format!("{} '{}': {} frames\n", self.kind, self.name, self.frames);
        for camera in &self.cameras {
            let _ = writeln!(text, "  camera {:<16} {}×{}", camera.name, camera.width, camera.height);
        }
        let (Contents::Capture { warnings, .. } | Contents::Store { warnings, .. }) = &self.contents;
        for warning in warnings {
            let _ = writeln!(text, "  warning: {warning}");
        }
        let path = path.display();
        let _ = match &self.contents {
            Contents::Capture { pixels, normals, .. } => write!(
                text,
                "  {} pixels, {}\nNext: overlook preprocess {path} --out scene.ovl",
                output::count(*pixels),
                if *normals { "with normals" } else { "normals to be estimated from depth" }
            ),
            Contents::Store { samples, bytes, sizes, spans, report, .. } => write!(
                text,
                "  {} samples ({} of {} pixels) over {spans} spans in {}\n{}{}Next: overlook {path}",
                output::count(*samples),
                output::percent(*samples, report.samples_in),
                output::count(report.samples_in),
                output::bytes(*bytes),
                output::without_depth(report).unwrap_or_default(),
                sizes.text()
            ),
        };
        text
    }
}
