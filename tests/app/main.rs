//! The window, driven as a person does: off screen by the names of its widgets, and on a display of the tests' own.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on should stop")]

mod alignment;
mod camera_signs;
mod cameras_and_view;
mod color;
#[cfg(target_os = "linux")]
#[expect(dead_code, reason = "other tests need its scene")]
#[path = "../common/command.rs"]
mod command;
mod device;
mod dialogs;
#[cfg(target_os = "linux")]
mod display;
mod display_choices;
mod driver;
mod edits;
mod every_size;
mod figures;
mod film;
#[cfg(target_os = "linux")]
mod first_minute;
mod guides;
mod help_and_recent;
mod inspector;
mod layout_faults;
mod manners;
mod many_cameras;
mod other_pictures;
mod palette;
#[path = "../common/private_words.rs"]
mod private_words;
mod random;
mod readings;
#[cfg(target_os = "linux")]
mod real_window;
mod screenshots;
mod share;
#[cfg(target_os = "linux")]
#[path = "../common/skip.rs"]
mod skip;
mod tables;
mod told_at_once;
mod typing;
mod viewer;
mod whole_window;
mod words;
