//! Carries out what concerns the live view's camera and what surrounds its picture.

use std::path::Path;

use crate::address;
use crate::app::control::overlook_app::OverlookApp;
use crate::app::rooms::frame::model::{DockView, NoticeKind};
use crate::app::rooms::live::model::{FLY_SPEEDS, HoleDisplay, LiveLook, OrbitCamera, ViewCommand};
use crate::app::rooms::path::control::key_of;
use crate::app::rooms::source::model::PictureZoom;
use overlook_engine::capture::transforms::{Easing, PathView, path_from_json, path_to_json};
use overlook_engine::settings::{Fill, RenderSettings};

/// Bytes of a copied view that are read at most: thousands of times what one takes.
const MOST_PASTED: usize = 1 << 20;

/// What is framed of a selection, root mean square distances from its mean: all of a ball, a disk or a square.
const SPREADS: f64 = 1.8;

impl OverlookApp {
    /// Carries out what concerns the live view's camera and what surrounds its picture.
    pub(crate) fn apply_to_view(&mut self, command: ViewCommand) {
        let live = &mut self.state.live;
        match command {
            ViewCommand::Copy => self.copy_view(),
            ViewCommand::CopyAddress => self.copy_address(),
            ViewCommand::GoToAddress(text) => self.go_to_address(&text),
            ViewCommand::Back => self.step_view(true),
            ViewCommand::Forward => self.step_view(false),
            ViewCommand::Kept(command) => self.apply_to_kept_views(command),
            ViewCommand::Paste => self.ctx.send_viewport_cmd(egui::ViewportCommand::RequestPaste),
            ViewCommand::Pasted(text) => self.paste_view(&text),
            ViewCommand::Look(mut look) => {
                look.fly_speed = look.fly_speed.clamp(*FLY_SPEEDS.start(), *FLY_SPEEDS.end());
                let (size, is_held, up) = (live.size, live.is_held, live.up);
                *live = LiveLook { orbit: live.orbit.take(), size, is_held, up, ..*look };
            }
            ViewCommand::Up(up) => {
                live.up = up;
                self.state.remember_up(up);
                let up = self.state.up_in_world();
                if let Some(orbit) = &mut self.state.live.orbit {
                    orbit.set_up(up);
                    orbit.level();
                }
            }
            ViewCommand::FindUp => {
                live.up_wanted_at = Some(self.ctx.cumulative_frame_nr());
                self.open_view(DockView::View);
            }
            ViewCommand::Size(size) => live.size = size,
            ViewCommand::Holes(holes) => self.show_holes(holes),
            ViewCommand::Home => {
                let up = self.state.up_in_world();
                self.state.live.orbit =
                    self.state.doc.scene.as_ref().and_then(|scene| OrbitCamera::home(scene, up));
                self.state.source.part = PictureZoom::default();
            }
            ViewCommand::JumpTo(index) => {
                let scene = self.state.doc.scene.as_ref();
                if let Some((scene, camera)) =
                    scene.and_then(|scene| Some((scene, scene.cameras.get(index)?)))
                {
                    live.orbit = Some(OrbitCamera::at_camera(scene, camera));
                }
            }
            ViewCommand::FramePoint => self.frame_point(),
            ViewCommand::Focus(point) => self.turn(|orbit| orbit.look_at(point)),
            ViewCommand::Camera(camera) => self.turn(|orbit| *orbit = *camera),
            ViewCommand::LookAlong(direction) => self.turn(|orbit| orbit.look_along(direction)),
            ViewCommand::Orbit(angles) => self.turn(|orbit| orbit.orbit(angles)),
            ViewCommand::Pan(share) => self.turn(|orbit| orbit.pan(share)),
            ViewCommand::Dolly(factor) => self.turn(|orbit| orbit.dolly(factor)),
            ViewCommand::DollyTo { factor, point_in_world } => {
                self.turn(|orbit| orbit.dolly_to(factor, point_in_world));
            }
            ViewCommand::Fly(steps) => self.turn(|orbit| orbit.fly(steps)),
        }
    }

    /// Changes the camera of the live view, where there is one.
    fn turn(&mut self, change: impl FnOnce(&mut OrbitCamera)) {
        if let Some(orbit) = &mut self.state.live.orbit {
            change(orbit);
        }
    }

