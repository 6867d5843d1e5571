//! What is drawn.

pub(crate) mod command_palette;
pub(crate) mod palette_entries;
pub(crate) mod palette_words;
pub(crate) mod panel;
pub(crate) mod view_entries;

pub(crate) use command_palette::palette_ui;
pub(crate) use panel::help_ui;
