//! The cameras in the live view: pyramids with their pictures in them, which are pointed at, clicked and double-clicked.

use egui::epaint::Vertex;
use egui::{Color32, Mesh, Painter, Pos2, Rect, Response, Shape, Stroke, Ui, pos2};
use glam::DVec2;

use crate::app::camera_cues;
use crate::app::model::command::{SourceCommand, ViewCommand, WindowCommand};
use crate::app::model::window::DockView;
use crate::app::model::{Command, Commands, State};
use crate::app::rooms::cameras::{answer_clicks, as_drawn, frustum, projected};

/// Length of a camera's pyramid, as a share of its distance to what all look at.
const PYRAMID: f64 = 0.12;

/// Parts of a picture along each side: drawn as flat patches, it follows the perspective.
const PATCHES: usize = 6;

/// Pyramids that cover more of the view than this are clicked at their edges alone: the picture is behind them.
const LARGE: f32 = 0.1;

/// How far from an edge a click may be, points.
const REACH: f32 = 6.0;

/// A camera as the live view shows it.
pub(crate) struct ProjectedCamera {
    pub index: usize,
    lines: Vec<[Pos2; 2]>,
    apex: Option<Pos2>,
    /// Its picture in patches, row by row, if all of it is in front of the view.
    picture: Option<Vec<Pos2>>,
    apart: f64,
    /// How much of it is to be seen, 0 to 1.
    presence: f32,
}

/// The cameras in view, the farthest first.
pub(crate) fn seen_cameras(canvas: Rect, state: &State) -> Vec<ProjectedCamera> {
    let vantage = state.camera_over(canvas).filter(|_| state.live.show_cameras);
    let Some((scene, vantage)) = state.doc.scene.as_ref().zip(vantage) else { return Vec::new() };
    let mut seen = Vec::new();
    for (index, camera) in scene.cameras.iter().enumerate() {
        let to_pivot = (scene.pivot_in_world - camera.position_in_world()).length();
        let apart = (vantage.position_in_world() - camera.position_in_world()).length();
        let length = PYRAMID * to_pivot;
        // From inside, a pyramid would only cross the picture: coming near, it fades.
        let presence = (apart / length - 1.0).clamp(0.0, 1.0) as f32;
        if presence == 0.0 {
            continue;
        }
        let drawn = as_drawn(camera);
        let (width, height) = (f64::from(camera.intrinsics.width), f64::from(camera.intrinsics.height));
        let steps = 0..=PATCHES;
        let places = steps.clone().flat_map(|row| steps.clone().map(move |column| (column, row)));
        let picture = places.map(|(column, row)| {
            let share = [column, row].map(|step| step as f64 / PATCHES as f64);
            let pixel = DVec2::new(share[0] * width, share[1] * height);
            projected(&vantage, drawn.unproject(pixel, length))
        });
        seen.push(ProjectedCamera {
            index,
            lines: frustum(camera, &vantage, length),
            apex: projected(&vantage, camera.position_in_world()),
            picture: picture.collect(),
            apart,
            presence,
        });
    }
    seen.sort_by(|a, b| b.apart.total_cmp(&a.apart));
    seen
}

/// Whether a camera is the chosen one. The first one is so by itself only where there is a picture of it.
pub(crate) fn is_chosen(state: &State, camera: usize) -> bool {
    camera == state.source.camera && (state.has_source() || state.source.chosen_at.is_some())
}

/// What clicks on a camera do, in a line.
pub(crate) fn clicks(state: &State) -> &'static str {
    if state.shows(DockView::Source) {
        "Click: show its picture. Double-click: view from it."
    } else {
        "Click: choose it; the View panel marks it. Double-click: view from it."
    }
}

/// The nearest camera with its pyramid under the pointer.
pub(crate) fn camera_at(seen: &[ProjectedCamera], canvas: Rect, pointer: Option<Pos2>) -> Option<usize> {
    let pointer = pointer.filter(|pointer| canvas.contains(*pointer))?;
    let hit = seen.iter().rev().find(|camera| is_hit(camera, canvas, pointer));
    hit.map(|camera| camera.index)
}

