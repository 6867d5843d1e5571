//! The settings, generated from the one table of settings, so that none is ever missing here; and settings to start from.

use egui::{
    Align, Align2, Button, CollapsingHeader, Color32, DragValue, Label, Layout, Painter, Rect, RichText,
    ScrollArea, Sense, Slider, Stroke, Ui, pos2, vec2,
};
use egui_material_icons::icons::{ICON_REDO, ICON_RESTART_ALT, ICON_UNDO};

use crate::app::control::gave_up_number;
use crate::app::model::command::{FileCommand, SettingsCommand};
use crate::app::model::purpose::Purpose;
use crate::app::model::setting_names::{ADVANCED, SECTIONS, SettingPairs};
use crate::app::model::{self, Command, Commands, SettingsSlot, State};
use crate::app::rooms::change::ui::change_ui;
use crate::app::rooms::settings::{BARS, CUT, PRESETS, ThresholdAxis, ThresholdHistogram, changed};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{bare_icon_button, choice_ui, fold_ui, help_beside, note, weak};
use overlook_engine::plural::{counted, either};
use overlook_engine::settings::{Field, Settings, ValueKind};

/// Width of the number beside a slider: as much as `65536` needs.
const NUMBER_BOX: f32 = 58.0;

pub(crate) fn settings_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let settings = state.shown_settings();
    let values = SettingPairs::new(&settings, &Settings::default());
    let editable = state.has_thresholds();
    if editable {
        history_ui(ui, state, commands);
        let words = match values.differing().count() {
            0 => "Every setting has its default".to_owned(),
            count => format!(
                "{} {}",
                counted(count, "setting"),
                either(count, "differs from its default", "differ from their defaults")
            ),
        };
        note(ui, words);
        change_ui(ui, state, commands);
    }
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        if !editable {
            weak(ui, "A store keeps the settings it was made with; only rendering can be changed.");
        }
        let found = state.inspector.find_setting.and_then(|path| path.split('.').next());
        // What can be changed of a store comes first.
        let mut sections: Vec<_> = SECTIONS.iter().collect();
        if !editable {
            sections.sort_by_key(|(section, ..)| *section != "render");
        }
        for (section, heading, open) in sections {
            CollapsingHeader::new(RichText::new(*heading).strong())
                .id_salt((*section, editable))
                .default_open(*open && (editable || *section == "render"))
                .open((found == Some(*section)).then_some(true))
                .show_unindented(ui, |ui| {
                    if *section == "capture" {
                        let text =
                            "For captures that are opened from now on: the one that is open stays as it is.";
                        note(ui, text);
                    }
                    ui.add_enabled_ui(editable || *section == "render", |ui| {
                        let (folded, shown): (Vec<_>, Vec<_>) =
                            fields_of(section).partition(|field| ADVANCED.contains(&field.path));
                        for field in shown {
                            field_ui(ui, field, &values, state, commands);
                        }
                        if folded.is_empty() {
                            return;
                        }
                        let wanted =
                            folded.iter().any(|field| state.inspector.find_setting == Some(field.path));
                        fold_ui(ui, "Advanced", section, wanted, |ui| {
                            for field in folded {
                                field_ui(ui, field, &values, state, commands);
                            }
                        });
                    });
                    ui.add_space(space::MEDIUM);
                });
        }
        let reset = ui.add_enabled(settings != Settings::default() && editable, Button::new("Reset all"));
        if reset.on_hover_text("Give every setting its default").clicked() {
            commands.push(Command::Settings(SettingsCommand::ResetAll));
        }
        ui.add_space(space::LARGE);
    });
}

/// Undo and redo, two settings that take turns, and settings to start from.
fn history_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let history = &state.inspector.history;
    ui.horizontal(|ui| {
        undo_button_ui(ui, state, true, commands);
        undo_button_ui(ui, state, false, commands);
        let help = "Two sets of settings to switch between: changes go to the one that is selected. The Compare view shows \
                    both at once.";
        for (slot, name) in [(SettingsSlot::A, "A"), (SettingsSlot::B, "B")] {
            let button = ui.add(Button::selectable(history.slot == slot, name).min_size(vec2(26.0, space::CONTROL)));
            let button = button.on_hover_text(help).accessible_name(format!("Settings {name}"));
            if button.clicked() && history.slot != slot {
                commands.push(Command::Settings(SettingsCommand::Switch));
            }
        }
        presets_menu_ui(ui, commands);
    });
    ui.add_space(space::SMALL);
}

fn fields_of(section: &str) -> impl Iterator<Item = &'static Field> {
    Settings::fields().filter(move |field| field.path.split_once('.').is_some_and(|(of, _)| of == section))
}

