//! The right view: what is left of the capture, seen from anywhere.

mod guides;
pub(crate) mod panel;

use egui::{
    Button, Label, Painter, PointerButton, Rect, Response, RichText, Sense, TextStyle, Ui, pos2, vec2,
};
use egui_material_icons::icons::{ICON_HOME, ICON_VIDEOCAM, ICON_VIDEOCAM_OFF};
use glam::DVec2;

use crate::app::model::camera_text::CameraText;
use crate::app::model::command::{DrawnDepth, EditTool, ViewCommand, WindowCommand};
use crate::app::model::picture::HoleDisplay;
use crate::app::model::purpose::FigureOf;
use crate::app::model::window::DockView;
use crate::app::model::{self, Command, Commands, State};
use crate::app::picture_menu::picture_menu_ui;
use crate::app::rooms::cameras::mark;
use crate::app::rooms::cameras::ui::overlay as cameras_overlay;
use crate::app::rooms::cameras::ui::overlay::{camera_at, seen_cameras};
use crate::app::rooms::change::ui as change;
use crate::app::rooms::edits::ui::drawing::{self, Drawn, PicturePlace, shape_ui};
use crate::app::rooms::edits::ui::tools_ui;
use crate::app::rooms::live::ui::guides::{color_under, inverse_depth_at, pixel_at, place_in};
use crate::app::rooms::pixel::state::Spot;
use crate::app::rooms::pixel::{FAILED_FRAME, verdict};
use crate::app::rooms::source::ui::{FOOTER, legend, point_at};
use crate::app::theme::Tokens;
use crate::app::widgets::{self, chips, icon_button, one_line, picture, scrolled, segments_ui, waiting};
use overlook_engine::capture::Intrinsics;
use overlook_engine::capture::sighting::tolerances::MARKED_SURFACE;
use overlook_engine::capture::sighting::{Sighting, compare};
use overlook_engine::edits::{Region, Viewpoint};
use overlook_engine::render::NO_IMAGE;

/// Radians of orbit per point that the pointer is dragged.
const ORBIT_PER_POINT: f64 = 0.008;

/// Largest side of the live view in pixels that is asked for.
const LARGEST_SIDE: f32 = 4096.0;

pub(crate) fn live_view_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    header_ui(ui, state, commands);
    let available = ui.available_rect_before_wrap();
    let canvas = Rect::from_min_max(available.min, available.max - vec2(0.0, FOOTER));
    picture_ui(ui, canvas, state, commands);
    ui.allocate_rect(canvas, Sense::hover());
    ui.add_space(2.0);
    legend::live_legend_ui(ui, state);
    ui.spacing_mut().item_spacing.y = 1.0;
    if !pinned_verdict_ui(ui, state, commands) {
        facts_ui(ui, state);
    }
}

/// The verdict on the pinned pixel where no panel explains it; a click on it opens the panel that does. False where there is none.
fn pinned_verdict_ui(ui: &mut Ui, state: &State, commands: &mut Commands) -> bool {
    let probe = &state.doc.probe;
    let probed = probe.shown.as_ref().filter(|_| probe.pinned && !state.shows(DockView::Pixel));
    let shown = state.doc.scene.as_ref().zip(probed);
    let Some((scene, probed)) = shown else { return false };
    let Some(explanation) = &probed.explanation else { return false };
    let line = CameraText::default().camera(probed.camera).words(format!(" {}, {}: ", probed.x, probed.y));
    let line = line.then(verdict(&scene.cameras, explanation.verdict));
    let line = chips(ui, &line, &scene.cameras, &TextStyle::Small, Tokens::in_ui(ui).text);
    let label = Label::new(line).truncate().sense(Sense::click());
    if ui.add(label).on_hover_text("Click to open Pixel, which says why.").clicked() {
        commands.push(Command::Window(WindowCommand::OpenView(DockView::Pixel)));
    }
    true
}

