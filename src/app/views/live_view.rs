//! The right view: what is left of the capture, seen from anywhere.

use egui::{Painter, PointerButton, Rect, Response, RichText, Sense, Ui, vec2};
use egui_material_icons::icons::{ICON_HOME, ICON_VIDEOCAM, ICON_VIDEOCAM_OFF};
use glam::DVec2;

use super::legend;
use super::overlays::{self, frustum};
use super::source_view::{self, CAMERA_LIST_WIDTH, FOOTER};
use crate::app::camera_cues;
use crate::app::model::verdict_text as words;
use crate::app::model::{self, ColorBy, Command, Commands, HoleDisplay, Spot, State};
use crate::app::theme::Tokens;
use crate::app::widgets::{
    self, camera_choices, choice_ui, icon_button, one_line, picture, scrolled, segments_ui, waiting,
};
use crate::render::NO_IMAGE;

/// Radians of orbit per point that the pointer is dragged.
const ORBIT_PER_POINT: f64 = 0.008;

/// Largest side of the live view in pixels that is asked for, so that turning stays smooth on large displays.
const LARGEST_SIDE: f32 = 1600.0;

/// Length of a camera's pyramid, as a share of its distance to what all look at.
const PYRAMID: f64 = 0.12;

/// Depths that differ by less than this share are taken for one surface.
const NEARLY: f64 = 0.03;

pub(crate) fn live_view_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    header_ui(ui, state, commands);
    let available = ui.available_rect_before_wrap();
    let canvas = Rect::from_min_max(available.min, available.max - vec2(0.0, FOOTER));
    picture_ui(ui, canvas, state, commands);
    ui.allocate_rect(canvas, Sense::hover());
    ui.add_space(2.0);
    legend::live_legend_ui(ui, state);
    ui.spacing_mut().item_spacing.y = 1.0;
    facts_ui(ui, state);
}

fn header_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        if let Some(color_by) = segments_ui(ui, "Live view shows", state.live.color_by, ColorBy::ALL) {
            commands.push(Command::ColorBy(color_by));
        }
        ui.separator();
        ui.label(RichText::new("Holes").size(12.5));
        if let Some(holes) = segments_ui(ui, "Holes", state.holes_shown(), HoleDisplay::ALL) {
            commands.push(Command::Holes(holes));
        }
    });
}

/// Places to go to, and whether cameras are drawn; from right to left.
pub(crate) fn go_to_camera_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(scene) = &state.scene else { return };
    let (icon, name) = if state.live.show_cameras {
        (ICON_VIDEOCAM, "Hide cameras")
    } else {
        (ICON_VIDEOCAM_OFF, "Show cameras")
    };
    if icon_button(ui, icon, name, name).clicked() {
        commands.push(Command::ShowCameras(!state.live.show_cameras));
    }
    if icon_button(ui, ICON_HOME, "Reset view", "Back to the start view (Home)").clicked() {
        commands.push(Command::Home);
    }
    let mut places = vec![(usize::MAX, "Go to…", "View the scene from a camera.")];
    places.extend(camera_choices(&scene.cameras));
    if let Some(camera) = choice_ui(ui, "Go to camera", usize::MAX, &places, CAMERA_LIST_WIDTH) {
        commands.push(Command::JumpTo(camera));
    }
}

fn picture_ui(ui: &mut Ui, canvas: Rect, state: &State, commands: &mut Commands) {
    let (response, painter) = widgets::canvas_ui(ui, canvas, "live picture", "Live picture");
    let pixels = canvas.size() * ui.ctx().pixels_per_point();
    let shrink = (LARGEST_SIDE / pixels.max_elem()).min(1.0);
    let size = [(pixels.x * shrink) as u32, (pixels.y * shrink) as u32].map(|side| side.max(1));
    if size != state.live.size {
        commands.push(Command::LiveSize(size));
    }
    if let Some(shown) = &state.live_shown {
        picture(&painter, shown.texture.id(), canvas);
    } else if !state.is_frame_failed() {
        waiting(ui, canvas, 28.0);
    }
    if state.live.show_cameras {
        cameras_overlay(ui, &painter, canvas, state);
    }
    motion(ui, &response, canvas, state, commands);
    probe_ui(&response, &painter, canvas, state, commands);
}

