//! A window that wgpu draws shows the GPU's pictures without copying them while they follow each other, and shows the same.

#[path = "app_driver/mod.rs"]
mod app_driver;

use std::time::Duration;

use app_driver::{Window, click, demo, pick, settle, wait};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use overlook::app::OverlookApp;
use overlook::render::gpu::device_descriptor;

/// A window drawn by wgpu, with the device that [`overlook::app::run`] asks for.
fn open() -> Window {
    let mut setup = egui_kittest::wgpu::default_wgpu_setup();
    if let eframe::egui_wgpu::WgpuSetup::CreateNew(setup) = &mut setup {
        setup.device_descriptor = std::sync::Arc::new(device_descriptor);
    }
    Harness::builder()
        .with_size([1280.0, 800.0])
        .with_os(egui::os::OperatingSystem::Nix)
        .with_render_cursor(false)
        .wgpu_setup(setup)
        .build_eframe(|cc| {
            let window = cc.wgpu_render_state.as_ref();
            OverlookApp::new(&cc.egui_ctx, None, window, demo(3, 4, (96, 72))).unwrap()
        })
}

/// The pixels of the live picture.
fn live_picture(window: &mut Window) -> image::RgbaImage {
    let area = window.get_by_label("Live picture").rect();
    let whole = window.render().unwrap();
    let [x, y, width, height] = [area.min.x, area.min.y, area.width(), area.height()].map(|side| side as u32);
    image::imageops::crop_imm(&whole, x, y, width, height).to_image()
}

#[test]
fn pictures_in_motion_stay_on_the_device_and_show_what_the_still_picture_shows() {
    let mut window = open();
    settle(&mut window);
    assert!(!window.state().live_is_on_device(), "the CPU paints");
    window.get_by_label("Render backend").scroll_to_me();
    window.run_steps(3);
    pick(&mut window, "Render backend", "Gpu");
    settle(&mut window);
    assert!(!window.state().live_is_on_device(), "a still picture can be asked about");
    click(&mut window, "Step forward");
    wait(&mut window, "a picture in motion", |window| window.state().live_is_on_device());
    let moving = live_picture(&mut window);
    std::thread::sleep(Duration::from_millis(250));
    settle(&mut window);
    assert!(!window.state().live_is_on_device(), "the picture came to rest");
    let still = live_picture(&mut window);
    let colors: std::collections::HashSet<_> = still.pixels().map(|pixel| pixel.0).collect();
    assert!(colors.len() > 100, "the picture shows {} colors", colors.len());
    let unlike = moving
        .pixels()
        .zip(still.pixels())
        .filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 2));
    assert_eq!(unlike.count(), 0);
}