fn header_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    ui.horizontal_wrapped(|ui| {
        if let Some(color_by) = segments_ui(ui, "Live view shows", state.live.color_by, state.live_colors()) {
            commands.push(Command::View(ViewCommand::look(&state.live, |live| live.color_by = color_by)));
        }
        let holes = state.holes_shown();
        let (_, name, help) = HoleDisplay::ALL[usize::from(holes == HoleDisplay::Hatched)];
        let button = Button::selectable(
            holes != HoleDisplay::Filled,
            RichText::new(format!("Holes: {name}")).size(12.5),
        );
        if ui.add(button).on_hover_text(format!("{help} A click changes it.")).clicked() {
            commands.push(Command::View(ViewCommand::Holes(holes.other())));
        }
    });
}

/// Places to go to, and whether cameras are drawn; from right to left.
pub(crate) fn go_to_camera_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let (icon, name) = if state.live.show_cameras {
        (ICON_VIDEOCAM, "Hide cameras")
    } else {
        (ICON_VIDEOCAM_OFF, "Show cameras")
    };
    if icon_button(ui, icon, name, name).clicked() {
        commands.push(Command::View(ViewCommand::look(&state.live, |live| live.show_cameras ^= true)));
    }
    if icon_button(ui, ICON_HOME, "Reset view", "Back to the start view (Home)").clicked() {
        commands.push(Command::View(ViewCommand::Home));
    }
    panel::go_to_ui(ui, state, commands);
}

fn picture_ui(ui: &mut Ui, room: Rect, state: &State, commands: &mut Commands) {
    let canvas = guides::picture_area(room, state);
    let (response, painter) = widgets::canvas_ui(ui, canvas, "live picture", "Live picture");
    let pixels = canvas.size() * ui.ctx().pixels_per_point();
    let shrink = (LARGEST_SIDE / pixels.max_elem()).min(1.0);
    let size = [(pixels.x * shrink) as u32, (pixels.y * shrink) as u32].map(|side| side.max(1));
    if size != state.live.size {
        commands.push(Command::View(ViewCommand::Size(size)));
    }
    if let Some(seen) = state.live_seen() {
        let place = place_of(state, &seen.camera.intrinsics, canvas);
        if place != canvas {
            widgets::empty_canvas(ui, &painter, canvas);
        }
        picture(&painter, seen.texture, place);
        widgets::note_picture(ui, canvas, "live picture");
    } else {
        widgets::empty_canvas(ui, &painter, canvas);
        if !state.is_frame_failed() {
            waiting(ui, canvas, 28.0);
        }
    }
    change::glows(&painter, canvas, state);
    let seen = seen_cameras(canvas, state);
    let pointed_at = camera_at(&seen, canvas, response.hover_pos().filter(|_| !state.live.ruler.active));
    cameras_overlay::draw(&painter, state, &seen, pointed_at);
    if let Some(seen) = state.seen_camera([canvas.width() as u32, canvas.height() as u32]) {
        drawing::fresh_areas(&painter, &PicturePlace::filling(canvas), &seen, state);
    }
    let draws = draw_ui(ui, &response, &painter, canvas, state, commands);
    if !cameras_overlay::menu(ui, &response, state, pointed_at, commands) {
        picture_menu_ui(&response, FigureOf::Live, state, commands);
    }
    let is_taken = draws || cameras_overlay::answer(ui, &response, state, pointed_at, commands);
    let is_taken = shape_ui(ui, &painter, canvas, state, commands) || is_taken;
    motion(ui, &response, canvas, state, is_taken, commands);
    guides::guides_ui(ui, &painter, canvas, state, commands);
    tools_ui(ui, canvas, state, commands);
    mark_probe(&painter, canvas, state);
    if state.live.ruler.active {
        measure_ui(ui, &response, canvas, state, commands);
    } else if !is_taken {
        probe_ui(&response, canvas, state, commands);
    }
}