/// Marks the selected pixel, and selects the one under the pointer.
fn probe_ui(response: &Response, painter: &Painter, canvas: Rect, state: &State, commands: &mut Commands) {
    let probe = &state.inspector.probe;
    let point = probe.shown.as_ref().and_then(|probed| probed.point_in_world);
    if let (Some(point), Some(orbit)) = (point, &state.live.orbit) {
        let vantage = orbit.camera(canvas.width() as u32, canvas.height() as u32);
        if let Some((position, depth)) = vantage.project(point) {
            let at = canvas.min + vec2(position.x as f32, position.y as f32);
            let painter = painter.with_clip_rect(canvas);
            let is_seen = shows(state, canvas, at, depth);
            overlays::mark(&painter, at, is_seen, probe.pinned, Tokens::of(state.dark));
        }
    }
    let (Some(pointer), Some(shown)) = (response.hover_pos(), &state.live_shown) else { return };
    let [width, height] = shown.picture.size;
    let share = (pointer - canvas.min) / canvas.size();
    let (x, y) = ((share.x * width as f32) as usize, (share.y * height as f32) as usize);
    if x < width && y < height {
        source_view::point_at(response, Spot::Live { x, y }, state, commands);
    }
}

/// Whether a sample in the live picture shows the surface at this place and depth, and nothing before it.
fn shows(state: &State, canvas: Rect, at: egui::Pos2, depth: f64) -> bool {
    let Some(picture) = state.live_shown.as_ref().and_then(|shown| shown.picture.rendered()) else {
        return false;
    };
    let share = (at - canvas.min) / canvas.size();
    if share.x < 0.0 || share.y < 0.0 {
        return false;
    }
    let (width, height) = picture.image.size();
    let (x, y) = ((share.x * width as f32) as usize, (share.y * height as f32) as usize);
    let has_sample = picture.image.get(x, y).is_some_and(|image| *image != NO_IMAGE);
    has_sample && (f64::from(picture.inverse_depth[(x, y)]) * depth - 1.0).abs() < NEARLY
}

fn cameras_overlay(ui: &Ui, painter: &Painter, canvas: Rect, state: &State) {
    let (Some(scene), Some(orbit)) = (&state.scene, &state.live.orbit) else { return };
    let vantage = orbit.camera(canvas.width() as u32, canvas.height() as u32);
    let mut names = Vec::new();
    for (index, camera) in scene.cameras.iter().enumerate() {
        let to_pivot = (scene.pivot_in_world - camera.position_in_world()).length();
        let apart = (vantage.position_in_world() - camera.position_in_world()).length();
        let length = PYRAMID * to_pivot;
        // From inside, a pyramid would only cross the picture: coming near, it fades.
        let presence = (apart / length - 1.0).clamp(0.0, 1.0) as f32;
        if presence == 0.0 {
            continue;
        }
        let shape = frustum(camera, &vantage, length);
        let selected = index == state.source.camera && state.has_capture();
        let color = camera_cues::color(index).gamma_multiply(presence);
        let stroke = egui::Stroke::new(if selected { 2.5 } else { 1.5 }, color);
        for line in shape.lines {
            painter.line_segment(line.map(|point| canvas.min + point.to_vec2()), stroke);
        }
        let apex = shape.apex.map(|apex| canvas.min + apex.to_vec2());
        if let Some(apex) = apex.filter(|apex| canvas.contains(*apex)) {
            names.push(CameraLabel { name: &camera.name, apex, is_chosen: selected, apart, presence });
        }
    }
    names_overlay(ui, painter, canvas, names);
}

/// The name of a camera in view.
struct CameraLabel<'a> {
    name: &'a str,
    apex: egui::Pos2,
    is_chosen: bool,
    /// How far away the camera is.
    apart: f64,
    /// How much of it is to be seen, 0 to 1.
    presence: f32,
}

