//! Addresses of views, which pages and windows open: copying one, and going to one.

use std::path::PathBuf;

use super::path_names::lasting;
use crate::address::{self, ViewAddress};
use crate::app::control::overlook_app::OverlookApp;
use crate::app::model::{Command, OpenScene, SceneSource};
use crate::app::rooms::files::model::{FileCommand, Opening};
use crate::app::rooms::frame::model::NoticeKind;
use crate::app::rooms::live::model::OrbitCamera;
use overlook_engine::capture::Camera;

impl OverlookApp {
    /// Copies the address of the view. The view becomes the one that the address says, a trillionth from where it was: whoever opens it
    /// sees the same to the last bit.
    pub(crate) fn copy_address(&mut self) {
        let (Some(scene), Some(view)) = (self.state.doc.scene.clone(), self.view_address()) else { return };
        let place = match &scene.origin {
            SceneSource::Path(path) => path.display().to_string(),
            SceneSource::Demo(_) | SceneSource::Room => String::new(),
        };
        self.ctx.copy_text(format!("{place}{view}"));
        self.go_to_view(&scene, &view);
        let state = &mut self.state;
        let text = "Paste it into a window of Overlook (Ctrl+V), give it to overlook open, or append what follows the # to a page.";
        state.notify(NoticeKind::Done, "Address copied", text);
    }

    /// The address of the view, without the scene's; `None` while nothing is shown.
    pub(crate) fn view_address(&self) -> Option<ViewAddress> {
        let state = &self.state;
        state.address_of(state.live.orbit.as_ref()?, state.timeline.frame)
    }

    /// Goes to the view of an address. A scene that is not open is opened first; a page and an address without a scene mean what is open.
    pub(crate) fn go_to_address(&mut self, text: &str) {
        let Some((place, view)) = address::split(text) else {
            let text = "An address ends like #view=…&frame=…; a page and this window copy them.";
            return self.state.warn_of_scene("No address", text);
        };
        let path = lasting(PathBuf::from(&place));
        let names_scene = !place.is_empty() && !address::is_page(&place);
        match self.state.doc.scene.clone() {
            Some(scene) if !names_scene || scene.origin == SceneSource::Path(path) => {
                self.go_to_view(&scene, &view);
            }
            _ if names_scene => {
                self.apply(Command::File(FileCommand::Open(Opening::Path(format!("{place}{view}").into()))));
            }
            _ => {}
        }
    }

    /// Goes to the view that a path was opened for.
    pub(crate) fn go_to_opened_address(&mut self, scene: &OpenScene) {
        let Some((path, view)) = self.address_to_open.take() else { return };
        if scene.origin == SceneSource::Path(path) {
            self.go_to_view(scene, &view);
        }
    }

    pub(crate) fn go_to_view(&mut self, scene: &OpenScene, view: &ViewAddress) {
        if let Some(orbit) = orbit_of(scene, view) {
            self.state.live.orbit = Some(orbit);
        }
        if let Some(number) = view.frame_number {
            let frame = scene.frame_numbers.partition_point(|known| *known < number);
            self.state.timeline.frame = frame.min(scene.frame_count().saturating_sub(1));
            self.state.timeline.playing = false;
        }
        let up = self.state.up_in_world();
        if let Some(orbit) = &mut self.state.live.orbit {
            orbit.set_up(up);
        }
    }
}

/// The view that an address says; `None` where it says none, or names a camera that is not there.
fn orbit_of(scene: &OpenScene, view: &ViewAddress) -> Option<OrbitCamera> {
    let first = scene.cameras.first()?;
    let named =
        view.camera.as_ref().and_then(|name| scene.cameras.iter().find(|camera| camera.name == *name));
    let Some((world_from_camera, pivot_distance)) = view.pose() else {
        return named.map(|camera| OrbitCamera::at_camera(scene, camera));
    };
    let lens = view.lens.unwrap_or(first.intrinsics);
    let camera = Camera { name: "address".to_owned(), intrinsics: lens, world_from_camera };
    let mut orbit = OrbitCamera::at_camera(scene, &camera);
    orbit.pivot_distance = pivot_distance;
    Some(orbit)
}
