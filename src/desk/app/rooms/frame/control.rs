//! Carries out commands about the window: workspaces, the maximized view, and hidden areas.

use crate::app::control::OverlookApp;
use crate::app::model::command::WindowCommand;
use crate::app::model::window::{Area, DockView, HelpPage};

impl OverlookApp {
    pub(crate) fn apply_to_window(&mut self, command: WindowCommand) {
        let look = &mut self.state.look;
        match command {
            WindowCommand::OpenView(view) => self.open_view(view),
            WindowCommand::ResetLayout => {
                self.dock.reset();
                (look.maximized, look.hides_totals) = (None, false);
                self.show_areas_that_fit();
            }
            WindowCommand::Workspace(workspace) => {
                self.dock.show_workspace(workspace);
                (look.workspace, look.maximized) = (workspace, None);
                self.show_areas_that_fit();
            }
            WindowCommand::Maximize(view) => {
                let view = view.or_else(|| self.dock.pointed_at()).unwrap_or(DockView::Live);
                look.maximized = (look.maximized != Some(view)).then_some(view);
            }
            WindowCommand::ShowArea(area, show) => self.show_area(area, show),
            WindowCommand::ShowTotals(show) => look.hides_totals = !show,
            WindowCommand::FullScreen => {
                let is_full = self.ctx.input(|input| input.viewport().fullscreen.unwrap_or(false));
                self.ctx.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!is_full));
            }
            WindowCommand::InterfaceSize(step) => match step {
                0 => self.ctx.set_zoom_factor(1.0),
                step if step > 0 => egui::gui_zoom::zoom_in(&self.ctx),
                _ => egui::gui_zoom::zoom_out(&self.ctx),
            },
            WindowCommand::Dark(dark) => self.state.dark = dark,
            WindowCommand::Dismiss(id) => self.state.notices.retain(|notice| notice.id != id),
            WindowCommand::Palette(palette) => self.state.inspector.palette = palette,
            WindowCommand::Help(page) => self.show_help(page),
        }
    }

    fn show_help(&mut self, page: Option<HelpPage>) {
        let state = &mut self.state;
        state.inspector.help = page;
        if page == Some(HelpPage::About) {
            state.inspector.held_memory = state.held_memory();
            let window = self.window.as_ref();
            let memory = window.and_then(|window| window.device.generate_allocator_report());
            state.inspector.graphics_memory = memory.map(|memory| memory.total_allocated_bytes);
        }
    }

    /// Brings a view to the front: out of an area that was hidden, and from behind one that fills the window.
    pub(crate) fn open_view(&mut self, view: DockView) {
        self.dock.open(view);
        if let Some(area) = self.dock.area_of(view) {
            self.show_area(area, true);
        }
        self.state.look.maximized = self.state.look.maximized.filter(|maximized| *maximized == view);
    }

    fn show_area(&mut self, area: Area, show: bool) {
        self.dock.show_area(area, show);
        let look = &mut self.state.look;
        look.hidden.retain(|hidden| *hidden != area);
        if !show {
            look.hidden.push(area);
        }
        look.maximized = None;
        self.show_useful_views();
    }

    /// Hides views without use for what is open, in shown areas as well.
    fn show_useful_views(&mut self) {
        for (view, ..) in DockView::ALL {
            let is_shown = self.dock.area_of(view).is_none_or(|area| self.state.look.shows(area));
            self.dock.show_view(view, is_shown && self.state.has_use_of(view));
        }
    }

    /// Hides the area of cameras' pictures where a store is open that shows none, and shows it again with a capture; the same of
    /// other views that there may be nothing for.
    pub(crate) fn show_views_of_scene(&mut self) {
        let (maximized, has_source) = (self.state.look.maximized, self.state.has_source());
        self.show_area(Area::Source, has_source);
        self.state.look.maximized = maximized
            .filter(|view| (has_source || *view != DockView::Source) && self.state.has_use_of(*view));
    }

    /// Shows every area of the workspace that has something to show: not every store shows pictures of cameras.
    pub(crate) fn show_areas_that_fit(&mut self) {
        let maximized = self.state.look.maximized;
        let has_source = self.state.doc.scene.is_none() || self.state.has_source();
        for (area, ..) in Area::ALL {
            self.show_area(area, area != Area::Source || has_source);
        }
        self.state.look.maximized = maximized;
    }
}
