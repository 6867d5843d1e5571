//! What is going on, how far it has come, and how to stop it.

use egui::{Align, Button, Layout, ProgressBar, RichText, Ui};
use egui_material_icons::icons::{ICON_CANCEL, ICON_REPLAY};

use crate::app::model;
use crate::app::model::{Busy, Command, Commands, SceneSource, State, StoppableWork};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::weak;

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
fn stage_words<'a>(state: &State, stage: &'a str) -> &'a str {
    let is_traced =
        state.doc.scene.as_ref().is_some_and(|scene| matches!(scene.origin, SceneSource::Demo(_)));
    match stage {
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
    let stage = stage_words(state, &progress.stage);
    let study = state.doc.charts.under_way().filter(|_| busy.work == StoppableWork::Study);
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
    let samples = inspected.inspection.samples.sample_count();
    let pixels: u64 = inspected.inspection.cameras.iter().map(|camera| camera.verdict.len() as u64).sum();
    let mut facts =
        format!("This frame: {} of {} drawn", model::count(samples), model::count_of(pixels, "sample"));
    if !inspected.with_scan {
        facts.push_str(" (static parts not known yet)");
    }
    ui.add_space(space::SMALL);
    weak(ui, facts).on_hover_text(
        "All pixels of all cameras at this frame, and the kept samples that represent them: those stored for all frames, for \
         several and for this one alone.",
    );
}
