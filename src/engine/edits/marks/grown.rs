//! A region that is grown or shrunk by some footprints.
//!
//! Source: dilation and erosion (J. Serra, 1982), of samples in space instead of pixels in a picture.

use std::sync::Arc;

use rayon::prelude::*;

use super::placed_points::{Origin, points_of};
use super::point_tree::{Point, PointTree};
use crate::edits::seen::ImageMarks;
use crate::error::Result;
use crate::job::Job;
use crate::samples::{ImageBuffer, SampleImage, SampleSet};

/// Points that are grown from between two looks at whether the work is cancelled.
const CHECKED: usize = 256;

/// The marks of a region, grown by some footprints (`grows`) or shrunk. `inside` are the marks of the region as it is. All points
/// that it grows from, or shrinks by, are held in memory.
pub(super) fn grown(
    images: &ImageBuffer,
    outline: &SampleSet,
    inside: &[ImageMarks],
    footprints: f64,
    grows: bool,
    job: &Job,
) -> Result<Vec<ImageMarks>> {
    let origin = Origin::of(outline);
    let is_inside = |image: usize, index: usize| inside[image].as_ref().is_some_and(|marks| marks[index]);
    let read = |index: usize| -> Result<(Arc<SampleImage>, Vec<Point>)> {
        job.check()?;
        let image = images.get(index)?;
        let camera = &outline.cameras[image.camera as usize];
        let points = points_of(&image, index, camera, origin, footprints);
        Ok((image, points))
    };
    let trees: Vec<PointTree> = (0..images.len())
        .into_par_iter()
        .map(|index| {
            if grows && inside[index].is_none() {
                return Ok(PointTree::default());
            }
            let (_, mut points) = read(index)?;
            points.retain(|point| is_inside(index, point.index as usize) == grows);
            Ok(if points.is_empty() { PointTree::default() } else { PointTree::new(points) })
        })
        .collect::<Result<_>>()?;
    let of_image = |index: usize| -> Result<ImageMarks> {
        if !grows && inside[index].is_none() {
            return Ok(None);
        }
        let (image, points) = read(index)?;
        let span = image.span;
        let beside: Vec<&PointTree> = trees
            .iter()
            .enumerate()
            .filter(|(other, tree)| {
                let theirs = images.facts_of(*other).span;
                !tree.points().is_empty() && theirs.start < span.end && span.start < theirs.end
            })
            .map(|(_, tree)| tree)
            .collect();
        let mut marks: Box<[bool]> = (0..image.len()).map(|sample| is_inside(index, sample)).collect();
        for (nth, point) in points.iter().enumerate() {
            if nth % CHECKED == 0 {
                job.check()?;
            }
            if marks[point.index as usize] == grows {
                continue;
            }
            let mut is_near = false;
            for tree in &beside {
                tree.for_each_near(
                    point.at,
                    point.reach,
                    |_| true,
                    |_| {
                        is_near = true;
                        false
                    },
                );
                if is_near {
                    marks[point.index as usize] = grows;
                    break;
                }
            }
        }
        Ok(marks.contains(&true).then_some(marks))
    };
    (0..images.len()).into_par_iter().map(of_image).collect()
}
