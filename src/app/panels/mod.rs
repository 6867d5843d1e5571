//! The areas of the window. Each borrows the state and sends commands; none changes anything itself.

mod notices;
mod parts;
mod path_field;
mod report;
mod settings_ui;
mod status;
mod timeline;
mod top_bar;
mod totals;

use egui::{CentralPanel, Frame, Margin, Panel, Stroke};

use super::command::Command;
use super::state::{Sidebar, State};
use super::theme::{Tokens, space};
use super::views::{live_view, source_view};
pub(super) use parts::{ICON_BUTTON, choice_ui, empty_ui, icon_button};

/// The whole window.
pub(super) fn window_ui(ui: &mut egui::Ui, state: &State, commands: &mut Vec<Command>) {
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
        .frame(bar.inner_margin(Margin::symmetric(space::PANEL, 6)))
        .show(ui, |ui| timeline::timeline_ui(ui, state, commands));
    Panel::right("sidebar")
        .exact_size(space::SIDEBAR)
        .resizable(false)
        .frame(bar.inner_margin(Margin { left: space::PANEL, right: 2, top: 8, bottom: 0 }))
        .show(ui, |ui| sidebar_ui(ui, state, commands));
    CentralPanel::no_frame()
        .frame(Frame::new().fill(tokens.background).inner_margin(Margin::same(8)))
        .show(ui, |ui| views_ui(ui, state, commands));
    notices::notices_ui(ui.ctx(), state, commands);
    path_field::path_field_ui(ui.ctx(), state, commands);
    drop_hint_ui(ui);
}

fn sidebar_ui(ui: &mut egui::Ui, state: &State, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        for (sidebar, name, help) in [
            (Sidebar::Settings, "Thresholds", "What counts as redundant, and how what is left is painted."),
            (Sidebar::Report, "Report", "What was pruned, by which rule and for which camera."),
        ] {
            if parts::tab_ui(ui, state.sidebar == sidebar, name).on_hover_text(help).clicked() {
                commands.push(Command::Sidebar(sidebar));
            }
        }
    });
    ui.add_space(space::SMALL);
    match state.sidebar {
        Sidebar::Settings => settings_ui::settings_ui(ui, state, commands),
        Sidebar::Report => report::report_ui(ui, state),
    }
}

fn views_ui(ui: &mut egui::Ui, state: &State, commands: &mut Vec<Command>) {
    if state.scene.is_none() {
        return nothing_open_ui(ui, state, commands);
    }
    let area = ui.available_rect_before_wrap();
    let gap = space::MEDIUM;
    let width = ((area.width() - gap) / 2.0).floor();
    let left = egui::Rect::from_min_size(area.min, egui::vec2(width, area.height()));
    let right = left.translate(egui::vec2(width + gap, 0.0));
    ui.scope_builder(egui::UiBuilder::new().max_rect(left).id_salt("source view"), |ui| {
        card_ui(ui, |ui| source_view::source_view_ui(ui, state, commands));
    });
    ui.scope_builder(egui::UiBuilder::new().max_rect(right).id_salt("live view"), |ui| {
        card_ui(ui, |ui| live_view::live_view_ui(ui, state, commands));
    });
}

fn card_ui(ui: &mut egui::Ui, contents: impl FnOnce(&mut egui::Ui)) {
    let tokens = Tokens::in_ui(ui);
    Frame::new()
        .fill(tokens.surface)
        .stroke(Stroke::new(1.0, tokens.border))
        .corner_radius(f32::from(space::RADIUS))
        .inner_margin(Margin::same(8))
        .show(ui, |ui| {
            ui.set_min_size(ui.available_size());
            contents(ui);
        });
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
