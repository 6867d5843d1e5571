//! `overlook info`: what a capture or a store holds.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::cli::output::{self, CommandError, Sizes};
use overlook_engine::capture::conventions::{self, Finding};
use overlook_engine::capture::{Camera, Capture, Description, Source, ValueChannel};
use overlook_engine::error::Error;
use overlook_engine::plural::counted;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::settings::{CaptureSettings, Settings};
use overlook_engine::store::file::{Provenance, Store, StoredValues};

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// A capture (a folder, or a file in it that names its pictures) or a store.
    path: PathBuf,
    /// Write a manifest of the capture as it is read, to be corrected by hand [default file: transforms.json in its folder].
    #[arg(long, value_name = "FILE")]
    #[expect(clippy::option_option, reason = "without, with, and with a file")]
    write_manifest: Option<Option<PathBuf>>,
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct CameraInfo {
    name: String,
    width: u32,
    height: u32,
    #[serde(rename = "orthographic", skip_serializing_if = "std::ops::Not::not")]
    is_orthographic: bool,
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

/// A channel of scalar values.
#[serde_with::skip_serializing_none]
#[derive(Serialize)]
struct ValueInfo {
    #[serde(flatten)]
    channel: ValueChannel,
    /// By how much a stored value differs from the capture's, at most.
    error: Option<f32>,
    /// Bytes of the channel in the store.
    bytes: Option<u64>,
}

impl ValueInfo {
    fn of(channel: &ValueChannel) -> Self {
        Self { channel: channel.clone(), error: None, bytes: None }
    }

    fn stored(stored: &StoredValues) -> Self {
        Self { channel: stored.channel.clone(), error: Some(stored.error), bytes: Some(stored.bytes) }
    }

    fn line(&self) -> String {
        let ValueChannel { name, unit, range: [low, high], tolerance, .. } = &self.channel;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let mut line = format!("value {name}: {low} to {high}{unit}, the same within {tolerance}");
        if let (Some(error), Some(bytes)) = (self.error, self.bytes) {
            let kept = if error > 0.0 { format!("within {error}") } else { "exact".to_owned() };
            let _ = write!(line, "; {kept}, {}", output::bytes(bytes));
        }
        line
    }
}

#[derive(Serialize)]
struct ConventionInfo {
    /// In words.
    sentence: String,
    /// Whether another reading fits far better, or the views could not be read.
    is_warning: bool,
    finding: Option<Finding>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Contents {
    Capture {
        pixels: u64,
        normals: bool,
        /// The channels of scalar values.
        values: Vec<ValueInfo>,
        reading: Box<Description>,
        /// The share of the pixels that are no samples because they are transparent, in pictures that were looked at.
        #[serde(skip_serializing_if = "Option::is_none")]
        transparent: Option<f64>,
        warnings: Vec<String>,
        /// The finding about the reading of poses and depth, from the agreement between views.
        conventions: ConventionInfo,
    },
    Store {
        samples: u64,
        bytes: u64,
        sizes: Box<Sizes>,
        spans: usize,
        /// The channels of scalar values.
        values: Vec<ValueInfo>,
        version: String,
        settings: Box<Settings>,
        report: Box<Report>,
        provenance: Box<Provenance>,
        warnings: Vec<String>,
    },
}

impl InfoArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let info = if Store::is_store(&self.path)? {
            if self.write_manifest.is_some() {
                let what = "is a store; a manifest can be written of a capture";
                return Err(Error::invalid(self.path.display(), what).into());
            }
            of_store(&self.path)?
        } else {
            self.of_capture()?
        };
        if self.json { output::print_json(&info) } else { output::print(&info.text(&self.path)) }
    }
}

