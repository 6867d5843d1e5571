//! Scalar values in the window: shown in the colors of a range, isolated, and exact under the pointer.

use std::sync::Arc;

use super::*;
use crate::app::model::command::{ViewCommand, WindowCommand};
use crate::app::model::look::{Display, ValueLook};
use crate::app::model::picture::ColorBy;
use crate::app::model::window::DockView;
use overlook_engine::capture;
use overlook_engine::render::{MISSING_COLOR, output};
use overlook_engine::settings::Settings;

/// The small capture with a value that grows from the left edge of each picture to the right one, and is missing in the lowest rows.
fn capture_with_values(folder: &Path) {
    copy_capture(folder);
    let opened = capture::open(folder, &Settings::default().capture).unwrap();
    let file = folder.join("transforms.json");
    let mut manifest: serde_json::Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    manifest["values"] = serde_json::json!([{ "name": "pressure", "unit": "Pa" }]);
    for (nth, entry) in manifest["frames"].as_array_mut().unwrap().iter_mut().enumerate() {
        let (width, height) = opened.cameras[0].intrinsics.size();
        let of = |x: usize, y: usize| if y + 4 > height { f32::NAN } else { 100.0 + x as f32 };
        let values = (0..height).flat_map(|y| (0..width).map(move |x| of(x, y)));
        std::fs::write(folder.join(format!("{nth}.npy")), npy([height, width], values)).unwrap();
        entry["value_file_paths"] = serde_json::json!({ "pressure": format!("{nth}.npy") });
    }
    std::fs::write(file, manifest.to_string()).unwrap();
}

fn npy([rows, columns]: [usize; 2], values: impl Iterator<Item = f32>) -> Vec<u8> {
    let keys = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    // The header has 118 bytes, so that values begin at a multiple of 64.
    let mut bytes = [&b"\x93NUMPY\x01\x00\x76\x00"[..], format!("{keys:<117}\n").as_bytes()].concat();
    bytes.extend(values.flat_map(f32::to_le_bytes));
    bytes
}

fn shown(app: &OverlookApp) -> Arc<egui::ColorImage> {
    app.state.shown_picture().unwrap().clone()
}

#[test]
fn values_are_shown_in_the_colors_of_their_range_isolated_and_changed_without_pruning_anew() {
    let folder = tempfile::tempdir().unwrap();
    capture_with_values(folder.path());
    let mut app = ready(2, 1);
    edits::open(&mut app, folder.path(), true);
    assert_eq!(app.state.value_channels().len(), 1);
    app.apply(Command::View(ViewCommand::JumpTo(0)));
    settle(&mut app);
    let picture = shown(&app);
    app.apply(Command::View(ViewCommand::look(&app.state.live, |live| live.color_by = ColorBy::Value)));
    settle(&mut app);
    let colored = shown(&app);
    assert!(colored != picture);
    app.apply(Command::Window(WindowCommand::OpenView(DockView::Color)));
    settle(&mut app);
    let counted = app.state.doc.values.as_ref().unwrap();
    assert!(counted.ascending.is_sorted() && counted.ascending.len() > 100);
    let whole = app.state.doc.whole.as_ref().unwrap().samples.clone();

    let look =
        ValueLook { range: Some([100.0, 140.0]), isolated: Some([100.0, 120.0]), ..ValueLook::default() };
    app.apply(Command::Display(Display { values: look, ..app.state.display }));
    settle(&mut app);
    let isolated = shown(&app);
    let live = app.state.doc.live_shown.as_ref().unwrap();
    let rendered = live.picture.rendered().unwrap();
    let values = output::PictureValues::of(&live.key.samples, &live.key.vantage, rendered);
    let colors = look.colors(&values.channels[0]).unwrap();
    let (mut gray, mut seen) = (0, 0);
    let pictured = rendered.image.as_slice().iter().zip(rendered.inverse_depth.as_slice());
    for ((value, pixel), (image, w)) in values.values.channel(0).zip(&isolated.pixels).zip(pictured) {
        if *image == NO_IMAGE {
            continue;
        }
        let shown = [pixel.r(), pixel.g(), pixel.b()];
        assert_eq!(shown, colors.color_at(value, *w), "{value}");
        seen += usize::from((100.0..=120.0).contains(&value));
        gray += usize::from(shown == MISSING_COLOR);
    }
    assert!(seen > 100 && gray > 100, "{seen} {gray}");
    let now = &app.state.doc.whole.as_ref().unwrap().samples;
    assert!(Arc::ptr_eq(&whole, now), "nothing is pruned anew");
}
