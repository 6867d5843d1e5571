//! The window: egui panels over the same library calls as the command line.
//!
//! ```text
//!            read-only State
//!   ui() ◀───────────────────── logic() ◀── Message ── workers (named threads, one kind of work each)
//!     │                           ▲  │
//!     └──────── Command ──────────┘  └──── requests ──▶ workers (of pictures the latest wins, files wait in line)
//! ```
//!
//! The UI thread neither computes nor touches files: the `logic` of [`OverlookApp`] takes in answers, carries out commands
//! and asks the workers for what is missing; its `ui` only draws. `model` holds the data, `work` computes and `control` changes
//! the state. What a feature adds to each of them, and how it is drawn, lies in one folder of `rooms`.

mod camera_cues;
mod colormap;
mod control;
mod dock;
mod export_menu;
mod model;
mod pace;
pub(crate) mod picture_menu;
mod rooms;
mod start;
mod theme;
mod views;
mod widgets;
mod work;

#[cfg(test)]
mod tests;

pub(crate) use crate::app::model::picture::Overlay;
pub(crate) use crate::app::model::pivot_of_store;
pub(crate) use crate::app::rooms::share::work::pictures::{
    of_camera as figure_of_camera, of_rendered as figure_of_rendered, write as write_figure,
};

pub use crate::app::control::{Observed, OverlookApp, Start};
pub use crate::app::start::run;