/// Of names that overlap only one is drawn: the chosen camera's, then the nearest.
fn names_overlay(ui: &Ui, painter: &Painter, canvas: Rect, mut names: Vec<CameraLabel<'_>>) {
    let tokens = Tokens::in_ui(ui);
    let font = egui::TextStyle::Small.resolve(ui.style());
    names.sort_by(|a, b| b.is_chosen.cmp(&a.is_chosen).then(a.apart.total_cmp(&b.apart)));
    let mut plates: Vec<Rect> = Vec::new();
    for CameraLabel { name, apex, presence, .. } in names {
        let text = tokens.on_scrim.gamma_multiply(presence);
        let galley = painter.layout_no_wrap(name.to_owned(), font.clone(), text);
        let size = galley.size() + vec2(8.0, 4.0);
        let corner = (apex + vec2(6.0, -18.0)).clamp(canvas.min, (canvas.max - size).max(canvas.min));
        let plate = Rect::from_min_size(corner, size);
        if plates.iter().any(|other| other.intersects(plate)) {
            continue;
        }
        plates.push(plate);
        painter.rect_filled(plate, 4.0, tokens.scrim.gamma_multiply(presence));
        painter.galley(plate.min + vec2(4.0, 2.0), galley, text);
    }
}

/// The surface point that the live picture shows at a place.
fn point_under(state: &State, canvas: Rect, at: egui::Pos2) -> Option<glam::DVec3> {
    let shown = state.live_shown.as_ref()?;
    let picture = &shown.picture.rendered()?.inverse_depth;
    let share = (at - canvas.min) / canvas.size();
    let place =
        DVec2::new(f64::from(share.x) * picture.width() as f64, f64::from(share.y) * picture.height() as f64);
    let inverse_depth = f64::from(*picture.get(place.x as usize, place.y as usize)?);
    (inverse_depth > 0.0).then(|| shown.key.vantage.camera.unproject(place, 1.0 / inverse_depth))
}

fn motion(ui: &Ui, response: &Response, canvas: Rect, state: &State, commands: &mut Commands) {
    if response.double_clicked() {
        commands.push(Command::Home);
        return;
    }
    let delta = response.drag_delta();
    let delta = DVec2::new(f64::from(delta.x), f64::from(delta.y));
    if delta != DVec2::ZERO {
        let shifts = response.dragged_by(PointerButton::Secondary)
            || response.dragged_by(PointerButton::Middle)
            || ui.ctx().input(|input| input.modifiers.shift);
        commands.push(if shifts {
            Command::Pan(delta / f64::from(canvas.height().max(1.0)))
        } else {
            Command::Orbit(delta * ORBIT_PER_POINT)
        });
    }
    if response.hovered() {
        let scroll = scrolled(ui);
        if scroll != 0.0 {
            let factor = (-f64::from(scroll) * 0.003).exp();
            let under = response.hover_pos().and_then(|pointer| point_under(state, canvas, pointer));
            commands.push(match under {
                Some(point_in_world) => Command::DollyTo { factor, point_in_world },
                None => Command::Dolly(factor),
            });
        }
    }
}

fn facts_ui(ui: &mut Ui, state: &State) {
    let tokens = Tokens::in_ui(ui);
    let facts = match &state.live_shown {
        Some(shown) => {
            let stats = &shown.picture.stats;
            let [width, height] = shown.picture.size;
            let reused = if stats.background_reused { ", static part cached" } else { "" };
            format!(
                "{} holes ({}) · {} samples at {width}×{height} in {} ms by the {}{reused}",
                model::count(stats.holes),
                model::percent(stats.holes, (width * height).max(1) as u64),
                model::count(stats.samples),
                model::significant(stats.milliseconds),
                shown.picture.painter
            )
        }
        None if state.is_frame_failed() => words::FAILED_FRAME.to_owned(),
        None => "Rendering the first picture.".to_owned(),
    };
    let help = "Drag to orbit, Shift + drag to pan, wheel to zoom, W A S D to fly, double-click to reset the view, click to pin \
                the pixel.";
    let notice = state.live_shown.as_ref().and_then(|shown| shown.picture.notice.as_ref());
    let (facts, color) = match notice {
        Some(notice) => (notice.clone(), tokens.warning),
        None => (facts, tokens.text_weak),
    };
    one_line(ui, facts, color).on_hover_text(help);
}
