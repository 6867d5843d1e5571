//! The numbers of what is selected: of shapes, ranges and colors.

use egui::{DragValue, Grid, Ui};

use crate::app::model::State;
use crate::app::theme::space;
use overlook_engine::color::{linear_from_srgb, srgb_from_linear};
use overlook_engine::edits::Region;

/// Footprints by which a selection grows, and that a step over a surface takes at most.
pub(super) const GROW_BY: std::ops::RangeInclusive<f64> = 0.5..=Region::MOST_FOOTPRINTS;

const AXES: [&str; 3] = ["X", "Y", "Z"];
const CHANNELS: [&str; 3] = ["red", "green", "blue"];
const ENDS: [&str; 2] = ["from", "to"];

/// How numbers of one kind are dragged.
#[derive(Clone, Copy)]
struct Dragged {
    least: f64,
    most: f64,
    /// Along a point.
    speed: f64,
    suffix: &'static str,
}

impl Dragged {
    const fn new(least: f64, most: f64, speed: f64, suffix: &'static str) -> Self {
        Self { least, most, speed, suffix }
    }
}

/// A row of numbers with the names of its parts; whether one was changed.
fn row(ui: &mut Ui, name: &str, parts: &[&str], values: &mut [&mut f64], how: Dragged) -> bool {
    ui.label(name);
    let mut changed = false;
    for (value, part) in values.iter_mut().zip(parts) {
        let drag = DragValue::new(*value).speed(how.speed).max_decimals(3).suffix(how.suffix);
        let drag = ui.add(drag.range(how.least..=how.most));
        changed |= drag.accessible_name(format!("{name} {part}")).changed();
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
pub(super) fn numbers_ui(ui: &mut Ui, region: &mut Region, state: &State) -> bool {
    let speed = state.live.orbit.as_ref().map_or(0.01, |orbit| orbit.pivot_distance * 0.003);
    let place = Dragged::new(f64::MIN, f64::MAX, speed, "");
    let size = Dragged::new(speed * 1e-3, f64::MAX, speed, "");
    let grid = Grid::new("shape").num_columns(4).spacing([space::SMALL, 4.0]);
    let shown = grid.show(ui, |ui| {
        ui.spacing_mut().button_padding.x = space::SMALL;
        match region {
            Region::Box { center, half_size, rotation_degrees } => {
                let turn = Dragged::new(f64::MIN, f64::MAX, 0.5, "°");
                let moved = row(ui, "Center", &AXES, &mut center.each_mut(), place);
                let resized = row(ui, "Half size", &AXES, &mut half_size.each_mut(), size);
                row(ui, "Turned", &AXES, &mut rotation_degrees.each_mut(), turn) || moved || resized
            }
            Region::Sphere { center, radius } => {
                let moved = row(ui, "Center", &AXES, &mut center.each_mut(), place);
                row(ui, "Radius", &AXES, &mut [radius], size) || moved
            }
            Region::SameSurface { footprints, angle, .. } => {
                let step = Dragged::new(*GROW_BY.start(), *GROW_BY.end(), 0.1, " footprints");
                let stepped = row(ui, "Step", &AXES, &mut [footprints], step);
                row(ui, "Turn", &AXES, &mut [angle], Dragged::new(0.0, 90.0, 0.5, "°")) || stepped
            }
            Region::Depth { from, to } => range_row(ui, "Depth", from, to, Dragged { least: 0.0, ..size }),
            Region::Angle { from, to } => {
                range_row(ui, "Angle", from, to, Dragged::new(0.0, 180.0, 0.5, "°"))
            }
            Region::Value { name, from, to } => {
                let speed = speed_of_value(state, name);
                let open = Dragged::new(f64::NEG_INFINITY, f64::INFINITY, speed, "");
                range_row(ui, "Value", from, to, open)
            }
            Region::Color { linear, tolerance } => color_ui(ui, linear, tolerance),
            _ => false,
        }
    });
    shown.inner
}

/// A color in steps of 1/255 as displays show it, and by how many others may differ.
fn color_ui(ui: &mut Ui, linear: &mut [f64; 3], tolerance: &mut f64) -> bool {
    let steps = Dragged::new(0.0, f64::MAX, 0.5, "");
    let shown = linear.map(|channel| f64::from(255.0 * srgb_from_linear(channel as f32)));
    let mut turned = shown;
    let is_turned = row(ui, "Color", &CHANNELS, &mut turned.each_mut(), steps);
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
