//! Selecting samples, deleting them, and the list of edits.

pub(crate) mod drawing;

use std::ops::RangeInclusive;

use egui::{Checkbox, DragValue, Grid, Label, RichText, ScrollArea, Slider, TextEdit, Ui};
use egui_material_icons::icons::{
    ICON_ARROW_DROP_DOWN, ICON_BRUSH, ICON_COLORIZE, ICON_DELETE, ICON_HIGHLIGHT_ALT, ICON_LASSO_SELECT,
    ICON_LAYERS, ICON_MORE_VERT, ICON_REDO, ICON_UNDO,
};
use glam::DVec3;

use crate::app::model::command::{
    Combine, DrawnDepth, EditCommand, EditTime, EditTool, EditTools, FileCommand,
};
use crate::app::model::purpose::Purpose;
use crate::app::model::window::DockView;
use crate::app::model::{self, Command, Commands, State};
use crate::app::rooms::edits::state::{BRUSH_RADII, last_shape, words as region_words};
use crate::app::theme::{Tokens, space};
use crate::app::widgets::{ICON_BUTTON, heading_ui, icon_button, note, segments_ui, weak};
use crate::ways_out;
use overlook_engine::color::{linear_from_srgb, srgb_from_linear};
use overlook_engine::edits::{Action, Region};

const ASKS_WHOLE: &str = "Edits act on all frames: they are shown once the whole capture is pruned.";

pub(crate) fn edits_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    if state.doc.scene.is_none() {
        return;
    }
    let mut sent = Vec::new();
    let mut tools = state.doc.edits.tools;
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.set_max_width(ui.available_width() - space::MEDIUM);
        select_ui(ui, state, &mut tools, &mut sent);
        selection_ui(ui, state, &mut tools, &mut sent);
        mask_ui(ui, state, &mut tools);
        list_ui(ui, state, &mut sent, commands);
        save_ui(ui, state, commands);
    });
    if tools != state.doc.edits.tools {
        sent.push(EditCommand::Tools(tools));
    }
    commands.extend(sent.into_iter().map(Command::Edit));
}

/// What is selected, its numbers, and what can be done with it.
fn selection_ui(ui: &mut Ui, state: &State, tools: &mut EditTools, sent: &mut Vec<EditCommand>) {
    let edits = &state.doc.edits;
    let Some(selection) = &edits.selection else {
        weak(ui, "Nothing is selected.");
        return;
    };
    ui.add(Label::new(RichText::new(region_words(selection)).strong()).truncate());
    let facts = match state.edited_now().filter(|_| edits.trouble.is_none()) {
        Some(edited) => {
            let left = edited.before - edited.deleted;
            let bytes = edited.bytes as f64 * edited.selected as f64 / left.max(1) as f64;
            format!(
                "{} ({}), {} in memory",
                model::count_of(edited.selected, "sample"),
                model::percent(edited.selected, left),
                model::bytes(bytes as u64)
            )
        }
        None if state.samples_to_edit().is_none() => ASKS_WHOLE.to_owned(),
        None if edits.trouble.is_some() => String::new(),
        None => "Selecting…".to_owned(),
    };
    note(ui, facts);
    let mut reshaped = selection.clone();
    if let Some(shape) = last_shape(&mut reshaped)
        && numbers_ui(ui, shape, state)
    {
        sent.push(EditCommand::Reshape(Some(reshaped)));
    }
    act_ui(ui, state, tools, sent);
}

