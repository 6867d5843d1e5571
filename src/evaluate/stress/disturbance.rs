//! The disturbances: what each does, and where its dial can stand.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::light::{Lighting, lit};
use super::recording_edits::{Edit, Edited};
use super::shapes::Inserted;
use crate::capture::{Camera, Capture, CaptureParts, Frame};
use crate::demo::tracer::mix;
use crate::error::Result;
use crate::evaluate::truth::{DERIVED_CACHE_BYTES, Recorded, Truth, TruthEdit, parts_of};

/// Something that goes wrong, or a scene that is difficult.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Disturbance {
    /// Depth is off by Gaussian noise that differs from frame to frame.
    DepthNoise,
    /// Depth is stored in whole numbers of so many bits between the nearest and farthest surface.
    DepthSteps,
    /// Depth is stored in floats of so many bits of mantissa; 10 is a half float. The capture says so.
    DepthFloat,
    /// Color carries the noise of a path tracer, which differs from frame to frame.
    ColorNoise,
    /// Color is filtered across silhouettes, as anti-aliasing does. The capture says so.
    Antialiasing,
    /// Normals are missing in squares of 8×8 pixels.
    NormalsMissing,
    /// Normals are off by Gaussian noise.
    NormalsNoisy,
    /// Every camera is turned, by the same angle about an axis of its own, from where the capture says it is.
    CameraPose,
    /// One camera runs behind the others.
    OutOfSync,
    /// Cameras are exposed differently, every other one more.
    Exposure,
    /// One camera delivers nothing in part of the frames.
    MissingCamera,
    /// Only some of the cameras are there.
    FewerCameras,
    /// Bars stand in the scene, thinner and thinner. Scored on and around them.
    ThinStructures,
    /// A patterned panel stands in the scene, seen at a more and more grazing angle by the first camera. Scored on it.
    GrazingViews,
    /// Cameras see a smaller and smaller part around the middle of their picture, until they no longer overlap.
    NarrowFrusta,
    /// Surfaces are shiny: a highlight that each camera sees elsewhere. Drawn in the picture, without shadows.
    Specular,
    /// A light goes round the scene once. Drawn in the picture, without shadows.
    MovingLight,
}

impl Disturbance {
    /// All of them.
    pub const ALL: [Self; 17] = [
        Self::DepthNoise,
        Self::DepthSteps,
        Self::DepthFloat,
        Self::ColorNoise,
        Self::Antialiasing,
        Self::NormalsMissing,
        Self::NormalsNoisy,
        Self::CameraPose,
        Self::OutOfSync,
        Self::Exposure,
        Self::MissingCamera,
        Self::FewerCameras,
        Self::ThinStructures,
        Self::GrazingViews,
        Self::NarrowFrusta,
        Self::Specular,
        Self::MovingLight,
    ];

