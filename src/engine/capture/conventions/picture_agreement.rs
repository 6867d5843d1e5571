//! How well the pictures of the views agree under a reading.
//!
//! Purpose: cameras that stand close together see almost the same depth whatever its unit is, and smooth surfaces whatever the focal
//! length is. What is painted on the surfaces still moves by many pixels. Source: normalized cross-correlation of small patches that
//! are carried from view to view, as in multi-view stereo (M. Goesele et al., *Multi-View Stereo for Community Photo Collections*,
//! ICCV 2007). What differs: patches face the camera that they come from, and are compared in small pictures, because the readings that
//! are told apart here differ by many pixels.

use std::sync::Arc;

use glam::{DAffine3, DVec2};

use super::agreement::Comparison;
use super::pictures::{shrunk, small};
use super::reading::{PixelRay, Reading};
use super::views::SourcePoint;
use crate::capture::camera::Intrinsics;
use crate::capture::frame::Frame;
use crate::color::brightness;
use crate::grid::Grid;

/// Columns of the pictures that are compared, at most.
const WIDTH: usize = 320;
/// Pixels of a patch to each side of its middle.
const RADIUS: i32 = 3;
const PATCH: usize = ((2 * RADIUS + 1) * (2 * RADIUS + 1)) as usize;
/// Patches whose brightness (the square root of luminance) has a smaller standard deviation show no texture.
const LEAST_TEXTURE: f64 = 0.02;
/// The same where a patch arrives: noise, which correlates with nothing.
const NOISE: f64 = 0.005;

/// The pictures of the views of a comparison.
pub(super) struct PictureComparison<'a> {
    comparison: &'a Comparison,
    /// In the order of its views: brightness, small.
    pictures: Vec<Grid<f32>>,
    /// Per pair, what is carried: its points with texture around them.
    patches: Vec<Vec<Patch<'a>>>,
}

/// A point with the brightness around it, less its mean.
struct Patch<'a> {
    point: &'a SourcePoint,
    values: [f64; PATCH],
    deviation: f64,
}

impl<'a> PictureComparison<'a> {
    pub(super) fn new(comparison: &'a Comparison, frames: &[Arc<Frame>]) -> Self {
        let pictures = frames.iter().zip(&comparison.views);
        let pictures: Vec<Grid<f32>> = pictures
            .map(|(frame, view)| {
                shrunk(frame, &small(&view.intrinsics, WIDTH)).map(|color| brightness(*color))
            })
            .collect();
        let of_pair = |&(from, _): &(usize, usize)| {
            let step = pixel_step(&comparison.views[from].intrinsics);
            let points = comparison.views[from].points.iter();
            points.filter_map(|point| Patch::around(point, &pictures[from], step)).collect()
        };
        let patches = comparison.pairs.iter().map(of_pair).collect();
        Self { comparison, pictures, patches }
    }

    /// Patches of all pairs.
    pub(super) fn patch_count(&self) -> usize {
        self.patches.iter().map(Vec::len).sum()
    }

    /// The mean correlation of patches under a reading, in each pair that has some; those that are carried out of the picture count as 0.
    /// At most `most` patches of a pair are carried.
    pub(super) fn correlations(&self, reading: &Reading, most: usize) -> Vec<f64> {
        let poses = self.comparison.poses(reading);
        let pairs =
            self.comparison.pairs.iter().zip(&self.patches).filter(|(_, patches)| !patches.is_empty());
        let of_pair = |(&(from, to), patches): (&(usize, usize), &Vec<Patch>)| {
            let taken = patches.len().min(most);
            let places = self.places(reading, [from, to], [&poses[from], &poses[to]]);
            let sum: f64 = patches[..taken].iter().filter_map(|patch| patch.correlation(&places)).sum();
            sum / taken as f64
        };
        pairs.map(of_pair).collect()
    }

    fn places(&self, reading: &Reading, pair: [usize; 2], poses: [&DAffine3; 2]) -> Carried<'_> {
        let views = pair.map(|view| &self.comparison.views[view]);
        let [lens, target_lens] = views.map(|view| reading.lens.of(&view.intrinsics));
        Carried {
            reading: *reading,
            lens,
            target_lens,
            world_from_source: *poses[0],
            target_from_source: poses[1].inverse() * *poses[0],
            near_clip: self.comparison.near_clip,
            steps: views.map(|view| pixel_step(&view.intrinsics)),
            picture: &self.pictures[pair[1]],
        }
    }
}

