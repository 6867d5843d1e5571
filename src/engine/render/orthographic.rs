//! Orthographic pictures: lines of sight are parallel, so that lengths can be read off the picture wherever they lie.
//!
//! Purpose: plans, elevations, and pictures with one scale bar. Source: a telecentric lens, the limit of a camera that goes back as its
//! lens gets longer. What differs: it goes back [`WIDTHS_BACK`] times the width of the picture and no farther, because single precision
//! has to tell depths apart. Two equal lengths, one behind the other by the width of the picture, differ by 0.2 %. Samples behind the
//! viewpoint are left out, since a camera farther back would see them. Viewpoints whose own camera is orthographic are rendered so as
//! well: the renderers know orthographic cameras as sources alone.

use std::sync::Arc;

use glam::DVec3;

use super::vantage::{Picture, Vantage};
use crate::capture::sighting::Landing;
use crate::capture::{Camera, Intrinsics, Projection};
use crate::error::{Error, Result};
use crate::median::median;
use crate::samples::SampleSet;

/// How far the camera goes back, in widths of the picture.
const WIDTHS_BACK: f64 = 500.0;

/// One in this many samples of an image is asked how far away it is.
const STRIDE: usize = 61;

/// An orthographic picture that can be rendered.
#[derive(Clone, Debug)]
pub struct OrthographicView {
    /// The samples ahead of the viewpoint.
    pub samples: Arc<SampleSet>,
    /// What has to be rendered of them.
    pub vantage: Vantage,
    /// How far behind the viewpoint that camera stands, world units.
    back: f64,
}

impl OrthographicView {
    /// The picture from the place and in the direction of a vantage, of its size, that shows `width` world units from its left edge to its
    /// right one. The scale is exact at the median depth of what lies ahead. `samples` hold those of the vantage's frame.
    ///
    /// # Errors
    /// `Invalid` where the width is not above 0 and finite, and as [`Vantage::check`].
    pub fn new(samples: &SampleSet, vantage: &Vantage, width: f64) -> Result<Self> {
        vantage.check(samples)?;
        if !(width.is_finite() && width > 0.0) {
            let what = "the width of an orthographic picture must be above 0 and finite, in world units";
            return Err(Error::invalid(format!("viewpoint '{}'", vantage.camera.name), what));
        }
        let size = vantage.camera.intrinsics;
        Ok(Self::through(samples, vantage, Intrinsics::orthographic(size.width, size.height, width), width))
    }

    /// The picture of a vantage whose camera is orthographic.
    ///
    /// # Errors
    /// As [`Vantage::check`].
    pub(super) fn of_camera(samples: &SampleSet, vantage: &Vantage) -> Result<Self> {
        vantage.check(samples)?;
        let lens = vantage.camera.intrinsics;
        Ok(Self::through(samples, vantage, lens, lens.depth_scale(1.0)))
    }

    /// The picture from a vantage through an orthographic lens, which is so wide in world units.
    fn through(samples: &SampleSet, vantage: &Vantage, lens: Intrinsics, width: f64) -> Self {
        let pose = vantage.camera.world_from_camera;
        let forward = pose.matrix3.z_axis.normalize_or_zero();
        let ahead = Ahead { eye: pose.translation, forward };
        let own = Camera { intrinsics: lens, ..vantage.camera.clone() };
        let middle = median_depth(samples, vantage.frame, &own);
        let back = WIDTHS_BACK * width;
        let (fx, fy) = (lens.fx * (back + middle), lens.fy * (back + middle));
        let intrinsics = Intrinsics { fx, fy, projection: Projection::Perspective, ..lens };
        let mut camera = Camera { intrinsics, ..own };
        camera.world_from_camera.translation -= back * forward;
        let samples = Arc::new(ahead.samples(samples, vantage.frame));
        Self { samples, vantage: Vantage { camera, frame: vantage.frame }, back }
    }

    /// The rendered picture with depths from the viewpoint.
    #[must_use]
    pub fn finish(&self, rendered: &Picture) -> Picture {
        let from_viewpoint = |inverse: &f32| {
            let depth = 1.0 / f64::from(*inverse) - self.back;
            // What was filled may lie behind the viewpoint.
            if *inverse > 0.0 { (1.0 / depth.max(1e-9 * self.back)) as f32 } else { *inverse }
        };
        Picture { inverse_depth: rendered.inverse_depth.map(from_viewpoint), ..rendered.clone() }
    }
}

/// The half of the world that a viewpoint looks into.
struct Ahead {
    eye: DVec3,
    /// Unit length.
    forward: DVec3,
}

impl Ahead {
    /// Of a camera: how far a point of a pixel lies ahead, times its inverse depth.
    fn depth_of<'a>(&'a self, camera: &'a Camera) -> impl Fn(usize, usize, f32) -> f64 + use<'a> {
        let along = camera.world_from_camera.matrix3.transpose() * self.forward;
        let offset = (camera.position_in_world() - self.eye).dot(self.forward);
        let lens = camera.intrinsics;
        move |x, y, inverse_depth| {
            let pixel = glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let offset = if lens.is_orthographic() {
                (camera.line_of_sight_start(pixel) - self.eye).dot(self.forward)
            } else {
                offset
            };
            lens.ray_in_camera(pixel).dot(along) + offset * f64::from(inverse_depth)
        }
    }

