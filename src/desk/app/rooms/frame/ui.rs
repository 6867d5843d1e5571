//! What surrounds the views: the bar at the top, workspaces, the line at the bottom, notices and the log.

use egui::{
    Align, Align2, Button, Color32, Frame, Id, Label, Layout, Margin, Order, ProgressBar, RichText, Stroke,
    Ui,
};
use egui_material_icons::icons::{
    ICON_CANCEL, ICON_CHECK_CIRCLE, ICON_CLOSE, ICON_DARK_MODE, ICON_DASHBOARD, ICON_ERROR, ICON_FOLDER_OPEN,
    ICON_HELP, ICON_LIGHT_MODE, ICON_REPLAY, ICON_SAVE, ICON_SCIENCE, ICON_TERMINAL, ICON_WARNING,
};

use crate::app::model::command::{FileCommand, Opening, ViewCommand, WindowCommand};
use crate::app::model::notice::Notice;
use crate::app::model::purpose::{Purpose, ShareCommand};
use crate::app::model::window::{CommandPalette, DockView, HelpPage, NoticeKind, Workspace};
use crate::app::model::{self, Busy, Command, Commands, SceneSource, State, WorkKind};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{self, choice_ui, icon_button, note, segments_ui, weak, width_of_segments};
use overlook_engine::demo::SCENES;
use overlook_engine::plural::counted;

pub(crate) fn top_bar_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    ui.horizontal_centered(|ui| {
        ui.label(RichText::new("Overlook").heading().color(tokens.text));
        ui.add_space(space::MEDIUM);
        open_menu_ui(ui, state, commands);
        save_menu_ui(ui, state, commands);
        demo_menu_ui(ui, commands);
        views_menu_ui(ui, state, commands);
        help_menu_ui(ui, commands);
        ui.add_space(space::MEDIUM);
        let title = title_of(state);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let (icon, name) =
                if state.dark { (ICON_LIGHT_MODE, "Light theme") } else { (ICON_DARK_MODE, "Dark theme") };
            if icon_button(ui, icon, name, name).clicked() {
                commands.push(Command::Window(WindowCommand::Dark(!state.dark)));
            }
            if icon_button(ui, ICON_TERMINAL, "Commands", "Find any command by name (Ctrl+P)").clicked() {
                commands.push(Command::Window(WindowCommand::Palette(Some(CommandPalette::default()))));
            }
            workspaces_ui(ui, state, width_of(ui, title.as_ref()), commands);
            // What is open gives way: all else is pressed.
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| title_ui(ui, state, title));
        });
    });
}

fn item<'a>(name: &'a str, keys: &'a str) -> Button<'a> {
    let button = Button::new(name);
    if keys.is_empty() { button } else { button.shortcut_text(keys) }
}

fn menu_ui(ui: &mut Ui, icon: egui_material_icons::MaterialIcon, name: &str, contents: impl FnOnce(&mut Ui)) {
    let button = Button::new((icon.rich_text().size(16.0), name));
    let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
        ui.set_min_width(210.0);
        contents(ui);
    });
    response.accessible_name(name);
}

fn open_menu_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    menu_ui(ui, ICON_FOLDER_OPEN, "Open", |ui| {
        for (name, keys, command) in [
            ("Open folder…", "", Command::File(FileCommand::AskPath(Purpose::OpenFolder))),
            ("Open file…", "Ctrl+O", Command::File(FileCommand::AskPath(Purpose::OpenFile))),
            ("Load settings…", "", Command::File(FileCommand::AskPath(Purpose::LoadSettings))),
            ("Open edits…", "", Command::File(FileCommand::AskPath(Purpose::LoadEdits))),
        ] {
            if ui.add(item(name, keys)).accessible_name(name).clicked() {
                commands.push(command);
            }
        }
        if state.recent.is_empty() {
            return;
        }
        ui.separator();
        note(ui, "Recent");
        for path in &state.recent {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                commands.push(Command::File(FileCommand::Open(Opening::Path(path.clone()))));
            }
        }
    });
}

