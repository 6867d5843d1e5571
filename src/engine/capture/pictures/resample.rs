//! Where the pixels of a pinhole picture are in the picture that a bent lens took.

use glam::DVec2;

use super::distortion::Distortion;
use crate::capture::camera::Intrinsics;

/// The position of every pixel of the pinhole picture in the bent one; `None` outside of it.
pub(crate) struct Sources {
    width: usize,
    height: usize,
    positions: Vec<Option<DVec2>>,
}

/// Follows every pixel's ray through the lens. Both pictures have the size and the focal lengths of `intrinsics`.
pub(crate) fn sources(intrinsics: &Intrinsics, distortion: &Distortion) -> Sources {
    let (width, height) = intrinsics.size();
    let position = |index: usize| {
        let pixel = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        let bent = distortion.distort(intrinsics.ray_in_camera(pixel).truncate())?;
        let at = DVec2::new(intrinsics.cx + intrinsics.fx * bent.x, intrinsics.cy + intrinsics.fy * bent.y);
        let is_inside = at.cmpge(DVec2::ZERO).all() && at.x < width as f64 && at.y < height as f64;
        is_inside.then_some(at)
    };
    Sources { width, height, positions: (0..width * height).map(position).collect() }
}

impl Sources {
    /// A plane of values between those of the four pixels around each position; NaN without a position.
    pub(crate) fn linear(&self, plane: &[f32]) -> Vec<f32> {
        let value = |at: &Option<DVec2>| {
            let Some(at) = at else { return f32::NAN };
            let (x, y) = ((at.x - 0.5).max(0.0), (at.y - 0.5).max(0.0));
            let (left, top) = ((x as usize).min(self.width - 1), (y as usize).min(self.height - 1));
            let (right, bottom) = ((left + 1).min(self.width - 1), (top + 1).min(self.height - 1));
            let (fx, fy) = ((x - left as f64) as f32, (y - top as f64) as f32);
            let row = |y: usize| {
                let (a, b) = (plane[y * self.width + left], plane[y * self.width + right]);
                a + fx * (b - a)
            };
            let (above, below) = (row(top), row(bottom));
            above + fy * (below - above)
        };
        self.positions.iter().map(value).collect()
    }

    /// A plane of the values of the pixels at the positions; `outside` without a position.
    pub(crate) fn nearest<T: Copy>(&self, plane: &[T], outside: T) -> Vec<T> {
        let value =
            |at: &Option<DVec2>| at.map_or(outside, |at| plane[at.y as usize * self.width + at.x as usize]);
        self.positions.iter().map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_shows_what_the_lens_put_elsewhere() {
        let intrinsics = Intrinsics::centered(40, 30, 30.0);
        let lens = Distortion::radial_tangential([0.3, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 2]).unwrap();
        let sources = sources(&intrinsics, &lens);
        let plane: Vec<f32> = (0..1200).map(|i| (i % 40) as f32 + 0.5).collect();
        let straight = sources.linear(&plane);
        let ray = intrinsics.ray_in_camera(DVec2::new(28.5, 15.5));
        let expected = 20.0 + 30.0 * lens.distort(ray.truncate()).unwrap().x;
        assert!((f64::from(straight[15 * 40 + 28]) - expected).abs() < 1e-4);
        assert!(straight[0].is_nan(), "the corner lies outside of what the lens took");
        assert_eq!(sources.nearest(&plane, -1.0)[0], -1.0);
    }
}
