//! The pixel under the pointer, in words.

use egui::{RichText, Ui};

use super::super::state::State;
use super::super::text;
use super::super::theme::Tokens;
use crate::color::srgb8_from_linear;
use crate::preprocess::{CameraInspection, PixelClass, Verdict};

const HINT: &str = "Point at a pixel to see what became of it.";

/// Two lines below the source picture: what was recorded, and what became of it.
pub(super) fn readout_ui(ui: &mut Ui, state: &State, pixel: Option<(usize, usize)>) {
    let tokens = Tokens::in_ui(ui);
    let (recorded, verdict) = match pixel {
        None => (camera_facts(state), HINT.to_owned()),
        Some((x, y)) => match state.inspection_here().map(|i| &i.cameras[state.source.camera]) {
            Some(camera) if camera.verdict.get(x, y).is_some() => {
                (recorded(camera, x, y), verdict(state, camera, x, y))
            }
            _ => (format!("Pixel {x}, {y}"), "Its verdict is being worked out.".to_owned()),
        },
    };
    ui.spacing_mut().item_spacing.y = 1.0;
    ui.add(egui::Label::new(RichText::new(recorded).small().color(tokens.text_weak)).truncate());
    let color = if pixel.is_some() { tokens.text } else { tokens.text_weak };
    ui.add(egui::Label::new(RichText::new(verdict).color(color)).truncate());
}

/// The camera shown at this frame, in figures.
fn camera_facts(state: &State) -> String {
    let Some(camera) = state.inspection_here().map(|inspection| &inspection.cameras[state.source.camera])
    else {
        return "Working out what is redundant here.".to_owned();
    };
    let pixels = camera.verdict.len() as u64;
    let kept = camera.verdict.as_slice().iter().filter(|verdict| verdict.is_kept()).count() as u64;
    format!(
        "{} of {} pixels represent themselves ({})",
        text::count(kept),
        text::count(pixels),
        text::percent(kept, pixels)
    )
}

fn recorded(camera: &CameraInspection, x: usize, y: usize) -> String {
    let inverse_depth = camera.frame.inverse_depth[(x, y)];
    let depth = match inverse_depth {
        w if w < 0.0 => "no depth".to_owned(),
        0.0 => "infinitely far".to_owned(),
        w => format!("depth {}", text::significant(1.0 / f64::from(w))),
    };
    let [r, g, b] = camera.frame.color[(x, y)].map(|c| srgb8_from_linear(c.to_f32()));
    let class = match camera.class[(x, y)] {
        PixelClass::Background => "same over all frames",
        PixelClass::Foreground => "of this frame",
        PixelClass::Invalid => "takes part in nothing",
    };
    format!("Pixel {x}, {y} · {depth} · color {r} {g} {b} · {class}")
}

fn verdict(state: &State, camera: &CameraInspection, x: usize, y: usize) -> String {
    let verdict = camera.verdict[(x, y)];
    let mut sentence = verdict.rule.sentence().to_owned();
    if verdict.is_kept() || verdict.witness_camera == Verdict::NO_CAMERA {
        return sentence;
    }
    let winner = verdict.witness_camera as usize;
    if let Some(scene) = &state.scene
        && let Some(witness) = scene.cameras.get(winner)
    {
        let width = witness.intrinsics.width.max(1);
        let (x, y) = (verdict.witness_pixel % width, verdict.witness_pixel / width);
        let layer = if verdict.witness_is_background { ", background" } else { "" };
        sentence += &format!(" Witness: {} at {x}, {y}{layer}.", witness.name);
    }
    sentence
}
