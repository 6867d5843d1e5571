//! What the window knows: plain data, commands and messages.

mod axis_marks;
mod camera_path;
mod chart_axis;
mod charts;
mod command;
mod compare_options;
mod document;
mod frame_timer;
mod inspector;
mod message;
mod orbit_camera;
mod presets;
mod scene;
pub(crate) mod setting_names;
mod text;
mod texture;
mod undo;

pub(crate) use axis_marks::{label, marks};
pub(crate) use camera_path::{ExportRequest, ExportTarget, Exported, NO_KEYS, SavedPathKey};
pub(crate) use chart_axis::Quantity;
pub(crate) use charts::{Study, method_name, point_name, series_name, settings_alone};
pub(crate) use command::Command;
pub(crate) use compare_options::{CompareLook, CompareMeasure, CompareSide, CompareVantage, Mode};
pub(crate) use document::{
    Busy, FIRST_SIZE, Inspected, LiveLook, Notice, NoticeKind, SIDES, ShownPicture, SourceLook, State,
    StoppableWork, Timeline, TypedPath, Whole, and_others, method_of,
};
pub(crate) use frame_timer::Stopwatch;
pub(crate) use inspector::{Inspector, InspectorLanes, InspectorPlan};
pub(crate) use message::{Accuracy, Message, Purpose};
pub(crate) use orbit_camera::OrbitCamera;
pub(crate) use presets::{PRESETS, keep};
pub(crate) use scene::{Content, OpenScene, Origin, median_depth};
pub(crate) use text::{bytes, count, percent, sentence, significant, time_left, words};
pub(crate) use texture::Texture;
pub(crate) use undo::SettingsSlot;
