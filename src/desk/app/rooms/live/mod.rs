//! The live view: the scene from any viewpoint, and how one looks around.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use egui::{Rect, TextureId};

use crate::address::ViewAddress;
use crate::app::model::camera::OrbitCamera;
use crate::app::model::state::State;
use overlook_engine::capture::Camera;
use overlook_engine::grid::Grid;

/// What the live view shows.
pub(crate) struct SeenPicture<'a> {
    pub texture: TextureId,
    /// Where it is seen from, with as many pixels as it has.
    pub camera: &'a Camera,
    /// As in a picture; `None` while its pixels cannot be read.
    pub inverse_depth: Option<&'a Grid<f32>>,
}

impl State {
    /// What the live view shows; `None` before the first picture.
    pub(crate) fn live_seen(&self) -> Option<SeenPicture<'_>> {
        let shown = self.doc.live_shown.as_ref()?;
        Some(match &self.doc.live_carried {
            Some(carried) => SeenPicture {
                texture: carried.texture.id(),
                camera: &carried.camera,
                inverse_depth: Some(&carried.inverse_depth),
            },
            None => SeenPicture {
                texture: shown.texture.id(),
                camera: &shown.key.vantage.camera,
                inverse_depth: shown.picture.rendered().map(|rendered| &rendered.inverse_depth),
            },
        })
    }

    /// Whether the view is where a picture was taken from.
    pub(crate) fn looks_from(&self, camera: &Camera) -> bool {
        let lens = camera.intrinsics;
        self.live_camera([lens.width, lens.height]).as_ref() == Some(camera)
    }

    /// The camera of the picture that the live view shows, for `width × height` pixels over it: what is drawn there lies where the
    /// picture shows it. Before the first picture, that of the view.
    pub(crate) fn seen_camera(&self, size: [u32; 2]) -> Option<Camera> {
        let Some(seen) = self.live_seen() else { return self.live_camera(size) };
        let intrinsics = seen.camera.intrinsics.resized(size[0], size[1]);
        Some(Camera { intrinsics, ..seen.camera.clone() })
    }

    /// That camera for what is drawn over the picture on a canvas: its pixels are points of the window.
    pub(crate) fn camera_over(&self, canvas: Rect) -> Option<Camera> {
        let mut camera = self.seen_camera([canvas.width() as u32, canvas.height() as u32])?;
        camera.intrinsics.cx += f64::from(canvas.left());
        camera.intrinsics.cy += f64::from(canvas.top());
        Some(camera)
    }

    /// The address of a view at a frame, without the scene's; `None` while nothing is open.
    pub(crate) fn address_of(&self, orbit: &OrbitCamera, frame: usize) -> Option<ViewAddress> {
        let scene = self.doc.scene.as_ref()?;
        let frame_number = scene.frame_numbers.get(frame).copied().unwrap_or_default();
        let lenses = [orbit.lens, scene.cameras.first()?.intrinsics];
        Some(ViewAddress::of(&orbit.world_from_camera, orbit.pivot_distance, lenses, frame_number))
    }

    /// The views that have small pictures: those that are kept, and the keys of the camera path.
    pub(crate) fn pictured_views(&self) -> Vec<ViewAddress> {
        let kept = self.doc.kept_views.iter().map(|kept| kept.view.clone());
        let keys = self.doc.path.keys.iter();
        kept.chain(keys.filter_map(|key| self.address_of(&key.orbit, key.frame))).collect()
    }
}