fn is_hit(camera: &ProjectedCamera, canvas: Rect, pointer: Pos2) -> bool {
    let near = |[a, b]: &[Pos2; 2]| {
        let along = *b - *a;
        let share = ((pointer - *a).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
        (*a + along * share - pointer).length() < REACH
    };
    if camera.lines.iter().any(near) {
        return true;
    }
    let Some(picture) = &camera.picture else { return false };
    let corner = |row: usize, column: usize| picture[row * (PATCHES + 1) + column];
    let corners = [corner(0, 0), corner(0, PATCHES), corner(PATCHES, PATCHES), corner(PATCHES, 0)];
    if Rect::from_points(&corners).area() > LARGE * canvas.area() {
        return false;
    }
    let mut triangles = vec![[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]];
    if let Some(apex) = camera.apex {
        triangles.extend((0..4).map(|side| [apex, corners[side], corners[(side + 1) % 4]]));
    }
    triangles.into_iter().any(|[a, b, c]| {
        let side = |a: Pos2, b: Pos2| (b - a).x * (pointer - a).y - (b - a).y * (pointer - a).x;
        let sides = [side(a, b), side(b, c), side(c, a)];
        sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
    })
}

/// Draws the cameras, the one that is pointed at on top.
pub(crate) fn draw(painter: &Painter, state: &State, seen: &[ProjectedCamera], pointed_at: Option<usize>) {
    for is_pointed_at in [false, true] {
        let cameras = seen.iter().filter(|camera| (Some(camera.index) == pointed_at) == is_pointed_at);
        cameras.for_each(|camera| draw_camera(painter, state, camera, is_pointed_at));
    }
}

fn draw_camera(painter: &Painter, state: &State, camera: &ProjectedCamera, is_pointed_at: bool) {
    let is_on = state.live.cameras.shows(camera.index);
    let strength = camera.presence * if is_on || is_pointed_at { 1.0 } else { 0.3 };
    let texture = state.doc.thumbs.get(camera.index).filter(|_| state.live.guides.pictures && is_on);
    if let (Some(texture), Some(picture)) = (texture, &camera.picture) {
        let tint = Color32::WHITE.gamma_multiply(strength);
        painter.add(Shape::mesh(patches(picture, texture.id(), tint)));
    }
    let width = match (is_pointed_at, is_chosen(state, camera.index)) {
        (true, _) => 3.5,
        (false, true) => 2.5,
        (false, false) => 1.5,
    };
    let stroke = Stroke::new(width, camera_cues::color(camera.index).gamma_multiply(strength));
    for line in &camera.lines {
        painter.line_segment(*line, stroke);
    }
}

/// A picture over its corners and the points between them.
fn patches(places: &[Pos2], texture: egui::TextureId, tint: Color32) -> Mesh {
    let mut mesh = Mesh::with_texture(texture);
    let side = PATCHES + 1;
    mesh.vertices.extend(places.iter().enumerate().map(|(at, &pos)| {
        let uv = pos2((at % side) as f32, (at / side) as f32) / PATCHES as f32;
        Vertex { pos, uv, color: tint }
    }));
    for row in 0..PATCHES {
        for column in 0..PATCHES {
            let corner = (row * side + column) as u32;
            let below = corner + side as u32;
            mesh.add_triangle(corner, corner + 1, below);
            mesh.add_triangle(corner + 1, below + 1, below);
        }
    }
    mesh
}

/// A click chooses the camera under the pointer, a double-click views from it. Returns whether there is one.
pub(crate) fn answer(
    ui: &Ui,
    response: &Response,
    state: &State,
    pointed_at: Option<usize>,
    commands: &mut Commands,
) -> bool {
    let Some(camera) = pointed_at.filter(|_| !response.dragged()) else { return false };
    ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
    if let Some(named) = state.doc.scene.as_ref().and_then(|scene| scene.cameras.get(camera)) {
        let help = format!("{}\n{} Right-click: more.", named.name, clicks(state));
        response.clone().on_hover_text_at_pointer(help);
    }
    answer_clicks(response, camera, commands);
    true
}

/// What can be done to the camera that the menu was opened on; whether there is one.
pub(crate) fn menu(
    ui: &Ui,
    response: &Response,
    state: &State,
    pointed_at: Option<usize>,
    commands: &mut Commands,
) -> bool {
    let id = response.id.with("camera of the menu");
    if response.secondary_clicked() {
        ui.data_mut(|data| data.insert_temp(id, pointed_at));
    }
    let Some(camera) = ui.data(|data| data.get_temp::<Option<usize>>(id)).flatten() else { return false };
    response.context_menu(|ui| {
        let cameras = &state.live.cameras;
        let is_solo = cameras.solo == Some(camera);
        let shows = cameras.shows(camera);
        if state.has_source() && ui.button("Show its picture").clicked() {
            commands.push(Command::Window(WindowCommand::OpenView(DockView::Source)));
            commands.push(Command::Source(SourceCommand::Camera(camera)));
            ui.close();
        }
        for (name, command) in [
            ("View from it", Command::View(ViewCommand::JumpTo(camera))),
            (
                if is_solo { "All cameras again" } else { "Solo" },
                Command::View(ViewCommand::look(&state.live, |live| {
                    live.cameras.solo = (!is_solo).then_some(camera);
                })),
            ),
            (
                if shows { "Hide" } else { "Show" },
                Command::View(ViewCommand::look(&state.live, |live| live.cameras.switch(camera, !shows))),
            ),
        ] {
            if ui.button(name).clicked() {
                commands.push(command);
                ui.close();
            }
        }
    });
    true
}