    /// Name for files, legends and the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DepthNoise => "depth noise",
            Self::DepthSteps => "depth quantization",
            Self::DepthFloat => "half-float depth",
            Self::ColorNoise => "color noise",
            Self::Antialiasing => "anti-aliased silhouettes",
            Self::NormalsMissing => "normals missing",
            Self::NormalsNoisy => "normals noisy",
            Self::CameraPose => "camera pose",
            Self::OutOfSync => "camera out of sync",
            Self::Exposure => "exposure",
            Self::MissingCamera => "missing camera",
            Self::FewerCameras => "fewer cameras",
            Self::ThinStructures => "thin structures",
            Self::GrazingViews => "grazing views",
            Self::NarrowFrusta => "frusta part",
            Self::Specular => "specular surface",
            Self::MovingLight => "moving light",
        }
    }

    /// Unit of the dial.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::DepthNoise => "% of depth",
            Self::DepthSteps => "bits",
            Self::DepthFloat => "bits of mantissa",
            Self::ColorNoise => "% of color",
            Self::Antialiasing => "px",
            Self::NormalsMissing => "% of pixels",
            Self::NormalsNoisy | Self::CameraPose | Self::GrazingViews => "degrees",
            Self::OutOfSync => "frames",
            Self::Exposure => "stops",
            Self::MissingCamera => "% of frames",
            Self::FewerCameras => "cameras gone",
            Self::ThinStructures => "px thick",
            Self::NarrowFrusta => "% of the width",
            Self::Specular => "× white",
            Self::MovingLight => "× light",
        }
    }

    /// Values of the dial, the undisturbed one first, the worst last. As many cameras stay as the truth needs.
    #[must_use]
    pub fn dial(self, capture: &Capture, truth: &Truth) -> Vec<f64> {
        match self {
            Self::DepthNoise => vec![0.0, 0.1, 0.3, 1.0, 3.0],
            Self::DepthSteps => vec![24.0, 12.0, 10.0, 8.0, 6.0],
            Self::DepthFloat => vec![23.0, 10.0, 7.0, 5.0],
            Self::ColorNoise => vec![0.0, 2.0, 5.0, 10.0, 20.0],
            Self::Antialiasing => vec![0.0, 0.5, 1.0, 2.0],
            Self::NormalsMissing | Self::MissingCamera => vec![0.0, 25.0, 50.0, 100.0],
            Self::NormalsNoisy => vec![0.0, 5.0, 15.0, 45.0],
            Self::CameraPose => vec![0.0, 0.05, 0.2, 0.5, 1.0],
            Self::OutOfSync => vec![0.0, 1.0, 2.0, 4.0],
            Self::FewerCameras => {
                let gone = capture.cameras.len().saturating_sub(truth.least_cameras()).min(4);
                (0..=gone).map(|gone| gone as f64).collect()
            }
            Self::ThinStructures => vec![8.0, 4.0, 2.0, 1.0, 0.5],
            Self::GrazingViews => vec![0.0, 45.0, 70.0, 80.0, 87.0],
            Self::NarrowFrusta => vec![100.0, 80.0, 60.0, 40.0],
            Self::Exposure | Self::Specular | Self::MovingLight => vec![0.0, 0.1, 0.3, 1.0],
        }
    }

    /// What there is not in a capture that this cannot change, in words that go on from "there".
    #[must_use]
    pub fn lacks(self, capture: &Capture) -> Option<&'static str> {
        match self {
            Self::NormalsMissing | Self::NormalsNoisy if !capture.has_normals => {
                Some("are no recorded normals")
            }
            Self::OutOfSync if capture.frame_count() < 2 => Some("is a single frame"),
            _ => None,
        }
    }

    /// The capture under this disturbance.
    ///
    /// # Errors
    /// Whatever loading its first frames gives: the size of the scene is taken from them.
    pub fn apply(self, capture: &Capture, dial: f64) -> Result<Recorded> {
        let amount = dial as f32;
        let middle = capture.cameras.len() / 2;
        let edited = |edit: Edit| recorded(capture, edit, |_| ());
        Ok(match self {
            Self::DepthNoise => edited(Edit::DepthNoise(0.01 * amount)),
            Self::DepthSteps => edited(Edit::DepthSteps { bits: dial, range: depth_range(capture)? }),
            Self::DepthFloat => edited(Edit::DepthFloat { bits: dial as u32 }),
            Self::ColorNoise => edited(Edit::ColorNoise(0.01 * amount)),
            Self::Antialiasing => recorded(capture, Edit::Antialiasing(amount), |parts| {
                parts.antialiased_color |= dial > 0.0;
            }),
            Self::NormalsMissing => edited(Edit::NormalsMissing(0.01 * amount)),
            Self::NormalsNoisy => edited(Edit::NormalsNoisy(amount.to_radians())),
            Self::CameraPose => recorded(capture, Edit::None, |parts| {
                for (index, camera) in parts.cameras.iter_mut().enumerate() {
                    turn(camera, index as u64, dial);
                }
            }),
            Self::OutOfSync => edited(Edit::OutOfSync { camera: middle, by: dial as usize }),
            Self::Exposure => edited(Edit::Exposure(amount)),
            Self::MissingCamera => edited(Edit::Missing { camera: middle, share: 0.01 * dial }),
            Self::FewerCameras => {
                let left = capture.cameras.len() - dial as usize;
                let few = capture.with_cameras(|index, _| index < left);
                Recorded { places: capture.clone(), ..Recorded::undisturbed(&few) }
            }
            Self::NarrowFrusta => edited(Edit::Narrow(0.01 * dial)),
            Self::ThinStructures => inserted(capture, Inserted::bars(capture, dial)?),
            Self::GrazingViews => inserted(capture, Inserted::panel(capture, dial)?),
            Self::Specular => relit(capture, Lighting::specular(capture, amount)),
            Self::MovingLight => relit(capture, Lighting::moving(capture, amount)),
        })
    }
}

