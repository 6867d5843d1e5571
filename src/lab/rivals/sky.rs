//! The sky: samples at infinity, for methods that model only surfaces.

use glam::DVec3;

use super::model::RecordedView;
use overlook_engine::capture::Camera;

/// The cameras in the order of their distance from a viewpoint.
pub(super) struct Sky<'a> {
    views: Vec<&'a RecordedView>,
}

impl<'a> Sky<'a> {
    pub(super) fn seen_from(views: &'a [RecordedView], target: &Camera) -> Self {
        Self { views: by_distance(views, target) }
    }

    /// Linear color of the sky in a direction in the world, by the nearest camera that saw it there.
    pub(super) fn color(&self, direction: DVec3) -> Option<[f32; 3]> {
        self.views.iter().find_map(|view| {
            let in_camera = view.camera.camera_from_world().transform_vector3(direction);
            let at = view.camera.intrinsics.project(in_camera)?;
            if at.x < 0.0 || at.y < 0.0 {
                return None;
            }
            let (x, y) = (at.x as usize, at.y as usize);
            let is_sky = *view.frame.inverse_depth.get(x, y)? == 0.0;
            is_sky.then(|| view.frame.color[(x, y)].map(half::f16::to_f32))
        })
    }
}

/// Views by the distance of their cameras from a viewpoint, those that look the other way last; of equals the first first.
pub(super) fn by_distance<'a>(views: &'a [RecordedView], target: &Camera) -> Vec<&'a RecordedView> {
    let mut views: Vec<&RecordedView> = views.iter().collect();
    let key = |view: &&RecordedView| {
        let looks_away = view.camera.forward_in_world().dot(target.forward_in_world()) <= 0.0;
        let distance = view.camera.position_in_world().distance(target.position_in_world());
        (looks_away, distance)
    };
    views.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    views
}