    /// The samples of a frame that lie ahead; those at infinity that are seen ahead are among them. Images of other frames stay as they are.
    fn samples(&self, samples: &SampleSet, frame: usize) -> SampleSet {
        let images = samples.images.iter().map(|image| {
            if !image.span.contains(frame) {
                return image.clone();
            }
            let depth = self.depth_of(&samples.cameras[image.camera as usize]);
            Arc::new(
                image
                    .part(image.span, |sample, inverse_depth| depth(sample.x, sample.y, inverse_depth) > 0.0),
            )
        });
        SampleSet { images: images.collect(), ..samples.clone() }
    }
}

/// The median depth of samples within the picture of an orthographic camera; 0 where there are none.
fn median_depth(samples: &SampleSet, frame: usize, own: &Camera) -> f64 {
    let camera_from_world = own.camera_from_world();
    let mut depths = Vec::new();
    for image in samples.images_at(frame) {
        let camera = &samples.cameras[image.camera as usize];
        let places = image.placed(camera).step_by(STRIDE);
        let places = places.map(|placed| camera_from_world.transform_point3(placed.point_in_world));
        let seen = places.filter_map(|place| Landing::through(&own.intrinsics, place, own.intrinsics.size()));
        depths.extend(seen.map(|landing| landing.depth));
    }
    median(&mut depths).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::DemoSpec;
    use crate::job::Job;
    use crate::render::{Renderer, tests};
    use crate::settings::{Backend, RenderSettings};

    fn rendered(samples: &SampleSet, vantage: &Vantage, width: f64) -> (OrthographicView, Picture) {
        let view = OrthographicView::new(samples, vantage, width).unwrap();
        let settings = RenderSettings { backend: Backend::Cpu, ..RenderSettings::default() };
        let (picture, _) =
            Renderer::new().render(&view.samples, &view.vantage, &settings, &Job::new()).unwrap();
        let picture = view.finish(&picture);
        (view, picture)
    }

    #[test]
    fn points_lie_where_parallel_lines_of_sight_meet_them_and_as_deep_as_they_are() {
        let (samples, vantage) = tests::scene(DemoSpec::new("orrery").size((72, 50)), 1);
        let width = 8.0;
        let (_, picture) = rendered(&samples, &vantage, width);
        let lens = vantage.camera.intrinsics;
        let per_unit = f64::from(lens.width) / width;
        let camera_from_world = vantage.camera.camera_from_world();
        let (mut near, mut all) = (0, 0);
        for image in samples.images_at(vantage.frame) {
            for placed in image.placed(&samples.cameras[image.camera as usize]) {
                let place = camera_from_world.transform_point3(placed.point_in_world);
                let at = [
                    place.x * per_unit + f64::from(lens.width) / 2.0,
                    place.y * per_unit + f64::from(lens.height) / 2.0,
                ];
                let is_inside = |at: f64, side: u32| at >= 1.0 && at < f64::from(side - 1);
                if place.z <= 0.0 || !is_inside(at[0], lens.width) || !is_inside(at[1], lens.height) {
                    continue;
                }
                let shown_at = |x: usize, y: usize| 1.0 / f64::from(picture.inverse_depth[(x, y)]);
                let (x, y) = (at[0] as usize, at[1] as usize);
                let around = (0..9).map(|nth| shown_at(x + nth % 3 - 1, y + nth / 3 - 1));
                let (least, most) = around.fold((f64::INFINITY, 0.0_f64), |(least, most), depth| {
                    (least.min(depth), most.max(depth))
                });
                // At an outline a pixel shows what covers most of it.
                if most - least > 6.0 / per_unit {
                    continue;
                }
                let shown = shown_at(x, y);
                all += 1;
                // What is shown is this sample or a nearer one.
                near += usize::from(shown <= place.z + 2.0 / per_unit);
            }
        }
        assert!(all > 1000 && near as f64 > 0.98 * f64::from(all), "{near} of {all}");
    }

    #[test]
    fn nothing_behind_the_viewpoint_is_shown_and_odd_widths_are_refused() {
        let (samples, vantage) = tests::scene(DemoSpec::new("orrery").size((72, 50)), 0);
        let mut turned = vantage.clone();
        let axes = turned.camera.world_from_camera.matrix3;
        // Looks the other way, out of the scene: what was ahead is behind.
        turned.camera.world_from_camera.matrix3 =
            glam::DMat3::from_cols(-axes.x_axis, axes.y_axis, -axes.z_axis);
        let view = OrthographicView::new(&samples, &turned, 8.0).unwrap();
        let camera_from_world = turned.camera.camera_from_world();
        for image in view.samples.images_at(0) {
            let mut placed = image.placed(&samples.cameras[image.camera as usize]);
            assert!(placed.all(|placed| camera_from_world.transform_point3(placed.point_in_world).z > 0.0));
        }
        assert!(view.samples.sample_count() < samples.sample_count());
        for width in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(OrthographicView::new(&samples, &vantage, width).is_err(), "{width}");
        }
    }
}
