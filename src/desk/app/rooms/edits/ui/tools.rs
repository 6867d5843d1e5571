//! What selects samples, and what masks pixels.

use egui::{DragValue, ScrollArea, Slider, Ui};
use glam::DVec3;

use crate::app::model::State;
use crate::app::rooms::edits::model::{BRUSH_RADII, Combine, DrawnDepth, EditCommand, EditTool, EditTools};
use crate::app::rooms::live::ui::view_panel::heading_ui;
use crate::app::widgets::segments_ui;
use overlook_engine::edits::Region;

/// A new box or sphere reaches this far, in distances from the view to what it turns about.
const NEW_SIZE: f64 = 0.15;

/// A new range of angles.
const SLANTED: Region = Region::Angle { from: 60.0, to: 90.0 };

/// Where a new shape is put, and how large: at the pinned pixel, else at what the view turns about.
fn new_place(state: &State) -> ([f64; 3], f64) {
    let pinned = state.doc.probe.pinned.then_some(state.doc.probe.shown.as_ref()).flatten();
    let pinned = pinned.and_then(|probed| probed.point_in_world);
    let pivot = state.doc.scene.as_ref().map_or(DVec3::ZERO, |scene| scene.pivot_in_world);
    let distance = state.live.orbit.as_ref().map_or(1.0, |orbit| orbit.pivot_distance);
    (pinned.unwrap_or(pivot).to_array(), NEW_SIZE * distance)
}

pub(crate) fn select_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>) {
    heading_ui(ui, "Select");
    let (center, size) = new_place(state);
    let edits = &state.doc.edits;
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
        for (name, help, region) in shapes {
            if ui.button(name).on_hover_text(help).accessible_name(format!("Select {name}")).clicked() {
                sent.push(EditCommand::Select(region));
            }
        }
        for tool in EditTool::ALL.iter().filter(|(tool, ..)| *tool != EditTool::Mask) {
            tool_ui(ui, state, tool, "Select", sent);
        }
    });
    brush_ui(ui, state, sent);
    evidence_ui(ui, state, sent);
    ranges_ui(ui, state, sent);
    if let Some(combine) = segments_ui(ui, "Selection", edits.tools.combine, Combine::ALL) {
        sent.push(EditCommand::Tools(EditTools { combine, ..edits.tools }));
    }
    if let Some(depth) = segments_ui(ui, "Drawing selects", edits.tools.depth, DrawnDepth::ALL) {
        sent.push(EditCommand::Tools(EditTools { depth, ..edits.tools }));
    }
}

/// Selects by what cameras say.
fn evidence_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>) {
    let id = ui.scope_id().with("least cameras");
    let mut least: u32 = ui.data(|data| data.get_temp(id)).unwrap_or(2);
    let knows_votes = state.has_capture();
    let why_not = "A store does not hold which cameras confirm its samples; open the capture, or use overlook edit --capture.";
    ui.horizontal_wrapped(|ui| {
        for (name, help, region, is_known) in [
            (
                "Contradicted",
                "Samples that more other cameras look past than confirm.",
                Region::Contradicted,
                knows_votes,
            ),
            (
                "One camera",
                "Samples that no other camera could have seen.",
                Region::SeenByOneCamera,
                knows_votes,
            ),
            (
                "Doubtful",
                "Samples that no other camera confirms among noisy cameras.",
                Region::Doubtful,
                true,
            ),
        ] {
            let button =
                ui.add_enabled(is_known, egui::Button::new(name)).accessible_name(format!("Select {name}"));
            if button.on_hover_text(help).on_disabled_hover_text(why_not).clicked() {
                sent.push(EditCommand::Select(region));
            }
        }
        let button = ui.add_enabled(knows_votes, egui::Button::new("Confirmed by fewer than"));
        let button = button.accessible_name("Select confirmed by fewer");
        let help = "Samples that fewer other cameras than this confirm.";
        if button.on_hover_text(help).on_disabled_hover_text(why_not).clicked() {
            sent.push(EditCommand::Select(Region::ConfirmedByFewerThan(least)));
        }
        let drag = ui.add(DragValue::new(&mut least).range(1..=64)).accessible_name("Least cameras");
        if drag.changed() {
            ui.data_mut(|data| data.insert_temp(id, least));
            if matches!(state.doc.edits.selection, Some(Region::ConfirmedByFewerThan(_))) {
                sent.push(EditCommand::Reshape(Some(Region::ConfirmedByFewerThan(least))));
            }
        }
        cameras_ui(
            ui,
            state,
            "Camera",
            |camera| EditCommand::Select(Region::Cameras(vec![camera.to_owned()])),
            sent,
        );
    });
}

