//! What the window knows: plain data, commands and messages.
//!
//! ```text
//! State ── drawn by views and panels ──▶ Command ── carried out by control ──▶ State
//!   └──── keys of what is missing ──▶ work ──▶ Message ── taken in by control ──▶ State
//! ```

pub(crate) mod camera;
pub(crate) mod camera_text;
pub(crate) mod command;
pub(crate) mod look;
pub(crate) mod message;
pub(crate) mod motion_budget;
pub(crate) mod notice;
pub(crate) mod picture;
pub(crate) mod purpose;
pub(crate) mod same;
pub(crate) mod scene;
pub(crate) mod setting_names;
pub(crate) mod state;
pub(crate) mod texture;
pub(crate) mod undo;
mod undo_list;
pub(crate) mod window;
pub(crate) mod work_kind;

pub(crate) use crate::app::model::scene::{
    Accuracy, CameraMemory, Content, Inspected, Method, OpenScene, SceneSource, Whole, median_depth,
    method_of, pivot_of_store,
};
pub(crate) use crate::app::model::state::{Busy, Document, SIDES, ShownPicture, State};
pub(crate) use crate::text::{
    account_parts, bytes, count, count_of, percent, sentence, significant, time_left, took, words,
};
pub(crate) use command::{Command, Commands};
pub(crate) use message::Message;
pub(crate) use same::Same;
pub(crate) use texture::Texture;
pub(crate) use undo::{Part, SettingsSlot, Undoable};
pub(crate) use work_kind::WorkKind;
