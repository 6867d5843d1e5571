//! The left view: the picture of a camera, and the verdict on each of its pixels; the Pixel view explains them.

pub(crate) mod legend;

use egui::{Painter, PointerButton, Rect, Response, Sense, Ui, Vec2};
use egui_material_icons::icons::ICON_HIDE_IMAGE;
use glam::DVec2;

use crate::app::model::camera_text::CameraText;
use crate::app::model::command::{
    DrawnDepth, EditCommand, EditTool, FileCommand, PixelCommand, SourceCommand,
};
use crate::app::model::picture::{Legend, Overlay, PictureZoom};
use crate::app::model::purpose::{FigureOf, Purpose};
use crate::app::model::{self, Command, Commands, State};
use crate::app::picture_menu::picture_menu_ui;
use crate::app::rooms;
use crate::app::rooms::cameras::mark_probe;
use crate::app::rooms::edits::ui::drawing::{self, Drawn, PicturePlace};
use crate::app::rooms::pixel::state::Spot;
use crate::app::rooms::pixel::{FAILED_FRAME, pending_verdict};
use crate::app::rooms::source::SourceLook;
use crate::app::theme::Tokens;
use crate::app::widgets::{
    self, camera_choices, chips, choice_ui, empty_ui, scrolled, segments_ui, waiting, weak,
};
use overlook_engine::color::srgb8_from_linear;
use overlook_engine::edits::{Region, Viewpoint};
use overlook_engine::grid::Grid;
use overlook_engine::plural::{counted, either};
use overlook_engine::samples::TILE;

/// Height of the legend and the read-out below a picture.
pub(crate) const FOOTER: f32 = 46.0;

pub(crate) const CAMERA_LIST_WIDTH: f32 = 104.0;

pub(crate) fn source_view_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    if !state.has_source() {
        let text = "This store does not say why its pixels went (store.verdicts). Open the capture it was made from to see the source \
                    pictures, and what became of each pixel.";
        empty_ui(ui, ICON_HIDE_IMAGE, "This store holds no source frames", text, |ui| {
            if ui.button("Open capture folder…").clicked() {
                commands.push(Command::File(FileCommand::AskPath(Purpose::OpenFolder)));
            }
        });
        return;
    }
    if let Some(overlay) = segments_ui(ui, "Source shows", state.source.overlay, state.overlays()) {
        commands.push(Command::Source(SourceCommand::Look(SourceLook { overlay, ..state.source })));
    }
    let available = ui.available_rect_before_wrap();
    let canvas = available.with_max_y(available.bottom() - FOOTER);
    let hovered = picture_ui(ui, canvas, state, commands);
    ui.allocate_rect(canvas, Sense::hover());
    ui.add_space(2.0);
    if let Some(shown) = &state.doc.source_shown {
        legend::source_legend_ui(ui, state, &shown.key, &shown.picture.legend, commands);
    }
    readout_ui(ui, state, hovered);
}

/// Which camera, and for the sampling ratio against which; from right to left.
pub(crate) fn cameras_ui(ui: &mut Ui, state: &State, commands: &mut Commands) {
    let Some(scene) = state.doc.scene.as_ref().filter(|_| state.has_source()) else { return };
    let cameras: Vec<_> = camera_choices(&scene.cameras).collect();
    if state.source.overlay == Overlay::SamplingRatio {
        let others = cameras.iter().filter(|(index, ..)| *index != state.source.camera);
        let others = others.map(|(index, name, help)| (Some(*index), *name, *help));
        let others: Vec<_> = std::iter::once((None, "best other", "")).chain(others).collect();
        if let Some(against) = choice_ui(ui, "Against", state.source.against, &others, CAMERA_LIST_WIDTH) {
            commands.push(Command::Source(SourceCommand::Look(SourceLook { against, ..state.source })));
        }
        weak(ui, "vs");
    }
    if let Some(camera) = choice_ui(ui, "Source camera", state.source.camera, &cameras, CAMERA_LIST_WIDTH) {
        commands.push(Command::Source(SourceCommand::Camera(camera)));
    }
}

