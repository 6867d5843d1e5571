//! A layered depth image: one picture with several samples along each ray.
//!
//! Source: J. Shade, S. Gortler, L. He and R. Szeliski, *Layered Depth Images*, SIGGRAPH 1998, §4 and §5: pictures with depth are
//! carried into one camera; samples of one ray whose depths are alike are one sample, the mean of them; the image is warped forward,
//! and each sample drawn as large as it appears.
//!
//! What differs: depths are alike within one hundredth; a z-buffer decides instead of the order in which samples are visited; a sample
//! is a square of whole pixels, without the Gaussian of its four fixed sizes. The camera is in the middle of all cameras and looks
//! where they look on average. It has their mean focal length, and a field of view up to 150° that holds everything they saw.

use glam::{DMat3, DVec2, DVec3};

use super::model::{RecordedView, RivalModel, deflated};
use super::splat::Splatter;
use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::color::{linear_from_srgb, srgb_from_linear};
use overlook_engine::render::Picture;

/// Samples of one ray whose depths differ by less than this share are one.
const SAME_DEPTH: f32 = 0.01;

/// Largest half width of the picture, in focal lengths: 150° in all.
const MAX_REACH: f64 = 3.7;

/// One sample of a ray: the mean of the samples that were carried there.
#[derive(Clone, Copy)]
struct LayerSample {
    inverse_depth: f32,
    /// Encoded.
    color: [f32; 3],
    count: f32,
}

/// The image.
pub(super) struct LayeredDepthImage {
    camera: Camera,
    /// Samples of each pixel, in the order in which they came.
    pixels: Vec<Vec<LayerSample>>,
}

impl LayeredDepthImage {
    pub(super) fn new(views: &[RecordedView]) -> Self {
        let camera = middle_camera(views);
        let mut image = Self { pixels: vec![Vec::new(); camera.intrinsics.pixel_count()], camera };
        for view in views {
            image.add(view);
        }
        image
    }

    fn add(&mut self, view: &RecordedView) {
        let (width, height) = self.camera.intrinsics.size();
        let to_here = self.camera.camera_from_world() * view.camera.world_from_camera;
        let columns = view.frame.size().0;
        let pixels = view.frame.inverse_depth.as_slice().iter().zip(view.frame.color.as_slice()).enumerate();
        for (pixel, (&inverse_depth, color)) in pixels {
            if inverse_depth < 0.0 {
                continue;
            }
            let center = DVec2::new((pixel % columns) as f64 + 0.5, (pixel / columns) as f64 + 0.5);
            let ray = view.camera.intrinsics.ray_in_camera(center);
            let point = to_here.matrix3 * ray + f64::from(inverse_depth) * to_here.translation;
            let Some(at) = self.camera.intrinsics.project(point) else { continue };
            if at.x < 0.0 || at.y < 0.0 || at.x >= width as f64 || at.y >= height as f64 {
                continue;
            }
            let color = color.map(|linear| srgb_from_linear(linear.to_f32()));
            let sample =
                LayerSample { inverse_depth: (f64::from(inverse_depth) / point.z) as f32, color, count: 1.0 };
            merge(&mut self.pixels[at.y as usize * width + at.x as usize], sample);
        }
    }
}

/// Adds a sample to a ray, to the one of like depth if there is one.
fn merge(ray: &mut Vec<LayerSample>, sample: LayerSample) {
    let alike = |known: &&mut LayerSample| {
        let larger = known.inverse_depth.max(sample.inverse_depth);
        (known.inverse_depth - sample.inverse_depth).abs() <= SAME_DEPTH * larger
    };
    let Some(known) = ray.iter_mut().find(alike) else { return ray.push(sample) };
    known.count += 1.0;
    let share = 1.0 / known.count;
    known.inverse_depth += share * (sample.inverse_depth - known.inverse_depth);
    for (mean, value) in known.color.iter_mut().zip(sample.color) {
        *mean += share * (value - *mean);
    }
}

impl RivalModel for LayeredDepthImage {
    fn render(&self, target: &Camera) -> Picture {
        let mut splatter = Splatter::new(target);
        let map = splatter.map_from(&self.camera);
        let width = self.camera.intrinsics.size().0;
        for (pixel, ray) in self.pixels.iter().enumerate() {
            let center = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
            for sample in ray {
                splatter.add(&map, center, sample.inverse_depth, sample.color.map(linear_from_srgb));
            }
        }
        splatter.finish()
    }