fn field_ui(
    ui: &mut Ui,
    field: &'static Field,
    values: &SettingPairs,
    state: &State,
    commands: &mut Commands,
) {
    let Some([value, default]) = values.of(field) else { return };
    let name = model::setting_names::name(field.path);
    // The line on the histogram takes the place of a slider.
    let cuts = state.has_capture() && CUT.contains(&field.path);
    let changed_to = ui.push_id(field.path, |ui| {
        ui.add_space(2.0);
        let beside_name = ui.horizontal(|ui| {
            let label = name_ui(ui, &name).on_hover_text(field.help);
            if state.inspector.find_setting == Some(field.path) {
                label.scroll_to_me(Some(Align::Center));
                let stroke = Stroke::new(1.5, Tokens::in_ui(ui).accent);
                ui.painter().rect_stroke(label.rect.expand(3.0), 3.0, stroke, egui::StrokeKind::Outside);
                commands.push(Command::Settings(SettingsCommand::Find(None)));
            }
            note(ui, field.unit).on_hover_text(field.help);
            let controls = ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.add_space(space::MEDIUM);
                let changed_to = match (field.kind, value) {
                    (ValueKind::Switch, toml::Value::Boolean(on)) => switch_ui(ui, field, &name, *on),
                    (ValueKind::Number { min, max, .. }, toml::Value::Float(number)) if cuts => {
                        number_ui(ui, field, &name, *number, [min, max])
                    }
                    _ => None,
                };
                let resets = value != default && reset_ui(ui, &name);
                resets.then(|| default.clone()).or(changed_to)
            });
            controls.inner
        });
        let below = match value.as_float() {
            Some(value) if cuts => histogram_ui(ui, field, &name, value, state).map(Into::into),
            _ => value_ui(ui, field, &name, value),
        };
        beside_name.inner.or(below)
    });
    if let Some(value) = changed_to.inner {
        commands.push(Command::Settings(SettingsCommand::Set { path: field.path, value }));
    }
}

/// The name of a setting. It is drawn only: read out is the control beside it, which has the same name.
fn name_ui(ui: &mut Ui, name: &str) -> egui::Response {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let galley = ui.painter().layout_no_wrap(name.to_owned(), font, ui.visuals().text_color());
    let (rect, response) = ui.allocate_exact_size(galley.size(), Sense::hover());
    ui.painter().galley(rect.min, galley, ui.visuals().text_color());
    response
}

fn switch_ui(ui: &mut Ui, field: &Field, name: &str, mut on: bool) -> Option<toml::Value> {
    let switch = ui.checkbox(&mut on, "").on_hover_text(field.help).accessible_name(name);
    switch.changed().then(|| on.into())
}

/// The number of a threshold whose slider is the line on its histogram.
fn number_ui(
    ui: &mut Ui,
    field: &Field,
    name: &str,
    mut number: f64,
    [min, max]: [f64; 2],
) -> Option<toml::Value> {
    let speed = 0.01 * number.abs().max(max * 1e-4);
    let drag = DragValue::new(&mut number)
        .range(min..=max)
        .speed(speed)
        .update_while_editing(false)
        .custom_formatter(|value, _| shown_number(value));
    ui.spacing_mut().interact_size.x = NUMBER_BOX;
    let drag = ui.add(drag).on_hover_text(field.help).accessible_name(name);
    (drag.changed() && !gave_up_number(ui.ctx())).then(|| number.into())
}

/// The button that gives a setting its default; whether it was clicked.
fn reset_ui(ui: &mut Ui, name: &str) -> bool {
    let icon = ICON_RESTART_ALT.rich_text().size(14.0).color(Tokens::in_ui(ui).accent);
    let button = ui.add(Button::new(icon).small().frame(false)).on_hover_text("Back to the default");
    button.accessible_name(format!("Reset {name}")).clicked()
}

fn value_ui(ui: &mut Ui, field: &'static Field, name: &str, value: &toml::Value) -> Option<toml::Value> {
    let width = ui.available_width() - space::MEDIUM;
    ui.spacing_mut().interact_size.x = NUMBER_BOX;
    ui.spacing_mut().slider_width = width - NUMBER_BOX - ui.spacing().item_spacing.x;
    match (field.kind, value) {
        (ValueKind::Number { min, max, log }, toml::Value::Float(number)) => {
            let mut number = *number;
            let slider = Slider::new(&mut number, min..=max)
                .logarithmic(log)
                .smallest_positive(max * 1e-4)
                .update_while_editing(false)
                .custom_formatter(|value, _| shown_number(value));
            let slider = ui.add(slider).on_hover_text(field.help).accessible_name(name);
            (slider.changed() && !gave_up_number(ui.ctx())).then(|| number.into())
        }
        (ValueKind::Integer { min, max }, toml::Value::Integer(number)) => {
            let mut number = *number;
            let slider = Slider::new(&mut number, min..=max).logarithmic(min > 0).update_while_editing(false);
            let slider = ui.add(slider).on_hover_text(field.help).accessible_name(name);
            (slider.changed() && !gave_up_number(ui.ctx())).then(|| number.into())
        }
        (ValueKind::Choice(names), toml::Value::String(current)) => {
            let current = names.iter().position(|(choice, _)| choice == current).unwrap_or(0);
            let choices: Vec<_> = names
                .iter()
                .enumerate()
                .map(|(index, (choice, help))| {
                    (index, model::setting_names::choice(field.path, choice), help.trim().to_owned())
                })
                .collect();
            choice_ui(ui, name, current, &choices, width).map(|index| names[index].0.into())
        }
        _ => None,
    }
}