/// What can be done with the selection, and at which frames.
fn act_ui(ui: &mut Ui, state: &State, tools: &mut EditTools, sent: &mut Vec<EditCommand>) {
    let edits = &state.doc.edits;
    if state.has_time() {
        tools.time = segments_ui(ui, "Edit acts at", tools.time, EditTime::ALL).unwrap_or(tools.time);
        if tools.time == EditTime::Range {
            ui.horizontal(|ui| range_ui(ui, state, "Edit", tools));
        }
    }
    let changes = [
        ("Delete", "Delete what is selected (Delete).", EditCommand::Act(Action::Delete)),
        ("Keep only", "Delete all but what is selected.", EditCommand::Act(Action::KeepOnly)),
        (
            "Restore",
            "Bring back what edits above delete of what is selected.",
            EditCommand::Act(Action::Restore),
        ),
        ("Invert", "Select what is not selected (Ctrl+I).", EditCommand::Reshape(edits.inverted())),
        ("Clear", "Select nothing (Esc).", EditCommand::SelectNothing),
    ];
    ui.horizontal_wrapped(|ui| changes_ui(ui, changes, sent));
    ui.horizontal_wrapped(|ui| {
        let grown = |grows| EditCommand::Reshape(edits.grown(grows));
        let changes = [
            ("Grow", "Select what is near the selection as well (G).", grown(true)),
            ("Shrink", "Take what is near its border out of the selection (Shift+G).", grown(false)),
        ];
        changes_ui(ui, changes, sent);
        ui.label("by");
        let by = DragValue::new(&mut tools.grow_by).speed(0.1).max_decimals(1).range(GROW_BY);
        ui.add(by.suffix(" footprints"))
            .on_hover_text("Widths of a pixel where the sample lies.")
            .accessible_name("Grow by");
    });
}

/// Buttons that do something to the selection, by their names and what they do.
fn changes_ui<const N: usize>(
    ui: &mut Ui,
    changes: [(&str, &str, EditCommand); N],
    sent: &mut Vec<EditCommand>,
) {
    for (name, help, command) in changes {
        let button = ui.button(name).accessible_name(format!("{name} selection"));
        if button.on_hover_text(help).clicked() {
            sent.push(command);
        }
    }
}

fn list_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>, commands: &mut Commands) {
    let edits = &state.doc.edits;
    heading_ui(ui, "List of edits");
    if edits.list.edits.is_empty() {
        weak(ui, "No edits yet. What is deleted stays in the list, to be switched off or saved.");
    }
    let mut list = edits.list.clone();
    let last = list.edits.len().saturating_sub(1);
    let (mut named, mut moved, mut removed) = (None, None, None);
    for (index, edit) in list.edits.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            let on = ui.add(Checkbox::without_text(&mut edit.is_on));
            on.accessible_name(format!("Edit {} acts", index + 1));
            let width = (ui.available_width() - 80.0).max(60.0);
            let field = ui.add(TextEdit::singleline(&mut edit.name).desired_width(width));
            let field = field.accessible_name(format!("Name of edit {}", index + 1));
            if field.on_hover_text(region_words(&edit.region)).changed() {
                named = Some(index);
            }
            let more = egui::Button::new(ICON_MORE_VERT.rich_text().size(16.0)).min_size(ICON_BUTTON);
            let (more, _) = egui::containers::menu::MenuButton::from_button(more).ui(ui, |ui| {
                for (name, to) in
                    [("Move up", index.checked_sub(1)), ("Move down", (index < last).then_some(index + 1))]
                {
                    if ui.add_enabled(to.is_some(), egui::Button::new(name)).clicked() {
                        moved = to.map(|to| (index, to));
                    }
                }
                let help = "To reshape it, or to combine it with others.";
                if ui.button("Select its region").on_hover_text(help).clicked() {
                    sent.push(EditCommand::Reshape(Some(edit.region.clone())));
                }
            });
            more.accessible_name(format!("More of edit {}", index + 1));
            if icon_button(ui, ICON_DELETE, "Remove edit", "Take this edit out of the list").clicked() {
                removed = Some(index);
            }
        });
        let count = state.cut_scene().and_then(|cut| cut.counts.get(index)).filter(|_| edit.is_on);
        if let Some(count) = count {
            let verb = if *count < 0 { "brought back" } else { "deleted" };
            // Below its name, which keeps the width.
            note(ui, format!("      {} {verb}", model::count_of(count.unsigned_abs(), "sample")));
        }
    }
    if let Some((index, to)) = moved {
        list.edits.swap(index, to);
    }
    if let Some(index) = removed {
        list.edits.remove(index);
    }
    if list != edits.list {
        sent.push(EditCommand::List(list, named));
    }
    if let Some(trouble) = &edits.trouble {
        ui.add(Label::new(RichText::new(trouble).color(Tokens::in_ui(ui).error)).wrap());
    } else if let Some(edited) = state.edited().filter(|edited| edited.deleted > 0) {
        let deleted = model::count_of(edited.deleted, "sample");
        let share = model::percent(edited.deleted, edited.before);
        note(ui, format!("{deleted} deleted ({share}); {} in memory", model::bytes(edited.bytes)));
    } else if edits.are_in_use() && state.samples_to_edit().is_none() {
        note(ui, ASKS_WHOLE);
    }
    below_list_ui(ui, state, sent, commands);
}

