//! Every workspace in both themes, in small and large windows and at twice the scale: nothing is cut off and nothing overlaps.
//! `OVERLOOK_WORKSPACE_PICTURES=FOLDER` keeps a picture of each.

use std::path::Path;

use egui::accesskit::Role;
use egui::{Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use overlook::app::{OverlookApp, Start};

use super::driver::{Window, click, demo, look_at, settle, small_demo};

/// Points of the window, and pixels per point.
const SIZES: [([f32; 2], f32); 6] = [
    ([1024.0, 640.0], 1.0),
    ([1280.0, 800.0], 1.0),
    ([1920.0, 1080.0], 1.0),
    ([2560.0, 1440.0], 1.0),
    ([1280.0, 800.0], 2.0),
    // 1280 × 800 pixels, all of them twice as large: smaller than a window can be made.
    ([640.0, 400.0], 2.0),
];

const WORKSPACES: [&str; 4] = ["Explore", "Inspect", "Compare", "Measure"];

fn open_at(start: Start, size: [f32; 2], pixels_per_point: f32) -> Window {
    Harness::builder()
        .with_size(size)
        .with_pixels_per_point(pixels_per_point)
        .with_os(egui::os::OperatingSystem::Nix)
        .with_render_cursor(false)
        .build_eframe(move |cc| OverlookApp::new(&cc.egui_ctx, None, None, start).unwrap())
}

/// What is pressed or read in the bars above the pictures, where nothing is scrolled, with its area.
fn controls(window: &Window, bars: Rect) -> Vec<(String, Rect)> {
    let roles = [Role::Button, Role::ComboBox, Role::CheckBox, Role::SpinButton, Role::Label];
    let nodes = window.query_all_by_label_contains("");
    nodes
        .filter(|node| roles.contains(&node.accesskit_node().role()))
        .filter(|node| bars.contains(node.rect().center()))
        .map(|node| {
            let told = node.accesskit_node();
            (told.label().or_else(|| told.value()).unwrap_or_default(), node.rect())
        })
        .collect()
}

fn assert_nothing_overlaps(window: &Window, size: [f32; 2], place: &str) {
    let whole = Rect::from_min_size(egui::Pos2::ZERO, vec2(size[0], size[1]));
    let picture = window.get_by_label("Live picture").rect();
    assert!(whole.contains_rect(picture) && picture.height() > 60.0, "{place}: {picture}");
    // Down to the tabs: below them panels are scrolled.
    let tabs = window.get_by_role_and_label(Role::Button, "Live view").rect().bottom();
    let controls = controls(window, Rect::from_min_max(whole.min, egui::pos2(size[0], tabs)));
    assert!(controls.len() > 15, "{place}: {} controls", controls.len());
    for (nth, (name, area)) in controls.iter().enumerate() {
        assert!(whole.expand(1.0).contains_rect(*area), "{place}: {name} at {area}");
        for (other, beside) in &controls[nth + 1..] {
            let common = area.intersect(*beside);
            let overlaps = common.width() > 2.0 && common.height() > 2.0;
            let is_inside = area.contains_rect(*beside) || beside.contains_rect(*area);
            assert!(!overlaps || is_inside, "{place}: {name} at {area} and {other} at {beside}");
        }
    }
}

/// Checks that which pixel is explained can be read: its name ends before the buttons begin.
fn assert_pixel_is_named_beside_its_buttons(window: &Window) {
    let (camera, x, y) = window.state().probed_pixel().unwrap();
    let name = window.query_all_by_label_contains(&format!("  {x}, {y}")).next().expect("a name").rect();
    let button = window.get_by_label("Unpin pixel").rect();
    assert!(name.width() > 50.0 && name.right() <= button.left(), "camera {camera}: {name} {button}");
}

fn keep_picture(window: &mut Window, name: &str) {
    if let Some(folder) = std::env::var_os("OVERLOOK_WORKSPACE_PICTURES") {
        let picture = window.render().unwrap();
        picture.save(Path::new(&folder).join(format!("{name}.png"))).unwrap();
    }
}

#[test]
fn every_workspace_fits_windows_of_every_size_in_both_themes() {
    let keeps = std::env::var_os("OVERLOOK_WORKSPACE_PICTURES").is_some();
    for (size, scale) in SIZES {
        let start = if keeps { demo(5, 16, (400, 300)) } else { small_demo() };
        let mut window = open_at(start, size, scale);
        settle(&mut window);
        for theme in ["dark", "light"] {
            for workspace in WORKSPACES {
                show_workspace(&mut window, workspace);
                settle(&mut window);
                if workspace == "Inspect" {
                    look_at(&mut window, "Source picture", vec2(0.55, 0.6));
                    settle(&mut window);
                    assert_pixel_is_named_beside_its_buttons(&window);
                }
                let name = format!("{workspace}_{}x{}@{scale}_{theme}", size[0], size[1]);
                assert_nothing_overlaps(&window, size, &name);
                keep_picture(&mut window, &name);
            }
            if theme == "dark" {
                click(&mut window, "Light theme");
            }
        }
    }
}

/// Chooses a workspace from the row of them, or from the list that a narrow window has.
fn show_workspace(window: &mut Window, workspace: &str) {
    let segment = format!("Workspace: {workspace}");
    if window.query_by_label(&segment).is_some() {
        click(window, &segment);
    } else {
        super::driver::pick(window, "Workspace", workspace);
    }
    window.hover_at(egui::pos2(5.0, 5.0));
    window.run_steps(4);
}