/// Where a picture of a lens belongs on a canvas: a canvas of another shape shows more or less of it, and nothing is stretched.
fn place_of(state: &State, lens: &Intrinsics, canvas: Rect) -> Rect {
    let (width, height) = (lens.width as f32, lens.height as f32);
    let now = state.live_camera([canvas.width() as u32, canvas.height() as u32]);
    let Some(now) = now.filter(|_| !SAME_SHAPE.contains(&(width / height / canvas.aspect_ratio()))) else {
        return canvas;
    };
    Rect::from_center_size(canvas.center(), vec2(width, height) * (now.intrinsics.fx / lens.fx) as f32)
}

/// Ratios of the shapes of a picture and its canvas that whole pixels explain.
const SAME_SHAPE: std::ops::Range<f32> = 0.98..1.02;

/// Selects what is drawn or clicked on; true while a tool for that is on.
fn draw_ui(
    ui: &Ui,
    response: &Response,
    painter: &Painter,
    canvas: Rect,
    state: &State,
    commands: &mut Commands,
) -> bool {
    match state.doc.edits.tools.tool {
        None | Some(EditTool::Mask) => return false,
        Some(EditTool::Surface) => {
            drawing::select_clicked(ui, response, state, commands, |at| {
                drawing::surface_region(state, point_under(state, canvas, at)?)
            });
        }
        Some(EditTool::Color) => drawing::select_clicked(ui, response, state, commands, |at| {
            color_under(state, canvas, at).map(drawing::color_region)
        }),
        Some(_) => {
            let place = PicturePlace::filling(canvas);
            drawing::select_drawn(ui, response, painter, &place, state, commands, |drawn| {
                let vantage = state.seen_camera([canvas.width() as u32, canvas.height() as u32])?;
                let Drawn { outline, strokes } = drawn;
                let frame = state.frame_number().filter(|_| state.doc.edits.tools.depth == DrawnDepth::Seen);
                let viewpoint = Viewpoint::of(&vantage);
                Some(Region::View { viewpoint, frame, outline, strokes, depth: None })
            });
        }
    }
    true
}

/// A click picks a point to measure from or to.
fn measure_ui(ui: &Ui, response: &Response, canvas: Rect, state: &State, commands: &mut Commands) {
    if response.hovered() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::Crosshair);
    }
    let clicked = response.interact_pointer_pos().filter(|_| response.clicked());
    if let Some(point) = clicked.and_then(|at| point_under(state, canvas, at)) {
        commands.push(Command::View(ViewCommand::look(&state.live, |live| live.ruler.pick(point))));
    }
}

/// Marks the selected pixel.
fn mark_probe(painter: &Painter, canvas: Rect, state: &State) {
    let probe = &state.doc.probe;
    let point = probe.shown.as_ref().and_then(|probed| probed.point_in_world);
    let point = point.filter(|_| probe.pinned || widgets::points_at_picture(painter.ctx()));
    let seen = point.zip(state.camera_over(canvas)).and_then(|(point, vantage)| vantage.project(point));
    if let Some((pixel, depth)) = seen {
        let at = pos2(pixel.x as f32, pixel.y as f32);
        mark(painter, at, shows(state, canvas, at, depth), probe.pinned, Tokens::of(state.dark));
    }
}

/// Selects the pixel under the pointer.
fn probe_ui(response: &Response, canvas: Rect, state: &State, commands: &mut Commands) {
    // What a carried picture shows is known once it is painted.
    let shown = state.doc.live_shown.as_ref().filter(|_| state.doc.live_carried.is_none());
    let (Some(pointer), Some(shown)) = (response.hover_pos(), shown) else { return };
    let size = shown.picture.size;
    if let Some((x, y)) = place_in(size.into(), canvas, pointer) {
        point_at(response, Spot::Live { x, y, size }, state, commands);
    }
}

/// Whether a sample in the live picture shows the surface at this place and depth, and nothing before it.
fn shows(state: &State, canvas: Rect, at: egui::Pos2, depth: f64) -> bool {
    let is_filled = state.doc.live_carried.is_none()
        && pixel_at(state, canvas, at).is_some_and(|(picture, place)| picture.image[place] == NO_IMAGE);
    !is_filled
        && inverse_depth_at(state, canvas, at)
            .is_some_and(|found| compare(found as f32, depth, MARKED_SURFACE) == Sighting::Same)
}