/// What leaves a camera out, and what takes edits back.
fn below_list_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        cameras_ui(ui, state, "Leave out camera", |index, _| EditCommand::LeaveOut(vec![index]), sent);
        for (icon, name, help, command, undoes) in [
            (ICON_UNDO, "Undo edit", "Undo the last edit (Ctrl+Z)", Command::Undo, true),
            (ICON_REDO, "Redo edit", "Redo it (Ctrl+Shift+Z)", Command::Redo, false),
        ] {
            ui.add_enabled_ui(state.would_step_edits(undoes), |ui| {
                if icon_button(ui, icon, name, help).clicked() {
                    commands.push(command);
                }
            });
        }
    });
}

fn save_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.add_space(space::MEDIUM);
    if ui.button("Save cleaned store…").on_hover_text(SAVES).clicked() {
        let store = Purpose::Share(&ways_out::store::STORE);
        commands.push(Command::File(FileCommand::AskPath(store)));
    }
    if state.has_capture() && !state.doc.edits.list.is_idle() {
        weak(
            ui,
            "Saving prunes the capture again: cameras that are left out take no part, and nothing brings deleted things back.",
        );
    }
}

const SAVES: &str = "Write what edits leave as a store. Cameras that are hidden in the View panel are saved; those that are left out here are not.";

/// Footprints by which a selection grows, and that a step over a surface takes at most.
const GROW_BY: RangeInclusive<f64> = 0.5..=Region::MOST_FOOTPRINTS;

const AXES: [&str; 3] = ["X", "Y", "Z"];
const CHANNELS: [&str; 3] = ["red", "green", "blue"];
const ENDS: [&str; 2] = ["from", "to"];