fn save_menu_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    menu_ui(ui, ICON_SAVE, "Save", |ui| {
        let opened = state.doc.scene.is_some();
        for (name, keys, enabled, command) in [
            ("Share…", "Ctrl+E", opened, Command::Share(ShareCommand::Open(None))),
            ("Copy the address of this view", "Ctrl+L", opened, Command::View(ViewCommand::CopyAddress)),
            ("Copy as command line", "", opened, Command::File(FileCommand::CopyCommandLine)),
            ("Save session…", "Ctrl+S", opened, Command::File(FileCommand::AskPath(Purpose::SaveSession))),
            ("Save settings…", "", true, Command::File(FileCommand::AskPath(Purpose::SaveSettings))),
            ("Save edits…", "", opened, Command::File(FileCommand::AskPath(Purpose::SaveEdits))),
        ] {
            let button = ui
                .add_enabled(enabled, item(name, keys))
                .accessible_name(name)
                .on_disabled_hover_text("Nothing is shown yet.");
            if button.clicked() {
                commands.push(command);
            }
        }
    });
}

fn demo_menu_ui(ui: &mut Ui, commands: &mut Commands) {
    menu_ui(ui, ICON_SCIENCE, "Demo", |ui| {
        if ui.button("Room, pruned").clicked() {
            commands.push(Command::File(FileCommand::Open(Opening::Room)));
        }
        note(ui, "The room that the program comes with: opens at once.");
        for (name, help) in SCENES {
            if ui.button(model::words(name)).clicked() {
                commands.push(Command::File(FileCommand::Open(Opening::Demo((*name).to_owned()))));
            }
            note(ui, *help);
        }
    });
}

fn views_menu_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    menu_ui(ui, ICON_DASHBOARD, "Panels", |ui| {
        // In two columns, so that all of the menu fits a window 640 points high.
        egui::Grid::new("views").num_columns(2).show(ui, |ui| {
            let views = DockView::ALL.into_iter().filter(|(view, ..)| state.has_use_of(*view));
            for (nth, (view, name, help)) in views.enumerate() {
                let button = ui.button(name).on_hover_text(help);
                if button.accessible_name(format!("Open view {name}")).clicked() {
                    commands.push(Command::Window(WindowCommand::OpenView(view)));
                }
                if nth % 2 == 1 {
                    ui.end_row();
                }
            }
        });
        ui.separator();
        if ui.button("Reset layout").on_hover_text("Put all views where they were at first").clicked() {
            commands.push(Command::Window(WindowCommand::ResetLayout));
        }
    });
}

fn help_menu_ui(ui: &mut Ui, commands: &mut Commands) {
    menu_ui(ui, ICON_HELP, "Help", |ui| {
        for (name, keys, page) in [
            ("Guide", "", HelpPage::Guide(0)),
            ("Keyboard and mouse shortcuts", "?", HelpPage::Shortcuts),
            ("Log", "", HelpPage::Log),
            ("About Overlook", "", HelpPage::About),
        ] {
            if ui.add(item(name, keys)).accessible_name(name).clicked() {
                commands.push(Command::Window(WindowCommand::Help(Some(page))));
            }
        }
    });
}

/// The name of what is open, and how large it is.
fn title_of(state: &State) -> Option<[RichText; 2]> {
    let scene = state.doc.scene.as_ref()?;
    let kind = match (&scene.origin, scene.capture().is_some()) {
        (SceneSource::Demo(_), _) => "built-in capture, traced here",
        (SceneSource::Room, _) => "built-in store",
        (_, true) => "capture",
        (_, false) => "store",
    };
    let cameras = scene.cameras.len();
    let (width, height) = scene.cameras.first().map_or((0, 0), |camera| camera.intrinsics.size());
    let facts = format!(
        "{kind} · {} × {} · {width}×{height}",
        counted(cameras, "camera"),
        counted(scene.frame_count(), "frame")
    );
    Some([RichText::new(&scene.name).strong(), RichText::new(facts)])
}

