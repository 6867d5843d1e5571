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
//! and asks the workers for what is missing; its `ui` only draws. `model` holds the data, `work` computes, `control` changes
//! the state, `views` and `panels` draw it.

mod camera_chips;
mod camera_cues;
mod colormap;
mod control;
mod dock;
mod model;
mod pace;
mod panels;
mod start;
mod theme;
mod views;
mod widgets;
mod window;
mod work;

#[cfg(test)]
mod tests;

pub(crate) use model::{DOTS_PER_INCH, FigureOptions, FigureWidth, Overlay, Unit, median_depth};
pub(crate) use work::{
    FIGURE_ENDINGS, of_camera as figure_of_camera, of_rendered as figure_of_rendered, write_figure,
};

pub use control::{Observed, OverlookApp, Start};
pub use start::run;