    fn step_view(&mut self, back: bool) {
        let Some(now) = self.state.live.orbit.clone() else { return };
        if let Some(view) = self.state.doc.views.step(back, now) {
            self.state.live.orbit = Some(view);
        }
    }

    /// Copies the pose of the live view as a manifest of one view, which the window pastes and `render --views` takes.
    fn copy_view(&mut self) {
        let (Some(scene), Some(orbit)) = (&self.state.doc.scene, &self.state.live.orbit) else { return };
        let camera = orbit.camera(orbit.lens.width, orbit.lens.height);
        let frame_number = scene.frame_numbers.get(self.state.timeline.frame).copied().unwrap_or_default();
        let view = PathView { camera, frame_number, is_key: true };
        match path_to_json(self.state.up_in_world(), &[view], Easing::Linear) {
            Ok(text) => {
                self.ctx.copy_text(text);
                self.state.notify(
                    NoticeKind::Done,
                    "View copied",
                    "Ctrl+V moves the view here again, in any window.",
                );
            }
            Err(error) => self.state.notify(NoticeKind::Error, "View not copied", error.to_string()),
        }
    }

    fn paste_view(&mut self, text: &str) {
        let Some(scene) = self.state.doc.scene.clone() else { return };
        if text.len() <= MOST_PASTED && address::split(text).is_some() {
            return self.go_to_address(text);
        }
        let bytes = text.as_bytes();
        let views = if bytes.len() > MOST_PASTED {
            Err("it is too long for a view".to_owned())
        } else {
            path_from_json(bytes, Path::new("clipboard")).map_err(|error| error.to_string())
        };
        match views.map(|views| views.into_iter().next()) {
            Ok(Some(view)) => {
                let key = key_of(&scene, &view);
                self.go_to_key(key);
            }
            Ok(None) => {}
            Err(why) => {
                let text = format!(
                    "What was copied is no view and no address of one: {why}. Copy one in the View panel (Ctrl+C)."
                );
                self.state.warn_of_scene("Nothing to paste", text);
            }
        }
    }

    /// Shows holes filled, hatched or dimmed; to be shown filled, they must be filled by the settings too.
    fn show_holes(&mut self, holes: HoleDisplay) {
        self.state.live.holes = holes;
        let mut settings = self.state.settings.clone();
        if holes != HoleDisplay::Hatched && settings.render.fill == Fill::None {
            settings.render.fill = RenderSettings::default().fill;
            self.change_settings(settings);
        }
    }

    pub(crate) fn copy_picture(&mut self) {
        if self.state.doc.live_shown.is_none() {
            return;
        }
        let Some(image) = self.state.shown_picture() else { return self.notify_in_motion() };
        self.ctx.copy_image(image.as_ref().clone());
        self.state.notify(NoticeKind::Done, "Copied", "The picture of the live view is on the clipboard.");
    }

    /// Pictures in motion may stay on the graphics card, out of reach.
    pub(crate) fn notify_in_motion(&mut self) {
        let text = "The live view is playing; pause it first, and try again.";
        self.state.warn_of_scene("No picture yet", text);
    }

    /// Frames what is selected to be edited, else centers the live view on the selected point.
    fn frame_point(&mut self) {
        if self.state.doc.edits.selection.is_some() {
            let place = self.state.edited_now().and_then(|edited| edited.place);
            match (place, &mut self.state.live.orbit) {
                (Some(place), Some(orbit)) => orbit.frame(place.mean, SPREADS * place.spread),
                _ => self.state.warn_of_scene(
                    "Nothing to frame",
                    "The selection has no place: it is empty or infinitely far away, or it is still being worked out.",
                ),
            }
            return;
        }
        let probed = self.state.doc.probe.shown.clone();
        let point = probed.as_ref().and_then(|probed| probed.point_in_world);
        if let (Some(point), Some(orbit)) = (point, &mut self.state.live.orbit) {
            orbit.look_at(point);
            return;
        }
        let (title, text) = match probed {
            Some(_) => ("No point here", "This pixel is infinitely far away; point at another one."),
            None => ("Point at a pixel first", "F then centers the live view on it."),
        };
        self.state.warn_of_scene(title, text);
    }
}