/// Width that the title takes where nothing of it is cut off.
fn width_of(ui: &Ui, title: Option<&[RichText; 2]>) -> f32 {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let width = |part: &RichText| {
        ui.painter().layout_no_wrap(part.text().to_owned(), font.clone(), Color32::PLACEHOLDER).size().x
    };
    title.map_or(0.0, |parts| parts.iter().map(|part| width(part) + ui.spacing().item_spacing.x).sum())
}

fn title_ui(ui: &mut Ui, state: &State, title: Option<[RichText; 2]>) {
    let (Some([name, facts]), Some(scene)) = (title, &state.doc.scene) else { return };
    ui.add(Label::new(name).truncate());
    let response = ui.add(Label::new(facts.color(Tokens::in_ui(ui).text_weak)).truncate());
    if let SceneSource::Path(path) = &scene.origin {
        response.on_hover_text(path.display().to_string());
    }
}

/// The workspaces, at the right end of what is left of a line; as a list where less than the `rest` would be left of it.
pub(crate) fn workspaces_ui(ui: &mut Ui, state: &State, rest: f32, commands: &mut Commands) {
    let now = state.look.workspace;
    let width = width_of_segments(ui, &Workspace::ALL);
    let chosen = if ui.available_width() < width + rest + 2.0 * space::MEDIUM {
        choice_ui(ui, "Workspace", now, &Workspace::ALL, 76.0)
    } else {
        let layout = Layout::left_to_right(Align::Center);
        let area = egui::vec2(width, space::CONTROL);
        ui.allocate_ui_with_layout(area, layout, |ui| segments_ui(ui, "Workspace", now, Workspace::ALL)).inner
    };
    commands.extend(chosen.map(|it| Command::Window(WindowCommand::Workspace(it))));
}

pub(crate) fn status_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    ui.horizontal_centered(|ui| {
        if let Some(busy) = state.busy.first() {
            // First in the line, so that it stays under the pointer while the words beside it change.
            if busy.cancellable {
                let cancel = Button::new((ICON_CANCEL.rich_text(), "Cancel")).small();
                if ui.add(cancel).on_hover_text("Stop (Esc)").accessible_name("Cancel").clicked() {
                    commands.push(Command::Cancel);
                }
            }
            busy_ui(ui, state, busy);
        } else if state.doc.stopped {
            ui.label(
                RichText::new("The whole capture is not computed with these settings.").color(tokens.warning),
            );
            let rerun = Button::new((ICON_REPLAY.rich_text(), "Recompute")).small();
            if ui.add(rerun).accessible_name("Recompute").clicked() {
                commands.push(Command::Recompute);
            }
        } else if state.is_stale() {
            let text = "A setting changed: this frame shows it now, the whole capture follows.";
            ui.label(RichText::new(text).color(tokens.warning));
        } else {
            weak(ui, "Ready");
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| frame_facts_ui(ui, state));
    });
}

/// A stage in the words of somebody who watches it: a built-in scene is traced as it is read, and nobody moves its cameras.
fn stage_words<'a>(state: &State, busy: &'a Busy) -> &'a str {
    let is_traced =
        state.doc.scene.as_ref().is_some_and(|scene| matches!(scene.origin, SceneSource::Demo(_)));
    match busy.progress.stage.as_str() {
        "" if busy.work == WorkKind::EditSamples => "Selecting",
        "" if busy.work == WorkKind::InspectFrame => "Reading this frame",
        "" => "Starting",
        "Reading frames" if is_traced => "Tracing the built-in scene",
        "Aligning cameras" => "Checking camera poses",
        stage => stage,
    }
}

