//! The areas of the window around the views.

mod command_palette;
mod help;
mod histogram;
mod matrix;
mod memory_view;
mod notices;
mod pair_grid;
mod palette_words;
mod path_field;
mod path_view;
mod report;
mod settings_ui;
mod status;
mod time;
mod timeline;
mod top_bar;
mod totals;
mod view_entries;
mod welcome;
mod workspaces;

pub(crate) use command_palette::palette_ui;
pub(crate) use help::help_ui;
pub(crate) use memory_view::memory_ui;
pub(crate) use notices::{log_ui, notices_ui};
pub(crate) use path_field::path_field_ui;
pub(crate) use path_view::path_ui;
pub(crate) use report::{matrix_view_ui, report_ui};
pub(crate) use settings_ui::{naming_ui, settings_ui};
pub(crate) use status::status_ui;
pub(crate) use time::time_ui;
pub(crate) use timeline::timeline_ui;
pub(crate) use top_bar::top_bar_ui;
pub(crate) use totals::totals_ui;
pub(crate) use welcome::{closing_ui, introduction_ui};
