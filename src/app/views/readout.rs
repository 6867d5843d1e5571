//! The pixel under the pointer, in one line; the Pixel view says the rest.

use egui::Ui;

use crate::app::model::verdict_text as words;
use crate::app::model::{self, State};
use crate::app::theme::Tokens;
use crate::app::widgets::one_line;
use crate::color::srgb8_from_linear;
use crate::preprocess::inspect::CameraInspection;

const MOUSE: &str = "Point at a pixel to see what became of it, and why. Wheel to zoom, drag to shift, double-click to \
                     fit, click to keep the pixel.";

/// A line below the source picture: what became of the pixel, or how much of the picture is kept.
pub(crate) fn readout_ui(ui: &mut Ui, state: &State, pixel: Option<(usize, usize)>) {
    let tokens = Tokens::in_ui(ui);
    let (line, more, color) = match pixel {
        Some((x, y)) => {
            let [verdict, recorded] = about_pixel(state, x, y);
            (verdict, recorded, tokens.text)
        }
        None => (camera_facts(state), MOUSE.to_owned(), tokens.text_weak),
    };
    one_line(ui, line, color).on_hover_text(&more);
}

/// The camera shown at this frame, in figures.
fn camera_facts(state: &State) -> String {
    // In motion verdicts come a few frames late, and so do the pictures that show them.
    let in_motion = state.timeline.playing && !state.skips_verdicts();
    let Some(inspected) = state.inspected.as_ref().filter(|_| in_motion || state.inspection_here().is_some())
    else {
        let text = if state.is_frame_failed() {
            words::FAILED_FRAME
        } else if state.skips_verdicts() {
            "In motion: pause, or choose an overlay above, to see what is redundant."
        } else {
            "Working out what is redundant here."
        };
        return text.to_owned();
    };
    let pixels = inspected.inspection.cameras[state.source.camera].verdict.len() as u64;
    let kept = inspected.kept[state.source.camera];
    format!(
        "{} of {} pixels are kept ({}). Point at one to see why.",
        model::count(kept),
        model::count(pixels),
        model::percent(kept, pixels)
    )
}

fn about_pixel(state: &State, x: usize, y: usize) -> [String; 2] {
    let (Some(scene), Some(inspection)) = (&state.scene, state.inspection_here()) else {
        return [words::pending_verdict(state, false).to_owned(), format!("Pixel {x}, {y}")];
    };
    let camera = &inspection.cameras[state.source.camera];
    let Some(verdict) = camera.verdict.get(x, y) else { return Default::default() };
    let recorded = recorded(camera, x, y);
    [format!("{} {recorded}", words::verdict(&scene.cameras, *verdict)), recorded]
}

fn recorded(camera: &CameraInspection, x: usize, y: usize) -> String {
    let depth = match camera.frame.inverse_depth[(x, y)] {
        w if w < 0.0 => "no depth".to_owned(),
        0.0 => "infinitely far".to_owned(),
        w => format!("depth {}", model::significant(1.0 / f64::from(w))),
    };
    let [r, g, b] = camera.frame.color[(x, y)].map(|c| srgb8_from_linear(c.to_f32()));
    format!("Pixel {x}, {y} · {depth} · color {r} {g} {b}")
}
