//! Every workspace in windows of every size and in both themes: nothing is cut off, and nothing lies over anything else.
//! `OVERLOOK_WORKSPACE_PICTURES=FOLDER` draws a picture of each, of a capture of the usual size; without it a few sizes are checked.

use std::path::PathBuf;

use egui::{Rect, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use overlook::app::Start;

use super::driver::{Window, click, demo, look_at, open, open_store, open_view, save_store, settle};
use super::layout_faults::faults;

/// Columns and rows of the screen, and pixels per point.
const SIZES: [([f32; 2], f32); 6] = [
    ([1024.0, 640.0], 1.0),
    ([1280.0, 800.0], 1.0),
    ([1920.0, 1080.0], 1.0),
    ([2560.0, 1440.0], 1.0),
    ([2560.0, 1440.0], 2.0),
    ([1920.0, 1080.0], 2.0),
];

/// The smallest window, a large one, and one that is smaller than a window can be made: the screen has no more.
const CHECKED_SIZES: [usize; 3] = [0, 2, 5];

const WORKSPACES: [&str; 4] = ["Explore", "Inspect", "Compare", "Benchmark"];

/// Where pictures are kept, if they are.
fn folder() -> Option<PathBuf> {
    std::env::var_os("OVERLOOK_WORKSPACE_PICTURES").map(PathBuf::from)
}

/// A recording as large as people's, where it is looked at.
fn recording(frames: usize) -> Start {
    if folder().is_some() { demo(5, frames, (400, 300)) } else { demo(3, frames.min(4), (96, 72)) }
}

fn keep_picture(window: &mut Window, name: &str) {
    if let Some(folder) = folder() {
        window.render().unwrap().save(folder.join(format!("{name}.png"))).unwrap();
    }
}

/// Chooses a workspace from the row of them, or from the list that a narrow window has.
fn show_workspace(window: &mut Window, workspace: &str) {
    let segment = format!("Workspace: {workspace}");
    if window.query_by_label(&segment).is_some() {
        click(window, &segment);
    } else {
        click(window, "Workspace");
        // A view may have the name of a workspace; the list is at the right end of the window.
        let entries = window.query_all_by_label(workspace);
        entries.max_by(|a, b| a.rect().right().total_cmp(&b.rect().right())).unwrap().click();
    }
    // Away from everything that would tell about itself.
    window.hover_at(egui::pos2(1.0, 1.0));
    window.run_steps(4);
    settle(window);
}

/// Shows all workspaces at some sizes, and checks each: in both themes where pictures are kept, else in one after the other.
fn check_every_workspace(window: &mut Window, what: &str, checked: &[usize]) {
    let (mut wrong, mut sizes) = (Vec::new(), 0);
    for (nth, (screen, scale)) in SIZES.into_iter().enumerate() {
        if folder().is_none() && !checked.contains(&nth) {
            continue;
        }
        let size = vec2(screen[0], screen[1]) / scale;
        window.set_pixels_per_point(scale);
        window.set_size(size);
        window.run_steps(4);
        settle(window);
        let themes = ["Light theme", "Dark theme"];
        let shown = if folder().is_some() { &themes[..] } else { &themes[sizes % 2..][..1] };
        sizes += 1;
        for theme in shown {
            click(window, theme);
            for workspace in WORKSPACES {
                show_workspace(window, workspace);
                if window.query_by_label("Source picture").is_some()
                    && window.state().observed().probed_pixel.is_none()
                {
                    look_at(window, "Source picture", vec2(0.55, 0.6));
                    settle(window);
                }
                let [width, height] = screen;
                let theme = theme.to_lowercase().replace(" theme", "");
                let place = format!("{what}_{workspace}_{width}x{height}@{scale}_{theme}");
                let picture = window.get_by_label("Live picture").rect();
                let whole = Rect::from_min_size(egui::Pos2::ZERO, size);
                assert!(whole.contains_rect(picture) && picture.height() > 60.0, "{place}: {picture}");
                let found = faults(window);
                wrong.extend(found.into_iter().map(|fault| format!("{place}: {fault}")));
                keep_picture(window, &place);
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The views that the menu offers.
fn views(window: &mut Window) -> Vec<String> {
    click(window, "Panels");
    let entries = window.query_all_by_label_contains("Open view ");
    let names = entries.filter_map(|entry| Some(entry.accesskit_node().label()?.replace("Open view ", "")));
    let names = names.collect();
    window.key_press(egui::Key::Escape);
    window.run_steps(3);
    names
}

#[test]
fn every_view_fits_the_smallest_window_wherever_it_lies() {
    let mut window = open(recording(16), SIZES[0].0);
    settle(&mut window);
    look_at(&mut window, "Source picture", vec2(0.55, 0.6));
    // While it is open, no message says that it has the keys.
    open_view(&mut window, "Camera path");
    window.key_press(egui::Key::K);
    window.key_press(egui::Key::K);
    let views = views(&mut window);
    assert!(views.len() > 10, "{views:?}");
    let mut wrong = Vec::new();
    for workspace in WORKSPACES {
        show_workspace(&mut window, workspace);
        for view in &views {
            open_view(&mut window, view);
            window.hover_at(egui::pos2(1.0, 1.0));
            window.run_steps(4);
            let found = faults(&window);
            wrong.extend(found.into_iter().map(|fault| format!("{view} in {workspace}: {fault}")));
            keep_picture(&mut window, &format!("{workspace}_{view}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_workspace_of_a_capture_fits_windows_of_every_size() {
    let mut window = open(recording(16), [1280.0, 800.0]);
    settle(&mut window);
    check_every_workspace(&mut window, "capture", &CHECKED_SIZES);
}

#[test]
fn every_workspace_of_a_single_frame_and_of_a_store_fits_the_smallest_window() {
    let mut window = open(recording(1), [1280.0, 800.0]);
    settle(&mut window);
    check_every_workspace(&mut window, "frame", &CHECKED_SIZES[..1]);
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(recording(16), [1280.0, 800.0]);
    settle(&mut window);
    let path = save_store(&mut window, folder.path());
    open_store(&mut window, &path);
    while !window.state().observed().notices.is_empty() {
        window.key_press(egui::Key::Escape);
        window.run_steps(2);
    }
    check_every_workspace(&mut window, "store", &CHECKED_SIZES[..1]);
}
