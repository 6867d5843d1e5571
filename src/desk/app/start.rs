//! Opens the window, with the renderer that suits the machine, and draws its bars, views and dialogs. Areas borrow the state and send commands.

use std::path::PathBuf;

use egui::{CentralPanel, Frame, Margin, Panel};
use egui_material_icons::icons::{ICON_FOLDER_OPEN, ICON_HOURGLASS_TOP};
use winit::event_loop::EventLoop;

use crate::app::control::{OverlookApp, Start, keyboard};
use crate::app::dock::{Dock, DockPart};
use crate::app::export_menu::export_ui;
use crate::app::model::command::{FileCommand, Opening, WindowCommand};
use crate::app::model::purpose::Purpose;
use crate::app::model::window::DockView;
use crate::app::model::{Command, Commands, State};
use crate::app::pace::{LeastPeriod, PacedWindow};
use crate::app::rooms::charts::state::Study;
use crate::app::rooms::charts::ui::parts::study_button;
use crate::app::rooms::help::ui::palette::palette_ui;
use crate::app::rooms::{charts, files, frame, help, live, readings, report, share, source, timeline};
use crate::app::theme::{Tokens, space};
use crate::app::views::views;
use crate::app::widgets::empty_ui;
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
        (app.least_period, app.has_dialogs) = (period, true);
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

impl eframe::App for OverlookApp {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        self.between_pictures(ctx);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        keyboard::commands(ui, &self.state, &mut self.commands);
        window_ui(ui, &self.state, &mut self.dock, &mut self.commands);
        self.after_picture();
    }

    /// What lies between the views: filling it once more would cost a tenth of the window where no graphics card draws it.
    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        Tokens::of(self.state.dark).background.to_normalized_gamma_f32()
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.remember(storage);
    }
}

pub(crate) fn window_ui(ui: &mut egui::Ui, state: &State, dock: &mut Dock, commands: &mut Commands) {
    let tokens = Tokens::in_ui(ui);
    let bar = Frame::new().fill(tokens.surface).inner_margin(Margin::symmetric(space::PANEL, 0));
    Panel::top("top bar")
        .exact_size(space::TOP_BAR)
        .frame(bar)
        .show(ui, |ui| frame::ui::top_bar_ui(ui, state, commands));
    if state.doc.scene.is_some() && !state.look.hides_totals && state.look.maximized.is_none() {
        Panel::top("totals")
            .exact_size(space::TOTALS)
            .frame(bar)
            .show(ui, |ui| report::ui::totals_ui(ui, state, commands));
    }
    files::ui::introduction_ui(ui, state, commands);
    Panel::bottom("status")
        .exact_size(space::STATUS)
        .frame(bar)
        .show(ui, |ui| frame::ui::status_ui(ui, state, commands));
    if state.has_time() {
        Panel::bottom("timeline")
            .exact_size(space::TIMELINE)
            .frame(bar.inner_margin(Margin::symmetric(space::PANEL, 4)))
            .show(ui, |ui| timeline::ui::timeline_ui(ui, state, commands));
    }
    CentralPanel::no_frame().frame(Frame::new().inner_margin(Margin { top: 4, ..Margin::ZERO })).show(
        ui,
        |ui| {
            if state.doc.scene.is_none() {
                nothing_open_ui(ui, state, commands);
            } else {
                let resized = dock.ui(ui, state.look.maximized, |ui, view, part| match (part, view) {
                    (DockPart::Contents, _) => view_ui(ui, view, state, commands),
                    (DockPart::TabBar, DockView::Source) => source::ui::cameras_ui(ui, state, commands),
                    (DockPart::TabBar, DockView::Live) => live::ui::go_to_camera_ui(ui, state, commands),
                    (DockPart::TabBar, DockView::Cameras) => {
                        study_button(ui, state, Study::Ranking, commands);
                    }
                    (DockPart::TabBar, view) => export_ui(ui, view, state, commands),
                });
                commands.extend(resized.map(|view| Command::Window(WindowCommand::Maximize(Some(view)))));
            }
        },
    );
    frame::ui::notices_ui(ui.ctx(), state, commands);
    share::ui::share_ui(ui.ctx(), state, commands);
    files::ui::path_field_ui(ui.ctx(), state, commands);
    palette_ui(ui.ctx(), state, commands);
    help::ui::help_ui(ui.ctx(), state, commands);
    readings::ui::readings_ui(ui.ctx(), state, commands);
    charts::ui::question_ui(ui.ctx(), state, commands);
    files::ui::closing_ui(ui.ctx(), state, commands);
    drop_hint_ui(ui);
}

pub(crate) fn view_ui(ui: &mut egui::Ui, view: DockView, state: &State, commands: &mut Commands) {
    macro_rules! drawn {
        ($($view:ident, $name:literal, $help:literal, $($draw:ident)::+;)*) => {
            match view {
                $(DockView::$view => crate::app::rooms::$($draw)::+(ui, state, commands),)*
            }
        };
    }
    views!(drawn);
}

fn nothing_open_ui(ui: &mut egui::Ui, state: &State, commands: &mut Commands) {
    if let Some(opening) = &state.opening {
        empty_ui(ui, ICON_HOURGLASS_TOP, &format!("Opening {opening}"), "Reading the first frame.", |ui| {
            ui.add(egui::Spinner::new().size(22.0));
        });
        return;
    }
    let text = "Open the folder of a capture as its program or app wrote it, or a store that was saved before. \
                You can also drop it on this window.";
    empty_ui(ui, ICON_FOLDER_OPEN, "Nothing is open", text, |ui| {
        for (name, command) in [
            ("Open folder…", Command::File(FileCommand::AskPath(Purpose::OpenFolder))),
            ("Open file…", Command::File(FileCommand::AskPath(Purpose::OpenFile))),
            ("Open the demo", Command::File(FileCommand::Open(Opening::Room))),
        ] {
            if ui.button(name).clicked() {
                commands.push(command);
            }
        }
        files::ui::recent_ui(ui, state, commands);
    });
}

fn drop_hint_ui(ui: &egui::Ui) {
    if ui.ctx().input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    let tokens = Tokens::in_ui(ui);
    let painter =
        ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop hint")));
    let area = ui.ctx().content_rect();
    painter.rect_filled(area, 0.0, tokens.scrim);
    let font = egui::TextStyle::Heading.resolve(ui.style());
    painter.text(area.center(), egui::Align2::CENTER_CENTER, "Drop to open", font, tokens.on_scrim);
}
