//! The dialog of all ways out: what each is for, how large it will be, and its making.

mod options;

use egui::{Button, Frame, Id, Label, Modal, ProgressBar, RichText, Ui, Vec2};
use egui_material_icons::icons::{ICON_CANCEL, ICON_CHECK_CIRCLE, ICON_ERROR, ICON_FOLDER_OPEN};

use crate::app::model::command::FileCommand;
use crate::app::model::purpose::{Purpose, ShareCommand};
use crate::app::model::{self, Busy, Command, Commands, State, WorkKind};
use crate::app::rooms::files::paths::what_is_missing;
use crate::app::rooms::share::state::{ShareOutcome, SharePreviewKey};
use crate::app::rooms::share::ui::options::options_ui;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{self, note, waiting, weak};
use crate::app::work::worker::Wanted;
use crate::ways_out::{Options, WAYS, WayOut};

/// Width of the dialog, of the list of ways, and of the bar of what is written, points.
const WIDTH: f32 = 760.0;
const LIST: f32 = 262.0;
const BAR: f32 = 260.0;

/// Height of what is beside the list, so that nothing moves when another way is chosen; of a way in the list; and of a preview, points.
const HEIGHT: f32 = 372.0;
const ROW: f32 = 34.0;
const PREVIEW: f32 = 108.0;

/// The dialog, while it is open.
pub(crate) fn share_ui(ctx: &egui::Context, state: &State, commands: &mut Commands) {
    let share = &state.share;
    if !share.is_open {
        return;
    }
    let mut options = share.options.clone();
    let frame = Frame::popup(&ctx.style_of(ctx.theme())).inner_margin(space::LARGE);
    let modal = Modal::new(Id::unique("share")).frame(frame).show(ctx, |ui| {
        ui.set_width(WIDTH);
        ui.heading("Share");
        ui.add_space(space::MEDIUM);
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = space::LARGE;
            ui.vertical(|ui| ways_ui(ui, state, &mut options));
            ui.vertical(|ui| {
                ui.set_width(ui.available_width());
                ui.set_height(HEIGHT);
                ui.spacing_mut().item_spacing.x = space::MEDIUM;
                egui::ScrollArea::vertical()
                    .auto_shrink(false)
                    .show(ui, |ui| way_ui(ui, state, &mut options, commands));
            });
        });
        ui.add_space(space::SMALL);
        ui.separator();
        if ui.button("Close").accessible_name("Close sharing").clicked() {
            commands.push(Command::Share(ShareCommand::Close));
        }
    });
    if options != share.options {
        commands.push(Command::Share(ShareCommand::Change(Box::new(options))));
    }
    // A click beside it is no answer: what is typed next would act on the window.
    if modal.should_close() && !modal.backdrop_response.clicked() {
        commands.push(Command::Share(ShareCommand::Close));
    }
}

/// Every way with its size.
fn ways_ui(ui: &mut Ui, state: &State, options: &mut Options) {
    ui.set_width(LIST);
    ui.spacing_mut().item_spacing.y = 2.0;
    for (way, WayOut { name, used, .. }) in WAYS {
        let size = state.share_size(way).text;
        let button = Button::selectable(way == options.way, *name)
            .shortcut_text(size.as_str())
            .min_size(Vec2::new(LIST, ROW));
        let button = ui.add(button).accessible_name(format!("{name}: {size}"));
        if button.on_hover_text(*used).clicked() {
            options.way = way;
        }
    }
}

/// The chosen way: what it is for, its options, its size, and its making.
fn way_ui(ui: &mut Ui, state: &State, options: &mut Options, commands: &mut Commands) {
    let WayOut { name, used, .. } = options.way.row();
    ui.label(RichText::new(*name).strong().size(15.0));
    ui.add(Label::new(RichText::new(*used).color(Tokens::in_ui(ui).text_weak)).wrap());
    ui.add_space(space::MEDIUM);
    options_ui(ui, state, options, commands);
    ui.add_space(space::MEDIUM);
    let size = state.share_size(options.way);
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(model::sentence(&size.text)).strong());
        weak(ui, size.reason);
        if !state.doc.edits.list.is_idle() && state.cut_scene().is_none() {
            weak(ui, "Before edits, which what is written has.");
        }
    });
    preview_ui(ui, state);
    ui.add_space(space::SMALL);
    let is_writing = |busy: &&Busy| matches!(busy.work, WorkKind::Export | WorkKind::File);
    if let Some(busy) = state.busy.iter().find(is_writing).filter(|_| state.share.asked.is_some()) {
        progress_ui(ui, busy, commands);
        return;
    }
    make_ui(ui, state, options, commands);
    ui.add_space(space::SMALL);
    if let Some(outcome) = &state.share.outcome {
        outcome_ui(ui, outcome, commands);
    }
}

