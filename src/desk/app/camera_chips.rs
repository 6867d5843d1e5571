//! Names of cameras in text, as chips in their colors.

use egui::text::{LayoutJob, TextFormat};
use egui::{Color32, FontId, TextStyle, Ui};

use crate::app::rooms::cameras::model::{CameraText, TextPart};
use crate::app::{camera_cues, colormap};
use overlook_engine::capture::Camera;

/// How far the color of a chip reaches beyond the letters, points.
const MARGIN: f32 = 2.0;

/// A text ready to be shown, wrapped or cut off by its label.
pub(crate) fn chips(
    ui: &Ui,
    text: &CameraText,
    cameras: &[Camera],
    style: &TextStyle,
    color: Color32,
) -> LayoutJob {
    let font = style.resolve(ui.style());
    let mut job = LayoutJob::default();
    for part in text.parts() {
        match part {
            TextPart::Words(words) => job.append(words, 0.0, TextFormat::simple(font.clone(), color)),
            TextPart::Camera(index) => {
                let Some(camera) = cameras.get(*index) else { continue };
                job.append(&camera.name, MARGIN, chip(*index, font.clone()));
                // Room for the margin on the other side.
                job.append("", MARGIN, TextFormat::simple(font.clone(), color));
            }
        }
    }
    job
}

/// How the name of a camera looks.
fn chip(index: usize, font: FontId) -> TextFormat {
    let background = camera_cues::color(index);
    TextFormat { background, expand_bg: MARGIN, ..TextFormat::simple(font, colormap::text_on(background)) }
}
