//! Draws what the last change of settings did: samples that went or came over the live view, and figures before and now.

use egui::{Align2, Button, Color32, Grid, Painter, Rect, RichText, Ui, pos2, vec2};

use crate::app::model::command::ViewCommand;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::change::state::Difference;
use crate::app::rooms::compare::compare_with;
use crate::app::rooms::compare::state::CompareSide;
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{note, plate};

/// Draws samples that went or came over the live view, and how many it keeps.
pub(crate) fn glows(painter: &Painter, canvas: Rect, state: &State) {
    let change = &state.doc.change;
    if !state.live.shows_changes {
        return;
    }
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    for glow in change.glows.iter().filter(|glow| state.looks_from(&glow.camera)) {
        let tint = Color32::WHITE.gamma_multiply(glow.strength());
        painter.image(glow.texture.id(), canvas, whole, tint);
    }
    let is_told = state.is_stale() || !change.glows.is_empty();
    if let Some(Difference { before, now: Some(now), change: Some(change), .. }) =
        state.differences().first().filter(|first| is_told && first.name == "This frame")
    {
        let text = format!("Kept of this frame: {before} » {now}, {change}");
        let at = canvas.center_top() + vec2(0.0, space::MEDIUM);
        plate(painter, at, Align2::CENTER_TOP, &text, Tokens::of(state.dark));
    }
}

/// Whether samples are seen going, and the way to what was before. It has one height: thresholds are dragged below it.
pub(crate) fn change_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.horizontal(|ui| {
        let mut shows = state.live.shows_changes;
        let help = "In the live view, samples that a change of settings drops glow and fade in the color of their camera; those that come \
                    back grow.";
        if ui.checkbox(&mut shows, "Show changes").on_hover_text(help).changed() {
            commands.push(Command::View(ViewCommand::look(&state.live, |live| live.shows_changes = shows)));
        }
        let told = state.differences();
        let button = ui.add_enabled(!told.is_empty(), Button::new("Before and now"));
        let button = button.on_disabled_hover_text("No setting was changed that decides which samples are kept.");
        if button.on_hover_ui(|ui| differences_ui(ui, &told)).clicked() {
            compare_with(CompareSide::Before, state, commands);
        }
    });
}

/// Figures before the last change of settings and now.
fn differences_ui(ui: &mut Ui, told: &[Difference]) {
    let tokens = Tokens::in_ui(ui);
    note(ui, "The last change");
    Grid::new("the last change").num_columns(3).spacing(vec2(space::MEDIUM, 2.0)).show(ui, |ui| {
        for Difference { name, before, now, change } in told {
            let small = |text: String| RichText::new(text).small();
            ui.label(small((*name).to_owned()).color(tokens.text_weak));
            ui.label(small(format!("{before} » {}", now.as_deref().unwrap_or("…"))));
            ui.label(small(change.clone().unwrap_or_default()));
            ui.end_row();
        }
    });
}
