//! Messages, over the views, until they are dismissed; and the log of all that happened, in order.

use egui::{Align2, Area, Frame, Id, Margin, Order, RichText, ScrollArea, Stroke, Ui};
use egui_material_icons::icons::{ICON_CHECK_CIRCLE, ICON_CLOSE, ICON_ERROR, ICON_NOTES, ICON_WARNING};

use crate::app::model::{Command, Commands, State};
use crate::app::rooms::frame::model::{Notice, NoticeKind, NoticeLink, WindowCommand};
use crate::app::rooms::help::model::HelpPage;
use crate::app::rooms::live::model::ViewCommand;
use crate::app::rooms::readings::model::ReadingCommand;
use crate::app::rooms::share::model::ShareCommand;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{empty_ui, icon_button};

/// Messages shown at once; older ones wait.
const SHOWN: usize = 3;

const WIDTH: f32 = 430.0;

pub(crate) fn notices_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    if state.notices.is_empty() {
        return;
    }
    let left = space::LARGE + 8.0;
    let (align, offset) = if state.doc.scene.is_some() {
        // Over the lower edge of the pictures: what is written below them stays readable.
        let below = space::STATUS + space::TIMELINE + 2.0 * space::LARGE;
        (Align2::LEFT_BOTTOM, egui::vec2(left, -below))
    } else {
        // Above the ways to open something.
        (Align2::LEFT_TOP, egui::vec2(left, space::TOP_BAR + space::TOTALS + space::LARGE))
    };
    Area::new(Id::unique("notices")).order(Order::Foreground).anchor(align, offset).show(ctx, |ui| {
        ui.set_width(WIDTH);
        for notice in state.notices.iter().rev().take(SHOWN).rev() {
            notice_ui(ui, notice, commands);
        }
    });
}

fn notice_ui(ui: &mut Ui, notice: &Notice, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let (icon, color, fill) = match notice.kind {
        NoticeKind::Error => (ICON_ERROR, tokens.error, tokens.error_faint),
        NoticeKind::Warning => (ICON_WARNING, tokens.warning, tokens.raised),
        NoticeKind::Done => (ICON_CHECK_CIRCLE, tokens.accent, tokens.raised),
    };
    Frame::new()
        .fill(fill)
        .stroke(Stroke::new(1.0, color))
        .corner_radius(f32::from(space::RADIUS))
        .inner_margin(Margin::symmetric(12, 8))
        .show(ui, |ui| {
            ui.horizontal_top(|ui| {
                ui.label(icon.rich_text().size(18.0).color(color));
                ui.vertical(|ui| {
                    ui.set_width(WIDTH - 110.0);
                    ui.label(RichText::new(&notice.title).strong().color(tokens.text));
                    ui.add(
                        egui::Label::new(RichText::new(&notice.text).color(tokens.text))
                            .wrap()
                            .selectable(true),
                    );
                    if let Some(link) = &notice.link {
                        let (name, command) = match link {
                            NoticeLink::View(view) => (
                                format!("Show in {}", view.name_and_help().0),
                                Command::Window(WindowCommand::OpenView(*view)),
                            ),
                            NoticeLink::Readings => (
                                "Compare readings…".to_owned(),
                                Command::Reading(ReadingCommand::Compare(true)),
                            ),
                            NoticeLink::Up => {
                                ("Set which way is up".to_owned(), Command::View(ViewCommand::FindUp))
                            }
                            NoticeLink::Sources => (
                                "What opens?".to_owned(),
                                Command::Window(WindowCommand::Help(Some(HelpPage::Sources))),
                            ),
                            NoticeLink::Folder(path) => (
                                "Show in folder".to_owned(),
                                Command::Share(ShareCommand::ShowInFolder(path.clone())),
                            ),
                        };
                        if ui.button(name).clicked() {
                            commands.push(command);
                            commands.push(Command::Window(WindowCommand::Dismiss(notice.id)));
                        }
                    }
                });
                if icon_button(ui, ICON_CLOSE, "Dismiss", "Dismiss (Esc)").clicked() {
                    commands.push(Command::Window(WindowCommand::Dismiss(notice.id)));
                }
            });
        });
}

pub(crate) fn log_ui(ui: &mut Ui, state: &State) {
    let tokens = Tokens::in_ui(ui);
    let log = &state.inspector.log;
    let Some(first) = log.front() else {
        empty_ui(
            ui,
            ICON_NOTES,
            "Nothing happened yet",
            "Work that is done and trouble that is met appear here.",
            |_| {},
        );
        return;
    };
    ScrollArea::vertical().auto_shrink(false).stick_to_bottom(true).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for line in log {
            ui.horizontal_top(|ui| {
                let seconds = line.at.duration_since(first.at).as_secs_f64();
                ui.label(RichText::new(format!("{seconds:8.2} s")).monospace().color(tokens.text_weak));
                let color = match line.kind {
                    NoticeKind::Error => tokens.error,
                    NoticeKind::Warning => tokens.warning,
                    NoticeKind::Done => tokens.text,
                };
                ui.add(egui::Label::new(RichText::new(&line.text).color(color)).wrap().selectable(true));
            });
        }
    });
}
