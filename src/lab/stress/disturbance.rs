//! The disturbances: what each does, and the values of its dial.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::depth_sensor::{depth_holes, flying_pixels, median_inverse_depth, misread, sensor_noise};
use super::recording_edits::{
    FrameKey, LightChange, Lighting, antialias, color_noise, depth_float, depth_noise, depth_steps, expose,
    narrow, normals_missing, normals_noisy,
};
use super::shapes::Inserted;
use crate::truth::{DERIVED_CACHE_BYTES, Recorded, Truth, TruthEdit};
use overlook_engine::capture::{
    Camera, Capture, Frame, INVALID_INVERSE_DEPTH, with_changed_frames, with_reindexed_frames,
};
use overlook_engine::error::Result;
use overlook_engine::random::mix;

/// Something that goes wrong, or a scene that is difficult.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Disturbance {
    /// Depth is off by Gaussian noise that differs from frame to frame.
    DepthNoise,
    /// Depth is rounded to an integer of the dial's bits between the nearest and farthest surface.
    DepthSteps,
    /// Depth is rounded to a float with the dial's bits of mantissa (10: half float). The capture declares it.
    DepthFloat,
    /// Color carries the noise of a path tracer, which differs from frame to frame.
    ColorNoise,
    /// Color is filtered across silhouettes, as anti-aliasing does. The capture declares it.
    Antialiasing,
    /// Normals are missing in squares of 8×8 pixels.
    NormalsMissing,
    /// Normals are off by Gaussian noise.
    NormalsNoisy,
    /// Every camera is turned away from its declared pose, by the same angle about an axis of its own.
    CameraPose,
    /// One camera runs behind the others.
    OutOfSync,
    /// Cameras are exposed differently, every other one more.
    Exposure,
    /// One camera delivers nothing in part of the frames.
    MissingCamera,
    /// Cameras are removed.
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
    /// Depth is off by the noise of a sensor: it grows with the square of the depth and is shared by pixels next to each other.
    SensorNoise,
    /// Pixels at depth steps are put in the air between the foreground and the background.
    FlyingPixels,
    /// One camera misreads the surface in the middle of its picture: half of it too near, half too far, as panes and mirrors do.
    MisreadSurface,
    /// Depth is missing in squares of 12×12 pixels.
    DepthHoles,
    /// Noise, flying pixels, a misread surface and holes, each at the dial's share of its largest, and no normals.
    CheapSensor,
}

