//! What the window shows, for tests that drive it.

use crate::app::control::overlook_app::OverlookApp;
use overlook_engine::capture::Camera;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::settings::Settings;

/// The state of a window beyond its labels.
#[derive(Clone, Debug)]
pub struct Observed<'a> {
    /// Whether all requested work is done and shown.
    pub is_idle: bool,
    /// Index of the frame shown.
    pub frame: usize,
    /// Name of what is open, or `None`.
    pub scene_name: Option<&'a str>,
    /// The account of the open capture or store, and whether it was made with the settings on the sliders.
    pub report: Option<(&'a Report, bool)>,
    /// The settings on the sliders.
    pub settings: &'a Settings,
    /// Pixel size of the live picture on screen and the share of it that samples reached; `None` before the first.
    pub live_coverage: Option<([usize; 2], f64)>,
    /// The texture of the live picture: [`egui::TextureId::User`] if its pixels never left the device that draws the window;
    /// `None` before the first.
    pub live_texture: Option<egui::TextureId>,
    /// Position of the live view in world space; `None` while nothing is open.
    pub live_position: Option<[f64; 3]>,
    /// Index of the camera whose picture the source view shows.
    pub source_camera: usize,
    /// Camera, column and row of the selected pixel; `None` while there is none.
    pub probed_pixel: Option<(usize, usize, usize)>,
    /// Title and text of every message on screen.
    pub notices: Vec<String>,
    /// Names of the views that can be seen, by their tabs.
    pub views_in_sight: Vec<&'static str>,
    /// Positions of all cameras in world space.
    pub camera_positions: Vec<[f64; 3]>,
    /// The cameras that the live view shows, each with the place of its middle as shares of the view.
    pub cameras_on_screen: Vec<(usize, egui::Vec2)>,
    /// The distance between the two points that were picked, in units of the scene; `None` before both were.
    pub measured_distance: Option<f64>,
}

impl OverlookApp {
    /// What the window shows now.
    #[must_use]
    pub fn observed(&self) -> Observed<'_> {
        let state = &self.state;
        let scene = state.doc.scene.as_deref();
        let cameras = scene.map_or(&[][..], |scene| &scene.cameras);
        let size = state.live.size;
        let vantage = state.seen_camera(size);
        let on_screen = |(index, camera): (usize, &Camera)| {
            let (pixel, _) = vantage.as_ref()?.project(camera.position_in_world())?;
            let share = egui::vec2(pixel.x as f32 / size[0] as f32, pixel.y as f32 / size[1] as f32);
            (share.min_elem() > 0.0 && share.max_elem() < 1.0).then_some((index, share))
        };
        let live = state.doc.live_shown.as_ref();
        let coverage = live.map(|shown| {
            let [width, height] = shown.picture.size;
            ([width, height], 1.0 - shown.picture.stats.holes as f64 / (width * height).max(1) as f64)
        });
        Observed {
            is_idle: self.workers.are_at_rest(state) && self.unread.is_none() && state.opening.is_none(),
            frame: state.timeline.frame,
            scene_name: scene.map(|scene| scene.name.as_str()),
            report: state.report().map(|report| (report, !state.is_stale())),
            settings: &state.settings,
            live_coverage: coverage,
            live_texture: live.map(|shown| shown.texture.id()),
            live_position: state
                .live
                .orbit
                .as_ref()
                .map(|orbit| orbit.world_from_camera.translation.to_array()),
            source_camera: state.source.camera,
            probed_pixel: state.doc.probe.shown.as_ref().map(|probed| (probed.camera, probed.x, probed.y)),
            notices: state
                .notices
                .iter()
                .map(|notice| format!("{}: {}", notice.title, notice.text))
                .collect(),
            views_in_sight: self.visible_views().into_iter().map(|view| view.name_and_help().0).collect(),
            camera_positions: cameras.iter().map(|camera| camera.position_in_world().to_array()).collect(),
            cameras_on_screen: cameras.iter().enumerate().filter_map(on_screen).collect(),
            measured_distance: state.live.ruler.distance(),
        }
    }
}
