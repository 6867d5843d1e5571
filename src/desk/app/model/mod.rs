//! What the window knows: plain data, commands and messages.
//!
//! ```text
//! State ── drawn by views and panels ──▶ Command ── carried out by control ──▶ State
//!   └──── keys of what is missing ──▶ work ──▶ Message ── taken in by control ──▶ State
//! ```

pub(crate) mod command;
pub(crate) mod document;
pub(crate) mod frame_timer;
pub(crate) mod inspector;
pub(crate) mod message;
pub(crate) mod results;
pub(crate) mod same;
pub(crate) mod scene;
pub(crate) mod state;
pub(crate) mod text;
pub(crate) mod texture;
pub(crate) mod undo;
mod undo_list;
pub(crate) mod work_kind;

pub(crate) use command::{Command, Commands};
pub(crate) use document::{Document, ShownPicture};
pub(crate) use frame_timer::Stopwatch;
pub(crate) use message::Message;
pub(crate) use results::{Accuracy, CameraMemory, Inspected, Method, Whole, method_of};
pub(crate) use same::Same;
pub(crate) use scene::{Content, OpenScene, SceneSource, median_depth, pivot_of_store};
pub(crate) use state::{Busy, SIDES, State, StoppableWork};
pub(crate) use text::{
    account_parts, bytes, count, count_of, percent, sentence, significant, time_left, took, words,
};
pub(crate) use texture::Texture;
pub(crate) use undo::{Part, SettingsSlot, Undoable};
pub(crate) use work_kind::WorkKind;