/// How numbers of one kind are dragged: within which range, by how much along a point, and in which unit.
type Dragged = (RangeInclusive<f64>, f64, &'static str);

/// A row of numbers with the names of its parts; whether one was changed.
fn row(ui: &mut Ui, name: &str, parts: &[&str], values: &mut [&mut f64], how: Dragged) -> bool {
    let (range, speed, unit) = how;
    ui.label(name);
    let mut changed = false;
    for (value, part) in values.iter_mut().zip(parts) {
        let drag = DragValue::new(*value).range(range.clone()).speed(speed).max_decimals(3).suffix(unit);
        changed |= ui.add(drag).accessible_name(format!("{name} {part}")).changed();
    }
    ui.end_row();
    changed
}

/// Both ends of a range.
fn range_row(ui: &mut Ui, name: &str, from: &mut f64, to: &mut f64, how: Dragged) -> bool {
    let changed = row(ui, name, &ENDS, &mut [&mut *from, &mut *to], how);
    *to = to.max(*from);
    changed
}

/// The numbers of a region without parts; whether one was changed.
fn numbers_ui(ui: &mut Ui, region: &mut Region, state: &State) -> bool {
    let speed = state.live.orbit.as_ref().map_or(0.01, |orbit| orbit.pivot_distance * 0.003);
    let place = (f64::MIN..=f64::MAX, speed, "");
    let size = (speed * 1e-3..=f64::MAX, speed, "");
    let grid = Grid::new("shape").num_columns(4).spacing([space::SMALL, 4.0]);
    let shown = grid.show(ui, |ui| {
        ui.spacing_mut().button_padding.x = space::SMALL;
        match region {
            Region::Box { center, half_size, rotation_degrees } => {
                let turn = (f64::MIN..=f64::MAX, 0.5, "°");
                let moved = row(ui, "Center", &AXES, &mut center.each_mut(), place);
                let resized = row(ui, "Half size", &AXES, &mut half_size.each_mut(), size);
                row(ui, "Turned", &AXES, &mut rotation_degrees.each_mut(), turn) || moved || resized
            }
            Region::Sphere { center, radius } => {
                let moved = row(ui, "Center", &AXES, &mut center.each_mut(), place);
                row(ui, "Radius", &AXES, &mut [radius], size) || moved
            }
            Region::SameSurface { footprints, angle, .. } => {
                let stepped = row(ui, "Step", &AXES, &mut [footprints], (GROW_BY, 0.1, " footprints"));
                row(ui, "Turn", &AXES, &mut [angle], (0.0..=90.0, 0.5, "°")) || stepped
            }
            Region::Depth { from, to } => range_row(ui, "Depth", from, to, (0.0..=f64::MAX, speed, "")),
            Region::Angle { from, to } => range_row(ui, "Angle", from, to, (0.0..=180.0, 0.5, "°")),
            Region::Value { name, from, to } => {
                let speed = speed_of_value(state, name);
                range_row(ui, "Value", from, to, (f64::NEG_INFINITY..=f64::INFINITY, speed, ""))
            }
            Region::ConfirmedByFewerThan(cameras) => {
                let mut count = f64::from(*cameras);
                let changed = row(ui, "Fewer than", &["cameras"], &mut [&mut count], (1.0..=64.0, 0.05, ""));
                *cameras = count as u32;
                changed
            }
            Region::Color { linear, tolerance } => color_ui(ui, linear, tolerance),
            _ => false,
        }
    });
    shown.inner
}

/// A color in steps of 1/255 as displays show it, and by how many others may differ.
fn color_ui(ui: &mut Ui, linear: &mut [f64; 3], tolerance: &mut f64) -> bool {
    let steps = (0.0..=f64::MAX, 0.5, "");
    let shown = linear.map(|channel| f64::from(255.0 * srgb_from_linear(channel as f32)));
    let mut turned = shown;
    let is_turned = row(ui, "Color", &CHANNELS, &mut turned.each_mut(), steps.clone());
    for ((linear, turned), shown) in linear.iter_mut().zip(turned).zip(shown) {
        // What is not turned keeps its last bit.
        if turned.to_bits() != shown.to_bits() {
            *linear = f64::from(linear_from_srgb(turned as f32 / 255.0));
        }
    }
    row(ui, "Tolerance", &AXES, &mut [tolerance], steps) || is_turned
}

/// By how much a value changes along a point that its number is dragged.
fn speed_of_value(state: &State, name: &str) -> f64 {
    let channel = state.value_channels().iter().find(|channel| channel.name == name);
    channel.map_or(0.01, |channel| f64::from((channel.range[1] - channel.range[0]).abs().max(1e-6)) / 200.0)
}

/// A new box or sphere reaches this far, in distances from the view to what it turns about.
const NEW_SIZE: f64 = 0.15;

/// Where a new shape is put, and how large: at the pinned pixel, else at what the view turns about.
fn new_place(state: &State) -> ([f64; 3], f64) {
    let pinned = state.doc.probe.pinned.then_some(state.doc.probe.shown.as_ref()).flatten();
    let pinned = pinned.and_then(|probed| probed.point_in_world);
    let pivot = state.doc.scene.as_ref().map_or(DVec3::ZERO, |scene| scene.pivot_in_world);
    let distance = state.live.orbit.as_ref().map_or(1.0, |orbit| orbit.pivot_distance);
    (pinned.unwrap_or(pivot).to_array(), NEW_SIZE * distance)
}

fn select_ui(ui: &mut Ui, state: &State, tools: &mut EditTools, sent: &mut Vec<EditCommand>) {
    heading_ui(ui, "Select");
    let (center, size) = new_place(state);
    ui.horizontal_wrapped(|ui| {
        let shapes = [
            (
                "Box",
                "A box at the pinned pixel, or in the middle; drag its handles, or give numbers.",
                Region::Box { center, half_size: [size; 3], rotation_degrees: [0.0; 3] },
            ),
            (
                "Sphere",
                "A sphere there; drag its handles, or give numbers.",
                Region::Sphere { center, radius: size },
            ),
        ];
        regions_ui(ui, state, shapes, sent);
        ui.menu_button(("By rule", ICON_ARROW_DROP_DOWN.rich_text()), |ui| rules_ui(ui, state, sent))
            .response
            .accessible_name("Select by rule");
    });
    if tools.tool.is_some_and(EditTool::has_radius) {
        ui.horizontal(|ui| {
            ui.label("Radius");
            let slider = Slider::new(&mut tools.radius, BRUSH_RADII).logarithmic(true);
            ui.add(slider.fixed_decimals(0).suffix(" px"))
                .on_hover_text("Radius of the brush on the screen ([ and ]).");
        });
    }
    tools.combine = segments_ui(ui, "Selection", tools.combine, Combine::ALL).unwrap_or(tools.combine);
    tools.depth = segments_ui(ui, "Drawing selects", tools.depth, DrawnDepth::ALL).unwrap_or(tools.depth);
}

const ASKS_CAPTURE: &str = "A store does not hold which cameras confirm its samples; open the capture, or use overlook edit --capture.";

/// Buttons that select regions, by their names and what is in them.
fn regions_ui<const N: usize>(
    ui: &mut Ui,
    state: &State,
    regions: [(&str, &str, Region); N],
    sent: &mut Vec<EditCommand>,
) {
    for (name, help, region) in regions {
        let is_known = state.has_capture() || !region.asks_for_votes();
        let button =
            ui.add_enabled(is_known, egui::Button::new(name)).accessible_name(format!("Select {name}"));
        if button.on_hover_text(help).on_disabled_hover_text(ASKS_CAPTURE).clicked() {
            sent.push(EditCommand::Select(region));
        }
    }
}

/// Selects by what cameras say, and by ranges, whose ends are then numbers of the selection.
fn rules_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>) {
    let distance = state.live.orbit.as_ref().map_or(1.0, |orbit| orbit.pivot_distance);
    let rules = [
        ("Contradicted", "Samples that more other cameras look past than confirm.", Region::Contradicted),
        ("One camera", "Samples that no other camera could have seen.", Region::SeenByOneCamera),
        (
            "Confirmed by few",
            "Samples that fewer other cameras than a number confirm.",
            Region::ConfirmedByFewerThan(2),
        ),
        ("Doubtful", "Samples that no other camera confirms among noisy cameras.", Region::Doubtful),
        (
            "Near and far",
            "Samples by their depth in their own camera; at first those nearer than what the view turns about.",
            Region::Depth { from: 0.0, to: distance },
        ),
        (
            "Angle",
            "Samples by the angle between their surface's normal and the direction to their camera, where normals are stored; at first \
             those seen at a slant.",
            Region::Angle { from: 60.0, to: 90.0 },
        ),
    ];
    regions_ui(ui, state, rules, sent);
    for channel in state.value_channels() {
        let [from, to] = channel.range.map(f64::from);
        if ui.button(format!("Value: {}", channel.name)).clicked() {
            sent.push(EditCommand::Select(Region::Value { name: channel.name.clone(), from, to }));
        }
    }
    let of_camera = |_, name: &str| EditCommand::Select(Region::Cameras(vec![name.to_owned()]));
    cameras_ui(ui, state, "Camera", of_camera, sent);
}