/// Draws the picture and gives the pixel under the pointer.
fn picture_ui(ui: &mut Ui, canvas: Rect, state: &State, commands: &mut Commands) -> Option<(usize, usize)> {
    let tokens = Tokens::in_ui(ui);
    let (response, painter) = widgets::canvas_ui(ui, canvas, "source picture", "Source picture");
    widgets::empty_canvas(ui, &painter, canvas);
    let Some(shown) = &state.doc.source_shown else {
        if !state.is_frame_failed() {
            waiting(ui, canvas, 28.0);
        }
        return None;
    };
    let size = Vec2::from(shown.picture.size.map(|side| side as f32));
    let picture = state.source.part.placed(size, canvas);
    let scale = picture.width() / size.x;
    widgets::picture(&painter, shown.texture.id(), picture);
    if let Legend::Tiles(shares) = &shown.picture.legend {
        legend::tile_shares(&painter, picture, size, shares, tokens);
    }
    let place = PicturePlace { corner: picture.min, scale, shown: picture.intersect(canvas) };
    picture_menu_ui(&response, FigureOf::Source, state, commands);
    let is_taken = draw_ui(ui, &response, &painter, &place, state, commands);
    zoom_and_pan(ui, &response, picture, state, is_taken, commands);
    widgets::note_picture(ui, place.shown, "source picture");
    if state.doc.probe.pinned || widgets::points_at_picture(ui.ctx()) {
        mark_probe(&painter.with_clip_rect(place.shown), picture, state, shown.key.camera);
    }
    let pointer = response.hover_pos()?;
    let at = (pointer - picture.min) / scale;
    if at.min_elem() < 0.0 || at.x >= size.x || at.y >= size.y {
        return None;
    }
    let (x, y) = (at.x as usize, at.y as usize);
    if !is_taken {
        point_at(&response, Spot::Source { camera: shown.key.camera, x, y }, state, commands);
    }
    if let Legend::Tiles(shares) = &shown.picture.legend {
        tile_tooltip(response, shares, [x, y], shown.picture.size);
    }
    if scale > 2.0 {
        let corner = picture.min + at.floor() * scale;
        let pixel = Rect::from_min_size(corner, Vec2::splat(scale));
        painter.rect_stroke(pixel, 0.0, egui::Stroke::new(1.0, tokens.on_scrim), egui::StrokeKind::Outside);
    }
    Some((x, y))
}

/// The kept share of the tile under the pointer.
fn tile_tooltip(response: Response, shares: &Grid<f32>, [x, y]: [usize; 2], [width, height]: [usize; 2]) {
    let (column, row) = (x / TILE, y / TILE);
    let Some(share) = shares.get(column, row) else { return };
    let (columns, rows) = (TILE.min(width - column * TILE), TILE.min(height - row * TILE));
    let pixels = columns * rows;
    let kept = (share * pixels as f32).round();
    let words = format!(
        "Tile {column}, {row}: {kept} of {} kept. An empty tile costs nothing.",
        counted(pixels, "sample")
    );
    response.on_hover_text_at_pointer(words);
}

/// Looks at the spot under the pointer; a click keeps it.
pub(crate) fn point_at(response: &Response, spot: Spot, state: &State, commands: &mut Commands) {
    let probe = &state.doc.probe;
    if response.clicked() {
        commands.push(Command::Pixel(PixelCommand::Probe(Some(spot))));
        commands.push(Command::Pixel(PixelCommand::Pin(true)));
    } else if !probe.pinned && !response.dragged() && probe.spot != Some(spot) {
        commands.push(Command::Pixel(PixelCommand::Probe(Some(spot))));
    }
}

/// Selects what is drawn or clicked on, or paints a mask, and shows what was drawn there; true while a tool for that is on.
fn draw_ui(
    ui: &Ui,
    response: &Response,
    painter: &Painter,
    place: &PicturePlace,
    state: &State,
    commands: &mut Commands,
) -> bool {
    let shown = state.doc.source_shown.as_ref().zip(state.doc.scene.as_ref());
    let Some(camera) = shown.and_then(|(shown, scene)| scene.cameras.get(shown.key.camera)) else {
        return false;
    };
    drawing::drawn_areas(painter, place, &camera.name, state);
    match state.doc.edits.tools.tool {
        None => return false,
        Some(tool @ (EditTool::Surface | EditTool::Color)) => {
            drawing::select_clicked(ui, response, state, commands, |at| {
                let within = (at - place.corner) / place.scale;
                let frame = &state.inspection_here()?.cameras.get(state.source.camera)?.frame;
                let (x, y) = (within.x.max(0.0) as usize, within.y.max(0.0) as usize);
                if tool == EditTool::Color {
                    return frame.color.get(x, y).copied().map(drawing::color_region);
                }
                let inverse_depth = f64::from(*frame.inverse_depth.get(x, y)?);
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let is_surface = inverse_depth > 0.0;
                let point = is_surface.then(|| camera.unproject(center, 1.0 / inverse_depth))?;
                drawing::surface_region(state, point)
            });
        }
        Some(EditTool::Mask) => {
            let drawn = drawing::drawing_ui(ui, response, painter, place, state);
            let strokes =
                drawn.filter(|(_, is_done)| *is_done).map_or_else(Vec::new, |(drawn, _)| drawn.strokes);
            let mask = |stroke| Command::Edit(EditCommand::Mask { camera: camera.name.clone(), stroke });
            commands.extend(strokes.into_iter().map(mask));
        }
        Some(_) => drawing::select_drawn(ui, response, painter, place, state, commands, |drawn| {
            let Drawn { outline, strokes } = drawn;
            Some(match state.doc.edits.tools.depth {
                DrawnDepth::Seen => {
                    let frame = Some(state.frame_number()?);
                    Region::Pixels { camera: camera.name.clone(), frame, outline, strokes }
                }
                DrawnDepth::Through => {
                    let viewpoint = Viewpoint::of(camera);
                    Region::View { viewpoint, frame: None, outline, strokes, depth: None }
                }
            })
        }),
    }
    true
}

