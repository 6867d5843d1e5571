//! Carries out what concerns the live view's camera and what surrounds its picture.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use egui::TextureOptions;

use crate::address;
use crate::app::control::OverlookApp;
use crate::app::model::camera::OrbitCamera;
use crate::app::model::command::{KeptViewCommand, ViewCommand};
use crate::app::model::look::FLY_SPEEDS;
use crate::app::model::picture::{
    CarriedLook, HoleDisplay, LiveKey, LivePicture, PictureZoom, PixelSource, ShownCarried,
};
use crate::app::model::texture::smaller;
use crate::app::model::window::{DockView, NoticeKind};
use crate::app::model::{ShownPicture, State, Texture};
use crate::app::rooms::live::state::{KeptView, LiveLook, next_name};
use crate::app::rooms::path::control::key_of;
use overlook_engine::capture::Camera;
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
                    orbit.up_in_world = up;
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
                let scene = self.state.doc.scene.as_ref();
                self.state.live.orbit = scene.and_then(|scene| OrbitCamera::home(scene, up));
                self.state.source.part = PictureZoom::default();
            }
            ViewCommand::JumpTo(index) => {
                if let Some(scene) = &self.state.doc.scene
                    && let Some(camera) = scene.cameras.get(index)
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
            ViewCommand::Dolly(factor, None) => self.turn(|orbit| orbit.dolly(factor)),
            ViewCommand::Dolly(factor, Some(point)) => self.turn(|orbit| orbit.dolly_to(factor, point)),
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
                let text = "Ctrl+V moves the view here again, in any window.";
                self.state.notify(NoticeKind::Done, "View copied", text);
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
        match views {
            Ok(views) => {
                if let Some(view) = views.first() {
                    self.go_to_key(key_of(&scene, view));
                }
            }
            Err(why) => {
                let text = format!(
                    "What was copied is no view and no address of one: {why}. Copy one in the View panel (Ctrl+C)."
                );
                self.state.warn_of_scene("Nothing to paste", text);
            }
        }
    }

    /// Shows holes filled or hatched; to be shown filled, they must be filled by the settings too.
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
        match self.state.doc.probe.shown.as_ref().map(|probed| probed.point_in_world) {
            Some(Some(point)) => self.turn(|orbit| orbit.look_at(point)),
            Some(None) => {
                let text = "This pixel is infinitely far away; point at another one.";
                self.state.warn_of_scene("No point here", text);
            }
            None => {
                self.state.warn_of_scene("Point at a pixel first", "F then centers the live view on it.");
            }
        }
    }

    /// Carries out what concerns views that are kept.
    fn apply_to_kept_views(&mut self, command: KeptViewCommand) {
        let kept = &mut self.state.doc.kept_views;
        match command {
            KeptViewCommand::Keep => {
                let name = next_name(kept);
                let Some(view) = self.view_address() else { return };
                let text = format!("It is \"{name}\" in Go to… and in the View panel.");
                self.state.doc.kept_views.push(KeptView { name, view });
                self.picture_view();
                self.state.notify(NoticeKind::Done, "View kept", text);
            }
            KeptViewCommand::GoTo(index) => {
                let Some((scene, kept)) = self.state.doc.scene.clone().zip(kept.get(index)) else { return };
                let view = kept.view.clone();
                self.go_to_view(&scene, &view);
            }
            KeptViewCommand::Change(changed) => *kept = changed,
        }
    }

    /// Gives the view that is shown a small picture, where it is one that has one.
    pub(crate) fn picture_view(&mut self) {
        let state = &self.state;
        let (Some(shown), None) = (&state.doc.live_shown, &state.doc.live_carried) else { return };
        let here = &shown.key.vantage;
        if here.frame != state.timeline.frame || !state.looks_from(&here.camera) {
            return;
        }
        let Some((view, picture)) = self.view_address().zip(state.shown_picture()) else { return };
        let wanted = state.pictured_views();
        if state.doc.view_pictures.of(&view).is_some() || !wanted.contains(&view) {
            return;
        }
        let picture = self.ctx.load_texture("view", smaller(picture), TextureOptions::LINEAR);
        self.state.doc.view_pictures.keep(view, picture, &wanted);
    }

    /// Takes in a live picture. If the view has moved on, what is shown stays until this picture is carried to where the view is: it
    /// would jump back.
    pub(crate) fn live_painted(&mut self, key: LiveKey, picture: Arc<LivePicture>) {
        let state = &mut self.state;
        state.report_damage(&picture.damage);
        let timeline = &state.timeline;
        let frame_rate = timeline.playing.then_some(timeline.frames_per_second);
        state.doc.motion.painted(&key, &picture, frame_rate);
        if state.timeline.playing {
            state.timeline.shown.add(key.vantage.frame, Instant::now());
        }
        let is_behind = !state.looks_from(&key.vantage.camera);
        let carried = state.doc.live_carried.take().filter(|_| is_behind && picture.rendered().is_some());
        let rests = || self.workers.live.asked().is_some_and(|asked| asked.quality.is_none());
        // One in motion is of no use after that at rest was asked for.
        if carried.is_some() && key.quality.is_some() && rests() {
            state.doc.live_carried = carried;
            return;
        }
        let texture = match (carried.is_some(), state.doc.live_shown.take()) {
            (true, Some(shown)) => Some(shown.texture),
            (_, shown) => self.texture_of(&picture, shown.map(|shown| shown.texture)),
        };
        self.state.doc.live_carried = carried;
        self.state.doc.live_shown = texture.map(|texture| ShownPicture { key, picture, texture });
        self.picture_view();
    }

    /// Takes in the live picture as `camera` sees it, unless that was painted in the meantime.
    pub(crate) fn live_carried(&mut self, camera: &Camera, carried: Option<CarriedLook>) {
        let state = &mut self.state;
        let is_painted =
            state.doc.live_shown.as_ref().is_none_or(|shown| state.looks_from(&shown.key.vantage.camera));
        let Some(CarriedLook { image, inverse_depth }) = carried.filter(|_| !is_painted) else { return };
        let replaced = state.doc.live_carried.take().map(|carried| carried.texture);
        let texture = Texture::send(&self.ctx, "carried", options_of(image.size, state), &image, replaced);
        state.doc.live_carried = Some(ShownCarried { camera: camera.clone(), inverse_depth, texture });
    }

    /// The texture that shows a picture of the live view; `None` if it is on the GPU and the window does not draw with one.
    fn texture_of(&self, picture: &LivePicture, replaced: Option<Texture>) -> Option<Texture> {
        let options = options_of(picture.size, &self.state);
        Some(match &picture.pixels {
            PixelSource::InMemory { image, .. } => Texture::send(&self.ctx, "live", options, image, replaced),
            PixelSource::OnAdapter(painted) => {
                Texture::painted(self.window.as_ref()?, options, painted, replaced)
            }
        })
    }
}

/// How a live picture is magnified: not at all where it has the pixels of its view, which costs a processor that draws the least.
fn options_of(size: [usize; 2], state: &State) -> TextureOptions {
    let fits = size.map(|side| side as u32) == state.live.size;
    if fits { TextureOptions::NEAREST } else { TextureOptions::LINEAR }
}