/// The tools that select in pictures, as icons at the left edge of one, while edits are worked on.
pub(crate) fn tools_ui(ui: &mut Ui, canvas: egui::Rect, state: &State, commands: &mut Commands) {
    if !state.shows(DockView::Edits) && state.doc.edits.tools.tool.is_none() {
        return;
    }
    let icons = [ICON_HIGHLIGHT_ALT, ICON_LASSO_SELECT, ICON_BRUSH, ICON_LAYERS, ICON_COLORIZE];
    let tools = EditTool::ALL.iter().filter(|(tool, ..)| *tool != EditTool::Mask);
    for (nth, ((tool, name, key, help), icon)) in tools.zip(icons).enumerate() {
        let corner = canvas.min + egui::vec2(8.0, 8.0 + nth as f32 * (ICON_BUTTON.y + 4.0));
        let place = egui::Rect::from_min_size(corner, ICON_BUTTON);
        let is_on = state.doc.edits.tools.tool == Some(*tool);
        let button = egui::Button::new(icon.rich_text().size(16.0)).selected(is_on).min_size(ICON_BUTTON);
        let button = ui.put(place, button).accessible_name(format!("Select {name}"));
        if button.on_hover_text(format!("{name}: {help} ({key})")).clicked() {
            commands.push(Command::Edit(EditCommand::Tools(state.doc.edits.tools.with(*tool))));
        }
    }
}