/// What a budget leaves of the view, while it makes it coarser.
fn preview_ui(ui: &mut Ui, state: &State) {
    let Some(key) = SharePreviewKey::wanted(state) else { return };
    let intrinsics = key.vantage.camera.intrinsics;
    let size = Vec2::new(PREVIEW * intrinsics.width as f32 / intrinsics.height.max(1) as f32, PREVIEW);
    let shown = state.share.preview.as_ref();
    let is_late = shown.is_none_or(|shown| shown.key != key);
    ui.add_space(space::SMALL);
    ui.horizontal_top(|ui| {
        let (area, response) = ui.allocate_exact_size(size, egui::Sense::hover());
        let picture = shown.and_then(|shown| shown.picture.as_ref());
        response
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Preview of what is shared"));
        if let Some((texture, _)) = picture {
            widgets::picture(ui.painter(), texture.id(), area);
        } else {
            ui.painter().rect_filled(area, 4.0, Tokens::in_ui(ui).surface);
        }
        if is_late {
            waiting(ui, area, 20.0);
        }
        ui.vertical(|ui| {
            let kept = model::percent((key.share * 1e6) as u64, 1_000_000);
            let text = match (is_late, picture) {
                (true, _) => "Preview…".to_owned(),
                (false, None) => "So little holds nothing of this frame.".to_owned(),
                (false, Some((_, decibels))) => {
                    let like = decibels.map_or_else(String::new, |decibels| {
                        format!(", {} dB from that of all samples", model::significant(decibels))
                    });
                    format!("This view of about {kept} of the samples{like}.")
                }
            };
            ui.add(Label::new(RichText::new(text).small().color(Tokens::in_ui(ui).text_weak)).wrap());
        });
    });
}

fn progress_ui(ui: &mut Ui, busy: &Busy, commands: &mut Commands) {
    let progress = &busy.progress;
    let stage = if progress.stage.is_empty() { "Starting" } else { &progress.stage };
    ui.add(Label::new(stage).truncate());
    ui.horizontal(|ui| {
        // As wide before anything is counted, so that *Cancel* does not move away from the pointer.
        let area = Vec2::new(BAR, ui.spacing().interact_size.y);
        if progress.total > 0 {
            let bar = ProgressBar::new(progress.fraction()).desired_height(8.0);
            let bar = ui.add_sized(area, bar.fill(Tokens::in_ui(ui).accent));
            bar.accessible_name("Progress of sharing");
        } else {
            ui.add_sized(area, egui::Spinner::new().size(16.0));
        }
        let cancel = ui.button((ICON_CANCEL.rich_text(), "Cancel")).accessible_name("Cancel sharing");
        if cancel.clicked() {
            commands.push(Command::Share(ShareCommand::Stop));
        }
        if let Some(secs) = busy.secs_left {
            weak(ui, model::time_left(secs));
        }
    });
    note(ui, "It goes on when this is closed; the line at the bottom shows it.");
}

fn make_ui(ui: &mut Ui, state: &State, options: &Options, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let (purpose, button) = (Purpose::Share(options.kind()), options.way.row().button);
    let missing = what_is_missing(state, purpose);
    let words = RichText::new(button).color(tokens.on_accent);
    let make = ui.add_enabled(missing.is_none(), Button::new(words).fill(tokens.accent));
    let make = make.accessible_name(button);
    // Enter goes on, as it does in the system's dialogs; a field for the path has the keyboard to itself.
    if state.typed_path.is_some() {
        make.surrender_focus();
    } else if missing.is_none() && ui.memory(|memory| memory.focused().is_none()) {
        make.request_focus();
    }
    if make.clicked() {
        commands.push(Command::File(FileCommand::AskPath(purpose)));
    }
    if let Some((_, why)) = missing {
        ui.add(Label::new(RichText::new(why).color(tokens.warning)).wrap());
    }
}

fn outcome_ui(ui: &mut Ui, outcome: &ShareOutcome, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    match outcome {
        ShareOutcome::Written { said, path } => {
            ui.horizontal_top(|ui| {
                ui.label(ICON_CHECK_CIRCLE.rich_text().color(tokens.accent));
                ui.add(Label::new(format!("{said}.")).wrap());
            });
            let place = RichText::new(path.display().to_string()).small().color(tokens.text_weak);
            ui.add(Label::new(place).truncate().selectable(true)).on_hover_text(path.display().to_string());
            let show = ui.button((ICON_FOLDER_OPEN.rich_text(), "Show in folder"));
            if show.accessible_name("Show in folder").clicked() {
                commands.push(Command::Share(ShareCommand::ShowInFolder(path.clone())));
            }
        }
        ShareOutcome::Failed(why) => {
            ui.horizontal_top(|ui| {
                ui.label(ICON_ERROR.rich_text().color(tokens.error));
                ui.add(Label::new(RichText::new(why).color(tokens.error)).wrap().selectable(true));
            });
        }
    }
}