/// A threshold with as many digits as matter.
fn shown_number(value: f64) -> String {
    match value.abs() {
        v if v >= 9.95 => format!("{value:.1}"),
        v if v >= 0.1 || v == 0.0 => format!("{value:.2}"),
        _ => format!("{value:.4}"),
    }
}

/// The menu, as wide as there is room.
fn presets_menu_ui(ui: &mut Ui, commands: &mut Commands) {
    let button = Button::new("Presets…").min_size(vec2(ui.available_width() - space::MEDIUM, 0.0));
    let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, |ui| {
        ui.set_min_width(220.0);
        for (name, help, change) in PRESETS {
            if ui.button(name).on_hover_text(help).clicked() {
                commands.push(Command::Settings(SettingsCommand::Preset(Box::new(changed(change)))));
            }
        }
        ui.separator();
        for (name, purpose) in
            [("Load settings…", Purpose::LoadSettings), ("Save settings…", Purpose::SaveSettings)]
        {
            if ui.button(name).clicked() {
                commands.push(Command::File(FileCommand::AskPath(purpose)));
            }
        }
    });
    response.accessible_name("Presets");
}

const BARS_HEIGHT: f32 = 40.0;
/// Height of the figures above them.
const FIGURES: f32 = 14.0;

/// The histogram with its line; `name` names it for screen readers. Gives the value that the line was dragged to.
fn histogram_ui(ui: &mut Ui, field: &'static Field, name: &str, value: f64, state: &State) -> Option<f64> {
    let tokens = Tokens::in_ui(ui);
    let axis = ThresholdAxis::of(field)?;
    let width = ui.available_width() - space::MEDIUM;
    let (rect, response) =
        ui.allocate_exact_size(vec2(width, FIGURES + BARS_HEIGHT), Sense::click_and_drag());
    response
        .widget_info(|| egui::WidgetInfo::slider(ui.is_enabled(), value, format!("{name} on its histogram")));
    let plot = Rect::from_min_max(rect.min + vec2(0.0, FIGURES), rect.max);
    let painter = ui.painter_at(rect);
    painter.rect_filled(plot, 3.0, tokens.background);
    // The room is kept while nothing is counted, so that nothing below jumps; the line can be dragged already.
    let mut histograms = state.doc.histograms.iter();
    let histogram = histograms.find(|histogram| histogram.path == field.path && !histogram.is_empty());
    if let Some(histogram) = histogram {
        if let Some(noise) = histogram.noise {
            let right = plot.left() + axis.position(f64::from(noise)) * plot.width();
            painter.rect_filled(plot.with_max_x(right), 3.0, tokens.raised);
            painter.vline(right, plot.y_range(), Stroke::new(1.0, tokens.text_weak));
        }
        let colors = [tokens.static_over_time, tokens.moving];
        bars(&painter, plot, &histogram.bars, |_, part| colors[part]);
    }
    let enabled = ui.is_enabled();
    let x = plot.left() + axis.position(value) * plot.width();
    let grabbed = enabled && (response.hovered() || response.dragged());
    line(&painter, plot, x, if enabled { tokens.text } else { tokens.text_weak }, grabbed);
    let font = egui::FontId::proportional(10.5);
    let [left, right] = side_words(histogram, value);
    painter.text(rect.left_top(), Align2::LEFT_TOP, left, font.clone(), tokens.text_weak);
    painter.text(rect.right_top(), Align2::RIGHT_TOP, right, font.clone(), tokens.text_weak);
    let frame = histogram.and_then(|histogram| histogram.frame);
    if let Some(frame) = frame.filter(|frame| *frame != state.timeline.frame) {
        let words = RichText::new(at_frame(frame)).font(font).color(tokens.warning);
        let place = Rect::from_min_max(rect.min, pos2(rect.right(), plot.top()));
        ui.place(place, Label::new(words).selectable(false));
    }
    help_beside(&response, help_words(histogram, value));
    let pointer = response.interact_pointer_pos().filter(|_| response.is_pointer_button_down_on())?;
    let dragged = axis.value((pointer.x - plot.left()) / plot.width());
    (enabled && (dragged - value).abs() > 1e-6 * value.abs()).then_some(dragged)
}