    fn bytes(&self) -> Option<u64> {
        let mut planes = vec![Vec::new(); 7];
        for ray in &self.pixels {
            planes[0].push(ray.len().min(255) as u8);
            for sample in ray {
                let [_, a, b, c] = sample.inverse_depth.to_bits().to_be_bytes();
                let color = sample.color.map(|encoded| (255.0 * encoded + 0.5).clamp(0.0, 255.0) as u8);
                for (plane, byte) in planes[1..].iter_mut().zip([a, b, c].into_iter().chain(color)) {
                    plane.push(byte);
                }
            }
        }
        Some(deflated(&planes.concat()))
    }
}

/// The camera in the middle of all others.
fn middle_camera(views: &[RecordedView]) -> Camera {
    let mean = |value: &dyn Fn(&Camera) -> f64| {
        views.iter().map(|view| value(&view.camera)).sum::<f64>() / views.len() as f64
    };
    let mean_vector = |value: &dyn Fn(&Camera) -> DVec3| {
        DVec3::from_array([0, 1, 2].map(|axis| mean(&|camera| value(camera)[axis])))
    };
    let first = &views[0].camera.world_from_camera.matrix3;
    let forward = mean_vector(&Camera::forward_in_world).try_normalize().unwrap_or(first.z_axis);
    let down = mean_vector(&|camera| camera.world_from_camera.matrix3.y_axis);
    let down = down.reject_from(forward).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    let mut camera = views[0].camera.clone();
    "layered depth image".clone_into(&mut camera.name);
    camera.world_from_camera.matrix3 = DMat3::from_cols(down.cross(forward), down, forward);
    camera.world_from_camera.translation = mean_vector(&Camera::position_in_world);
    let focal = [mean(&|camera| camera.intrinsics.fx), mean(&|camera| camera.intrinsics.fy)];
    let [right, bottom] = reach(views, &camera);
    let sides = [right * focal[0], bottom * focal[1]].map(|half| (half.ceil() as u32).max(1));
    camera.intrinsics =
        Intrinsics { fy: focal[1], ..Intrinsics::centered(2 * sides[0], 2 * sides[1], focal[0]) };
    camera
}

/// Largest horizontal and vertical distance from the middle at which `camera` sees a sample, in focal lengths.
fn reach(views: &[RecordedView], camera: &Camera) -> [f64; 2] {
    const STRIDE: usize = 4;
    let mut reach = [0.1_f64; 2];
    for view in views {
        let to_camera = camera.camera_from_world() * view.camera.world_from_camera;
        let (width, height) = view.frame.size();
        for y in (0..height).step_by(STRIDE) {
            for x in (0..width).step_by(STRIDE) {
                let inverse_depth = view.frame.inverse_depth[(x, y)];
                if inverse_depth < 0.0 {
                    continue;
                }
                let ray = view.camera.intrinsics.ray_in_camera(DVec2::new(x as f64, y as f64));
                let point = to_camera.matrix3 * ray + f64::from(inverse_depth) * to_camera.translation;
                if point.z > 0.0 {
                    reach[0] = reach[0].max((point.x / point.z).abs().min(MAX_REACH));
                    reach[1] = reach[1].max((point.y / point.z).abs().min(MAX_REACH));
                }
            }
        }
    }
    reach
}

#[cfg(test)]
mod tests {
    use super::super::tests::slope;
    use super::*;

    #[test]
    fn two_views_of_one_surface_are_one_layer_and_show_it() {
        let alone = LayeredDepthImage::new(&[slope(0.0)]);
        let twice = LayeredDepthImage::new(&[slope(0.0), slope(0.0)]);
        let count = |image: &LayeredDepthImage| image.pixels.iter().map(Vec::len).sum::<usize>();
        assert_eq!((count(&alone), count(&twice)), (48 * 32, 48 * 32));
        assert!(twice.bytes() <= alone.bytes().map(|bytes| bytes + 64), "a second look costs nothing");
        let truth = slope(0.0);
        let picture = twice.render(&truth.camera);
        let off = picture.inverse_depth.as_slice().iter().zip(truth.frame.inverse_depth.as_slice());
        assert!(off.clone().all(|(shown, known)| (shown / known - 1.0).abs() < 0.05));
    }
}