/// A disturbance, its name for files, legends and the command line, the unit of its dial, and the values of the dial: the
/// undisturbed one first, the worst last.
type DisturbanceRow = (Disturbance, &'static str, &'static str, &'static [f64]);

const TABLE: [DisturbanceRow; 22] = [
    (Disturbance::DepthNoise, "depth noise", "% of depth", &[0.0, 0.1, 0.3, 1.0, 3.0]),
    (Disturbance::DepthSteps, "depth quantization", "bits", &[24.0, 12.0, 10.0, 8.0, 6.0]),
    (Disturbance::DepthFloat, "half-float depth", "bits of mantissa", &[23.0, 10.0, 7.0, 5.0]),
    (Disturbance::ColorNoise, "color noise", "% of color", &[0.0, 2.0, 5.0, 10.0, 20.0]),
    (Disturbance::Antialiasing, "anti-aliased silhouettes", "px", &[0.0, 0.5, 1.0, 2.0]),
    (Disturbance::NormalsMissing, "normals missing", "% of pixels", &[0.0, 25.0, 50.0, 100.0]),
    (Disturbance::NormalsNoisy, "normals noisy", "degrees", &[0.0, 5.0, 15.0, 45.0]),
    (Disturbance::CameraPose, "camera pose", "degrees", &[0.0, 0.05, 0.2, 0.5, 1.0]),
    (Disturbance::OutOfSync, "camera out of sync", "frames", &[0.0, 1.0, 2.0, 4.0]),
    (Disturbance::Exposure, "exposure", "stops", &[0.0, 0.1, 0.3, 1.0, 2.0]),
    (Disturbance::MissingCamera, "missing camera", "% of frames", &[0.0, 25.0, 50.0, 100.0]),
    (Disturbance::FewerCameras, "fewer cameras", "cameras gone", &[0.0, 1.0, 2.0, 3.0, 4.0]),
    (Disturbance::ThinStructures, "thin structures", "px thick", &[8.0, 4.0, 2.0, 1.0, 0.5]),
    (Disturbance::GrazingViews, "grazing views", "degrees", &[0.0, 45.0, 70.0, 80.0, 87.0]),
    (Disturbance::NarrowFrusta, "frusta part", "% of the width", &[100.0, 80.0, 60.0, 40.0]),
    (Disturbance::Specular, "specular surface", "× white", &[0.0, 0.1, 0.3, 1.0]),
    (Disturbance::MovingLight, "moving light", "× light", &[0.0, 0.1, 0.3, 1.0]),
    (Disturbance::SensorNoise, "sensor noise", "% at median depth", &[0.0, 0.3, 1.0, 3.0]),
    (Disturbance::FlyingPixels, "flying pixels", "% of edge pixels", &[0.0, 10.0, 30.0, 100.0]),
    (Disturbance::MisreadSurface, "misread surface", "% of the width", &[0.0, 20.0, 40.0, 80.0]),
    (Disturbance::DepthHoles, "holes in depth", "% of pixels", &[0.0, 10.0, 30.0, 60.0]),
    (Disturbance::CheapSensor, "cheap sensor", "% of each", &[0.0, 10.0, 30.0, 100.0]),
];

impl Disturbance {
    /// All of them.
    pub const ALL: [Self; TABLE.len()] = {
        let mut all = [Self::DepthNoise; TABLE.len()];
        let mut row = 0;
        while row < TABLE.len() {
            all[row] = TABLE[row].0;
            assert!(all[row] as usize == row, "rows are in the order of the enum");
            row += 1;
        }
        all
    };

    /// Name for files, legends and the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        TABLE[self as usize].1
    }

    /// Unit of the dial.
    #[must_use]
    pub fn unit(self) -> &'static str {
        TABLE[self as usize].2
    }

    /// The last value of the dial.
    fn largest(self) -> f64 {
        TABLE[self as usize].3.last().copied().unwrap_or_default()
    }

    /// Values of the dial, the undisturbed one first, the worst last. As many cameras stay as the truth needs.
    #[must_use]
    pub fn dial(self, capture: &Capture, truth: &Truth) -> Vec<f64> {
        let dial = TABLE[self as usize].3;
        match self {
            Self::FewerCameras => {
                let most_gone = capture.cameras.len().saturating_sub(truth.least_cameras());
                dial.iter().copied().take(most_gone + 1).collect()
            }
            _ => dial.to_vec(),
        }
    }

    /// What the capture lacks for this disturbance to change it, as the end of a sentence that begins with "there".
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
    /// Those of loading its first frames, which give the size of the scene.
    pub fn apply(self, capture: &Capture, dial: f64) -> Result<Recorded> {
        let amount = dial as f32;
        let middle = capture.cameras.len() / 2;
        Ok(match self {
            Self::DepthNoise => edited(capture, move |frame, at| depth_noise(frame, 0.01 * amount, at)),
            Self::DepthSteps => {
                let (near, far) = depth_range(capture)?;
                edited(capture, move |frame, _| depth_steps(frame, dial, near, far))
            }
            Self::DepthFloat => edited(capture, move |frame, _| depth_float(frame, dial as u32)),
            Self::ColorNoise => edited(capture, move |frame, at| color_noise(frame, 0.01 * amount, at)),
            Self::Antialiasing => {
                let recorded = edited(capture, move |frame, _| antialias(frame, amount));
                let is_filtered = capture.antialiased_color || dial > 0.0;
                Recorded { capture: recorded.capture.with_antialiased_color(is_filtered), ..recorded }
            }
            Self::NormalsMissing => {
                edited(capture, move |frame, at| normals_missing(frame, 0.01 * amount, at))
            }
            Self::NormalsNoisy => {
                let radians = amount.to_radians();
                edited(capture, move |frame, at| normals_noisy(frame, radians, at))
            }
            Self::CameraPose => {
                let turned = |index: usize, camera: &mut Camera| turn(camera, index as u64, dial);
                recorded(capture, capture.clone().with_changed_cameras(turned))
            }
            Self::OutOfSync => {
                let behind = dial as usize;
                let shown = move |camera: usize, frame: usize| {
                    if camera == middle { frame.saturating_sub(behind) } else { frame }
                };
                recorded(capture, with_reindexed_frames(capture, DERIVED_CACHE_BYTES, shown))
            }
            Self::Exposure => edited(capture, move |frame, at| expose(frame, amount, at.camera)),
            Self::MissingCamera => {
                let first_missing = capture.frame_count() as f64 * (1.0 - 0.01 * dial);
                edited(capture, move |frame, at| {
                    if at.camera == middle && at.frame as f64 >= first_missing {
                        frame.inverse_depth.as_mut_slice().fill(INVALID_INVERSE_DEPTH);
                    }
                })
            }
            Self::FewerCameras => {
                let left = capture.cameras.len() - dial as usize;
                let few = capture.with_cameras(|index, _| index < left);
                Recorded { all_cameras: capture.clone(), ..Recorded::undisturbed(&few) }
            }
            Self::NarrowFrusta => edited(capture, move |frame, _| narrow(frame, 0.01 * dial)),
            Self::ThinStructures => inserted(capture, Inserted::bars(capture, dial)?),
            Self::GrazingViews => inserted(capture, Inserted::panel(capture, dial)?),
            Self::Specular => relit(capture, Lighting::new(capture, LightChange::Specular, amount)),
            Self::MovingLight => relit(capture, Lighting::new(capture, LightChange::Moving, amount)),
            Self::SensorNoise
            | Self::FlyingPixels
            | Self::MisreadSurface
            | Self::DepthHoles
            | Self::CheapSensor => self.sensed(capture, dial)?,
        })
    }

    /// The capture as a depth sensor records it with this one fault, or with all of them.
    fn sensed(self, capture: &Capture, dial: f64) -> Result<Recorded> {
        let median = median_inverse_depth(capture)?;
        let middle = capture.cameras.len() / 2;
        let amount = |fault: Self| match self {
            Self::CheapSensor => 0.0001 * dial * fault.largest(),
            _ if self == fault => 0.01 * dial,
            _ => 0.0,
        };
        let [noise, flying, misread_part, holes] =
            [Self::SensorNoise, Self::FlyingPixels, Self::MisreadSurface, Self::DepthHoles].map(amount);
        let without_normals = self == Self::CheapSensor && dial > 0.0;
        let recorded = edited(capture, move |frame, at| {
            if without_normals {
                frame.normal_in_world = None;
            }
            if at.camera == middle {
                misread(frame, misread_part);
            }
            flying_pixels(frame, flying as f32, at);
            sensor_noise(frame, noise as f32 * median, at);
            depth_holes(frame, holes as f32, at);
        });
        if without_normals {
            return Ok(Recorded { capture: recorded.capture.without_normals(), ..recorded });
        }
        Ok(recorded)
    }
}