/// From one view into another under a reading.
struct Carried<'a> {
    reading: Reading,
    lens: Intrinsics,
    target_lens: Intrinsics,
    world_from_source: DAffine3,
    target_from_source: DAffine3,
    near_clip: f64,
    /// Pixels of the source and of the target for a pixel of their small pictures.
    steps: [f64; 2],
    picture: &'a Grid<f32>,
}

impl Carried<'_> {
    /// Brightness where the other view sees a pixel of the source that has the planar z `z`; `None` outside of its picture.
    fn brightness(&self, pixel: DVec2, z: f64) -> Option<f64> {
        let point = self.target_from_source.transform_point3(self.lens.ray_in_camera(pixel) * z);
        let at = self.target_lens.project(point).filter(|_| point.z > 0.0)?;
        brightness_at(self.picture, at / self.steps[1])
    }
}

impl<'a> Patch<'a> {
    /// `step` is the width of a pixel of the small picture. `None` without texture, and at the border.
    fn around(point: &'a SourcePoint, picture: &Grid<f32>, step: f64) -> Option<Self> {
        let mut values = [0.0; PATCH];
        for (value, offset) in values.iter_mut().zip(offsets()) {
            *value = brightness_at(picture, point.pixel / step + offset)?;
        }
        let deviation = centered(&mut values);
        (deviation > LEAST_TEXTURE).then_some(Self { point, values, deviation })
    }

    /// With what the other view shows in its place; `None` if that is not all within the picture.
    fn correlation(&self, carried: &Carried) -> Option<f64> {
        let ray = PixelRay::through(&carried.lens, self.point.pixel);
        let z =
            carried.reading.planar_z(self.point.value, ray, &carried.world_from_source, carried.near_clip);
        if z.is_nan() || z <= 0.0 {
            return None;
        }
        let mut found = [0.0; PATCH];
        for (value, offset) in found.iter_mut().zip(offsets()) {
            *value = carried.brightness(self.point.pixel + offset * carried.steps[0], z)?;
        }
        let deviation = centered(&mut found);
        let product: f64 = self.values.iter().zip(&found).map(|(a, b)| a * b).sum();
        Some(product / PATCH as f64 / (self.deviation * deviation.max(NOISE)))
    }
}

/// Pixels of a view for a pixel of its small picture.
fn pixel_step(lens: &Intrinsics) -> f64 {
    f64::from(lens.width) / f64::from(small(lens, WIDTH).width)
}

fn offsets() -> impl Iterator<Item = DVec2> {
    let side = -RADIUS..=RADIUS;
    side.clone().flat_map(move |y| side.clone().map(move |x| DVec2::new(f64::from(x), f64::from(y))))
}

/// Takes the mean away; the standard deviation of what is left.
fn centered(values: &mut [f64; PATCH]) -> f64 {
    let mean = values.iter().sum::<f64>() / PATCH as f64;
    for value in values.iter_mut() {
        *value -= mean;
    }
    (values.iter().map(|value| value * value).sum::<f64>() / PATCH as f64).sqrt()
}

/// Between the four pixels around a position, in pixels from the corner of the picture; `None` where it has not all four.
fn brightness_at(picture: &Grid<f32>, at: DVec2) -> Option<f64> {
    let corner = at - 0.5;
    let (left, top) = (corner.x.floor(), corner.y.floor());
    let (width, height) = picture.size();
    if !(left >= 0.0 && top >= 0.0 && left + 1.0 < width as f64 && top + 1.0 < height as f64) {
        return None;
    }
    let (right, down) = (corner.x - left, corner.y - top);
    let start = top as usize * width + left as usize;
    let values = picture.as_slice();
    let row = |start: usize| f64::from(values[start]) * (1.0 - right) + f64::from(values[start + 1]) * right;
    Some(row(start) * (1.0 - down) + row(start + width) * down)
}