/// Selects by ranges, whose ends are then numbers of the selection.
fn ranges_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>) {
    let distance = state.live.orbit.as_ref().map_or(1.0, |orbit| orbit.pivot_distance);
    ui.horizontal_wrapped(|ui| {
        for (name, help, region) in [
            (
                "Near and far",
                "Samples by their depth in their own camera; at first those nearer than what the view turns about.",
                Region::Depth { from: 0.0, to: distance },
            ),
            (
                "Angle",
                "Samples by the angle between their surface's normal and the direction to their camera, where normals are stored; at first \
                 those seen at a slant.",
                SLANTED,
            ),
        ] {
            if ui.button(name).on_hover_text(help).accessible_name(format!("Select {name}")).clicked() {
                sent.push(EditCommand::Select(region));
            }
        }
        let channels = state.value_channels();
        if !channels.is_empty() {
            ui.menu_button("Value", |ui| {
                for channel in channels {
                    if ui.button(&channel.name).clicked() {
                        let [from, to] = channel.range.map(f64::from);
                        let name = channel.name.clone();
                        sent.push(EditCommand::Select(Region::Value { name, from, to }));
                    }
                }
            });
        }
    });
}

/// A button that takes a tool up or lays it down.
fn tool_ui(
    ui: &mut Ui,
    state: &State,
    &(tool, name, key, help): &(EditTool, &str, &str, &str),
    does: &str,
    sent: &mut Vec<EditCommand>,
) {
    let is_on = state.doc.edits.tools.tool == Some(tool);
    let button = ui.selectable_label(is_on, name).accessible_name(format!("{does} {name}"));
    if button.on_hover_text(format!("{help} ({key})")).clicked() {
        sent.push(EditCommand::Tools(state.doc.edits.tools.with(tool)));
    }
}

/// How wide the brush is, while there is one.
fn brush_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>) {
    if !state.doc.edits.tools.tool.is_some_and(EditTool::has_radius) {
        return;
    }
    ui.horizontal(|ui| {
        ui.label("Radius");
        let mut radius = state.doc.edits.tools.radius;
        let slider = Slider::new(&mut radius, BRUSH_RADII).logarithmic(true).fixed_decimals(0).suffix(" px");
        let slider = ui.add(slider).on_hover_text("Radius of the brush on the screen ([ and ]).");
        if slider.changed() {
            sent.push(EditCommand::Tools(EditTools { radius, ..state.doc.edits.tools }));
        }
    });
}

/// Masks, which are drawn in source pictures.
pub(crate) fn mask_ui(ui: &mut Ui, state: &State, sent: &mut Vec<EditCommand>) {
    if !state.has_capture() {
        return;
    }
    heading_ui(ui, "Mask pixels of a camera");
    ui.horizontal_wrapped(|ui| {
        for tool in EditTool::ALL.iter().filter(|(tool, ..)| *tool == EditTool::Mask) {
            tool_ui(ui, state, tool, "Draw", sent);
        }
        if state.has_time() {
            range_ui(ui, state, "Mask", sent);
        }
    });
}

/// The first and the last frame of a range.
pub(crate) fn range_ui(ui: &mut Ui, state: &State, what: &str, sent: &mut Vec<EditCommand>) {
    let numbers = state.doc.scene.as_ref().map_or(&[][..], |scene| &scene.frame_numbers);
    let Some((first, last)) = numbers.first().zip(numbers.last()) else { return };
    let mut range = state.doc.edits.tools.range.unwrap_or([*first, *last]);
    let mut changed = false;
    for (at, (before, name)) in range.iter_mut().zip([("frames", "first frame"), ("to", "last frame")]) {
        ui.label(before);
        let drag = ui.add(DragValue::new(at).range(*first..=*last));
        changed |= drag.accessible_name(format!("{what}: {name}")).changed();
    }
    if changed {
        sent.push(EditCommand::Tools(EditTools { range: Some(range), ..state.doc.edits.tools }));
    }
}

/// A menu of cameras, by their names.
pub(crate) fn cameras_ui(
    ui: &mut Ui,
    state: &State,
    name: &str,
    command: impl Fn(&str) -> EditCommand,
    sent: &mut Vec<EditCommand>,
) {
    let Some(scene) = &state.doc.scene else { return };
    ui.menu_button(name, |ui| {
        ScrollArea::vertical().max_height(320.0).show(ui, |ui| {
            for camera in &scene.cameras {
                if ui.button(&camera.name).clicked() {
                    sent.push(command(&camera.name));
                }
            }
        });
    });
}