/// A disturbed capture beside the clean one.
fn recorded(clean: &Capture, capture: Capture) -> Recorded {
    Recorded { capture, ..Recorded::undisturbed(clean) }
}

/// The capture with every frame changed, beside the clean one.
fn edited(capture: &Capture, edit: impl Fn(&mut Frame, FrameKey) + Send + Sync + 'static) -> Recorded {
    let change = move |camera: usize, frame: usize, recorded: &Frame| {
        let mut changed = recorded.clone();
        edit(&mut changed, FrameKey { camera, frame });
        changed
    };
    recorded(capture, with_changed_frames(capture, DERIVED_CACHE_BYTES, change))
}

/// A scene with something put into it: the truth shows it too.
fn inserted(capture: &Capture, inserted: Inserted) -> Recorded {
    let (inserted, cameras) = (Arc::new(inserted), capture.cameras.clone());
    let shapes = inserted.clone();
    let scene = edited(capture, move |frame, at| shapes.put_into(&cameras[at.camera], frame)).capture;
    let edit: TruthEdit = Arc::new(move |camera: &Camera, _, frame: &mut Frame| {
        inserted.put_into(camera, frame);
        inserted.only_near(camera, frame);
    });
    Recorded { edit_truth: Some(edit), ..Recorded::undisturbed(&scene) }
}

/// A scene under other light: so is the truth.
fn relit(capture: &Capture, lighting: Lighting) -> Recorded {
    let (lighting, cameras) = (Arc::new(lighting), capture.cameras.clone());
    let light = lighting.clone();
    let scene = edited(capture, move |frame, at| light.apply(&cameras[at.camera], at.frame, frame)).capture;
    let numbers = capture.frame_numbers.clone();
    let edit: TruthEdit = Arc::new(move |camera: &Camera, number, frame: &mut Frame| {
        lighting.apply(camera, numbers.binary_search(&number).unwrap_or_default(), frame);
    });
    Recorded { edit_truth: Some(edit), ..Recorded::undisturbed(&scene) }
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