/// `is_drawn` where dragging draws.
fn zoom_and_pan(
    ui: &Ui,
    response: &Response,
    picture: Rect,
    state: &State,
    is_drawn: bool,
    commands: &mut Commands,
) {
    let part = state.source.part;
    let zoom = |part| Command::Source(SourceCommand::Look(SourceLook { part, ..state.source }));
    if response.double_clicked() && !is_drawn {
        commands.push(zoom(PictureZoom::default()));
        return;
    }
    let pans = response.dragged() && !(is_drawn && response.dragged_by(PointerButton::Primary));
    if pans && part.zoom > 1.0 {
        commands.push(zoom(part.shifted(response.drag_delta() / picture.size())));
    }
    let Some(pointer) = response.hover_pos() else { return };
    let scroll = scrolled(ui);
    if scroll != 0.0 {
        let at = (pointer - picture.min) / picture.size();
        commands.push(zoom(part.scrolled(scroll, at)));
    }
}

const MOUSE: &str = "Point at a pixel to see what became of it, and why. Wheel to zoom, drag to pan, double-click to \
                     fit, click to pin the pixel.";

/// A line below the source picture: the verdict on the pixel, or the kept share of the picture.
fn readout_ui(ui: &mut Ui, state: &State, pixel: Option<(usize, usize)>) {
    let tokens = Tokens::in_ui(ui);
    let (line, more, color) = match pixel {
        Some((x, y)) => {
            let (verdict, recorded) = about_pixel(state, x, y);
            (verdict, recorded, tokens.text)
        }
        None => (CameraText::new(camera_facts(state)), MOUSE.to_owned(), tokens.text_weak),
    };
    let cameras = state.doc.scene.as_ref().map_or(&[][..], |scene| &scene.cameras);
    let line = chips(ui, &line, cameras, &egui::TextStyle::Small, color);
    ui.add(egui::Label::new(line).truncate()).on_hover_text(&more);
}

/// The camera shown at this frame, in figures.
fn camera_facts(state: &State) -> String {
    // In motion verdicts come a few frames late, and so do the pictures that show them.
    let in_motion = state.timeline.playing && !state.skips_verdicts();
    let Some(inspected) =
        state.doc.inspected.as_ref().filter(|_| in_motion || state.inspection_here().is_some())
    else {
        let text = if state.is_frame_failed() {
            FAILED_FRAME
        } else if state.skips_verdicts() {
            "Playing: pause, or choose an overlay above, to see what is redundant."
        } else {
            "Computing what is redundant here."
        };
        return text.to_owned();
    };
    let pixels = inspected.inspection.cameras[state.source.camera].verdict.len() as u64;
    let kept = inspected.kept[state.source.camera];
    let all = model::count_of(pixels, "pixel");
    let legend = state.doc.source_shown.as_ref().map(|shown| &shown.picture.legend);
    if matches!(legend, Some(Legend::Winners { .. })) {
        // The legend above has the share.
        return format!("{all}. Point at one to see why it was kept or dropped.");
    }
    let (count, are, share) = (model::count(kept), either(pixels, "is", "are"), model::percent(kept, pixels));
    format!("{count} of {all} {are} kept ({share}). Point at one to see why.")
}

/// The verdict on a pixel, and what was recorded there.
fn about_pixel(state: &State, x: usize, y: usize) -> (CameraText, String) {
    let (Some(scene), Some(inspection)) = (&state.doc.scene, state.inspection_here()) else {
        return (CameraText::new(pending_verdict(state, false)), format!("Pixel {x}, {y}"));
    };
    let camera = &inspection.cameras[state.source.camera];
    let Some(verdict) = camera.verdict.get(x, y) else { return Default::default() };
    let depth = match camera.frame.inverse_depth[(x, y)] {
        w if w < 0.0 => "no depth".to_owned(),
        0.0 => "infinitely far".to_owned(),
        w => format!("depth {}", model::significant(1.0 / f64::from(w))),
    };
    let [r, g, b] = camera.frame.color[(x, y)].map(|c| srgb8_from_linear(c.to_f32()));
    let recorded = format!("Pixel {x}, {y} · {depth} · color {r} {g} {b}");
    (rooms::pixel::verdict(&scene.cameras, *verdict).words(format!(" {recorded}")), recorded)
}