/// Masks, which are drawn in source pictures.
fn mask_ui(ui: &mut Ui, state: &State, tools: &mut EditTools) {
    if !state.has_capture() {
        return;
    }
    heading_ui(ui, "Mask pixels of a camera");
    ui.horizontal_wrapped(|ui| {
        let masks = EditTool::ALL.into_iter().filter(|(tool, ..)| *tool == EditTool::Mask);
        for (tool, name, key, help) in masks {
            let button = ui.selectable_label(tools.tool == Some(tool), name);
            let button = button.accessible_name(format!("Draw {name}"));
            if button.on_hover_text(format!("{help} ({key})")).clicked() {
                *tools = tools.with(tool);
            }
        }
        if state.has_time() {
            range_ui(ui, state, "Mask", tools);
        }
    });
}

fn range_ui(ui: &mut Ui, state: &State, what: &str, tools: &mut EditTools) {
    let numbers = state.doc.scene.as_ref().map_or(&[][..], |scene| &scene.frame_numbers);
    let Some((first, last)) = numbers.first().zip(numbers.last()) else { return };
    let mut range = tools.range.unwrap_or([*first, *last]);
    let mut changed = false;
    for (at, (before, name)) in range.iter_mut().zip([("frames", "first frame"), ("to", "last frame")]) {
        ui.label(before);
        let drag = ui.add(DragValue::new(at).range(*first..=*last));
        changed |= drag.accessible_name(format!("{what}: {name}")).changed();
    }
    if changed {
        tools.range = Some(range);
    }
}

/// A menu of cameras, by their names; `command` gets the index and the name of the one that is chosen.
fn cameras_ui(
    ui: &mut Ui,
    state: &State,
    name: &str,
    command: impl Fn(usize, &str) -> EditCommand,
    sent: &mut Vec<EditCommand>,
) {
    let Some(scene) = &state.doc.scene else { return };
    ui.menu_button(name, |ui| {
        ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
            for (index, camera) in scene.cameras.iter().enumerate() {
                if ui.button(&camera.name).clicked() {
                    sent.push(command(index, &camera.name));
                }
            }
        });
    });
}
