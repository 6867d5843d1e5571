//! The areas of the window. Each borrows the state and sends commands; none changes anything itself.

mod agreement;
mod histogram;
mod log;
mod matrix;
mod memory_view;
mod notices;
mod palette;
mod parts;
mod path_field;
mod path_view;
mod presets;
mod report;
mod settings_ui;
mod status;
mod time;
mod timeline;
mod top_bar;
mod totals;
mod welcome;

use egui::{CentralPanel, Frame, Margin, Panel};

use super::command::Command;
use super::dock::{Dock, View};
use super::state::State;
use super::theme::{Tokens, space};
use super::views::{
    cameras_view, chart_view, compare_view, live_view, pixel_view, source_view, stability_view,
};
pub(super) use palette::Palette;
pub(super) use parts::{choice_ui, empty_ui, icon_button, segments_ui};

/// The whole window.
pub(super) fn window_ui(ui: &mut egui::Ui, state: &State, dock: &mut Dock, commands: &mut Vec<Command>) {
    let tokens = Tokens::in_ui(ui);
    let bar = Frame::new().fill(tokens.surface).inner_margin(Margin::symmetric(space::PANEL, 0));
    Panel::top("top bar")
        .exact_size(space::TOP_BAR)
        .frame(bar)
        .show(ui, |ui| top_bar::top_bar_ui(ui, state, commands));
    Panel::top("totals").exact_size(space::TOTALS).frame(bar).show(ui, |ui| totals::totals_ui(ui, state));
    Panel::bottom("status")
        .exact_size(space::STATUS)
        .frame(bar)
        .show(ui, |ui| status::status_ui(ui, state, commands));
    Panel::bottom("timeline")
        .exact_size(space::TIMELINE)
        .frame(bar.inner_margin(Margin::symmetric(space::PANEL, 4)))
        .show(ui, |ui| timeline::timeline_ui(ui, state, commands));
    CentralPanel::no_frame()
        .frame(Frame::new().fill(tokens.background).inner_margin(Margin { top: 4, ..Margin::ZERO }))
        .show(ui, |ui| {
            if state.scene.is_none() {
                nothing_open_ui(ui, state, commands);
            } else {
                dock.ui(ui, state, commands);
            }
        });
    notices::notices_ui(ui.ctx(), state, commands);
    path_field::path_field_ui(ui.ctx(), state, commands);
    presets::naming_ui(ui.ctx(), state, commands);
    welcome::introduction_ui(ui.ctx(), state, commands);
    palette::palette_ui(ui.ctx(), state, commands);
    palette::cheat_sheet_ui(ui.ctx(), state, commands);
    welcome::closing_ui(ui.ctx(), state, commands);
    drop_hint_ui(ui);
}

/// One view.
pub(super) fn view_ui(ui: &mut egui::Ui, view: View, state: &State, commands: &mut Vec<Command>) {
    match view {
        View::Source => source_view::source_view_ui(ui, state, commands),
        View::Live => live_view::live_view_ui(ui, state, commands),
        View::Compare => compare_view::compare_view_ui(ui, state, commands),
        View::Path => path_view::path_ui(ui, state, commands),
        View::Tradeoff => chart_view::tradeoff_ui(ui, state, commands),
        View::Stability => stability_view::stability_ui(ui, state, commands),
        View::Pixel => pixel_view::pixel_view_ui(ui, state, commands),
        View::Cameras => cameras_view::cameras_view_ui(ui, state, commands),
        View::Matrix => report::matrix_view_ui(ui, state),
        View::Time => time::time_ui(ui, state, commands),
        View::Memory => memory_view::memory_ui(ui, state),
        View::Thresholds => settings_ui::settings_ui(ui, state, commands),
        View::Report => report::report_ui(ui, state),
        View::Log => log::log_ui(ui, state),
    }
}

fn nothing_open_ui(ui: &mut egui::Ui, state: &State, commands: &mut Vec<Command>) {
    use super::message::Purpose;
    use egui_material_icons::icons::{ICON_FOLDER_OPEN, ICON_HOURGLASS_TOP};
    if let Some(opening) = &state.opening {
        empty_ui(
            ui,
            ICON_HOURGLASS_TOP,
            &format!("Opening {opening}"),
            "The first picture is on its way.",
            |ui| {
                ui.add(egui::Spinner::new().size(22.0));
            },
        );
        return;
    }
    let text = "Open a folder of EXR frames with its transforms.json, or a store that was saved before. \
                You can also drop it on this window.";
    empty_ui(ui, ICON_FOLDER_OPEN, "Nothing is open", text, |ui| {
        for (name, command) in [
            ("Open folder…", Command::AskPath(Purpose::OpenFolder)),
            ("Open file…", Command::AskPath(Purpose::OpenFile)),
            ("Show the orrery", Command::OpenDemo("orrery".to_owned())),
        ] {
            if ui.button(name).clicked() {
                commands.push(command);
            }
        }
    });
}

fn drop_hint_ui(ui: &egui::Ui) {
    if ui.ctx().input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let tokens = Tokens::in_ui(ui);
    let painter =
        ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop hint")));
    let area = ui.ctx().content_rect();
    painter.rect_filled(area, 0.0, tokens.scrim);
    let font = egui::TextStyle::Heading.resolve(ui.style());
    painter.text(area.center(), egui::Align2::CENTER_CENTER, "Drop to open", font, tokens.on_scrim);
}