impl InfoArgs {
    fn of_capture(&self) -> Result<Info, CommandError> {
        let source = Source::find(&self.path)?;
        let capture = source.open(&CaptureSettings::default())?;
        if let Some(file) = &self.write_manifest {
            let file = file.clone().unwrap_or_else(|| source.manifest_path());
            source.write_manifest(&file)?;
            eprintln!("wrote {}", file.display());
        }
        Ok(Info {
            kind: "capture",
            name: capture.name.clone(),
            cameras: camera_infos(&capture.cameras),
            frames: capture.frame_count(),
            contents: Contents::Capture {
                pixels: capture.pixel_count(),
                normals: capture.has_normals,
                values: capture.value_channels().iter().map(ValueInfo::of).collect(),
                reading: Box::new(source.description().clone()),
                transparent: capture.transparent_share()?,
                warnings: capture.warnings.clone(),
                conventions: ConventionInfo::of(&capture),
            },
        })
    }
}

fn camera_infos(cameras: &[Camera]) -> Vec<CameraInfo> {
    let info = |camera: &Camera| {
        let (name, intrinsics) = (camera.name.clone(), camera.intrinsics);
        let is_orthographic = intrinsics.is_orthographic();
        CameraInfo { name, width: intrinsics.width, height: intrinsics.height, is_orthographic }
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
            values: info.values.iter().map(ValueInfo::stored).collect(),
            version: format!("{}.{}", info.version.0, info.version.1),
            settings: Box::new(info.settings.clone()),
            report: Box::new(report),
            provenance: Box::new(info.provenance.clone()),
            warnings: info.warnings.clone(),
        },
    })
}

impl ConventionInfo {
    fn of(capture: &Capture) -> Self {
        match conventions::check(capture) {
            Ok(finding) => Self {
                sentence: finding.sentence(),
                is_warning: finding.warning().is_some(),
                finding: Some(finding),
            },
            Err(error) => Self { sentence: format!("not checked: {error}"), is_warning: true, finding: None },
        }
    }
}

impl Info {
    fn text(&self, path: &Path) -> String {
        let mut text = format!("{} '{}': {}\n", self.kind, self.name, counted(self.frames, "frame"));
        for camera in &self.cameras {
            let _ = writeln!(text, "  camera {:<16} {}×{}", camera.name, camera.width, camera.height);
        }
        if let Contents::Capture { reading, transparent, .. } = &self.contents {
            for line in reading.lines() {
                let _ = writeln!(text, "  {line}");
            }
            if let Some(share) = transparent.filter(|share| *share > 0.0) {
                let share = 100.0 * share;
                let _ = writeln!(
                    text,
                    "  alpha: what is transparent is no sample ({share:.0} % of the pixels of the pictures looked at); \"use_alpha\": false in the manifest says otherwise"
                );
            }
        }
        let (Contents::Capture { warnings, values, .. } | Contents::Store { warnings, values, .. }) =
            &self.contents;
        for value in values {
            let _ = writeln!(text, "  {}", value.line());
        }
        for warning in warnings {
            let _ = writeln!(text, "  warning: {warning}");
        }
        if let Contents::Capture { conventions, .. } = &self.contents {
            let word = if conventions.is_warning { "warning" } else { "conventions" };
            let _ = writeln!(text, "  {word}: {}", conventions.sentence);
        }
        let path = path.display();
        let _ = match &self.contents {
            Contents::Capture { pixels, normals, .. } => write!(
                text,
                "  {}, {}\nNext: overlook preprocess {path} --out scene.ovl",
                output::count_of(*pixels, "pixel"),
                if *normals { "with normals" } else { "normals to be estimated from depth" }
            ),
            Contents::Store { samples, bytes, sizes, spans, report, .. } => write!(
                text,
                "  {} ({} of {}) over {} in {}\n{}{}{}Next: overlook {path}",
                output::count_of(*samples, "sample"),
                output::percent(*samples, report.samples_in),
                output::count_of(report.samples_in, "pixel"),
                counted(*spans, "span"),
                output::bytes(*bytes),
                output::without_depth(report).unwrap_or_default(),
                output::cut_by_hand(report),
                sizes.text()
            ),
        };
        text
    }
}
