//! What the window knows: plain data, commands and messages.
//!
//! ```text
//! State ── drawn by views and panels ──▶ Command ── carried out by control ──▶ State
//!   └──── keys of what is missing ──▶ work ──▶ Message ── taken in by control ──▶ State
//! ```

mod camera_path;
mod camera_text;
mod chart_axis;
mod charts;
mod command;
mod comparable;
mod compare_vantage;
mod comparison;
mod display;
mod document;
mod edit_command;
mod edited_region;
mod edited_samples;
mod edits;
mod figure;
mod frame_timer;
mod held_memory;
mod histogram;
mod inspector;
mod live_picture;
mod message;
mod motion_budget;
mod notice;
mod notify;
mod orbit_camera;
mod picture_folder;
mod picture_zoom;
mod pixel;
mod pose;
mod presets;
mod purpose;
mod readings;
mod recent;
mod results;
mod scene;
mod scene_values;
mod seen_picture;
mod session;
pub(crate) mod setting_names;
mod share;
mod share_size;
mod source_picture;
mod table;
mod table_text;
mod text;
mod texture;
mod timeline;
mod undo;
mod value_look;
pub(crate) mod verdict_text;
mod view;
mod view_history;
mod view_look;
mod work_kind;
mod workspace;

pub(crate) use camera_path::{CameraPath, ExportTarget, Exported, NO_KEYS, SavedPathKey};
pub(crate) use camera_text::{CameraText, TextPart};
pub(crate) use chart_axis::Quantity;
pub(crate) use charts::{Study, method_name, point_name, series_name, settings_alone};
pub(crate) use command::{Command, CommandPalette, Commands, HelpPage};
pub(crate) use compare_vantage::CompareVantage;
pub(crate) use comparison::{
    CompareChoice, CompareKey, CompareLook, CompareMeasure, CompareMode, CompareSide, DisplayColors,
    PictureDifference, ShownComparison,
};
pub(crate) use display::{Background, Channel, Display, EXPOSURES, LEVELS, PictureHistogram, ToneCurve};
pub(crate) use document::{Busy, SIDES, ShownPicture, SourceLook, State, StoppableWork};
pub(crate) use edit_command::{Combine, DrawnDepth, EditCommand, EditTime, EditTool};
pub(crate) use edited_region::{last_shape, words as region_words};
pub(crate) use edits::{BRUSH_RADII, EditKey, EditedScene, SceneEdits};
pub(crate) use figure::{DOTS_PER_INCH, FigureOf, FigureOptions, FigureWidth};
pub(crate) use frame_timer::Stopwatch;
pub(crate) use histogram::{BARS, CUT, ThresholdAxis, ThresholdHistogram};
pub(crate) use live_picture::{
    CarriedLook, CarryKey, ColorBy, HoleDisplay, LiveKey, LivePicture, PixelSource, ShownCarried,
};
pub(crate) use message::Message;
pub(crate) use motion_budget::MotionBudget;
pub(crate) use notice::{Notice, NoticeKind, NoticeLink, and_others};
pub(crate) use orbit_camera::OrbitCamera;
pub(crate) use picture_folder::PictureFolder;
pub(crate) use picture_zoom::PictureZoom;
pub(crate) use pixel::{ProbeKey, Probed, Spot};
pub(crate) use pose::{ANGLES_OF_VIEW, ViewAngles};
pub(crate) use presets::{PRESETS, keep};
pub(crate) use purpose::{Destination, Purpose, TypedPath};
pub(crate) use readings::{ReadingCheck, ReadingImages, ShownReadings};
pub(crate) use recent::{RECENT_SIDES, RecentPicture};
pub(crate) use results::{Accuracy, CameraMemory, Inspected, Whole, method_of};
pub(crate) use scene::{Content, OpenScene, SceneSource, median_depth};
pub(crate) use session::{SESSION_ENDING, Session};
pub(crate) use share::{
    PictureFacts, ShareCommand, ShareFacts, ShareKey, ShareOptions, ShareOutcome, SharePreview,
    SharePreviewKey, ShareWay, SharedPictures, ShownPreview,
};
pub(crate) use source_picture::{
    Legend, Overlay, RATIO_RANGE, SourceKey, SourcePicture, VIEW_DEPENDENCE_RANGE, ranked,
};
pub(crate) use table::{Table, TableForm};
pub(crate) use table_text::table_text;
pub(crate) use text::{
    account_parts, bytes, count, count_of, percent, sentence, significant, time_left, words,
};
pub(crate) use texture::Texture;
pub(crate) use timeline::{ShownRate, Timeline};
pub(crate) use undo::SettingsSlot;
pub(crate) use value_look::{ValueLook, titled_value};
pub(crate) use view::{Area, DockView};
pub(crate) use view_history::ViewHistory;
pub(crate) use view_look::{
    FLY_SPEEDS, FrameGuide, Guides, Ruler, ShownCameras, UP_DIRECTIONS, Unit, ViewCommand,
};
pub(crate) use work_kind::WorkKind;
pub(crate) use workspace::Workspace;