impl std::str::FromStr for Disturbance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = Self::ALL.into_iter().find(|disturbance| disturbance.name() == text);
        named.ok_or_else(|| format!("'{text}' is not one of {}", Self::ALL.map(Self::name).join(", ")))
    }
}

fn derived(capture: &Capture, edit: Edit, change: impl FnOnce(&mut CaptureParts)) -> Capture {
    let mut parts = parts_of(capture, Arc::new(Edited { capture: capture.clone(), edit }));
    change(&mut parts);
    Capture::new(parts, DERIVED_CACHE_BYTES)
}

fn recorded(capture: &Capture, edit: Edit, change: impl FnOnce(&mut CaptureParts)) -> Recorded {
    Recorded { capture: derived(capture, edit, change), ..Recorded::undisturbed(capture) }
}

/// A scene with something put into it: what the cameras recorded is the truth's own scene.
fn inserted(capture: &Capture, inserted: Inserted) -> Recorded {
    let inserted = Arc::new(inserted);
    let there = derived(capture, Edit::Inserted(inserted.clone()), |_| ());
    let edit: TruthEdit = Arc::new(move |camera: &Camera, _, frame: Frame| {
        let frame = inserted.put_into(camera, frame);
        inserted.only_near(camera, frame)
    });
    Recorded { edit_truth: Some(edit), ..Recorded::undisturbed(&there) }
}

/// A scene under other light.
fn relit(capture: &Capture, lighting: Lighting) -> Recorded {
    let lighting = Arc::new(lighting);
    let there = derived(capture, Edit::Relit(lighting.clone()), |_| ());
    let numbers = capture.frame_numbers.clone();
    let edit: TruthEdit = Arc::new(move |camera: &Camera, number, frame: Frame| {
        let index = numbers.binary_search(&number).unwrap_or_default();
        lit(&lighting, camera, index, frame)
    });
    Recorded { edit_truth: Some(edit), ..Recorded::undisturbed(&there) }
}

/// Turns a camera about an axis of its own.
fn turn(camera: &mut Camera, index: u64, degrees: f64) {
    let part = |salt: u64| (mix(index ^ salt) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
    let axis = DVec3::new(part(11), part(22), part(33)).try_normalize().unwrap_or(DVec3::X);
    let rotation = glam::DMat3::from_quat(DQuat::from_axis_angle(axis, degrees.to_radians()));
    camera.world_from_camera.matrix3 = rotation * camera.world_from_camera.matrix3;
}

/// Nearest and farthest depth of all cameras' first frames.
fn depth_range(capture: &Capture) -> Result<(f32, f32)> {
    let (mut near, mut far) = (f32::INFINITY, 0.0_f32);
    for camera in 0..capture.cameras.len() {
        for inverse_depth in capture.frame(camera, 0)?.inverse_depth.as_slice() {
            if *inverse_depth > 0.0 {
                (near, far) = (near.min(1.0 / inverse_depth), far.max(1.0 / inverse_depth));
            }
        }
    }
    Ok(if far > 0.0 { (0.5 * near, 1.1 * far) } else { (0.0, 1.0) })
}
