//! Opens the window, with the renderer that suits the machine.

use std::path::PathBuf;

use winit::event_loop::EventLoop;

use crate::app::control::{OverlookApp, Start};
use crate::app::pace::{LeastPeriod, PacedWindow};
use overlook_engine::error::{Error, Result};
use overlook_engine::render::gpu::device_descriptor;

/// Opens the window on a capture or store at `path`, or on the room that comes with the program, and runs until it is closed.
///
/// # Errors
/// [`Error::Gpu`] where there is no display or no window can be opened.
pub fn run(path: Option<PathBuf>) -> Result<()> {
    if !has_display() {
        return Err(Error::Gpu {
            what: "there is no display for a window; overlook demo, info, preprocess, render and evaluate work without one"
                .to_owned(),
        });
    }
    let start = path.map_or(Start::Welcome, Start::Path);
    let has_card = has_graphics_card();
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Overlook")
            .with_app_id("overlook")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([1024.0, 640.0])
            .with_drag_and_drop(true),
        renderer: if has_card { eframe::Renderer::Wgpu } else { eframe::Renderer::Glow },
        wgpu_options: window_device(),
        // Its noise costs a program that draws on the processor more than all the rest.
        dithering: false,
        ..Default::default()
    };
    let least_period = LeastPeriod::default();
    let period = least_period.clone();
    let created: eframe::AppCreator<'_> = Box::new(|cc| {
        let mut app = OverlookApp::new(&cc.egui_ctx, cc.storage, cc.wgpu_render_state.as_ref(), start)?;
        app.least_period = period;
        Ok(Box::new(app))
    });
    let opened = if has_card {
        eframe::run_native("overlook", options, created)
    } else {
        run_paced(options, created, least_period)
    };
    opened.map_err(|error| Error::Gpu { what: format!("no window can be opened: {error}") })
}

/// Runs a window that the processor draws.
fn run_paced(
    options: eframe::NativeOptions,
    created: eframe::AppCreator<'_>,
    least_period: LeastPeriod,
) -> eframe::Result {
    let event_loop = EventLoop::<eframe::UserEvent>::with_user_event().build()?;
    let window = eframe::create_native("overlook", options, created, &event_loop);
    Ok(event_loop.run_app(&mut PacedWindow::new(window, least_period))?)
}

/// A window whose device can do whatever its adapter can, so that the GPU renderer can share it.
fn window_device() -> eframe::egui_wgpu::WgpuConfiguration {
    let mut configuration = eframe::egui_wgpu::WgpuConfiguration::default();
    if let eframe::egui_wgpu::WgpuSetup::CreateNew(setup) = &mut configuration.wgpu_setup {
        setup.device_descriptor = std::sync::Arc::new(device_descriptor);
    }
    configuration
}

/// Only X11 and Wayland can be missing; other systems always have a display.
fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(all(unix, not(target_os = "macos"))) || set("DISPLAY") || set("WAYLAND_DISPLAY")
}

/// Whether some adapter is more than a program on the CPU. A software Vulkan paints a window at a tenth of the speed that
/// eframe's OpenGL renderer reaches there, so such machines get the latter.
fn has_graphics_card() -> bool {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all())).iter().any(|adapter| {
        matches!(
            adapter.get_info().device_type,
            wgpu::DeviceType::DiscreteGpu | wgpu::DeviceType::IntegratedGpu | wgpu::DeviceType::VirtualGpu
        )
    })
}
