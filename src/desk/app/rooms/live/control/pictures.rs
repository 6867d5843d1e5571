//! Takes in pictures of the live view.

use std::sync::Arc;
use std::time::Instant;

use egui::TextureOptions;

use crate::app::control::overlook_app::OverlookApp;
use crate::app::model::{ShownPicture, State, Texture};
use crate::app::rooms::live::model::{CarriedLook, LiveKey, LivePicture, PixelSource, ShownCarried};
use overlook_engine::capture::Camera;

impl OverlookApp {
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
        match &picture.pixels {
            PixelSource::InMemory { image, .. } => {
                let options = options_of(image.size, &self.state);
                Some(Texture::send(&self.ctx, "live", options, image, replaced))
            }
            PixelSource::OnAdapter(painted) => {
                let options =
                    options_of([painted.width(), painted.height()].map(|side| side as usize), &self.state);
                Some(Texture::painted(self.window.as_ref()?, options, painted, replaced))
            }
        }
    }
}

/// How a live picture is magnified: not at all where it has the pixels of its view, which costs a processor that draws the least.
fn options_of(size: [usize; 2], state: &State) -> TextureOptions {
    let fits = size.map(|side| side as u32) == state.live.size;
    if fits { TextureOptions::NEAREST } else { TextureOptions::LINEAR }
}