/// The running work. If it is a part of larger work, the larger comes first and has the remaining time.
fn busy_ui(ui: &mut Ui, state: &State, busy: &Busy) {
    let tokens = Tokens::in_ui(ui);
    let progress = &busy.progress;
    let stage = stage_words(state, busy);
    let study = state.doc.charts.under_way().filter(|_| busy.work == WorkKind::Study);
    let whole = match study {
        Some(study) if progress.context.is_empty() => study.name().to_owned(),
        Some(study) => format!("{}: {}", study.name(), progress.context),
        None => progress.context.clone(),
    };
    if whole.is_empty() {
        ui.label(stage);
    } else {
        ui.label(&whole);
        weak(ui, stage);
    }
    if progress.total == 0 {
        ui.add(egui::Spinner::new().size(14.0));
        return;
    }
    let count = format!("{} of {}", progress.done.min(progress.total), progress.total);
    let bar = ProgressBar::new(progress.fraction())
        .desired_width(if whole.is_empty() { 200.0 } else { 100.0 })
        .desired_height(8.0)
        .fill(tokens.accent);
    ui.add(bar).accessible_name("Progress");
    weak(ui, count);
    if let Some(secs) = busy.secs_left {
        weak(ui, model::time_left(secs));
    }
}

fn frame_facts_ui(ui: &mut Ui, state: &State) {
    let Some(inspected) = state.doc.inspected.as_ref().filter(|_| state.inspection_here().is_some()) else {
        return;
    };
    let edited = state.edited_samples().filter(|edited| edited.frame_numbers.len() == state.frame_count());
    let samples = match edited {
        Some(edited) => edited.images_at(state.timeline.frame).map(|image| image.len() as u64).sum(),
        None => inspected.inspection.samples.sample_count(),
    };
    let pixels: u64 = inspected.inspection.cameras.iter().map(|camera| camera.verdict.len() as u64).sum();
    let mut facts =
        format!("This frame: {} kept of {}", model::count(samples), model::count_of(pixels, "pixel"));
    if !inspected.with_scan {
        facts.push_str(" (static parts not known yet)");
    }
    if edited.is_some() {
        facts.push_str(&state.with_edits());
    }
    ui.add_space(space::SMALL);
    weak(ui, facts).on_hover_text(
        "All pixels of all cameras at this frame, and the kept samples that represent them: those stored for all frames, for \
         several and for this one alone.",
    );
}

/// Messages shown at once; older ones wait.
const SHOWN: usize = 3;

const WIDTH: f32 = 430.0;

pub(crate) fn notices_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    if state.notices.is_empty() {
        return;
    }
    let area = egui::Area::new(Id::unique("notices")).order(Order::Foreground);
    let area = match widgets::drawn_picture(ctx, |name, _| name == "live picture") {
        Some(picture) => {
            let right = ctx.content_rect().right() - WIDTH - space::LARGE;
            let corner = egui::pos2((picture.left() + 8.0).min(right), picture.bottom() - 8.0);
            area.pivot(Align2::LEFT_BOTTOM).fixed_pos(corner)
        }
        None if state.doc.scene.is_some() => {
            let below = space::STATUS + space::TIMELINE + 2.0 * space::LARGE;
            area.anchor(Align2::LEFT_BOTTOM, egui::vec2(space::LARGE + 8.0, -below))
        }
        None => {
            let offset = egui::vec2(space::LARGE + 8.0, space::TOP_BAR + space::TOTALS + space::LARGE);
            area.anchor(Align2::LEFT_TOP, offset)
        }
    };
    area.show(ctx, |ui| {
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
                        Label::new(RichText::new(&notice.text).color(tokens.text)).wrap().selectable(true),
                    );
                    if let Some((name, command)) = &notice.link
                        && ui.button(*name).clicked()
                    {
                        commands.push(command.clone());
                        commands.push(Command::Window(WindowCommand::Dismiss(notice.id)));
                    }
                });
                if icon_button(ui, ICON_CLOSE, "Dismiss", "Dismiss (Esc)").clicked() {
                    commands.push(Command::Window(WindowCommand::Dismiss(notice.id)));
                }
            });
        });
}
