//! A window that wgpu draws shows the GPU's pictures without copying them while they follow each other, and shows the same.

use std::time::Duration;

use super::driver::{
    SIZE, Window, click, demo, do_command, drop_on, pick, settle, shows, small_capture, small_demo, wait,
};
use eframe::egui_wgpu::RenderState;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use overlook::app::{OverlookApp, Start};
use overlook_engine::render::gpu::device_descriptor;

/// A window drawn by wgpu, with the device that [`overlook::app::run`] asks for, and what draws it.
fn open(start: Start) -> (Window, RenderState) {
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    let mut setup = egui_kittest::wgpu::default_wgpu_setup();
    if let eframe::egui_wgpu::WgpuSetup::CreateNew(setup) = &mut setup {
        setup.device_descriptor = std::sync::Arc::new(device_descriptor);
    }
    let window = Harness::builder()
        .with_size(SIZE)
        .with_os(egui::os::OperatingSystem::Nix)
        .with_render_cursor(false)
        .wgpu_setup(setup)
        .build_eframe(move |cc| {
            let drawing = cc.wgpu_render_state.clone().unwrap();
            sender.send(drawing.clone()).unwrap();
            OverlookApp::new(&cc.egui_ctx, None, Some(&drawing), start).unwrap()
        });
    (window, receiver.recv().unwrap())
}

/// Whether the live picture is shown without its pixels ever having left the device that draws the window.
fn is_on_device(window: &Window) -> bool {
    matches!(window.state().observed().live_texture, Some(egui::TextureId::User(_)))
}

/// The pixels of the live picture.
fn live_picture(window: &mut Window) -> image::RgbaImage {
    let area = window.get_by_label("Live picture").rect();
    let whole = window.render().unwrap();
    let [x, y, width, height] = [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
    image::imageops::crop_imm(&whole, x, y, width, height).to_image()
}

/// Has the GPU paint, which leaves holes and tests no lines of sight, and steps until a picture in motion is shown.
fn set_in_motion(window: &mut Window) {
    // Cameras are drawn over the picture with what they see, which is of the frame before while time passes.
    click(window, "Hide cameras");
    do_command(window, "Line-of-sight test: off");
    window.get_by_label("Hole filling").scroll_to_me();
    window.run_steps(3);
    pick(window, "Hole filling", "None");
    window.get_by_label("Renderer").scroll_to_me();
    window.run_steps(3);
    pick(window, "Renderer", "GPU");
    settle(window);
    assert!(!is_on_device(window), "a still picture can be asked about");
    click(window, "Step forward");
    wait(window, "a picture in motion", is_on_device);
}

/// Mean difference of two pictures of the same size, 8-bit steps, over squares of so many pixels that it does not matter how coarse they
/// are.
fn difference(a: &image::RgbaImage, b: &image::RgbaImage) -> f64 {
    let coarse = |picture: &image::RgbaImage| {
        image::imageops::thumbnail(picture, picture.width() / 16, picture.height() / 16)
    };
    let (a, b) = (coarse(a), coarse(b));
    let sum: f64 = a.iter().zip(b.iter()).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    sum / a.len() as f64
}

#[test]
fn pictures_in_motion_stay_on_the_device_and_show_the_scene_of_the_still_picture() {
    let (mut window, _) = open(demo(3, 4, (640, 480)));
    settle(&mut window);
    assert!(!is_on_device(&window), "the CPU paints");
    set_in_motion(&mut window);
    let moving = live_picture(&mut window);
    std::thread::sleep(Duration::from_millis(250));
    settle(&mut window);
    assert!(!is_on_device(&window), "the picture came to rest");
    let still = live_picture(&mut window);
    let colors: std::collections::HashSet<_> = still.pixels().map(|pixel| pixel.0).collect();
    assert!(colors.len() > 100, "the picture shows {} colors", colors.len());
    let turned = difference(&image::imageops::rotate180(&moving), &still);
    let found = difference(&moving, &still);
    assert!(found < 4.0 && found * 4.0 < turned, "{found}, and {turned} upside down");
}

#[test]
fn a_scene_opened_in_motion_leaves_no_texture_behind() {
    let (mut window, drawing) = open(small_demo());
    settle(&mut window);
    set_in_motion(&mut window);
    let moving = window.state().observed().live_texture.unwrap();
    assert!(drawing.renderer.read().texture(&moving).is_some());
    let capture = small_capture();
    window.get_by_label("Play").click();
    drop_on(&mut window, &capture);
    wait(&mut window, "the other scene", |window| {
        window.state().observed().scene_name == Some("small_capture")
    });
    assert!(drawing.renderer.read().texture(&moving).is_none());
}

#[test]
fn about_names_the_gpu_and_the_memory_in_use_on_it() {
    let (mut window, drawing) = open(small_demo());
    settle(&mut window);
    click(&mut window, "Help");
    click(&mut window, "About Overlook");
    assert!(shows(&window, &drawing.adapter.get_info().name));
    let memory = window.get_by_label_contains("GPU memory in use: ").accesskit_node().value().unwrap();
    assert!(memory.ends_with("MB") || memory.ends_with("kB") || memory.ends_with("GB"), "{memory}");
}