/// A line that can be dragged, with its handle.
pub(crate) fn line(painter: &Painter, plot: Rect, x: f32, color: Color32, is_grabbed: bool) {
    painter.vline(x, plot.y_range(), Stroke::new(if is_grabbed { 3.0 } else { 2.0 }, color));
    let handle = [pos2(x - 5.0, plot.top()), pos2(x + 5.0, plot.top()), pos2(x, plot.top() + 7.0)];
    painter.add(egui::Shape::convex_polygon(handle.to_vec(), color, Stroke::NONE));
}

/// The shares within the line and beyond it.
fn side_words(histogram: Option<&ThresholdHistogram>, value: f64) -> [String; 2] {
    let (within, beyond) = histogram.map_or((0, 0), |histogram| histogram.sides(value));
    let share = |part: usize| model::percent(part as u64, (within + beyond) as u64);
    [format!("{} within", share(within)), format!("{} beyond", share(beyond))]
}

/// What is counted, and what the colors of the bars mean.
fn help_words(histogram: Option<&ThresholdHistogram>, value: f64) -> String {
    let Some(histogram) = histogram else {
        return "Not counted yet; the line can be dragged already.".to_owned();
    };
    let (within, beyond) = histogram.sides(value);
    format!(
        "{} {}{}: {within} within the line, {beyond} beyond. Blue passes all rules, orange does not{}. Drag the line.",
        model::count((within + beyond) as u64),
        histogram.of,
        histogram.frame.map_or_else(String::new, |frame| format!(", {}", at_frame(frame))),
        if histogram.noise.is_some() { "; measured noise explains the light band" } else { "" }
    )
}

fn at_frame(frame: usize) -> String {
    format!("at frame {}", frame + 1)
}

/// The bars of a histogram, each of parts one on the other; `color` is that of a part of a bar, by their indices.
pub(crate) fn bars<const PARTS: usize>(
    painter: &Painter,
    plot: Rect,
    bars: &[[u32; PARTS]],
    color: impl Fn(usize, usize) -> Color32,
) {
    // The logarithm lets rare values be seen beside frequent ones.
    let height = |count: u32| (count as f32).ln_1p();
    let totals = bars.iter().map(|bar| bar.iter().sum::<u32>());
    let most = height(totals.clone().max().unwrap_or(0).max(1));
    let step = plot.width() / BARS as f32;
    for (index, (bar, total)) in bars.iter().zip(totals).enumerate() {
        let left = plot.left() + index as f32 * step;
        let of_one = height(total) / most * (plot.height() - 3.0) / total.max(1) as f32;
        let mut bottom = plot.bottom();
        for (part, count) in bar.iter().enumerate() {
            let top = bottom - *count as f32 * of_one;
            let area = Rect::from_min_max(pos2(left, top), pos2(left + step - 0.5, bottom));
            painter.rect_filled(area, 0.0, color(index, part));
            bottom = top;
        }
    }
}

/// Width of the list, points.
const LIST_WIDTH: f32 = 320.0;

/// The button for undo, or for redo: it names the change, and a right click lists the next ones, to go back to any.
fn undo_button_ui(ui: &mut Ui, state: &State, undo: bool, commands: &mut Commands) {
    let (icon, name, keys, command) = if undo {
        (ICON_UNDO, "Undo", "Ctrl+Z", Command::Undo)
    } else {
        (ICON_REDO, "Redo", "Ctrl+Y", Command::Redo)
    };
    let button = ui.add_enabled_ui(state.can_undo(undo), |ui| bare_icon_button(ui, icon, name)).inner;
    let button = button.on_disabled_hover_text(format!("Nothing to {} ({keys}).", name.to_lowercase()));
    // What it would say is worked out only where it is read.
    let button = button.on_hover_ui(|ui| {
        let change = state.undo_list(undo).into_iter().next().unwrap_or_default();
        ui.label(format!("{name} ({keys}): {change}\nRight-click: the changes before it."));
    });
    if button.clicked() {
        commands.push(command.clone());
    }
    button.context_menu(|ui| {
        ui.set_width(LIST_WIDTH);
        note(ui, if undo { "Undo up to" } else { "Redo up to" });
        for (nth, change) in state.undo_list(undo).into_iter().enumerate() {
            let entry = ui.add(Button::new(change.as_str()).truncate());
            if entry.accessible_name(format!("{name} {}: {change}", nth + 1)).clicked() {
                commands.extend(std::iter::repeat_n(command.clone(), nth + 1));
                ui.close();
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_has_a_section_in_the_panel() {
        for field in Settings::fields() {
            let shown = SECTIONS.iter().any(|(section, ..)| fields_of(section).any(|f| f.path == field.path));
            assert!(shown, "{}", field.path);
        }
    }
}