/// The surface point that the live picture shows at a place.
fn point_under(state: &State, canvas: Rect, at: egui::Pos2) -> Option<glam::DVec3> {
    let seen = state.live_seen()?;
    let picture = seen.inverse_depth?;
    let share = (at - canvas.min) / canvas.size();
    let place =
        DVec2::new(f64::from(share.x) * picture.width() as f64, f64::from(share.y) * picture.height() as f64);
    let inverse_depth = f64::from(*picture.get(place.x as usize, place.y as usize)?);
    (inverse_depth > 0.0).then(|| seen.camera.unproject(place, 1.0 / inverse_depth))
}

/// Turns, shifts and zooms the view; `is_taken` where a camera answers clicks.
fn motion(
    ui: &Ui,
    response: &Response,
    canvas: Rect,
    state: &State,
    is_taken: bool,
    commands: &mut Commands,
) {
    if response.double_clicked() && !is_taken && !state.live.ruler.active {
        // Nothing is asked for while the depth of the picture cannot be read.
        if state.live_seen().is_some_and(|seen| seen.inverse_depth.is_some()) {
            let point = response.interact_pointer_pos().and_then(|at| point_under(state, canvas, at));
            commands.push(Command::View(point.map_or(ViewCommand::Home, ViewCommand::Focus)));
        }
        return;
    }
    let draws = state.doc.edits.tools.tool.is_some_and(|tool| tool != EditTool::Mask);
    let is_drawn = draws && response.dragged_by(PointerButton::Primary);
    let delta = if is_drawn { egui::Vec2::ZERO } else { response.drag_delta() };
    let delta = DVec2::new(f64::from(delta.x), f64::from(delta.y));
    if delta != DVec2::ZERO {
        let shifts = response.dragged_by(PointerButton::Secondary)
            || response.dragged_by(PointerButton::Middle)
            || ui.ctx().input(|input| input.modifiers.shift);
        commands.push(if shifts {
            Command::View(ViewCommand::Pan(delta / f64::from(canvas.height().max(1.0))))
        } else {
            Command::View(ViewCommand::Orbit(delta * ORBIT_PER_POINT))
        });
    }
    if response.hovered() {
        let scroll = scrolled(ui);
        if scroll != 0.0 {
            let factor = (-f64::from(scroll) * 0.003).exp();
            let under = response.hover_pos().and_then(|pointer| point_under(state, canvas, pointer));
            commands.push(Command::View(ViewCommand::Dolly(factor, under)));
        }
    }
}

/// What the mouse does in the picture.
const MOUSE: &str = "Drag to orbit, Shift + drag to pan, wheel to zoom, W A S D to fly, double-click to orbit about a point (beside all \
                     surfaces: to reset the view), click to pin the pixel.";

fn facts_ui(ui: &mut Ui, state: &State) {
    let tokens = Tokens::in_ui(ui);
    let mut help = MOUSE.to_owned();
    let facts = match &state.doc.live_shown {
        Some(shown) => {
            let stats = &shown.picture.stats;
            let [width, height] = shown.picture.size;
            let reused = if stats.background_reused { ", static part cached" } else { "" };
            let took = model::significant(stats.milliseconds);
            help = format!("{width}×{height} in {took} ms by the {}{reused}. {help}", shown.picture.painter);
            format!("{} drawn{}", model::count_of(stats.samples, "sample"), state.with_edits())
        }
        None if state.is_frame_failed() => FAILED_FRAME.to_owned(),
        None => "Rendering the first picture.".to_owned(),
    };
    let notice = state.doc.live_shown.as_ref().and_then(|shown| shown.picture.notice.clone());
    let (facts, color) = notice.map_or((facts, tokens.text_weak), |notice| (notice, tokens.warning));
    one_line(ui, facts, color).on_hover_text(help);
}
